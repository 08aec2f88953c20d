"""OSQP driven directly: one persistent problem with full sparsity patterns, updated in place, warm."""

from __future__ import annotations

from typing import Any

import numpy as np
import osqp
from scipy import sparse

from ..arrays import Array
from ..settings import Settings
from .problem import FlatQP, FlatResult, Sizes

#: OSQP takes this for infinity.
INFINITY = 1e30


class OSQP:
    """Keeps one ``osqp.OSQP``; box bounds travel as rows, which is how OSQP knows them."""

    def __init__(self, sizes: Sizes, settings: Settings) -> None:
        self.sizes = sizes
        self.options = {
            "eps_abs": max(settings.qp_tolerance, 1e-8),
            "eps_rel": 0.0,
            "max_iter": settings.qp_iterations,
            # Every level has a point that is feasible and bounded below: such a verdict would be round-off.
            "eps_prim_inf": 1e-30,
            "eps_dual_inf": 1e-30,
            "polishing": False,
            "verbose": False,
        }
        self.osqp: Any = None
        n = sizes.variables
        self._triangle = np.tril_indices(n)  # column-major order of the upper triangle, transposed

    def solve(self, qp: FlatQP) -> FlatResult:
        rows, lower, upper = qp.C, qp.lower, qp.upper
        if qp.box_lower is not None and qp.box_upper is not None:
            rows = np.concatenate([rows, np.eye(self.sizes.variables)])
            lower, upper = np.concatenate([lower, qp.box_lower]), np.concatenate([upper, qp.box_upper])
        lower, upper = np.maximum(lower, -INFINITY), np.minimum(upper, INFINITY)
        if self.osqp is None:
            self.osqp = osqp.OSQP()
            pattern = sparse.csc_matrix(np.triu(np.ones_like(qp.H)))
            P = sparse.csc_matrix((qp.H[self._triangle], pattern.indices, pattern.indptr), shape=qp.H.shape)
            self.osqp.setup(P, qp.g, _full_csc(rows), lower, upper, **self.options)
        else:
            self.osqp.update(q=qp.g, l=lower, u=upper, Px=qp.H[self._triangle], Ax=rows.ravel(order="F"))
        return self._run()

    def move(self, g: Array) -> FlatResult:
        self.osqp.update(q=g)
        return self._run()

    def _run(self) -> FlatResult:
        found = self.osqp.solve(raise_error=False)
        rows, n = self.sizes.rows, self.sizes.variables
        solved = found.info.status_val == osqp.SolverStatus.OSQP_SOLVED
        y = np.array(found.x, dtype=np.float64) if found.x is not None else np.full(n, np.nan)
        if not (solved and np.isfinite(y).all()):
            self.osqp = None  # set up anew next time instead of starting from what was given up
        z = np.array(found.y, dtype=np.float64) if found.y is not None else np.zeros(rows + n)
        return FlatResult(y, solved, str(found.info.status), z[:rows], z[rows:])


def _full_csc(rows: Array) -> Any:
    """CSC with every entry stored, zeros too, so that later numbers always fit the pattern."""
    m, n = rows.shape
    return sparse.csc_matrix((rows.ravel(order="F"), np.tile(np.arange(m), n), m * np.arange(n + 1)), shape=(m, n))


def make(solver: str, sizes: Sizes, settings: Settings) -> OSQP:
    """A persistent OSQP."""
    return OSQP(sizes, settings)
