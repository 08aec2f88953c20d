"""ProxQP through its dense interface: one persistent problem, updated in place, warm."""

from __future__ import annotations

from typing import Any

import numpy as np
from proxsuite import proxqp

from ..arrays import Array
from ..settings import Settings
from .problem import FlatQP, FlatResult, Sizes

#: Relative tolerance: absolute ones cannot be met by numbers of 1e7.
ROUND_OFF = 1e-13
#: ProxQP's own limits are 10 000 and 1500.
MOST_OUTER, MOST_INNER = 100, 100


class ProxQP:
    """Keeps one ``proxqp.dense.QP`` of these sizes."""

    def __init__(self, sizes: Sizes, settings: Settings) -> None:
        self.sizes = sizes
        self.qp: Any = proxqp.dense.QP(sizes.variables, 0, sizes.rows, sizes.box)
        self.qp.settings.eps_abs = settings.qp_tolerance
        self.qp.settings.eps_rel = ROUND_OFF
        # Outer times inner iterations: beyond a few dozen of either, ProxQP circles for seconds.
        self.qp.settings.max_iter = min(settings.qp_iterations, MOST_OUTER)
        self.qp.settings.max_iter_in = min(settings.qp_iterations, MOST_INNER)
        # Without the gap, a point strictly inside a row that carries a dual counts as solved.
        self.qp.settings.check_duality_gap = True
        self.qp.settings.eps_duality_gap_abs = settings.qp_tolerance
        self.qp.settings.eps_duality_gap_rel = ROUND_OFF
        # Every level has a feasible point, so a verdict of infeasibility would be round-off.
        self.qp.settings.eps_primal_inf = self.qp.settings.eps_dual_inf = 1e-30
        self.qp.settings.initial_guess = proxqp.InitialGuess.NO_INITIAL_GUESS
        self.fresh = True

    def solve(self, qp: FlatQP) -> FlatResult:
        load = self.qp.init if self.fresh else self.qp.update
        box = (qp.box_lower, qp.box_upper) if self.sizes.box else ()
        load(qp.H, qp.g, None, None, qp.C, qp.lower, qp.upper, *box)
        self.qp.solve()
        if self.fresh:
            self.qp.settings.initial_guess = proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
            self.fresh = False
        return self._result()

    def move(self, g: Array) -> FlatResult:
        self.qp.update(g=g)
        self.qp.solve()
        return self._result()

    def _result(self) -> FlatResult:
        results, rows = self.qp.results, self.sizes.rows
        status = results.info.status
        solved = status == proxqp.PROXQP_SOLVED
        y = np.array(results.x)
        if not (solved and np.isfinite(y).all()):
            # The next warm start must not begin at a point that was given up.
            self.qp.settings.initial_guess = proxqp.InitialGuess.NO_INITIAL_GUESS
            self.fresh = True
        z = np.array(results.z)
        return FlatResult(y, solved, status.name, z[:rows], z[rows:])


def make(solver: str, sizes: Sizes, settings: Settings) -> ProxQP:
    """A persistent ProxQP."""
    return ProxQP(sizes, settings)
