r"""Rows of very different lengths on one level: the long ones first, as levels of their own.

Where rows of length :math:`a` conflict, round-off of their forces is :math:`\epsilon a \|w\|`, and a row of length
:math:`b \ll a` beside them has a slack of that divided by :math:`b`: on which side of its bound it is, is decided by
round-off. But it pulls with a share of :math:`b / a`, and moves the long rows by the square of it. So long rows above
short ones have, up to that square, the optimum of all on one level, and no row is hidden by another.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arrays import Array, Indices
from ..hierarchy import Hierarchy, Level

#: Rows are parted where the next one is shorter by such a factor; the larger it is, the smaller is the error.
FACTORS = (1e4, 1e3, 100.0, 10.0)


def gradings(hierarchy: Hierarchy) -> Iterator[Hierarchy]:
    """Hierarchies with uneven levels in parts, the longest rows above: the nearest to the given one first."""
    lengths, done = hierarchy.row_norms() * hierarchy.weights, len(hierarchy.levels)
    for factor in FACTORS:
        levels = [
            _rows(hierarchy, k, part)
            for k in range(len(hierarchy.levels))
            for part in _parts(lengths[hierarchy.pointers[k] : hierarchy.pointers[k + 1]], factor)
        ]
        if len(levels) > done:
            done = len(levels)
            yield Hierarchy(levels, n=hierarchy.n)


def _parts(lengths: Array, factor: float) -> list[Indices]:
    """Rows of one level, parted where their lengths leave a gap of this factor; zero rows are with the shortest."""
    order = np.argsort(-lengths, kind="stable")
    longer, shorter = lengths[order[:-1]], lengths[order[1:]]
    return np.split(order, np.flatnonzero((shorter > 0.0) & (longer > factor * shorter)) + 1)


def _rows(hierarchy: Hierarchy, k: int, rows: Indices) -> Level:
    level = hierarchy.levels[k]
    lower, upper, weights = level.lower[rows], level.upper[rows], level.weights[rows]
    if level.indices is not None:
        return Level.bounds(lower, upper, indices=level.indices[rows], weights=weights)
    return Level(hierarchy.matrix(k)[rows], lower, upper, weights=weights)
