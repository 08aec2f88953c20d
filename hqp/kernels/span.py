"""The span of the free normals in the certificate, level by level, with the ranks that nobody can tell decided alike.

V spans the normals of free rows: first those of the highest level, then what the rows of the next one add, and so on.
Each row is split as in :mod:`.orthogonal`. Its *share* is the part of its length that was left when it became a row of
V. Where shares are small, the smallest singular value of the triangle of unit normals tells whether the row adds a
direction, or round-off.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner
from .memory import ints, marks, matrix, vector
from .orthogonal import factor, padded
from .rows import copy_row

#: Rank tolerance of the free normals; and that of :class:`hqp.Settings`, by which most solvers decide. A level passes
#: with either, so that an answer passes however its solver decided a doubtful rank.
FREE_RANK, SOLVED_RANK = 1e-12, 1e-9
#: A share above this leaves no doubt about the rank.
CLEAR = 1e-6
#: Steps of inverse iteration: each gains the square of the ratio of the two smallest singular values.
STEPS = 4


@inner
def enter(here, count, c, tau):
    """Append the `count` rows in ``ids`` and R to V[:c], the longest first; returns how many rows V then has.

    With SOLVED_RANK for `tau` a row counts by its share alone, as for a solver.
    """
    n, ids, pivot = ints(here, 0, at.HEAD)[at.N], marks(here, at.IDS), marks(here, at.PIVOT)
    norm, V, L, R = vector(here, at.NORM), matrix(here, at.V), matrix(here, at.L), matrix(here, at.R)
    slots, lengths = marks(here, at.SLOTS), vector(here, at.LENGTHS)
    end = c + factor(ids, count, slots, lengths, R, norm, V, L, c, padded(n), tau)
    for q in range(c, end):
        pivot[q] = ids[q - c]
    for q in range(c, end if tau == FREE_RANK else c):
        if L[pivot[q]][q] <= CLEAR * norm[pivot[q]] and least_singular(here, 0, q + 1) <= FREE_RANK:
            end = q
            break
    for r in range(count):
        row, width = L[ids[r]], min(c + r + 1, end)  # a row of V has no part along those after it
        for q in range(width, n):
            row[q] = 0.0
    return end


@inner
def take_up(here, i, count):
    """Write row i to place `count` of ``ids`` and R."""
    marks(here, at.IDS)[count] = i
    copy_row(i, matrix(here, at.R)[count], here)


@inner
def least_singular(here, base, end):
    """The smallest singular value of the rows ``pivot`` base .. end - 1 of V, in the null space of V[:base]; at most 1.

    Each is divided by its length there. By inverse iteration with their triangle T, from above. It begins with the
    signs that let ``T^-T y`` grow, so that no small share is missed (Cline, Moler, Stewart, Wilkinson 1979); the unit
    vector y that it finds stands in ``scratch``.
    """
    pivot, L = marks(here, at.PIVOT), matrix(here, at.L)
    y, sizes = vector(here, at.SCRATCH), vector(here, at.MULTIPLIER)
    least = 1.0
    for q in range(base, end):
        row, square = L[pivot[q]], 0.0
        for p in range(base, q + 1):
            square += row[p] * row[p]
        sizes[q], y[q] = math.sqrt(square), 0.0
    start = 1.0 / math.sqrt(end - base) if end > base else 0.0
    for _ in range(STEPS if end > base else 0):
        for q in range(end - 1, base - 1, -1):  # T' z = y
            row = L[pivot[q]]
            y[q] += math.copysign(start, y[q])
            much = y[q] / row[q]
            y[q] = sizes[q] * much
            for p in range(base, q):
                y[p] -= much * row[p]
        start = 0.0
        for q in range(base, end):  # T y = z
            row, total = L[pivot[q]], sizes[q] * y[q]
            for p in range(base, q):
                total -= row[p] * y[p]
            y[q] = total / row[q]
        square = 0.0
        for q in range(base, end):
            square += y[q] * y[q]
        if not square > 0.0 or square == math.inf:
            return 0.0 if square > 0.0 else least
        large = math.sqrt(square)
        least = min(least, 1.0 / math.sqrt(large))
        for q in range(base, end):
            y[q] /= large
    return least
