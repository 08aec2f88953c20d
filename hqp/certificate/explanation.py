"""The explanation of an answer: how far each level is met and which rows hold it back, as text, table or JSON data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .causes import LEAST_SHARE, Cause
from .parts import PartExplanation

if TYPE_CHECKING:
    from rich.table import Table

#: The most causes, or parts, that a line of text names.
MOST_NAMED = 3


@dataclass(frozen=True, eq=False)
class LevelExplanation:
    """How far one level is met, and what held it back.

    Attributes
    ----------
    level, name
        Number and name.
    proved : bool
        Whether the certificate accepts the level. If not, the causes do not explain all that is missing.
    contradicts : bool
        Whether the level is not met although no row above holds it back: its own rows contradict each other, or are
        zero.
    rank, fixing : int
        How many directions of x the level fixes, and how many equality and violated rows fix them.
    at_bound : int
        How many of its other rows are at a bound.
    parts : tuple of PartExplanation
    causes : tuple of Cause
        The strongest first.
    inner : float
        How far the forces of its parts cancel each other: the sum of their norms less the norm of their sum, in the
        unit of the strengths.
    damped : str
        Why the solver relaxed the level, and in which direction; empty if it did not.
    zero : bool
        Whether all rows that are not met are zero: nothing in x moves them.
    unmoved : str
        Of a damped level, the direction in which most is missing, if nothing in x moves it there; else empty.
    """

    level: int
    name: str
    proved: bool
    contradicts: bool
    rank: int
    fixing: int
    at_bound: int
    parts: tuple[PartExplanation, ...]
    causes: tuple[Cause, ...]
    inner: float
    damped: str = ""
    zero: bool = False
    unmoved: str = ""

    @property
    def rows(self) -> int:
        """How many rows the level has."""
        return sum(len(part.labels) for part in self.parts)

    @property
    def met(self) -> bool:
        """Whether every row is satisfied within its tolerance."""
        return all(part.met for part in self.parts)

    def __str__(self) -> str:
        if self.met:
            parts = [part.part for part in self.parts] or [self.name or f"level {self.level}"]
            named = " and ".join(parts[:MOST_NAMED])
            more = f" and {len(parts) - MOST_NAMED} more" if len(parts) > MOST_NAMED else ""
            return f"{self._beside()}{named}{more} met ({self._standing()})"
        causes = list(map(str, self.causes))
        if self.inner > LEAST_SHARE * sum(cause.strength for cause in self.causes):
            causes.insert(sum(cause.strength > self.inner for cause in self.causes), "each other")
        named = ", then ".join(causes[:MOST_NAMED])
        if self.damped:
            named = ", then ".join([f"damped, {self.damped}", *causes[:1]])
        more = f" and {len(causes) - MOST_NAMED} more" if len(causes) > MOST_NAMED and not self.damped else ""
        why = f"{self.own} ({self._standing()})" if self.contradicts else named + more or "nothing above"
        told = self.parts if len(self.parts) <= MOST_NAMED else tuple(part for part in self.parts if not part.met)
        short = f"{self._beside()}{', '.join(map(str, told))}"
        return f"{short}: {why}" + ("" if self.proved else "; not proved optimal")

    def _beside(self) -> str:
        """The name of the level and a colon; empty if it has none, or one like the name of a part."""
        alike = (part.part in self.name or self.name in part.part for part in self.parts)
        known = not self.name or not self.parts or any(alike)
        return "" if known else f"{self.name}: "

    @property
    def own(self) -> str:
        """Why a level that contradicts itself is not met."""
        if self.unmoved:
            return f"nothing moves it in this direction ({self.unmoved})"
        lacking = [pair for part in self.parts for pair in zip(part.labels, part.missing, strict=True) if pair[1]]
        rows = [label.row or label.part for label, _ in lacking]
        if self.zero and len(rows) < self.fixing and len(rows) <= MOST_NAMED:
            return f"of its own rows {' and '.join(rows)} {'are' if len(rows) > 1 else 'is'} zero"
        if self.fixing <= 1:
            return "its own row is zero"
        return "its own rows are zero" if self.zero else "its own rows contradict each other"

    def _standing(self) -> str:
        if self.fixing:
            return f"rank {self.rank} of {self.fixing}"
        return f"{self.at_bound} of {self.rows} rows at a bound" if self.rows else "no rows"

    def data(self) -> dict[str, Any]:
        """The explanation as plain Python data, ready for JSON."""
        return {
            "level": self.level, "name": self.name, "met": self.met, "proved": self.proved,
            "contradicts": self.contradicts, "rank": self.rank, "fixing": self.fixing, "at_bound": self.at_bound,
            "parts": [part.data() for part in self.parts], "causes": [cause.data() for cause in self.causes],
            "inner": self.inner, "damped": self.damped,
        }  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Explanation:
    """Which row stopped which level; ``print`` it, or let rich do so, as a table.

    Attributes
    ----------
    levels : tuple of LevelExplanation
        All levels but the implicit last one; empty if nothing was solved.
    message : str
        The message of the solution.
    """

    levels: tuple[LevelExplanation, ...]
    message: str = ""

    def __str__(self) -> str:
        return "\n".join([self.message] * bool(self.message) + [str(level) for level in self.levels])

    __repr__ = __str__

    def __rich__(self) -> Table:
        from rich.box import SIMPLE_HEAD
        from rich.table import Table
        from rich.text import Text  # not plain strings: a name may look like markup

        table = Table(box=SIMPLE_HEAD, pad_edge=False, caption=Text(self.message) if self.message else None)
        for title in ("level", "part", "state", "short by", "rank", "held back by"):
            table.add_column(title)
        for level in self.levels:
            why = level.own if level.contradicts else "\n".join(f"{cause} {cause.share:.0%}" for cause in level.causes)
            rank = f"{level.rank} of {level.fixing}" if level.fixing else ""
            for number, part in enumerate(level.parts):
                first = number == 0
                state = ("met" if part.met else "short") + ("" if level.proved else ", not proved")
                cells = (
                    str(level.level) if first else "", part.part, state, part.lacking,
                    rank if first else "", why if first else "",
                )  # fmt: skip
                table.add_row(*map(Text, cells))
        return table

    def data(self) -> dict[str, Any]:
        """The explanation as plain Python data, ready for JSON."""
        return {"message": self.message, "levels": [level.data() for level in self.levels]}
