r"""DAQP's own hierarchy: all levels in one call of one dual active-set method (Arnström, Bemporad, Axehill 2022).

DAQP scales every row to norm one, and then

.. math::

    \min_x \; \tfrac12 \|x - x_\text{ref}\|^2 + \tfrac1{2\rho} \|w_k\|^2
    \quad \text{subject to} \quad \bar l_k \le \bar A_k x - w_k \le \bar u_k

level by level, with the levels above as hard rows which the slacks found have widened. So

* a level that cannot be met is met as if its rows had norm one: neither their own norms nor their weights count;
* its first level is hard. If that fails, it is called once more with an empty level on top;
* rows that repeat rows of a level above can make it silently wrong: the certificate detects this.

Rho is ``settings.proximal_weight``, the tolerance of a row, of norm one, is ``settings.tolerance``.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..hierarchy import Hierarchy
from ..settings import Settings
from ..solution import Counts, Status
from .base import Answer

#: DAQP's flag of an equality row.
EQUALITY = 5
#: Multipliers above minus this count as none of the wrong sign: DAQP's own default.
DUAL_TOLERANCE = 1e-12
#: Exit flags that claim an optimum, without and with slack.
CLAIMED = (1, 2)
#: What the other exit flags mean.
FLAGS = {
    3: "a level failed below one that was solved",
    -1: "infeasible",
    -2: "cycling",
    -3: "unbounded",
    -4: "iteration limit",
    -5: "not convex",
    -6: "dependent equalities at the start",
}


class DaqpProblem(NamedTuple):
    """A hierarchy as DAQP takes it; the first rows, those without an A, are bounds on x[0], x[1], and so on."""

    A: Array
    upper: Array
    lower: Array
    sense: NDArray[np.intc]
    break_points: NDArray[np.intc]

    @classmethod
    def of(cls, hierarchy: Hierarchy) -> DaqpProblem:
        """Out of a hierarchy; free rows, zero rows and empty levels constrain nothing and are left out."""
        says = (hierarchy.row_norms() > 0) & ~(np.isinf(hierarchy.lower) & np.isinf(hierarchy.upper))
        ends = {int(says[:pointer].sum()) for pointer in hierarchy.pointers}
        columns = hierarchy.columns[says]
        simple = int(np.argmin(np.append(columns == np.arange(len(columns)), False)))
        upper, lower = hierarchy.upper[says], hierarchy.lower[says]
        return cls(
            A=hierarchy.dense()[says][simple:],
            upper=upper,
            lower=lower,
            sense=np.where(lower == upper, EQUALITY, 0).astype(np.intc),
            break_points=np.array(sorted(ends - {0}), dtype=np.intc),
        )


class DAQP:
    """DAQP's own hierarchy as a backend; every call is cold."""

    def __init__(self, settings: Settings) -> None:
        self.call: Callable[..., Any] = import_module("daqp").solve
        self.options = {
            "rho_soft": settings.proximal_weight,
            "primal_tol": settings.tolerance,
            "dual_tol": DUAL_TOLERANCE,
            "iter_limit": settings.qp_iterations,
        }

    def solve(self, hierarchy: Hierarchy, x_ref: Array) -> Answer:
        rows = DaqpProblem.of(hierarchy)
        if not len(rows.upper):
            return Answer(x_ref.copy())
        flag, calls = 0, 0
        for calls, top in enumerate(([], [0]), start=1):
            break_points = np.array([*top, *rows.break_points], dtype=np.intc)
            x, _, flag, _ = self.call(np.eye(hierarchy.n), -x_ref, *rows[:4], break_points, **self.options)
            if flag in CLAIMED and np.isfinite(x).all():
                return Answer(x, counts=Counts(qp_solves=calls))
        said = FLAGS.get(flag, "not a number" if flag in CLAIMED else "unknown")
        message = f"DAQP failed (exit flag {flag}: {said}); x is x_ref"
        return Answer(x_ref.copy(), Status.FAILED, message, counts=Counts(qp_solves=calls))

    def reset(self) -> None:
        """No effect: nothing is kept between calls."""


def make(name: str, settings: Settings) -> DAQP:
    """The one backend of this module."""
    return DAQP(settings)
