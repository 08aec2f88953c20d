"""The causes that hold a level back: rows of the levels above with their forces, ``multiplier * row``."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array, length
from ..hierarchy import Hierarchy, Label, Side, in_words, side_in_words
from .rows import RowStates

#: Causes with a smaller share are left out.
LEAST_SHARE = 1e-6


@dataclass(frozen=True, eq=False)
class Cause:
    """A cause that holds a level back: rows of one part on a level above.

    It is one inequality row, or all equality rows of the part, or all its rows if they have places, such as obstacles.

    Attributes
    ----------
    level : int
        The level of the rows.
    part, row : str
        Their names; several rows together have no `row`.
    side : Side
        On which side the row is active.
    rows : tuple of int
        Their numbers in the whole hierarchy.
    force : array, shape (n,)
        The force with which they push: the sum of multiplier times row.
    strength : float
        Norm of the force, in the unit of the gradient of the level that is held back.
    share : float
        The strength divided by the sum of the strengths of all causes of that level.
    where : str
        For rows that have places: the part, and at how many of its places.
    left : bool
        Whether x is not at the bound: it stopped the level, and levels below have left it. Only of damped levels.
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
    left: bool = False

    def __str__(self) -> str:
        named = bool(self.row) or self.side is not Side.EQUALITY
        told = self.where or (in_words(self.part, self.row, self.side) if named else self.part)
        return f"{told}, left by the levels below" if self.left else told

    def data(self) -> dict[str, Any]:
        """The cause as plain Python data, ready for JSON."""
        return {
            "level": self.level, "part": self.part, "row": self.row, "side": side_in_words(self.side),
            "rows": list(self.rows), "strength": self.strength, "share": self.share, "left": self.left,
        }  # fmt: skip


def causes_of(
    hierarchy: Hierarchy, labels: list[Label], rows: RowStates, dense: Array, multipliers: Array
) -> tuple[Cause, ...]:
    """The causes of one level, strongest first; causes of equal share, up to round-off, in the order of their rows.

    Parameters
    ----------
    hierarchy : Hierarchy
    labels : list of Label
        Of all rows.
    rows : RowStates
    dense : array, shape (m, n)
        All rows of the hierarchy.
    multipliers : array, shape (rows above,)
        Of the level, over all rows of the levels above it.
    """
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
    return by_share(causes)


def by_share(causes: Iterable[Cause]) -> tuple[Cause, ...]:
    """The strongest first; those of equal share, up to round-off, in the order given."""
    return tuple(sorted(causes, key=lambda cause: -round(cause.share, 6)))


def _where(hierarchy: Hierarchy, labels: list[Label], part: str, own: tuple[int, ...]) -> str:
    """The part, and at how many of its places these rows are; empty if they have no places."""
    places = {labels[row].place for row in own}
    if not all(places):
        return ""
    first, end = hierarchy.pointers[hierarchy.locate(own[0])[0] :][:2]
    known = {label.place for label in labels[first:end] if label.part == part}
    noun = f"{min(places).rstrip('0123456789 ')}s"
    return part if len(known) == 1 else f"{part}, at {len(places)} of {len(known)} {noun}"
