"""Solvers that read one number wrong: after all rows are written, and before they are solved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hqp import Hierarchy, Solution, Solver
from tasks import Controller


class Slip(NamedTuple):
    """One number of a hierarchy, and what is read in its place."""

    place: int
    by: float

    def read(self, numbers: np.ndarray) -> np.ndarray:
        """The numbers with the slip in them: an infinite one becomes finite."""
        wrong = numbers.copy()
        right = wrong[self.place]
        wrong[self.place] = right + self.by * max(abs(right), 1.0) if np.isfinite(right) else self.by
        return wrong


def slips(h: Hierarchy, rng: np.random.Generator, count: int) -> list[Slip]:
    """Some of its rows, bounds and weights, as many of each; bounds stay in order and weights positive."""
    dense, m = h.A.size, h.m
    rows, low, high, weights = (
        rng.integers(begin, end, count) if end > begin else []
        for begin, end in ((0, dense), (dense, dense + m), (dense + m, dense + 2 * m), (dense + 2 * m, dense + 3 * m))
    )
    found = [Slip(int(i), float(rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 1.0))) for i in rows]
    found += [Slip(int(i), -float(rng.uniform(0.2, 1.0))) for i in low]
    found += [Slip(int(i), float(rng.uniform(0.2, 1.0))) for i in high]
    return found + [Slip(int(i), float(rng.uniform(0.5, 3.0))) for i in weights]


class Misreader:
    """A solver of plain hierarchies that makes a slip."""

    def __init__(self, right: Callable[..., Any], slip: Slip, lasting: bool = False) -> None:
        self._right, self._slip, self._lasting = right, slip, lasting

    def __call__(self, h: Hierarchy, *others: Any) -> Any:
        given = h.numbers.copy()
        h.numbers[:] = self._slip.read(given)
        try:
            return self._right(h, *others)
        finally:
            if not self._lasting:
                h.numbers[:] = given

    solve = __call__

    def forget(self) -> None:
        """Nothing is kept."""


def in_python(controller: Controller) -> Any:
    """Have a controller that damps by curvature ask for its stages in Python; its solver of stages."""
    solver = controller._now.solver._solver  # type: ignore[union-attr]
    solver._native = False
    solver._ask_for_stages(False)
    return solver


def stage_misread(controller: Controller, state: tuple[Any, Any], k: int, slip: Slip) -> Solution:
    """What a controller answers, once it is :func:`in_python`, that misreads the stage of level k."""
    solver = in_python(controller)
    solver._solvers[k] = Misreader(Solver(settings=solver.settings).solve, slip)
    try:
        return controller(*state).solution
    finally:
        solver._solvers.clear()


def misread(solver: Solver, h: Hierarchy, slip: Slip, x_ref: np.ndarray | None = None, lasting: bool = False) -> Any:
    """What a solver answers that misreads a hierarchy."""
    solver.solve(h, x_ref)
    way = solver._way
    right = way.run, solver._backend.solve
    way.run = lambda numbers, x: Misreader(lambda _: right[0](numbers, x), slip, lasting)(h)
    solver._backend.solve = Misreader(right[1], slip, lasting)  # type: ignore[method-assign]
    try:
        return solver.solve(h, x_ref)
    finally:
        way.run, solver._backend.solve = right  # type: ignore[method-assign]
