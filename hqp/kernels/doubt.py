"""Finds rank decisions that are in doubt: rows count as dependent, but the solution would change if they did not.

Rows that depend on others in exact arithmetic, as where limits saturate, depend on them only up to round-off, magnified
by the condition number of the others. Their rank is then arbitrary, but the levels below depend on it: the forces of
such rows along what projection leaves of them stay unbalanced. So the certificate has to accept the answer. It also has
to where only one can tell a slack from round-off, the forces of the level, the tolerance of the row, or that of the
certificate: then solver and certificate see other active rows.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner
from .extent import extent
from .memory import ints, marks, matrix, vector
from .orthogonal import NONE
from .rows import EQUALITY, entry_of, target
from .signs import CLEAR

#: Smallest rank tolerance: well-conditioned others leave no larger share of a dependent row, by round-off.
SHARPEST = 2e-12
#: A dependent row of which such a share is left may be independent for the certificate: half of its
#: :data:`.span.FREE_RANK`, as its share there is another one by round-off.
COUNTED = 5e-13
#: Dependent rows of which a larger share is left are not in doubt: the user has set such a rank tolerance on purpose.
MOST = 1e-9
#: A row of which a smaller share is left counts, but what it asks for is magnified, and so is the round-off of all rows
#: that are left in its direction: the signs of their multipliers are in doubt. Round-off that a row above has magnified
#: is magnified again, so that the shares of both count together.
WEAK = 1e-5
#: A row that is shorter by this factor than another of its level may disappear in the round-off of that one: forces and
#: factors go by squares of lengths.
EVEN = 1e-6
#: The levels below are balanced if no more than this share of their forces is left: so far the span of the rows above
#: may turn.
TURNED = 1e-10


@inner
def note_doubt(here, hard, rank, own, own_rank, pull, frozen):
    """Set DOUBT to 1 if a rank or a sign of a level that :mod:`.polish` has solved may be round-off.

    That is so if a pivot row is :data:`WEAK`; if the dependent rows of an unmet level leave too much of its forces,
    `pull`, unbalanced; and if what is left of a row that the level freezes may turn the levels below, :func:`turns`.
    The `hard` active rows of the levels above are in ``ids``, then the `own` ones, first `rank` and `own_rank` pivots.
    """
    head, ids, side = ints(here, 0, at.HEAD), marks(here, at.IDS), marks(here, at.SIDE)
    lengths, w, norm = vector(here, at.LENGTHS), vector(here, at.W), vector(here, at.NORM)
    for r in range(hard + own_rank):
        if (r < rank or r >= hard) and lengths[r] < WEAK * norm[ids[r]]:
            head[at.DOUBT] = 1
    unbalanced, end = 0.0, frozen + rank + own_rank
    for r in range(hard + own_rank, hard + own):
        i = ids[r]
        if lengths[r] <= MOST * norm[i]:
            unbalanced += abs(w[i]) * lengths[r]
        if (pull > 0.0 or side[i] == EQUALITY) and turns(here, i, lengths[r], frozen, end):
            head[at.DOUBT] = 1
    if unbalanced > CLEAR * pull > 0.0:
        head[at.DOUBT] = 1


@inner
def turns(here, i, left, first, end):
    """Whether the levels below, where dependent row i is an equality, may see another span than V[:end].

    There, inequalities at a bound may have no multiplier. Then, besides equalities and violated rows, row i adds its
    part along those rows of V[first:end] that were made of inequalities at a bound, and what is left, which has been
    neglected: the shorter that part, of which the others span nothing, the more it turns.
    """
    norm, pivot, L, part = vector(here, at.NORM), marks(here, at.PIVOT), matrix(here, at.L), vector(here, at.SHARE)
    if left <= NONE * norm[i] or left > MOST * norm[i]:
        return False
    size, low, least = extent(vector(here, at.X), here), first, math.inf
    while low < end and is_free(here, pivot[low], size):
        low += 1
    for q in range(low, end):
        part[q] = L[i][q]
    for q in range(end - 1, low - 1, -1):  # row i is the sum of the rows, times their parts
        row = L[pivot[q]]
        part[q] /= row[q]
        for t in range(low, q):
            part[t] -= part[q] * row[t]
        much = abs(part[q]) * norm[pivot[q]]
        if much > SHARPEST * norm[i] and not is_free(here, pivot[q], size):
            least = min(least, much * clear_of_others(here, q, q, end))
    return left > min(COUNTED * norm[i], TURNED * least)


@inner
def clear_of_others(here, place, first, end):
    """How far a unit row of the basis V[first:end] is from the span of the others.

    `place` is its place there, or -1 - i for the active bound i of a variable that has left the problem. The distance
    is one over the length of the column of the inverse of the basis that belongs to it.
    """
    col, row_of, norm, B = marks(here, at.COL), marks(here, at.ROW_OF), vector(here, at.NORM), matrix(here, at.B)
    pivot, L, column = marks(here, at.PIVOT), matrix(here, at.L), vector(here, at.SCRATCH)
    square = 1.0 if place < 0 else 0.0
    for q in range(first, end):
        row, total = L[pivot[q]], norm[pivot[q]] if q == place else 0.0
        if place < 0:
            total = entry_of(pivot[q], col[-1 - place], col, row_of, norm, B)
        for p in range(first, q):
            total -= row[p] * column[p]
        column[q] = total / row[q]
        square += column[q] * column[q]
    return 1.0 / math.sqrt(square)


@inner
def weakest_share(here, c):
    """The smallest share of its length that projection left of a row when it became one of V[:c]."""
    pivot, norm, L, weakest = marks(here, at.PIVOT), vector(here, at.NORM), matrix(here, at.L), 1.0
    for q in range(c):
        weakest = min(weakest, abs(L[pivot[q]][q]) / norm[pivot[q]])
    return weakest


@inner
def is_free(here, i, size):
    """Whether active row i is an equality, or violated by more than its tolerance, with an x as long as `size`."""
    side, bound = (
        marks(here, at.SIDE)[i],
        target(marks(here, at.SIDE)[i], vector(here, at.LO)[i], vector(here, at.HI)[i]),
    )
    near = vector(here, at.OPTION)[at.TOL] * (abs(bound) + vector(here, at.NORM)[i] * size)
    return side == EQUALITY or abs(vector(here, at.W)[i]) > near


@inner
def may_be_met(here, i, size):
    """Whether the certificate may take the slack of row i, which counts here, for round-off; x is as long as `size`.

    Then the row, an inequality, is held by a multiplier of one sign there, and is free here.
    """
    side, w = marks(here, at.SIDE)[i], vector(here, at.W)[i]
    bound = target(side, vector(here, at.LO)[i], vector(here, at.HI)[i])
    near = vector(here, at.OPTION)[at.JUDGED] * (2.0 * abs(bound) + vector(here, at.NORM)[i] * size)
    return side != EQUALITY and w != 0.0 and abs(w) <= near


@inner
def sharpen(here):
    """Set the rank tolerance to SHARPEST, and DOUBT to 1; False if it is as small already, or was set by the user."""
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    if option[at.TAU] <= SHARPEST or option[at.TAU] > MOST:
        return False
    option[at.TAU], head[at.DOUBT] = SHARPEST, 1
    return True


@inner
def is_even(here, k, length):
    """Whether the weighted rows of level k, and one more of this length, if not 0, are comparable: see :data:`EVEN`."""
    ptr, norm = marks(here, at.PTR), vector(here, at.NORM)
    shortest, longest = length if length > 0.0 else math.inf, length
    for i in range(ptr[k], ptr[k + 1]):
        if norm[i] > 0.0:
            shortest, longest = min(shortest, norm[i]), max(longest, norm[i])
    return not shortest < EVEN * longest


@inner
def all_even(here):
    """Whether the weighted rows of each level are of comparable length."""
    even = True
    for k in range(ints(here, 0, at.HEAD)[at.LEVELS]):
        even = even and is_even(here, k, 0.0)
    return even


@inner
def doubtful(here):
    """Whether the certificate must judge an answer: a rank is in doubt, or a level has rows of very unequal lengths."""
    return ints(here, 0, at.HEAD)[at.DOUBT] != 0 or not all_even(here)
