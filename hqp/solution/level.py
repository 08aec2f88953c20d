"""One level at the solution: slacks, active rows, rank and multipliers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, length
from ..certificate import Certificate, RowStates, excess, row_space
from ..hierarchy import Hierarchy, Side


@dataclass(frozen=True, eq=False)
class LevelSolution:
    """One level at the solution.

    Attributes
    ----------
    name : str
    slack : array, shape (m_k,)
        Raw slack ``w = A x - clip(A x, lower, upper)``, in the unit of the row.
    residual_norm : float
        Weighted: ``||D_k w_k||``.
    rank : int
        Directions of x which this level fixes among those that the levels above left open: the
        rank of its equality and violated rows in the null space of theirs.
    smallest : float
        How clear this rank is: the smallest singular value of those rows, in units of their norms; 1 if the rank is 0.
    active : array of int8, shape (m_k,)
        :class:`hqp.Side` of each row: -1 at (or below) its lower bound, 0 inside, 1 at (or
        above) its upper bound, 2 equality.
    multipliers : array
        The forces that hold this level back: one number for every row of levels 0..k-1, positive at an
        upper bound. Their unit is that of ``D_k^2 w_k A_k`` divided by that of the row's A.
    """

    name: str
    slack: Array
    rank: int
    smallest: float
    active: NDArray[np.int8]
    residual_norm: float
    multipliers: Array

    def __repr__(self) -> str:
        active = int(np.count_nonzero((self.active == Side.LOWER) | (self.active == Side.UPPER)))
        return (
            f"LevelSolution({self.name!r}: residual_norm={self.residual_norm:.6g}, rank={self.rank},"
            f" {active} of {len(self.slack)} rows at a bound)"
        )


def levels_at(
    h: Hierarchy, certificate: Certificate, rows: RowStates, ranks: Sequence[tuple[int, float]]
) -> tuple[LevelSolution, ...]:
    """Every level at x, by its certificate, the states of its rows there, and what they fix; see :func:`ranks_of`."""
    judged = certificate.levels
    return tuple(
        LevelSolution(
            name=level.name,
            slack=rows.slack[a:b],
            rank=ranks[k][0],
            smallest=ranks[k][1],
            active=rows.sides[a:b],
            residual_norm=judged[k].residual_norm,
            multipliers=judged[k].multipliers,
        )
        for k, (level, a, b) in enumerate(zip(h.levels, h.pointers[:-1], h.pointers[1:], strict=True))
    )


def ranks_of(h: Hierarchy, rows: RowStates, rank_tolerance: float) -> list[tuple[int, float]]:
    """Of every level, rank and smallest singular value of what it fixes, its rows in units of their norms."""
    ranks, Z = list[tuple[int, float]](), np.eye(h.n)
    for k in range(len(h.levels)):
        own = slice(h.pointers[k], h.pointers[k + 1])
        frozen = ((rows.sides[own] == Side.EQUALITY) | rows.violated[own]) & (rows.norms[own] > 0)
        units = h.matrix(k)[frozen] @ Z / rows.norms[own][frozen, None]
        range_, null, smallest = row_space(units, rank_tolerance)
        ranks.append((range_.shape[1], smallest))
        Z = Z @ null
    return ranks


def residual_norm(hierarchy: Hierarchy, k: int, x: Array) -> float:
    """``||D_k w_k||`` at x."""
    level = hierarchy.levels[k]
    return length(level.weights * excess(hierarchy.matrix(k) @ x, level.lower, level.upper))
