"""Problem families: a name, what it is made of, and a seeded stream of hierarchies."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from itertools import cycle, islice

import numpy as np

from hqp import BackendInfo, Hierarchy, InvalidInput
from hqp.families import FAMILIES as ADVERSARIES
from hqp.families import hierarchies
from hqp.problems import equality_cases, random_hierarchy


@dataclass(frozen=True)
class Family:
    """One family; ``problems(count, seed)`` yields the same hierarchies for the same arguments."""

    name: str
    about: str
    inequalities: bool
    problems: Callable[[int, int], Iterator[Hierarchy]]

    def refusal(self, info: BackendInfo) -> str | None:
        """Why this backend has no part in the family, or None."""
        if not info.lexicographic:
            return f"{info.name} aims at the optimum of another hierarchy"
        if self.inequalities and not info.inequalities:
            return f"{info.name} takes no inequalities"
        return None

    def left_out(self, infos: Iterable[BackendInfo]) -> str | None:
        """Why none of these backends has a part in the family, or None if one has."""
        refusals = [self.refusal(info) for info in infos]
        return None if None in refusals else f"{self.name}: left out, {', '.join(filter(None, refusals))}"


def select(names: Collection[str] | None, families: Iterable[Family]) -> list[Family]:
    """Those of these names, in their own order; all of them where none is named."""
    among = {family.name: family for family in families}
    for name in names or ():
        if name not in among:
            raise InvalidInput(f"unknown family {name!r}; there are {', '.join(among)}")
    return [family for name, family in among.items() if not names or name in names]


def _equalities(count: int, seed: int) -> Iterator[Hierarchy]:
    rng = np.random.default_rng(seed)
    for case in islice(cycle(equality_cases()), count):
        yield case.hierarchy(rng)


def _mixed(count: int, seed: int) -> Iterator[Hierarchy]:
    for k in range(count):
        yield random_hierarchy(np.random.default_rng([seed, k]))


def _adversarial(count: int, seed: int) -> Iterator[Hierarchy]:
    streams = [hierarchies(name, count, seed) for name, family in ADVERSARIES.items() if family.expect == "certified"]
    for _, stream in zip(range(count), cycle(streams), strict=False):
        yield next(stream)


FAMILIES = (
    Family("equalities", "the shapes and rank cases of hqp validate, in turn", False, _equalities),
    Family("mixed", "inequalities, conflicts, duplicates, weights; n 2-12, up to 6 levels", True, _mixed),
    Family(
        "adversarial",
        "what breaks solvers and can be certified, the families of hqp.families in turn",
        True,
        _adversarial,
    ),
)
