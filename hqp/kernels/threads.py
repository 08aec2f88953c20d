r"""Rows that hold a level by a thread: whether the rows of the level itself tell them.

A multiplier that is positive, but so small that the certificate may not count it (:data:`.signs.HELD_FIRMLY`), keeps a
row of the levels above at its bound for all levels below. There the certificate lets go of that row, but has the rows
of the level itself, which are free. Those that depend on the basis are combinations of its rows,

.. math:: a_r = \sum_q c_{rq} a_q .

If combinations of the a_r without the *open* rows, which hold nothing yet, have as many independent parts c as there
are rows by a thread, then these are told: the basis spans the same without them, and with the a_r. So solver and
certificate agree, whatever the signs are on the levels below. Where the basis spans all of x, a tiny part of a single
row will do, as no turn of the span is felt: that the a_r balance the level is one.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .doubt import clear_of_others, is_free
from .extent import extent
from .memory import ints, marks, matrix, vector
from .rows import entry_of

#: Coefficients of unit normals below the first are round-off. The second is the smallest pivot among them: its inverse
#: magnifies the round-off of the span.
NOTHING, TELLS = 1e-12, 1e-4
#: If the basis spans all of x, the part of a_r that the other rows leave must be clear for the certificate: well above
#: its :data:`.shift.STATIONARITY`, and, times the least share of another row, above :data:`.span.FREE_RANK`.
COUNTS, SPANS = 5e-10, 1e-11


@inner
def told(here, threads, opens, low, high, first, end, whole):
    """Whether the dependent rows low .. high - 1 in ``ids`` tell the rows by a thread, ``queue[:threads]``.

    The basis is V[first:end]. ``queue`` has places there, or -1 - i for the active bound i of a variable that has left
    the problem; its last entries, as many as `opens`, are the open rows. `whole` tells whether V[:end] spans all of x,
    and no row holds a level further up: then the certificate has no weak rows in the basis but those of this level.
    """
    n, ids, queue = ints(here, 0, at.HEAD)[at.N], marks(here, at.IDS), marks(here, at.QUEUE)
    col, row_of, norm, B = marks(here, at.COL), marks(here, at.ROW_OF), vector(here, at.NORM), matrix(here, at.B)
    part, pivot, L, C = vector(here, at.SHARE), marks(here, at.PIVOT), matrix(here, at.L), matrix(here, at.H)
    size, rows, most = extent(vector(here, at.X), here), integer(0), 0.0
    for r in range(low, high):
        i = ids[r]
        if rows == n or norm[i] == 0.0 or not is_free(here, i, size):
            continue
        for q in range(first, end):
            part[q] = L[i][q]
        for q in range(end - 1, first - 1, -1):
            row = L[pivot[q]]
            part[q] /= row[q]
            for p in range(first, q):
                part[p] -= part[q] * row[p]
        for t in range(opens + threads):
            place = queue[n - opens + t if t < opens else t - opens]
            if place >= 0:
                C[rows][t] = part[place] * norm[pivot[place]] / norm[i]
                continue
            j = col[-1 - place]
            left = entry_of(i, j, col, row_of, norm, B)
            for q in range(first, end):
                left -= part[q] * entry_of(pivot[q], j, col, row_of, norm, B)
            C[rows][t] = left / norm[i]
        most = max(most, abs(C[rows][opens]))
        rows += 1
    if independent(C, rows, opens, opens + threads):
        return True
    return whole and threads == 1 and opens == 0 and is_clear(here, queue[0], first, end, most)


@inner
def is_clear(here, place, first, end, much):
    """Whether so `much` of the row at a place of the basis is clear of the others: see :data:`COUNTS`."""
    norm, pivot, L, least = vector(here, at.NORM), marks(here, at.PIVOT), matrix(here, at.L), 1.0
    for q in range(end):
        least = min(least, L[pivot[q]][q] / norm[pivot[q]])
    left = much * clear_of_others(here, place, first, end)
    return left > COUNTS and left * least > SPANS


@inner
def independent(C, rows, opens, columns):
    """Whether C[:rows], once its first `opens` columns are eliminated, has full rank in the others. C is lost."""
    done = integer(0)
    for t in range(columns):
        best, place, most = integer(-1), t, NOTHING
        for r in range(done, rows):
            for s in range(t, columns if t >= opens else t + 1):
                if abs(C[r][s]) > most:
                    best, place, most = r, s, abs(C[r][s])
        if best < 0 and t < opens:
            continue
        if most < TELLS:
            return False
        for s in range(columns):
            C[done][s], C[best][s] = C[best][s], C[done][s]
        for r in range(done, rows):
            C[r][t], C[r][place] = C[r][place], C[r][t]
        for r in range(done + 1, rows):
            much = C[r][t] / C[done][t]
            for s in range(t, columns):
                C[r][s] -= much * C[done][s]
        done += 1
    return True
