"""A row of the hierarchy, plain bound or dense: its vector a_i, its value at a point, and its bound on a side."""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .lines import product
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
    return product(B[row_of[i]], x, n)


@inner
def note_spans(here):
    """Write where the entries of each row begin and end that are not 0, for :func:`value_within`."""
    head = ints(here, 0, at.HEAD)
    n, col, row_of, B = head[at.N], marks(here, at.COL), marks(here, at.ROW_OF), matrix(here, at.B)
    begin, end = marks(here, at.BEGIN), marks(here, at.END)
    for i in range(head[at.ROWS]):
        first, past = integer(0), n
        if col[i] < 0:
            row = B[row_of[i]]
            while first < past and row[first] == 0.0:
                first += 1
            while first < past and row[past - 1] == 0.0:
                past -= 1
        begin[i], end[i] = first, past


@inner
def value_within(i, x, here):
    """The value a_i x of dense row i, from the entries that :func:`note_spans` has found."""
    row_of = marks(here, at.ROW_OF)
    first, past = marks(here, at.BEGIN)[i], marks(here, at.END)[i]
    row, part, total = matrix(here, at.B)[row_of[i]][first:past], x[first:past], 0.0
    for j in range(past - first):
        total += row[j] * part[j]
    return total


@inner
def copy_row(i, out, here):
    """Write the weighted row a_i as a dense vector to out[:n], and zeros behind it."""
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    col, row_of = marks(here, at.COL), marks(here, at.ROW_OF)
    norm = vector(here, at.NORM)
    B = matrix(here, at.B)
    if col[i] >= 0:
        for j in range(len(out)):
            out[j] = 0.0
        out[col[i]] = norm[i]
    else:
        row = B[row_of[i]]
        for j in range(n):
            out[j] = row[j]
        for j in range(n, len(out)):
            out[j] = 0.0


@inner
def entry_of(i, j, col, row_of, norm, B):
    """Entry j of the weighted row i."""
    if col[i] >= 0:
        return norm[i] if col[i] == j else 0.0
    return B[row_of[i]][j]


@inner
def target(side, low, high):
    """The bound of a row that is active on this side; of an equality, both are the same."""
    return low if side == LOWER else high
