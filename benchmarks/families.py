"""Problem families: a name, what it is made of, and a seeded stream of hierarchies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import cycle, islice

import numpy as np

from hqp import Hierarchy
from hqp.problems import equality_cases, random_hierarchy


@dataclass(frozen=True)
class Family:
    """One family; ``problems(count, seed)`` yields the same hierarchies for the same arguments."""

    name: str
    about: str
    inequalities: bool
    problems: Callable[[int, int], Iterator[Hierarchy]]


def _equalities(count: int, seed: int) -> Iterator[Hierarchy]:
    rng = np.random.default_rng(seed)
    for case in islice(cycle(equality_cases()), count):
        yield case.hierarchy(rng)


def _mixed(count: int, seed: int) -> Iterator[Hierarchy]:
    for k in range(count):
        yield random_hierarchy(np.random.default_rng([seed, k]))


FAMILIES = (
    Family("equalities", "the shapes and rank cases of hqp validate, in turn", False, _equalities),
    Family("mixed", "inequalities, conflicts, duplicates, weights; n 2-12, up to 6 levels", True, _mixed),
)
