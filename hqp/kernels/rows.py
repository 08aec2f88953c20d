"""A row of the hierarchy, plain bound or dense: its vector a_i, its value at a point, and its bound on a side."""

from __future__ import annotations

from . import layout as at
from .compile import inner
from .memory import ints, marks, matrix, vector

#: The sides on which a row can be active, as :class:`hqp.Side`.
LOWER, INACTIVE, UPPER, EQUALITY = -1, 0, 1, 2


@inner
def value_of(i, x, here):
    """The value a_i x of row i, weighted, at x (n,)."""
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    col, row_of = marks(here, at.COL), marks(here, at.ROW_OF)
    norm = vector(here, at.NORM)
    B = matrix(here, at.B)
    if col[i] >= 0:
        return norm[i] * x[col[i]]
    row = B[row_of[i]]
    total = 0.0
    for j in range(n):
        total += row[j] * x[j]
    return total


@inner
def copy_row(i, out, here):
    """Write the weighted row a_i as a dense vector to out (n,)."""
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    col, row_of = marks(here, at.COL), marks(here, at.ROW_OF)
    norm = vector(here, at.NORM)
    B = matrix(here, at.B)
    if col[i] >= 0:
        for j in range(n):
            out[j] = 0.0
        out[col[i]] = norm[i]
    else:
        row = B[row_of[i]]
        for j in range(n):
            out[j] = row[j]


@inner
def target(side, low, high):
    """The bound of a row that is active on this side; of an equality, both are the same."""
    return low if side == LOWER else high
