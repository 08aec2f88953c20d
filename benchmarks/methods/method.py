"""The measured methods: each solves a hierarchy, called as a user would call it.

A method hands out *calls*: functions of nothing which solve one problem. What a user could have done beforehand is done
beforehand: a solver of ours is made, the arrays of DAQP are laid out.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from hqp import Hierarchy
from hqp.arrays import Array

from ..families import Family
from ..settings import LOOSE, TIGHT, Setting

Call = Callable[[], Any]


class Outcome(NamedTuple):
    """The result of a call.

    Attributes
    ----------
    x : array, shape (n,)
    claimed : bool
        Whether the method itself says that x is the optimum.
    status : str
        In its own words.
    iterations : int
        Guesses and steps of the native solver, QPs of a cascade, iterations of DAQP.
    """

    x: Array
    claimed: bool
    status: str
    iterations: int


@dataclass(frozen=True)
class Method(ABC):
    """A name, and calls that are ready to be timed."""

    name: str

    @property
    def slow(self) -> bool:
        """Whether a few draws must do."""
        return False

    @property
    def settings(self) -> tuple[Setting, ...]:
        """The settings that make a difference to it."""
        return TIGHT, LOOSE

    @property
    @abstractmethod
    def about(self) -> str:
        """What it is, in one line."""

    @abstractmethod
    def missing(self) -> str:
        """Why it cannot run here; empty if it can."""

    @abstractmethod
    def refusal(self, family: Family) -> str:
        """Why it does not take part in the family; empty if it does."""

    @abstractmethod
    def cold(self, problem: Hierarchy, setting: Setting = TIGHT) -> Call:
        """Solve without a warm start; only the structure is known."""

    def one_shot(self, problem: Hierarchy, setting: Setting = TIGHT) -> Call:
        """Solve a problem that nothing was prepared for, as :func:`hqp.solve` does; `cold` where there is no other."""
        return self.cold(problem, setting)

    @abstractmethod
    def warm(self, before: Hierarchy, now: Hierarchy, setting: Setting = TIGHT) -> Call:
        """Solve `now` right after `before`."""

    @abstractmethod
    def outcome(self, answer: Any) -> Outcome:
        """What a call returned."""
