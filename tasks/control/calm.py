"""Default damping of a controller: levels damped where their linearisation is inaccurate (:mod:`hqp.solver.curved`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from hqp import Hierarchy, Settings, Solution
from hqp.solver.curved import CurvedSolver
from hqp.solver.linearisation import Bound, Contraction, Errors, Linearisation

from ..base.checks import Array
from ..robots.robot import RobotState
from ..rows.components import Components, Work, components
from ..rows.hierarchy_writer import HierarchyWriter
from ..rows.levels import Rule
from ..rows.task import Task

#: Text of explanations for a task with a direction in which the joints hardly move it.
STRAIGHT = "the joints move it little in this direction"
#: The deceleration of joints at the ends of their ranges, where no acceleration is limited [rad/s^2]: from the speeds
#: of arms they come to rest within 0.1 s, not within a tick. Elsewhere nothing is braked.
GENTLE = 30.0


def curved_levels(rows: HierarchyWriter) -> tuple[int, ...]:
    """Which levels may be damped by default (1), are below a task but left strict (2), or neither (0).

    Limits above all tasks are never damped, and a level with an inequality stays strict. The whole stack stays strict
    if the curvature of no task is known, or if contact forces are unknowns too.
    """
    return (0,) * len(rows.levels.damping) if rows.unknowns.blocks else levels_of(rows.work, rows.levels.damping)


def levels_of(work: Sequence[Work], rules: Sequence[Rule]) -> tuple[int, ...]:
    """The same by the parts and the rules of the levels."""
    levels = len(rules)
    first = min((k for k, _, part, _, _ in work if not part.is_limit), default=levels)
    bends = any(plan.curvature is not None for _, _, _, plan, _ in work)
    if not bends or all(rule is False for rule in rules[first:]):
        return (0,) * levels
    bounded = {k for k, _, part, _, _ in work if part.is_limit}
    return tuple(0 if k < first else 2 if rule is False or k in bounded else 1 for k, rule in enumerate(rules))


def unknown_curvatures(rows: HierarchyWriter) -> list[str]:
    """The tasks that the default would damp if their curvature were known, in their order."""
    work, rules = rows.work, rows.levels.damping
    first = min((k for k, _, part, _, _ in work if not part.is_limit), default=len(rules))
    return [
        part.full_name()
        for k, _, part, plan, site in work
        if k >= first and rules[k] is None and not part.is_limit and site.off
        if plan.curvature is None and not plan.linear
    ]


def passing(rows: HierarchyWriter, x: Array) -> Callable[[], object] | None:
    """What tells whether x passes a limit in space above all tasks; None if there is none."""
    from ..base.loops import Call
    from ..rows.kernels.passing import passes

    first = min((k for k, _, part, _, _ in rows.work if not part.is_limit), default=len(rows.levels.damping))
    sites = [site for k, _, _, _, site in rows.work if k < first]
    found = [(site.rows, site.A, site.lower, site.upper) for site in sites if site.A is not None]
    return Call(passes, len(x), x, len(found), *(entry for told in found for entry in told)).run if found else None


def kinds_of(rows: HierarchyWriter, blocks: Components) -> NDArray[np.int64]:
    """What :func:`curved_levels` would be for each block alone, shape (blocks, levels)."""
    rules = rows.levels.damping
    kinds = np.zeros((blocks.size, len(rules)), dtype=np.int64)
    for block, kind in enumerate(kinds):
        work = [told for told in rows.work if (blocks.rows[told[1] : told[1] + told[4].rows] == block).any()]
        kind[:] = levels_of(work, rules)
    return kinds


def linearised(rows: HierarchyWriter, blocks: Components, dt: float | None, curved: tuple[int, ...]) -> Linearisation:
    """The linearisation that the rows of a stack come from, as planned now; the last x is taken for the present v."""
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
    paced = paces(gains_of(rows), blocks, dt, len(curved))
    told = curved, *blocks, kinds_of(rows, blocks)
    return Linearisation(
        *told, errors, contractions, unknown, S, *paced, rows.aims.every, rows.shared.v, STRAIGHT, (tables, work)
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
    tasks: list[tuple[slice, Task, bool]], blocks: Components, dt: float | None, levels: int
) -> tuple[Array, Array, Array]:
    """The gain K of each row relative to the largest, what a unit of the row is worth, and the share of a tick.

    The largest is that of the block of the row. A row that looks ahead asks for K^2 times its error. The share is that
    of the error which a level removes in a tick.
    """
    gains, worth = np.zeros(len(blocks.rows)), np.zeros(len(blocks.rows))
    for own, task, looks in tasks:
        gains[own], worth[own] = task.gain, looks
    fastest = np.array([gains[blocks.rows == block].max(initial=0.0) for block in range(blocks.size)])
    scales = gains / np.where(fastest > 0.0, fastest, 1.0)[blocks.rows]
    np.divide(scales, gains**2, out=worth, where=worth > 0.0)
    shares = np.where(fastest > 0.0, fastest * dt, 1.0) if dt else np.ones(blocks.size)
    return scales, worth, np.repeat(shares[:, None], levels, axis=1)


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
        self._rows, self._dt = rows, dt
        self._blocks = blocks = components(rows.work, rows.shared.robot, rows.hierarchy.m)
        damped = kinds_of(rows, blocks) == 1
        self._curved = tuple(np.where(damped.any(axis=0), 1, curved).tolist())
        ends = np.where(damped.any(axis=1)[blocks.columns], GENTLE, np.inf)
        rows.brake((k for k, kind in enumerate(self._curved) if kind == 1), ends, blocks)
        self._ends, self._reached = ends, np.zeros(rows.hierarchy.n)
        self._linearise()
        self._known: bool | None = None  # whether the last x is: not told yet
        self._solver = CurvedSolver(rows.hierarchy, self._linearisation, backend, settings)

    def _linearise(self) -> None:
        """Take the linearisation of the rows as they are planned now."""
        rows = self._rows
        self._linearisation = linearised(rows, self._blocks, self._dt, self._curved)
        self._passes = passing(rows, self._reached)
        self._planned, self._tuned, self._gains = rows.planned, rows.tuned, gains_of(rows)

    def solve_at(self, state: RobotState, t: float, known: bool) -> Solution:
        """The solution at this state and time t [s].

        `known` tells whether the v of the state is the x of the previous tick. Where joints that come to rest gently at
        the ends of their ranges keep a limit in space from being met, they stop as hard as they have to.
        """
        rows = self._rows
        hierarchy = rows.fill(state, t)
        if known is not self._known or self._planned != rows.planned or self._tuned != rows.tuned:
            self._keep_up(known)
        solution = self._solver.solve(hierarchy)
        if self._passes is None:
            return solution
        envelope = rows.shared.envelope
        self._reached[:] = solution.x
        if not self._passes() or np.isinf(envelope.eased):
            return solution
        envelope.ease_ends(np.full_like(self._ends, np.inf))
        try:
            return self._solver.solve(rows.fill(state, t))
        finally:
            envelope.ease_ends(self._ends)

    def solve(self, hierarchy: Hierarchy) -> Solution:
        """Solve the rows as they are filled now."""
        self._keep_up(False)
        return self._solver.solve(hierarchy)

    def _keep_up(self, known: bool) -> None:
        """Take up whether the last x is known, and what has changed in the rows."""
        rows = self._rows
        if self._planned != rows.planned:
            self._linearise()
            self._solver.relinearise(self._linearisation)
        elif self._tuned != rows.tuned:
            told = self._linearisation
            told.scales[:], told.worth[:], told.shares[:] = paces(
                self._gains, self._blocks, self._dt, len(self._curved)
            )
            self._tuned = rows.tuned
        self._known = known
        self._solver.know_last(known and self._dt is not None)
