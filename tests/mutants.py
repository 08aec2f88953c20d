"""Wrong solvers, each for one reason and above some number of unknowns only: mutations of a backend's public solve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

import numpy as np
import pytest

from hqp import Hierarchy, Level, Settings, Solver
from hqp.backends.base import Answer, Backend
from hqp.backends.registry import make_backend

#: Where solvers get their backends from.
SOLVE = import_module("hqp.solver.solver")
#: From the levels and x_ref to those that are solved in their place.
Misread = Callable[[list[Level], np.ndarray], tuple[list[Level], np.ndarray]]


@dataclass(frozen=True)
class Mutation:
    """A wrong solver: right up to n = `above`."""

    name: str
    above: int
    misread: Misread | None = None
    noise: float = 0.0


class Mutant:
    """A backend, but for what a mutation does to it."""

    def __init__(self, name: str, mutation: Mutation, settings: Settings) -> None:
        self.right, self.mutation = Solver(name, settings), mutation
        self.rng = np.random.default_rng(0)

    def solve(self, hierarchy: Hierarchy, x_ref: np.ndarray) -> Answer:
        n, mutation = hierarchy.n, self.mutation
        if n > mutation.above and mutation.misread is not None:
            levels, x_ref = mutation.misread(dense(hierarchy), x_ref)
            hierarchy = Hierarchy(levels, n=n)
        found = self.right.solve(hierarchy, x_ref)
        x = found.x
        if n > mutation.above and mutation.noise:
            direction = self.rng.standard_normal(n)
            x = x + mutation.noise * np.linalg.norm(x) * direction / np.linalg.norm(direction)
        return Answer(x, found.status, found.message, found.level, found.counts)

    def reset(self) -> None:
        self.right.forget()


def mutate(monkeypatch: pytest.MonkeyPatch, name: str, mutation: Mutation) -> None:
    """Put the mutant in the place of the backend, for every solver that is made from now on."""

    def make(asked: str, settings: Settings) -> Backend:
        if asked != name:
            return make_backend(asked, settings)
        with monkeypatch.context() as inside:  # the one that it stands on is right
            inside.setattr(SOLVE, "make_backend", make_backend)
            return Mutant(name, mutation, settings)

    monkeypatch.setattr(SOLVE, "make_backend", make)


def dense(hierarchy: Hierarchy) -> list[Level]:
    """Its levels, plain bounds as rows."""
    return [like(level, hierarchy.matrix(k)) for k, level in enumerate(hierarchy.levels)]


def like(level: Level, A: np.ndarray, **changed: np.ndarray) -> Level:
    """The level with other rows, bounds or weights."""
    kept = {"lower": level.lower, "upper": level.upper, "weights": level.weights} | changed
    return Level(A, kept["lower"], kept["upper"], weights=kept["weights"])


def some(level: Level, rows: np.ndarray) -> Level:
    """Some of its rows."""
    return Level(level.A[rows], level.lower[rows], level.upper[rows], weights=level.weights[rows])


def equal(level: Level) -> np.ndarray:
    return level.lower == level.upper


def joined(first: Level, second: Level) -> Level:
    parts = (np.concatenate([getattr(level, name) for level in (first, second)]) for name in ("A", "lower", "upper"))
    return Level(*parts, weights=np.concatenate([first.weights, second.weights]))


def each(change: Callable[[Level], Level]) -> Misread:
    """The same misreading of every level."""
    return lambda levels, x_ref: ([change(level) for level in levels], x_ref)


def by_weight(levels: list[Level], x_ref: np.ndarray) -> tuple[list[Level], np.ndarray]:
    """Rows above the median weight of their level on a level of their own, above the others."""
    parts = []
    for level in levels:
        heavy = level.weights > np.median(level.weights) if len(level) else np.zeros(0, dtype=bool)
        parts += [some(level, heavy), some(level, ~heavy)]
    return parts, x_ref


def unit_rows(level: Level) -> Level:
    """Rows of norm > 1 divided by it, as DAQP does with all."""
    scale = np.maximum(np.linalg.norm(level.A, axis=1), 1.0)
    return like(level, level.A / scale[:, None], lower=level.lower / scale, upper=level.upper / scale)


def below_the_top(levels: list[Level], x_ref: np.ndarray) -> tuple[list[Level], np.ndarray]:
    return [*levels[:1], *(some(level, equal(level)) for level in levels[1:])], x_ref


MUTATIONS = (
    Mutation("drops the second level", 3, lambda levels, x_ref: ([*levels[:1], *levels[2:]], x_ref)),
    Mutation("swaps the first two levels", 7, lambda levels, x_ref: ([*levels[:2][::-1], *levels[2:]], x_ref)),
    Mutation(
        "merges the first two levels",
        7,
        lambda levels, x_ref: ([joined(*levels[:2]), *levels[2:]] if len(levels) > 1 else levels, x_ref),
    ),
    Mutation("ignores weights", 3, each(lambda level: like(level, level.A, weights=np.ones(len(level))))),
    Mutation("squares weights", 10, each(lambda level: like(level, level.A, weights=level.weights**2))),
    Mutation("takes weights for priorities", 7, by_weight),
    Mutation(
        "ignores lower bounds",
        7,
        each(lambda level: like(level, level.A, lower=np.where(equal(level), level.lower, -np.inf))),
    ),
    Mutation(
        "ignores upper bounds",
        10,
        each(lambda level: like(level, level.A, upper=np.where(equal(level), level.upper, np.inf))),
    ),
    Mutation("ignores x_ref", 0, lambda levels, x_ref: (levels, np.zeros_like(x_ref))),
    Mutation("ignores x_ref above n = 10", 10, lambda levels, x_ref: (levels, np.zeros_like(x_ref))),
    Mutation("ignores inequalities below the top", 6, below_the_top),
    Mutation("drops rows of norm > 1", 7, each(lambda level: some(level, np.linalg.norm(level.A, axis=1) <= 1.0))),
    Mutation("takes rows of norm > 1 for rows of norm 1", 15, each(unit_rows)),
    Mutation("ignores levels deeper than 4", 7, lambda levels, x_ref: (levels[:4], x_ref)),
    Mutation("stops one level early", 10, lambda levels, x_ref: (levels[:-1], x_ref)),
    Mutation("takes inequalities for equalities", 7, each(lambda level: like(
        level, level.A, lower=np.where(np.isfinite(level.lower), level.lower, level.upper),
        upper=np.where(np.isfinite(level.lower), level.lower, level.upper),
    ))),
    Mutation("is off by 1e-4", 15, noise=1e-4),
    Mutation("is off by 5e-7", 7, noise=5e-7),
)  # fmt: skip
