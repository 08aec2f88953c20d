"""What solves a hierarchy in the race of ``python -m benchmarks solve``: a backend of ours, or DAQP called as it is.

A method hands out *calls*: functions of nothing which solve one problem and give x. What a user could have done
beforehand is done beforehand: a solver of ours is made, the arrays of DAQP are laid out.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

import numpy as np

from hqp import Hierarchy, InvalidInput, Solver, available_backends, backend_info
from hqp.arrays import Array
from hqp.backends.daqp import Rows

from .families import Family

Call = Callable[[], Array]

#: DAQP's settings at which its answers are good to 1e-8; they cost no time.
TIGHT = {"rho_soft": 1e-8, "primal_tol": 1e-9, "dual_tol": 1e-12}
#: DAQP's hierarchy with the identity level as rows, and with it as the cost ``||x - b||`` below all levels.
DAQP_ROWS, DAQP_COST = "daqp.solve/rows", "daqp.solve/cost"
#: The methods that are raced where none is named, as far as they are here.
RACED = (
    "native",
    DAQP_ROWS,
    DAQP_COST,
    "cascade:proxsuite",
    "cascade:qpsolvers/daqp",
    "cascade:qpsolvers/quadprog",
    "pseudoinverse",
)


@dataclass(frozen=True)
class Method(ABC):
    """A name, and calls that are ready to be timed."""

    name: str

    @property
    def slow(self) -> bool:
        """Whether a few draws must do."""
        return self.name.startswith("cascade:")

    @abstractmethod
    def takes(self, family: Family) -> bool:
        """Whether it can solve the problems of the family."""

    @abstractmethod
    def cold(self, problem: Hierarchy) -> Call:
        """Solve with nothing remembered but the structure."""

    @abstractmethod
    def warm(self, base: Hierarchy, problem: Hierarchy) -> Call:
        """Solve right after `base`."""


class Backend(Method):
    """A backend of ours, through :class:`hqp.Solver`."""

    def takes(self, family: Family) -> bool:
        return family.refusal(backend_info(self.name)) is None

    def cold(self, problem: Hierarchy) -> Call:
        solver = Solver(self.name)
        solver.solve(problem)
        solver.forget()
        return lambda: solver.solve(problem).x

    def warm(self, base: Hierarchy, problem: Hierarchy) -> Call:
        solver = Solver(self.name)
        solver.solve(base)
        return lambda: solver.solve(problem).x


class Daqp(Method):
    """DAQP's own hierarchy, called directly. It keeps nothing, so its every call is cold.

    Its first level is hard, which suits every family here: the first level can be met in all of them.
    """

    def takes(self, family: Family) -> bool:
        return True

    def cold(self, problem: Hierarchy) -> Call:
        f = np.zeros(problem.n)
        if self.name == DAQP_COST:
            *above, posture = problem.levels
            problem, f = Hierarchy(above, n=problem.n), -posture.lower
        solve, rows = import_module("daqp").solve, Rows.of(problem)
        given = (np.eye(problem.n), f, rows.A, rows.upper, rows.lower, rows.sense, rows.break_points)
        return lambda: solve(*given, **TIGHT)[0]

    def warm(self, base: Hierarchy, problem: Hierarchy) -> Call:
        return self.cold(problem)


def method(name: str) -> Method:
    """The method of that name: of `RACED`, or any backend.

    Raises
    ------
    InvalidInput
        If there is none of that name, or a package is missing.
    """
    if name in available_backends():
        return Backend(name)
    if name in (DAQP_ROWS, DAQP_COST):
        backend_info("daqp")  # says what to install
        return Daqp(name)
    raise InvalidInput(f"unknown method {name!r}; there are {', '.join([DAQP_ROWS, DAQP_COST, *available_backends()])}")


def raced() -> list[str]:
    """The names of `RACED` that are here."""
    here = available_backends()
    return [name for name in RACED if name in here or (name.startswith("daqp.") and "daqp" in here)]
