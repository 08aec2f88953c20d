"""Default damping of a controller: levels damped where their linearisation is inaccurate (:mod:`hqp.solver.curved`)."""

from __future__ import annotations

import numpy as np

from hqp import Hierarchy, Settings, Solution
from hqp.solver.curved import CurvedSolver
from hqp.solver.linearisation import Bound, Contraction, Errors, Linearisation

from ..base.checks import Array
from ..rows.hierarchy_writer import HierarchyWriter
from ..rows.task import Task

#: Text of explanations for a task with a direction in which the joints hardly move it.
STRAIGHT = "the joints move it little in this direction"
#: The deceleration of joints at the ends of their ranges, where no acceleration is limited [rad/s^2]: from the speeds
#: of arms they come to rest within 50 ms, not within a tick. Elsewhere nothing is braked.
GENTLE = 60.0


def curved_levels(rows: HierarchyWriter) -> tuple[int, ...]:
    """Which levels may be damped by default (1), are below a task but left strict (2), or neither (0).

    Limits above all tasks are never damped, and a level with an inequality stays strict. The whole stack stays strict
    if the curvature of no task is known, or if contact forces are unknowns too.
    """
    rules, work = rows.levels.damping, rows.work
    levels = len(rules)
    first = min((k for k, _, part, _, _ in work if not part.is_limit), default=levels)
    bends = any(plan.curvature is not None for _, _, _, plan, _ in work)
    if not bends or rows.unknowns.blocks or all(rule is False for rule in rules[first:]):
        return (0,) * levels
    bounded = {k for k, _, part, _, _ in work if part.is_limit}
    return tuple(0 if k < first else 2 if rule is False or k in bounded else 1 for k, rule in enumerate(rules))


def linearised(rows: HierarchyWriter, dt: float | None, curved: tuple[int, ...], last: Array) -> Linearisation:
    """The linearisation that the rows of a stack come from, as planned now; `last` is x of the previous tick."""
    from ..base.loops import Table, address, compiled

    work, n = rows.work, rows.hierarchy.n
    S, tables, unknown = np.zeros((n, n)), list[Table](), np.zeros(rows.hierarchy.m, dtype=bool)
    contractions, errors = list[Contraction](), list[Errors]()
    for _, row, _, plan, site in work:
        errors += [Errors(*off, row) for off in site.off]
        unknown[row : row + site.rows] = plan.curvature is None and not plan.linear
        if plan.curvature is not None:
            weights = np.zeros(site.rows)
            table = Table(weights, S, *plan.curvature.table.told[2:])
            tables.append(table)
            loop = compiled(plan.curvature.kernel)
            bound = None
            if plan.bound is not None:
                most = np.zeros((site.rows, site.rows))
                tables.append(Table(most, S, *plan.curvature.table.told[2:]))
                bound = Bound(compiled(plan.bound), address(tables[-1]), most)
            contractions.append(Contraction(loop, address(table), weights, row, bound))
    paced = paces(gains_of(rows), rows.hierarchy.m, dt, len(curved))
    return Linearisation(
        curved, errors, contractions, unknown, S, *paced, rows.every_aim, last, STRAIGHT, (tables, work)
    )


def gains_of(rows: HierarchyWriter) -> list[tuple[slice, Task, bool]]:
    """The rows that follow the law of a task, the task that has their gain, and whether they look ahead.

    Those of tasks with a curvature do, at acceleration order.
    """
    ahead = rows.shared.order == "acceleration"
    parts = [
        (slice(row, row + site.rows), getattr(part, "task", part), ahead and plan.curvature is not None)
        for _, row, part, plan, site in rows.work
        if site.off
    ]
    return [(own, task, looks) for own, task, looks in parts if isinstance(task, Task)]


def paces(
    tasks: list[tuple[slice, Task, bool]], rows: int, dt: float | None, levels: int
) -> tuple[Array, Array, Array]:
    """The gain K of each row relative to the largest, what a unit of the row is worth, and the share of a tick.

    A row that looks ahead asks for K^2 times its error. The share is that of the error which a level removes in a tick.
    """
    gains, worth = np.zeros(rows), np.zeros(rows)
    for own, task, looks in tasks:
        gains[own], worth[own] = task.gain, looks
    fastest = float(gains.max())
    scales = gains / (fastest or 1.0)
    np.divide(scales, gains**2, out=worth, where=worth > 0.0)
    return scales, worth, np.full(levels, fastest * dt if dt and fastest else 1.0)


class CalmSolver:
    """Solves a stack, with levels damped where their linearisation is inaccurate.

    Parameters
    ----------
    rows : HierarchyWriter
    dt : float or None
        Tick [s]; if it is None, the last x is not used.
    curved : tuple of int
        See :func:`curved_levels`.
    backend : str
    settings : hqp.Settings, optional
    """

    def __init__(
        self, rows: HierarchyWriter, dt: float | None, curved: tuple[int, ...], backend: str, settings: Settings | None
    ) -> None:
        self.backend = backend
        self._rows, self._dt, self._curved, self._last = rows, dt, curved, np.full(rows.hierarchy.n, np.nan)
        rows.brake((k for k, kind in enumerate(curved) if kind == 1), GENTLE)
        self._linearisation = linearised(rows, dt, curved, self._last)
        self._solver = CurvedSolver(rows.hierarchy, self._linearisation, backend, settings)
        self._planned, self._tuned, self._gains = rows.planned, rows.tuned, gains_of(rows)

    def solve(self, hierarchy: Hierarchy, last: Array | None = None) -> Solution:
        """Solve the rows as they are filled now; `last` is the x of the previous tick, None or NaN if it is unknown."""
        rows = self._rows
        if self._planned != rows.planned:
            self._linearisation = linearised(rows, self._dt, self._curved, self._last)
            self._solver.relinearise(self._linearisation)
            self._planned, self._tuned, self._gains = rows.planned, rows.tuned, gains_of(rows)
        elif self._tuned != rows.tuned:
            told = self._linearisation
            told.scales[:], told.worth[:], told.shares[:] = paces(self._gains, hierarchy.m, self._dt, len(self._curved))
            self._tuned = rows.tuned
        self._last[:] = np.nan if last is None or self._dt is None else last
        return self._solver.solve(hierarchy)
