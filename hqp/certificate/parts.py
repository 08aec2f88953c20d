"""What the rows of one part on one level lack, in their units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array, length
from ..hierarchy import Label


@dataclass(frozen=True, eq=False)
class PartExplanation:
    """The rows of one part on one level.

    Attributes
    ----------
    part : str
    labels : tuple of Label
        Labels of its rows.
    missing : array, shape (rows,)
        What each row lacks: required bound minus attained value, in the unit of the row, without its weight; 0 where
        it is satisfied within its tolerance.
    weights : array, shape (rows,)
        Weights of the rows.
    """

    part: str
    labels: tuple[Label, ...]
    missing: Array
    weights: Array

    @property
    def met(self) -> bool:
        """Whether every row is satisfied within its tolerance."""
        return not self.missing.any()

    @property
    def residual(self) -> dict[str, float]:
        """Unit -> Euclidean norm of what the rows of that unit lack."""
        units = [label.unit for label in self.labels]
        return {unit: length(self.missing[[own == unit for own in units]]) for unit in dict.fromkeys(units)}

    @property
    def short_by(self) -> str:
        """The residual in words, as in ``0.02 m/s and 0.1 rad/s``; empty if the part is met."""
        return " and ".join(f"{norm:.3g} {unit}".rstrip() for unit, norm in self.residual.items() if norm > 0.0)

    @property
    def weighed(self) -> str:
        """The weights in words, as in ``(weight 0.01)``; empty if all are 1."""
        least, most = float(self.weights.min(initial=np.inf)), float(self.weights.max(initial=-np.inf))
        if not len(self.weights) or least == most == 1.0:
            return ""
        return f"(weight {least:.3g})" if least == most else f"(weights {least:.3g} to {most:.3g})"

    @property
    def lacking(self) -> str:
        """The residual and the weights in words; empty if the part is met."""
        return "" if self.met else f"{self.short_by} {self.weighed}".rstrip()

    def __str__(self) -> str:
        return f"{self.part} met" if self.met else f"{self.part} short by {self.lacking}"

    def data(self) -> dict[str, Any]:
        """The part as plain Python data, ready for JSON."""
        rows = [
            {"row": label.row, "unit": label.unit, "missing": float(missing), "weight": float(weight)}
            for label, missing, weight in zip(self.labels, self.missing, self.weights, strict=True)
        ]
        return {"part": self.part, "met": self.met, "residual": self.residual, "rows": rows}


def parts_of(labels: list[Label], missing: Array, weights: Array) -> tuple[PartExplanation, ...]:
    """The rows of one level, part by part; `missing` and `weights` have an entry for each row, as `labels`."""
    rows: dict[str, list[int]] = {}
    for row, label in enumerate(labels):
        rows.setdefault(label.part, []).append(row)
    return tuple(
        PartExplanation(part, tuple(labels[i] for i in own), missing[own], weights[own]) for part, own in rows.items()
    )
