"""The stack as a linearisation, so that it is damped where that misleads: see :mod:`hqp.solver.curved`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from hqp import Settings, Solution
from hqp.solver.curved import Contraction, CurvedSolver, Errors, Linearisation

from ..base.checks import Array
from ..rows.rows import Rows
from ..rows.task import Task

if TYPE_CHECKING:
    from hqp import DampingRule, Hierarchy


def linearised(rows: Rows, dt: float | None, order: str, rules: Sequence[DampingRule | None]) -> Linearisation:
    """What the rows of a stack are the linearisation of, as they are planned now."""
    from hqp.kernels.call import address_of

    from ..base.loops import SIGNATURE, Table, address

    hierarchy, work = rows.hierarchy, rows.work
    n, levels = hierarchy.n, len(hierarchy.levels)
    S, tables = np.zeros((n, n)), list[Table]()
    contractions, errors, gains = list[Contraction](), list[Errors](), np.zeros(levels)
    for k, row, part, plan, site in work:
        errors += [Errors(*off, row) for off in site.off]
        task = getattr(part, "task", part)
        if isinstance(task, Task) and site.off:
            gains[k] = max(gains[k], float(task.gain.max()))
        if plan.curvature is not None:
            weights = np.zeros(site.rows)
            table = Table(weights, S, *plan.curvature.table.told[2:])
            tables.append(table)
            loop = address_of(plan.curvature.kernel, SIGNATURE)
            contractions.append(Contraction(loop, address(table), weights, row))
    first = min((k for k, _, part, _, _ in work if not part.is_limit), default=levels)
    curved = tuple(k >= first for k in range(levels))
    shares = np.where(gains > 0.0, gains * (dt or 0.0), 1.0)
    return Linearisation(
        curved, errors, contractions, S, shares, np.zeros((levels, n)), np.full(n, np.nan), (tables, work)
    )


class CalmSolver:
    """Solves the rows of a stack, damped where they mislead."""

    def __init__(
        self,
        rows: Rows,
        dt: float | None,
        order: str,
        rules: Sequence[DampingRule | None],
        backend: str,
        settings: Settings | None,
    ) -> None:
        self._rows, self._told = rows, (dt, order, rules)
        self._solver = CurvedSolver(rows.hierarchy, linearised(rows, *self._told), backend, settings)
        self._planned, self.backend = rows.planned, backend
        self._lin = self._solver._linearisation

    def solve(self, hierarchy: Hierarchy, last: Array | None = None) -> Solution:
        if self._planned != self._rows.planned:
            self._lin = linearised(self._rows, *self._told)
            self._solver.relinearise(self._lin)
            self._planned = self._rows.planned
        if last is not None:
            self._lin.last[:] = last
        return self._solver.solve(hierarchy)
