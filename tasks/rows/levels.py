"""The levels that are solved: their parts in order of priority, and how each level is damped."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, NamedTuple, TypeAlias

from hqp import DampingRule

from .row_writer import RowWriter

#: How a level is damped: by a rule of its own, never (False), or as the controller does by default (None).
Rule: TypeAlias = "DampingRule | Literal[False] | None"


class Levels(NamedTuple):
    """The parts of every level and its damping, the highest level first.

    Attributes
    ----------
    parts : tuple of tuples of RowWriter
        Of each level.
    damping : tuple of DampingRule, False or None
        Of each level.
    """

    parts: tuple[tuple[RowWriter, ...], ...]
    damping: tuple[Rule, ...]

    @property
    def all_parts(self) -> Iterator[RowWriter]:
        """All parts, from the highest level down."""
        return (part for level in self.parts for part in level)

    @property
    def damps(self) -> bool:
        """Whether there is damping: a level with a rule, or rows of damping beside a task."""
        beside = any(part.damps and len(level) > 1 for level in self.parts for part in level)
        return beside or any(self.damping)
