"""Every solver that qpsolvers finds installed. Set up anew and cold each time: qpsolvers keeps
no problem between calls, and a primal guess without its duals makes some solvers miss their tolerance."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import qpsolvers

from ..arrays import Array
from ..errors import MissingPackage
from ..settings import Settings
from .problem import FlatQP, FlatResult, Sizes

#: For a QP without constraints, qpsolvers answers by LSQR *instead of* these solvers' own method unless told
#: otherwise; the row 0 y <= 1 tells it otherwise. The solvers not listed here get that row.
_SOLVE_UNCONSTRAINED = {"daqp", "osqp", "piqp", "proxqp", "quadprog"}


def options(solver: str, settings: Settings) -> dict[str, Any]:
    """The settings in the solver's own words."""
    eps, iterations = settings.qp_tolerance, settings.qp_iterations
    known: dict[str, dict[str, Any]] = {
        "proxqp": {"eps_abs": eps, "eps_rel": 0.0, "max_iter": iterations}
        | {"check_duality_gap": True, "eps_duality_gap_abs": eps, "eps_duality_gap_rel": 0.0},
        "osqp": {"eps_abs": max(eps, 1e-8), "eps_rel": 0.0, "max_iter": iterations, "raise_error": False}
        # Every level has a point that is feasible and bounded below: a verdict to the contrary would be round-off.
        | {"eps_prim_inf": 1e-30, "eps_dual_inf": 1e-30},
        "daqp": {"primal_tol": eps, "dual_tol": eps, "iter_limit": iterations},
        "clarabel": {"tol_gap_abs": eps, "tol_gap_rel": eps, "tol_feas": eps},
        "piqp": {"eps_abs": eps, "eps_rel": eps},
        "scs": {"eps_abs": eps, "eps_rel": 0.0, "max_iters": 10 * iterations},
    }
    return known.get(solver, {})


class QPSolvers:
    """One solver of qpsolvers under the protocol of this package."""

    def __init__(self, solver: str, settings: Settings) -> None:
        if solver not in qpsolvers.available_solvers:
            raise MissingPackage(f"qpsolvers finds {', '.join(qpsolvers.available_solvers)} here, but not {solver!r}")
        self.solver = solver
        self.options = options(solver, settings)
        self.qp: FlatQP | None = None

    def solve(self, qp: FlatQP) -> FlatResult:
        self.qp = qp
        n = len(qp.g)
        C, lower, upper, lb, ub = qp.C, qp.lower, qp.upper, qp.box_lower, qp.box_upper
        if lb is not None and ub is not None and not np.isfinite([lb, ub]).all():
            # Not every solver knows infinite bounds; rows can leave a side out.
            C, lower, upper = np.concatenate([C, np.eye(n)]), np.concatenate([lower, lb]), np.concatenate([upper, ub])
            lb = ub = None
        above, below = np.flatnonzero(upper < np.inf), np.flatnonzero(lower > -np.inf)
        G = np.concatenate([C[above], -C[below]])
        h = np.concatenate([upper[above], -lower[below]])
        if not len(h) and lb is None and self.solver not in _SOLVE_UNCONSTRAINED:
            G, h = np.zeros((1, n)), np.ones(1)
        found, message = self._run(
            qpsolvers.Problem(qp.H, qp.g, G if len(h) else None, h if len(h) else None, lb=lb, ub=ub)
        )
        if found is None or found.x is None:
            return FlatResult(np.full(n, np.nan), False, message, np.zeros(len(qp.lower)), np.zeros(n))

        duals = np.zeros(len(lower))
        if found.z is not None and len(found.z) >= len(above) + len(below):
            np.add.at(duals, above, found.z[: len(above)])
            np.subtract.at(duals, below, found.z[len(above) : len(above) + len(below)])
        row_duals, box_duals = duals[: len(qp.lower)], duals[len(qp.lower) :]
        if not len(box_duals):
            given = found.z_box is not None and len(found.z_box) == n
            box_duals = np.asarray(found.z_box, dtype=np.float64) if given else np.zeros(n)
        return FlatResult(np.asarray(found.x, dtype=np.float64), bool(found.found), message, row_duals, box_duals)

    def _run(self, problem: qpsolvers.Problem) -> tuple[qpsolvers.Solution | None, str]:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            try:
                found = qpsolvers.solve_problem(problem, self.solver, **self.options)
            except (qpsolvers.exceptions.QPError, ValueError, ArithmeticError) as error:
                return None, f"{type(error).__name__}: {error}"
        message = "; ".join(str(warning.message) for warning in said if "csc_matrix" not in str(warning.message))
        return found, message or ("solved" if found.found else "not solved")

    def move(self, g: Array) -> FlatResult:
        if self.qp is None:
            raise RuntimeError("move before solve")
        return self.solve(replace(self.qp, g=g))


def make(solver: str, sizes: Sizes, settings: Settings) -> QPSolvers:
    """The named solver of qpsolvers."""
    return QPSolvers(solver, settings)
