"""Seven families of problems shaped as those of controllers: limits above tasks above a posture.

From three unknowns (P1) and the size of an arm (P2) to that of a humanoid (P4). Every variable lies in -1 .. 1, but
for P1; the rows of the tasks have random directions and norm one; the last level asks for a posture, so that x is
unique. P3h is P3 with a level that cannot be met; W48 has forty two-sided rows above most of its tasks,
and WB, a :mod:`.whole_body`, dozens of them active.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hqp import Hierarchy, Level
from hqp.arrays import Array

from .family import Family, drawn
from .whole_body import WHOLE_BODY

#: Half of what the bounds of a two-sided row leave between them, and the standard deviation of their centre.
HALF_WIDTH, CENTRE = 0.8, 0.4
#: From the upper bound of a row to the lower one of the row that contradicts it.
CONTRADICTION = 1.0


@dataclass(frozen=True)
class Shape:
    """What a family is made of.

    Attributes
    ----------
    n : int
        Unknowns.
    spread : float
        Of the point x at which a task would be met, level by level; half of it for the posture.
    tasks : tuple of (int, str)
        Rows of each level, and ``"="`` for equalities or ``"<>"`` for two-sided rows.
    limits
        Whether bounds on every variable come first.
    conflict
        Whether the first row of a two-sided level comes again, with bounds that its own exclude.
    """

    n: int
    spread: float
    tasks: tuple[tuple[int, str], ...]
    limits: bool = True
    conflict: bool = False

    @property
    def about(self) -> str:
        """As in ``n = 7: 7 bounds | 3 = | 3 = | identity``."""
        levels = [f"{rows + (self.conflict and kind != '=')} {kind}" for rows, kind in self.tasks]
        return f"n = {self.n}: {' | '.join([f'{self.n} bounds'] * self.limits + levels + ['identity'])}"

    def family(self, name: str) -> Family:
        """The family of that name."""
        return Family("control", name, self.about, drawn(self.hierarchy), self.limits, feasible=True, posture=True)

    def hierarchy(self, rng: np.random.Generator) -> Hierarchy:
        """One draw."""
        n = self.n
        levels = [Level.bounds(-np.ones(n), np.ones(n), name="limits")] if self.limits else []
        for rows, kind in self.tasks:
            A = rng.standard_normal((rows, n))
            A /= np.linalg.norm(A, axis=1)[:, None]
            levels.append(self._equalities(A, rng) if kind == "=" else self._two_sided(A, rng))
        posture = 0.5 * self.spread * rng.standard_normal(n)
        return Hierarchy([*levels, Level.bounds(posture, posture, name="posture")])

    def _equalities(self, A: Array, rng: np.random.Generator) -> Level:
        return Level.equality(A, A @ (self.spread * rng.standard_normal(self.n)))

    def _two_sided(self, A: Array, rng: np.random.Generator) -> Level:
        centre = CENTRE * rng.standard_normal(len(A))
        if self.conflict:
            A, centre = np.concatenate([A, A[:1]]), np.append(centre, centre[0] + 2 * HALF_WIDTH + CONTRADICTION)
        return Level(A, centre - HALF_WIDTH, centre + HALF_WIDTH)


_THIRTY = ((12, "="), (3, "="), (6, "="), (10, "<>"))
_SIXTY = ((12, "="), (6, "="), (6, "="), (12, "<>"), (6, "="), (10, "<>"))

FAMILIES = (
    Shape(3, 0.5, ((2, "="), (1, "=")), limits=False).family("P1"),
    Shape(7, 0.5, ((3, "="), (3, "="))).family("P2"),
    Shape(30, 0.35, _THIRTY).family("P3"),
    Shape(30, 0.35, _THIRTY, conflict=True).family("P3h"),
    Shape(60, 0.35, _SIXTY).family("P4"),
    Shape(48, 0.35, ((18, "="), (40, "<>"), (6, "="), (6, "="), (3, "="))).family("W48"),
    WHOLE_BODY,
)

#: By name.
CONTROL = {family.name: family for family in FAMILIES}
