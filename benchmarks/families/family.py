"""A problem family: a name, what it is made of, and one problem for every seed and number."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hqp import Hierarchy

#: By what share of their standard deviation targets move between two ticks, where nothing else tells.
TICK = 0.02


class Sample(NamedTuple):
    """One problem, `now`, and the one of the same shape that a control loop has solved just before it."""

    before: Hierarchy
    now: Hierarchy


@dataclass(frozen=True)
class Family:
    """One family.

    Attributes
    ----------
    group, name : str
        Together the `key`, as in ``control/P2``.
    about : str
        What the problems are made of, in one line.
    sample : callable
        The problem of a seed and a number: ``sample(seed, draw)``, the same for the same arguments.
    inequalities : bool
        Whether some row has a bound on one side only, or two different ones.
    feasible : bool
        Whether the first level can be met in all of them.
    posture : bool
        Whether the last level asks for one x, as an equality on each variable alone.
    draws : int, optional
        How many there are; by default without end. Where there is an end, all seeds have the same ones.
    curve : str
        The growth curve on which it is a point: along ``n``, ``levels`` or ``rows``; empty for none.
    at : int
        Where on that curve.
    needs : str
        The package without which there are no problems, if any beyond the core.
    """

    group: str
    name: str
    about: str
    sample: Callable[[int, int], Sample]
    inequalities: bool = True
    feasible: bool = False
    posture: bool = False
    draws: int | None = None
    curve: str = ""
    at: int = 0
    needs: str = ""

    @property
    def key(self) -> str:
        """Group and name."""
        return f"{self.group}/{self.name}"

    def problems(self, count: int, seed: int) -> Iterator[Hierarchy]:
        """The first `count` problems of a seed."""
        return (self.sample(seed, draw).now for draw in range(count))


def moved(hierarchy: Hierarchy, rng: np.random.Generator, share: float) -> Hierarchy:
    """A copy whose equality targets b have moved by ``share * std(b) * N(0, 1)``, level by level; the rest stays."""
    twin = hierarchy.copy()
    for level in twin.levels:
        equal = level.lower == level.upper
        if equal.any():
            b = level.lower[equal]
            level.lower[equal] = level.upper[equal] = b + share * b.std() * rng.standard_normal(len(b))
    return twin


def drawn(make: Callable[[np.random.Generator], Hierarchy]) -> Callable[[int, int], Sample]:
    """The `sample` of a family whose problems are drawn one by one, each after one with moved targets."""

    def sample(seed: int, draw: int) -> Sample:
        now = make(np.random.default_rng([seed, draw]))
        return Sample(moved(now, np.random.default_rng([seed, draw, 1]), TICK), now)

    return sample
