"""The table that ``controller.describe()`` prints: which loop writes the rows of each part, or why Python does."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hqp import Label

from .plan import Plan

if TYPE_CHECKING:
    from ..base.loops import Call

#: Up to so many rows all names are shown; of more, the first and the last.
FEW = 4
TITLES = ("level", "part", "rows", "written by")


@dataclass(frozen=True)
class WrittenPart:
    """The rows of one part, and the loop or Python function that writes them every tick.

    Attributes
    ----------
    level : int
        0 is the highest.
    part : str
        Its name in messages.
    rows : tuple of hqp.Label
    loops : tuple of str
        The compiled loops, by name, in the order in which they run. None where Python writes all, or where the part
        says nothing at this order.
    python : bool
        Whether Python writes something, before the loops: it costs some ten microseconds a tick.
    why : str
        Why Python does.
    """

    level: int
    part: str
    rows: tuple[Label, ...]
    loops: tuple[str, ...]
    python: bool = False
    why: str = ""

    @classmethod
    def of(
        cls,
        level: int,
        part: str,
        rows: tuple[Label, ...],
        plan: Plan,
        shared: tuple[str, ...],
        before: Sequence[Call] = (),
    ) -> WrittenPart:
        """From the plan of a part, the loops that write rows of several parts, and those of it that run before all."""
        loops = tuple(call.kernel.__name__ for call in (*before, *plan.calls))
        return cls(level, part, rows, loops + shared, plan.python is not None, plan.why)

    @property
    def writer(self) -> str:
        """Who writes the rows, in words."""
        if not self.python:
            return ", ".join(self.loops) or "nobody: no bounds at this order"
        return f"{', '.join(['Python', *self.loops])}: {self.why}"


@dataclass(frozen=True)
class Description:
    """The loops that write each part of a stack; ``print`` it as a table, or iterate over the parts.

    Attributes
    ----------
    parts : tuple of WrittenPart
        From the highest level down.
    """

    parts: tuple[WrittenPart, ...]

    def __iter__(self) -> Iterator[WrittenPart]:
        return iter(self.parts)

    def __len__(self) -> int:
        return len(self.parts)

    @property
    def in_python(self) -> tuple[WrittenPart, ...]:
        """The parts of which Python writes something."""
        return tuple(part for part in self.parts if part.python)

    def __str__(self) -> str:
        lines = [TITLES, *((str(part.level), part.part, _named(part.rows), part.writer) for part in self.parts)]
        widths = [max(len(line[column]) for line in lines) for column in range(len(TITLES))]
        padded = ("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) for line in lines)
        return "\n".join(line.rstrip() for line in padded)

    __repr__ = __str__


def _named(rows: tuple[Label, ...]) -> str:
    names = [label.row for label in rows]
    return ", ".join(names) if len(names) <= FEW else f"{names[0]} .. {names[-1]} ({len(names)})"
