r"""Which row stopped which level: the multipliers of the certificate, in the words of the labels.

A level k that is not met pulls at x with its gradient :math:`A_k^T D_k^2 w_k`. Where x is optimal, rows of the levels
above push back, row i with the force :math:`\lambda_i a_i`, and all forces sum to minus the gradient. These rows are
the causes: an inequality row by itself, the equality rows of one part together. Where the pulls of the level's own
rows cancel, nothing above pushes, and the level contradicts itself. Where rows depend on each other the multipliers
are not unique; those of the certificate are valid ones.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array, length
from ..hierarchy import Hierarchy, Label, Side, in_words, side_in_words
from .balance import STATIONARITY
from .certificate import Certificate
from .rows import RowStates

if TYPE_CHECKING:
    from rich.table import Table

#: Causes with less of a share are left out.
LEAST_SHARE = 1e-6
#: Causes that a line of text names.
MOST_NAMED = 3


@dataclass(frozen=True, eq=False)
class Cause:
    """What holds a level back: an inequality row of a level above, or several, if they have places, or the equality
    rows of one part there.

    Attributes
    ----------
    level : int
        Where the rows stand.
    part, row : str
        What they are called; several rows together have no `row`.
    side : Side
        On which side the row is active.
    rows : tuple of int
        Their numbers in the whole hierarchy.
    force : array, shape (n,)
        With which they push: the sum of multiplier times row.
    strength : float
        Its length, in the unit of the gradient of the level held back.
    share : float
        Of the strengths of all causes of that level.
    where : str
        Of rows that have places: at how many.
    """

    level: int
    part: str
    row: str
    side: Side
    rows: tuple[int, ...]
    force: Array
    strength: float
    share: float
    where: str = ""

    def __str__(self) -> str:
        if self.where:
            return self.where
        return in_words(self.part, self.row, self.side) if self.row or self.side is not Side.EQUALITY else self.part

    def data(self) -> dict[str, Any]:
        """Plain Python, as JSON takes it."""
        return {
            "level": self.level, "part": self.part, "row": self.row, "side": side_in_words(self.side),
            "rows": list(self.rows), "strength": self.strength, "share": self.share,
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class PartExplanation:
    """The rows of one part on one level.

    Attributes
    ----------
    part : str
    labels : tuple of Label
        Of its rows.
    missing : array
        What each row lacks: required bound minus attained value, 0 where it is satisfied within its tolerance.
    """

    part: str
    labels: tuple[Label, ...]
    missing: Array

    @property
    def met(self) -> bool:
        """Whether every row is satisfied."""
        return not self.missing.any()

    @property
    def residual(self) -> dict[str, float]:
        """Euclidean norm of what is missing, for every unit that the rows have."""
        units = [label.unit for label in self.labels]
        return {unit: length(self.missing[[own == unit for own in units]]) for unit in dict.fromkeys(units)}

    @property
    def short_by(self) -> str:
        """The residual in words, as in ``0.02 m/s and 0.1 rad/s``; empty where the part is met."""
        return " and ".join(f"{norm:.3g} {unit}".rstrip() for unit, norm in self.residual.items() if norm > 0.0)

    def __str__(self) -> str:
        return f"{self.part} met" if self.met else f"{self.part} short by {self.short_by}"

    def data(self) -> dict[str, Any]:
        """Plain Python, as JSON takes it."""
        rows = [
            {"row": label.row, "unit": label.unit, "missing": float(missing)}
            for label, missing in zip(self.labels, self.missing, strict=True)
        ]
        return {"part": self.part, "met": self.met, "residual": self.residual, "rows": rows}


@dataclass(frozen=True, eq=False)
class LevelExplanation:
    """What one level got, and what held it back.

    Attributes
    ----------
    level, name
        Index and name.
    proved : bool
        Whether the level is optimal by the certificate. If not, the causes do not explain all that is missing.
    contradicts : bool
        Whether the level is not met although nothing above pushes: its own rows contradict each other, or are zero.
    rank, fixing : int
        Directions of x which the level fixes, and by how many equality and violated rows.
    at_bound : int
        Its other rows that are at a bound.
    parts : tuple of PartExplanation
    causes : tuple of Cause
        The strongest first.
    inner : float
        What the pulls of its parts take from each other: the sum of their lengths less the length of their sum, in the
        unit of the strengths.
    damped : str
        Why the level gave way, and in which direction, where the solver chose so; empty where it did not.
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
            return f"{named}{more} met ({self._standing()})"
        causes = list(map(str, self.causes))
        if self.inner > LEAST_SHARE * sum(cause.strength for cause in self.causes):
            causes.insert(sum(cause.strength > self.inner for cause in self.causes), "each other")
        named = ", then ".join(causes[:MOST_NAMED])
        if self.damped:
            named = ", then ".join([f"damped, {self.damped}", *causes[:1]])
        more = f" and {len(causes) - MOST_NAMED} more" if len(causes) > MOST_NAMED and not self.damped else ""
        why = f"{self._own} ({self._standing()})" if self.contradicts else named + more or "nothing above"
        told = self.parts if len(self.parts) <= MOST_NAMED else tuple(part for part in self.parts if not part.met)
        return f"{', '.join(map(str, told))}: {why}" + ("" if self.proved else "; not proved optimal")

    @property
    def _own(self) -> str:
        return "its own rows contradict each other" if self.fixing > 1 else "its own row is zero"

    def _standing(self) -> str:
        if self.fixing:
            return f"rank {self.rank} of {self.fixing}"
        return f"{self.at_bound} of {self.rows} rows at a bound" if self.rows else "no rows"

    def data(self) -> dict[str, Any]:
        """Plain Python, as JSON takes it."""
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
        All but the implicit last one; none where nothing was solved.
    message : str
        That of the solution.
    """

    levels: tuple[LevelExplanation, ...]
    message: str = ""

    def __str__(self) -> str:
        return "\n".join([self.message] * bool(self.message) + [str(level) for level in self.levels])

    __repr__ = __str__

    def __rich__(self) -> Table:
        from rich.box import SIMPLE_HEAD
        from rich.table import Table
        from rich.text import Text  # as it stands: a name may look like markup

        table = Table(box=SIMPLE_HEAD, pad_edge=False, caption=Text(self.message) if self.message else None)
        for title in ("level", "part", "state", "short by", "rank", "held back by"):
            table.add_column(title)
        for level in self.levels:
            why = level._own if level.contradicts else "\n".join(f"{cause} {cause.share:.0%}" for cause in level.causes)
            rank = f"{level.rank} of {level.fixing}" if level.fixing else ""
            for number, part in enumerate(level.parts):
                first = number == 0
                state = ("met" if part.met else "short") + ("" if level.proved else ", not proved")
                cells = (
                    str(level.level) if first else "", part.part, state, part.short_by,
                    rank if first else "", why if first else "",
                )  # fmt: skip
                table.add_row(*map(Text, cells))
        return table

    def data(self) -> dict[str, Any]:
        """Plain Python, as JSON takes it."""
        return {"message": self.message, "levels": [level.data() for level in self.levels]}


def explain(
    hierarchy: Hierarchy, certificate: Certificate, rows: RowStates, ranks: Iterable[int]
) -> tuple[LevelExplanation, ...]:
    """The levels of a hierarchy, explained.

    Parameters
    ----------
    hierarchy : Hierarchy
    certificate : Certificate
        Of its solution; the multipliers are taken from here.
    rows : RowStates
        At the same x, by the same tolerance.
    ranks : iterable of int
        Of every level.
    """
    labels = [hierarchy.label_of(row) for row in range(hierarchy.m)]
    dense, missing = hierarchy.dense(), np.where(rows.violated, -rows.slack, 0.0)
    levels = []
    for k, (level, rank) in enumerate(zip(hierarchy.levels, ranks, strict=True)):
        own, judged = slice(*hierarchy.pointers[k : k + 2]), certificate.levels[k]
        contradicts = _cancels(dense[own], rows.norms[own], level.weights, missing[own], rows.tolerance[own])
        sides, fixing = rows.sides[own], (rows.sides[own] == Side.EQUALITY) | rows.violated[own]
        levels.append(
            LevelExplanation(
                level=k,
                name=level.name,
                proved=judged.ok,
                contradicts=contradicts,
                rank=rank,
                fixing=int(fixing.sum()),
                at_bound=int(((sides != Side.INACTIVE) & ~fixing).sum()),
                parts=_parts(labels[own], missing[own]),
                causes=() if contradicts else _causes(hierarchy, labels, rows, dense, judged.multipliers),
                inner=_inner(dense[own], level.weights**2 * missing[own], labels[own]),
            )
        )
    return tuple(levels)


def _cancels(A: Array, norms: Array, weights: Array, missing: Array, tolerance: Array) -> bool:
    """Whether the pulls of violated rows sum to zero, to round-off or to what their tolerances may hide."""
    force = norms * weights**2
    blur = length((force * tolerance)[missing != 0.0])
    gradient = length(A.T @ np.where(norms > 0.0, weights**2 * missing, 0.0))
    return bool(missing.any()) and gradient <= STATIONARITY * float(force @ np.abs(missing)) + blur


def _inner(A: Array, pull: Array, labels: list[Label]) -> float:
    """What the pulls of the parts of a level take from each other."""
    parts = np.array([label.part for label in labels])
    pulls = [A[parts == part].T @ pull[parts == part] for part in dict.fromkeys(parts.tolist())]
    lengths = sum(map(length, pulls))
    left = lengths - length(np.sum(pulls, axis=0)) if pulls else 0.0
    return left if left > STATIONARITY * lengths else 0.0


def _parts(labels: list[Label], missing: Array) -> tuple[PartExplanation, ...]:
    rows: dict[str, list[int]] = {}
    for row, label in enumerate(labels):
        rows.setdefault(label.part, []).append(row)
    return tuple(PartExplanation(part, tuple(labels[i] for i in own), missing[own]) for part, own in rows.items())


def _causes(
    hierarchy: Hierarchy, labels: list[Label], rows: RowStates, dense: Array, multipliers: Array
) -> tuple[Cause, ...]:
    """What pushes with these multipliers, the strongest first."""
    groups: dict[tuple[int, str, str, Side, int], list[int]] = {}
    for row in map(int, np.flatnonzero(multipliers)):
        (k, _), label, side = hierarchy.locate(row), labels[row], Side(rows.sides[row])
        low, high = float(hierarchy.lower[row]), float(hierarchy.upper[row])
        part = label.part_at(side, high if side is Side.UPPER else low)
        together = low == high and label.bound is None
        name = (k, part, "", side, -1) if together or label.place else (k, part, label.row, side, row)
        groups.setdefault(name, []).append(row)
    forces = {name: multipliers[own] @ dense[own] for name, own in groups.items()}
    total = sum(map(length, forces.values()))
    causes = [
        Cause(k, part, row, side, own, force, size, size / total, _where(hierarchy, labels, part, own))
        for name, force in forces.items()
        for size in [length(force)]
        if size >= LEAST_SHARE * total > 0.0
        for k, part, row, side, _ in [name]
        for own in [tuple(groups[name])]
    ]
    return tuple(sorted(causes, key=lambda cause: -cause.strength))


def _where(hierarchy: Hierarchy, labels: list[Label], part: str, own: tuple[int, ...]) -> str:
    """At how many of its places a part pushes with these rows; empty where they have none."""
    places = {labels[row].place for row in own}
    if not all(places):
        return ""
    first, end = hierarchy.pointers[hierarchy.locate(own[0])[0] :][:2]
    known = {label.place for label in labels[first:end] if label.part == part}
    noun = f"{min(places).rstrip('0123456789 ')}s"
    return part if len(known) == 1 else f"{part}, at {len(places)} of {len(known)} {noun}"
