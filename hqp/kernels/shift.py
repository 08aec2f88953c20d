r"""Decides whether a residual force d, which no row above balances, still allows the level to be optimal.

As in :mod:`hqp.certificate.balance`, it does in two cases: d lies in directions that the rows of the level hardly move,
where their rank is not certain (:func:`moving`); or the slacks of the level can shift within the tolerances of their
rows so that d vanishes (:func:`carried`): x is then optimal for slacks that round-off cannot tell from its own.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .escape import residual
from .memory import ints, marks, matrix, vector
from .orthogonal import pivots, reflect, separate, triangle
from .rows import INACTIVE, LOWER, UPPER, copy_row
from .working_set import balance

#: As in the certificate: the rank tolerance of the rows of the level in the null space of those above.
OWN_RANK = 4e-9
#: A row that depends on others of the level up to this share of its length is not shifted along its remainder.
ALONE = 1e-6
#: How often the shift is computed again without the rows that would have to shift in the wrong direction.
ROUNDS = 4


@inner
def moving(here, k, c):
    """An upper bound of the part of d in the row space of level k, projected onto the null space of V[:c].

    Directions with a singular value below :data:`OWN_RANK` count as none.
    """
    n, ptr, where = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR), marks(here, at.HELD)
    ids, slots, lengths = marks(here, at.IDS), marks(here, at.SLOTS), vector(here, at.LENGTHS)
    norm, d = vector(here, at.NORM), vector(here, at.D)
    V, L, R = matrix(here, at.V), matrix(here, at.L), matrix(here, at.R)
    count = integer(0)
    for i in range(ptr[k], ptr[k + 1]):
        if where[i] != INACTIVE:
            ids[count] = i
            copy_row(i, R[count], here)
            count += 1
    separate(ids, count, slots, lengths, R, norm, V, L, integer(0), c, n, 0.0)
    rank = pivots(ids, count, slots, lengths, R, norm, V, L, c, n, 0.25 * OWN_RANK)
    moved = left = 0.0
    for q in range(c, c + rank):
        direction, along = V[q], 0.0
        for j in range(n):
            along += direction[j] * d[j]
        for j in range(n):
            d[j] -= along * direction[j]
        moved += along * along
    for r in range(rank, count):
        row, along = R[slots[r]], 0.0
        for j in range(n):
            along += row[j] * d[j]
        along /= norm[ids[r]]
        left += along * along
    return math.sqrt(moved) + math.sqrt(left) / OWN_RANK


@inner
def carried(here, k, base, c, enough):
    """Whether slacks of level k can shift within their tolerances so that a residual of at most `enough` is left.

    V[:c] are the normals that balance the level; those from `base` on belong to rows at a bound, whose multipliers must
    keep their signs.
    """
    n, ids, where = ints(here, 0, at.HEAD)[at.N], marks(here, at.IDS), marks(here, at.HELD)
    room, g, shift = vector(here, at.LAMBDA), vector(here, at.G), vector(here, at.RHS)
    norm, R = vector(here, at.NORM), matrix(here, at.R)
    pivot, side, multiplier = marks(here, at.PIVOT), marks(here, at.SIDE), vector(here, at.MULTIPLIER)
    count, hopeless = list_shifts(here, k, residual(here, c), enough)
    for _ in range(ROUNDS):
        if hopeless or count == 0:
            return False
        shortest_shift(here, count, c)
        fits, kept = True, integer(0)
        for r in range(count):
            i = ids[r]
            wrong = (where[i] == UPPER and shift[r] < 0.0) or (where[i] == LOWER and shift[r] > 0.0)
            fits = fits and not wrong and abs(shift[r]) <= 1.0
            if not wrong:
                ids[kept], shift[kept] = i, shift[r]
                kept += 1
        if fits:
            break
        hopeless, count = kept == count, kept
    if not fits:
        return False
    for r in range(count):
        i = ids[r]
        copy_row(i, R[r], here)
        row, much = R[r], shift[r] * room[i] / norm[i]
        for j in range(n):
            g[j] += much * row[j]
    if residual(here, c) > enough:
        return False
    balance(vector(here, at.G), base, c, here)
    pressing = True
    for q in range(base, c):
        pressing = pressing and multiplier[q] * side[pivot[q]] >= 0.0
    return pressing


@inner
def list_shifts(here, k, steep, enough):
    """Write the rows of level k with a tolerance to ``ids``; returns how many, and whether they are hopeless.

    They are if all their tolerances together change d, of length `steep`, too little to leave at most `enough`.
    """
    n, ptr, where = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR), marks(here, at.HELD)
    ids, norm, room = marks(here, at.IDS), vector(here, at.NORM), vector(here, at.LAMBDA)
    d, row = vector(here, at.D), vector(here, at.SHARE)
    count, reach = integer(0), 0.0
    for i in range(ptr[k], ptr[k + 1]):
        if where[i] != INACTIVE and room[i] > 0.0:
            copy_row(i, row, here)
            along = 0.0
            for j in range(n):
                along += row[j] * d[j]
            reach += room[i] / norm[i] * abs(along)
            ids[count] = i
            count += 1
    return count, reach < steep * (steep - enough)


@inner
def shortest_shift(here, count, c):
    """Write ``shift``: the least-norm shift of the `count` rows ``ids`` that cancels d, in units of their tolerances.

    By Householder reflections, on the null space of V[:c].
    """
    n, ids, slots = ints(here, 0, at.HEAD)[at.N], marks(here, at.IDS), marks(here, at.SLOTS)
    lengths, norm, room = vector(here, at.LENGTHS), vector(here, at.NORM), vector(here, at.LAMBDA)
    shift, y = vector(here, at.RHS), vector(here, at.Y)
    d, V, L, R, H = vector(here, at.D), matrix(here, at.V), matrix(here, at.L), matrix(here, at.R), matrix(here, at.H)
    for r in range(count):
        copy_row(ids[r], R[r], here)
        row, unit = R[r], room[ids[r]] / norm[ids[r]]
        for j in range(n):
            row[j] *= unit
    separate(ids, count, slots, lengths, R, room, V, L, integer(0), c, n, ALONE)
    rank = pivots(ids, count, slots, lengths, R, room, V, L, c, n, ALONE)
    for r in range(count):
        shift[r] = 0.0
    triangle(ids, count, rank, L, c, shift, y, H)  # of L^T shift = V d
    for q in range(rank - 1, -1, -1):
        direction, column, total = V[c + q], H[q], 0.0
        for j in range(n):
            total += direction[j] * d[j]
        for r in range(q + 1, rank):
            total -= column[r] * shift[r]
        shift[q] = total / y[c + q]
    for q in range(rank):
        column = H[q]
        square = column[q] * column[q]
        for r in range(rank, count):
            square += column[r] * column[r]
        reflect(shift, column, q, column[q], 2.0 / square, rank, count)
