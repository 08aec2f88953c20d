"""The solvers of weighted QPs, called directly: whatever the wrapper around them would cost is left out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from importlib import import_module
from typing import Any

import numpy as np

from hqp.arrays import Array
from hqp.backends.daqp import EQUALITY

from .weighted import WeightedQP


class QPSolver(ABC):
    """Laid out by :meth:`given`, asked by :meth:`solve`: what is timed apart.

    Raises
    ------
    NoAnswer
        By :meth:`solve`, where the solver has none.
    """

    name: str

    @abstractmethod
    def given(self, qp: WeightedQP) -> Any:
        """The QP as the solver takes it."""

    @abstractmethod
    def solve(self, given: Any) -> Array:
        """The optimum."""


class NoAnswer(Exception):
    """A solver does not claim to have found the optimum."""


class ProxQP(QPSolver):
    """ProxQP's dense interface with its own settings, warm; one problem is kept for each set of equalities."""

    name = "proxqp"

    def __init__(self) -> None:
        self.proxqp: Any = import_module("proxsuite").proxqp
        self.kept: dict[bytes, Any] = {}

    def given(self, qp: WeightedQP) -> Any:
        equal = qp.equal
        other = ~equal & (np.isfinite(qp.lower) | np.isfinite(qp.upper))
        key = np.stack([equal, other]).tobytes()
        told = (qp.H, qp.g, qp.C[equal], qp.lower[equal], qp.C[other], qp.lower[other], qp.upper[other])
        return key, (*told, qp.low, qp.high)

    def solve(self, given: Any) -> Array:
        key, told = given
        problem = self.kept.pop(key, None)
        if problem is None:
            problem = self.proxqp.dense.QP(len(told[1]), len(told[3]), len(told[5]), True)
            problem.init(*told)
        else:
            problem.settings.initial_guess = self.proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
            problem.update(*told)
        problem.solve()
        if problem.results.info.status != self.proxqp.PROXQP_SOLVED:
            raise NoAnswer(problem.results.info.status.name)  # from where no other solve begins
        self.kept[key] = problem
        return np.array(problem.results.x)


class Quadprog(QPSolver):
    """quadprog, the method of Goldfarb and Idnani, of which TSID has a version of its own; every call is cold."""

    name = "quadprog"

    def __init__(self) -> None:
        self.call = import_module("quadprog").solve_qp

    def given(self, qp: WeightedQP) -> Any:
        equal, fixed, unit = qp.equal, qp.low == qp.high, np.eye(len(qp.g))
        below, above = (~equal & np.isfinite(bound) for bound in (qp.lower, qp.upper))
        low, high = (~fixed & np.isfinite(bound) for bound in (qp.low, qp.high))
        rows = np.concatenate([qp.C[equal], unit[fixed], qp.C[below], -qp.C[above], unit[low], -unit[high]])
        ends = [qp.lower[equal], qp.low[fixed], qp.lower[below], -qp.upper[above], qp.low[low], -qp.high[high]]
        return qp.H, -qp.g, rows.T, np.concatenate(ends), int(equal.sum() + fixed.sum())

    def solve(self, given: Any) -> Array:
        return np.asarray(self.call(*given)[0])


class DAQP(QPSolver):
    """DAQP's flat QP; every call is cold."""

    name = "daqp"

    def __init__(self) -> None:
        self.call = import_module("daqp").solve

    def given(self, qp: WeightedQP) -> Any:
        says = np.isfinite(qp.lower) | np.isfinite(qp.upper)
        upper, lower = np.concatenate([qp.high, qp.upper[says]]), np.concatenate([qp.low, qp.lower[says]])
        return qp.H, qp.g, qp.C[says], upper, lower, np.where(lower == upper, EQUALITY, 0).astype(np.intc)

    def solve(self, given: Any) -> Array:
        x, _, flag, _ = self.call(*given)
        if flag <= 0:
            raise NoAnswer(f"exit flag {flag}")
        return np.asarray(x)


#: Package -> solver.
SOLVERS: dict[str, type[QPSolver]] = {"proxsuite": ProxQP, "quadprog": Quadprog, "daqp": DAQP}
