"""A plan of a sweep, families x methods x settings, and its cells."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
from importlib.util import find_spec

from hqp import InvalidInput

from ..families import FAMILIES, Family
from ..methods import METHODS, Method
from ..registry import select
from ..settings import SETTINGS, Setting

#: How often a slow method is repeated, at the most.
SLOW_ROUNDS = 2


@dataclass(frozen=True)
class Cell:
    """What is measured without a pause, and kept or lost as a whole: some draws of one family by all methods."""

    family: str
    first: int
    last: int

    @property
    def name(self) -> str:
        """As a file is called."""
        return f"{re.sub(r'[^a-z0-9]+', '-', self.family.lower())}-{self.first:04d}"


@dataclass(frozen=True)
class Plan:
    """Families x methods x settings, and how much of each.

    Attributes
    ----------
    name, about : str
    families, methods, settings : tuple of str
        Their keys and names; in a plan that is not yet resolved, patterns of them.
    draws, few : int
        Problems of each family, and how many of them a slow method gets at the most, spread over all.
    block : int
        Draws of a cell.
    rounds : int
        How often everything is repeated; the shortest counts. Slow methods have `SLOW_ROUNDS`.
    seed : int
    """

    name: str
    about: str
    families: tuple[str, ...] = ("*",)
    methods: tuple[str, ...] = ("*",)
    settings: tuple[str, ...] = ("tight",)
    draws: int = 64
    few: int = 8
    block: int = 16
    rounds: int = 3
    seed: int = 0

    @property
    def digest(self) -> str:
        """What tells this plan from all others."""
        return sha256(repr(sorted(asdict(self).items())).encode()).hexdigest()[:16]

    def resolved(self) -> tuple[Plan, list[str]]:
        """The same with keys and names in place of patterns: what can run here; and why the rest is left out.

        Raises
        ------
        InvalidInput
            If a pattern matches nothing, or nothing is left.
        """
        left_out = []
        families, methods = [], []
        for family in select(self.families, FAMILIES, "family"):
            if family.needs and find_spec(family.needs) is None:
                left_out.append(f"{family.key}: the package {family.needs!r} is not installed")
            else:
                families.append(family.key)
        for method in select(self.methods, METHODS, "method"):
            if why := method.missing():
                left_out.append(f"{method.name}: {why}")
            else:
                methods.append(method.name)
        settings = tuple(setting.name for setting in select(self.settings, SETTINGS, "setting"))
        plan = replace(self, families=tuple(families), methods=tuple(methods), settings=settings)
        if not any(plan.entrants(FAMILIES[key]) for key in families):
            raise InvalidInput(f"nothing to measure; {'; '.join(left_out) or 'no method takes one of these families'}")
        return plan, left_out

    def entrants(self, family: Family) -> list[tuple[Method, Setting]]:
        """Who takes part in a family."""
        return [
            (method, setting)
            for method in map(METHODS.__getitem__, self.methods)
            if not method.refusal(family)
            for setting in method.settings
            if setting.name in self.settings
        ]

    def cells(self) -> list[Cell]:
        """All cells in which somebody takes part: first those of all families' first draws, so that a look is early."""
        cells = []
        for key in self.families:
            family = FAMILIES[key]
            draws = min(self.draws, family.draws or self.draws)
            if self.entrants(family):
                cells += [Cell(key, k, min(k + self.block, draws)) for k in range(0, draws, self.block)]
        return sorted(cells, key=lambda cell: cell.first)

    def rounds_of(self, method: Method, draw: int) -> int:
        """How often a method is to solve this draw."""
        if not method.slow:
            return self.rounds
        return min(SLOW_ROUNDS, self.rounds) if draw % -(-self.draws // self.few) == 0 else 0
