r"""Decides whether a residual force d, which no row above balances, still allows the level to be optimal.

It does in three cases: nearly dependent normals magnify round-off so far; d lies in directions that the rows of the
level hardly move, where their rank is not certain (:func:`moving`); or the slacks of the level can shift within the
tolerances of their rows so that d vanishes (:func:`carried`). This last one is a backward error: x is optimal for
slacks that round-off cannot tell from its own.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .escape import clear, residual
from .members import prepare
from .memory import ints, marks, matrix, vector
from .orthogonal import length, padded, pivots, separate
from .rows import INACTIVE, LOWER, UPPER, copy_row
from .span import FREE_RANK, least_singular
from .working_set import FROZEN, HARD, WORKING, balance

#: Largest residual of a level that passes, relative to the sum of its forces ``||A_i|| d_i^2 |w_i|``.
STATIONARITY = 1e-10
#: Upper limit of that tolerance if the rows that hold the level back are badly conditioned; what is then left, times
#: their smallest singular value, must be round-off of a sum of forces.
BLURRED, BALANCED = 1e-6, 256 * 2.0**-52
#: Rank tolerance of the rows of the level itself, projected onto the null space of the free normals: the largest that a
#: solver may have used, with a margin.
OWN_RANK = 4e-9
#: What is left has become so much smaller: rows are shortened to it, see :func:`shorten`.
SHORTER = 1e-3
#: Most steps of :func:`carried`; :func:`shift_last` also ends where a step gains less than this share. And this share
#: of what may pass is enough: what then passes does not hang on round-off.
ROUNDS, GAINS, ENOUGH = 300, 1e-5, 0.1


@inner
def round_off(here, k, base, working, left, scale):
    """Whether the residual force ``d`` of level k, of length `left`, is round-off: an exact x could leave as much.

    `working` rows of V follow V[:base], with multipliers ``share``; `scale` is as in :func:`.proof.balanced`.
    """
    least = weakest(here, k, base, working)
    if passes(left, least):
        return True
    return passes(moving(here, k, base + working), least) or passes(carried(here, k, base, working, scale), least)


@inner
def passes(left, least):
    """Whether so much may be left, where `least` is the smallest singular value of the normals that balance a level."""
    return left <= STATIONARITY or (left <= BLURRED and left * least <= BALANCED)


@inner
def weakest(here, k, base, working):
    """An upper bound of the smallest singular value of the normals that balance level k, by inverse iteration.

    Of the free ones C, of which some may depend on others, it is ``||C y||`` for the y that their pivot rows tell; of
    those behind V[:base], that of :func:`.span.least_singular`, or the least share.
    """
    kind, pivot, norm = marks(here, at.KIND), marks(here, at.PIVOT), vector(here, at.NORM)
    y, L, square = vector(here, at.SCRATCH), matrix(here, at.L), 0.0
    least = least_singular(here, base, base + working)
    for q in range(base, base + working):
        least = min(least, length(L[pivot[q]][base : q + 1], q + 1 - base) / norm[pivot[q]])
    if base > 0:
        least_singular(here, integer(0), base)
        for i in range(marks(here, at.PTR)[k]):
            if kind[i] == FROZEN and norm[i] > 0.0:
                row, total = L[i], 0.0
                for q in range(base):
                    total += row[q] * y[q]
                total /= norm[i]
                square += total * total
        least = min(least, math.sqrt(square))
    return least


@inner
def moving(here, k, c):
    """Reduce ``d`` to its part in the row space of level k, projected onto the null space of V[:c].

    Directions with a singular value of at most :data:`OWN_RANK` count as none. Returns the length of that part.
    """
    head, ptr, where = ints(here, 0, at.HEAD), marks(here, at.PTR), marks(here, at.HELD)
    ids, slots, lengths = marks(here, at.IDS), marks(here, at.SLOTS), vector(here, at.LENGTHS)
    n, norm, d, parts = head[at.N], vector(here, at.NORM), vector(here, at.D), vector(here, at.SCRATCH)
    V, L, R = matrix(here, at.V), matrix(here, at.L), matrix(here, at.R)
    if k == head[at.LEVELS]:
        return length(d, n)
    count = integer(0)
    for i in range(ptr[k], ptr[k + 1]):
        if where[i] != INACTIVE:
            ids[count] = i
            copy_row(i, R[count], here)
            count += 1
    separate(ids, count, slots, lengths, R, norm, V, L, integer(0), c, padded(n), 0.0)
    rank = pivots(ids, count, slots, lengths, R, norm, V, L, c, padded(n), FREE_RANK)
    left = 0.0  # squared Frobenius norm of what V[c : c + rank] leaves of the unit rows: no singular value is larger
    for q in range(rank - 1, -1, -1):
        for r in range(q, count):
            part = L[ids[r]][c + q] / norm[ids[r]]
            left += part * part
        if left > OWN_RANK * OWN_RANK:
            break
        rank = q
    for q in range(rank):
        direction, along = V[c + q], 0.0
        for j in range(n):
            along += direction[j] * d[j]
        parts[q] = along
    for j in range(n):
        d[j] = 0.0
    for q in range(rank):
        direction, along = V[c + q], parts[q]
        for j in range(n):
            d[j] += along * direction[j]
    return length(d, n)


@inner
def carried(here, k, base, working, scale):
    """The length of the residual force if the slacks of level k may shift within the tolerances of their rows.

    A shift of row i changes the residual along a_i, in both directions, or in one for a row at a bound. Multipliers of
    signed rows above may change with it. These are least squares with bounds, solved by conjugate gradients face by
    face (Polyak 1969), in all directions with a singular value above :data:`OWN_RANK`: in these the gradient is a
    larger share of what is left. Small singular values ask for large changes, so that the sum tells what is left.
    """
    head = ints(here, 0, at.HEAD)
    if k == head[at.LEVELS]:
        return carried_last(here, base, working, scale)
    n, d = head[at.N], vector(here, at.D)
    list_shifts(here, k, base, working, scale)
    left = length(d, n)
    if hopeless(here, k, left):
        return left
    before, whole, rest, unit = 0.0, False, vector(here, at.BALANCE), left
    for j in range(n):
        rest[j] = d[j]
    add_changes(here, k, 1.0, rest)
    for _ in range(ROUNDS):
        if left < SHORTER * unit:
            shorten(here, k, left)
            before, whole, unit = 0.0, False, left
        square = descent(here, k, before, whole)
        if not square > (OWN_RANK * left * left) ** 2:
            if not whole:  # the best there is, whichever values are at their bounds
                break
            before, whole = 0.0, False
            continue
        whole = advance(here, k, square)
        before, left = square, length(d, n)
        if left <= ENOUGH * STATIONARITY:
            break
    add_changes(here, k, -1.0, rest)
    return length(rest, n)


@inner
def add_changes(here, k, times, out):
    """Add `times` the sum of all ``value_i P_i`` to `out`; that sum and ``d`` are together the same at all steps."""
    n, P = ints(here, 0, at.HEAD)[at.N], matrix(here, at.P)
    low, high, value = vector(here, at.LOW), vector(here, at.HIGH), vector(here, at.VALUE)
    for i in range(marks(here, at.PTR)[k + 1]):
        if low[i] < high[i] and value[i] != 0.0:
            row, much = P[i], times * value[i]
            for j in range(n):
                out[j] += much * row[j]


@inner
def list_shifts(here, k, base, working, scale):
    """Write for each row that may shift, or have a multiplier: its projection P_i, ``value`` along it, and its bounds.

    P_i is as long as the row can change the residual, and no longer than what is left of it, so that a short step in
    all values keeps most bounds. The bounds ``low`` and ``high`` are equal where a row has no part: inactive, or
    dependent on free rows, so that what is left of it is round-off.
    """
    n, ptr, pivot, side = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR), marks(here, at.PIVOT), marks(here, at.SIDE)
    kind, where, norm = marks(here, at.KIND), marks(here, at.HELD), vector(here, at.NORM)
    value, share, room = vector(here, at.VALUE), vector(here, at.SHARE), vector(here, at.LAMBDA)
    low, high = vector(here, at.LOW), vector(here, at.HIGH)
    end, left = ptr[k + 1], length(vector(here, at.D), n)
    for i in range(end):
        value[i] = low[i] = high[i] = 0.0
    for q in range(base, base + working):
        value[pivot[q]] = share[q] * side[pivot[q]]
    for i in range(end):
        most = math.inf if i < ptr[k] else room[i] / scale
        if norm[i] == 0.0 or where[i] == INACTIVE or (i < ptr[k] and kind[i] != HARD and kind[i] != WORKING):
            continue
        prepare(i, base, here)
        mine = matrix(here, at.P)[i]
        size = length(mine, n)
        if size > FREE_RANK * norm[i]:
            unit = min(most, left / size)
            low[i] = 0.0 if where[i] == UPPER else -most / unit
            high[i] = 0.0 if where[i] == LOWER else most / unit
            value[i] /= unit
            for j in range(n):
                mine[j] *= unit


@inner
def shorten(here, k, left):
    """Make all P_i as long as `left` at most, as they were made of the residual at first; their values grow.

    Rows that can change little count as much as the others again, which would else hide them by their round-off.
    """
    n, P = ints(here, 0, at.HEAD)[at.N], matrix(here, at.P)
    low, high, value = vector(here, at.LOW), vector(here, at.HIGH), vector(here, at.VALUE)
    for i in range(marks(here, at.PTR)[k + 1]):
        if low[i] < high[i]:
            row = P[i]
            unit = min(1.0, left / length(row, n))
            low[i], high[i], value[i] = low[i] / unit, high[i] / unit, value[i] / unit
            for j in range(n):
                row[j] *= unit


@inner
def hopeless(here, k, left):
    """Whether no multiplier can grow for the better, and all shifts together leave more than STATIONARITY of ``d``."""
    ptr, low, high, reach = marks(here, at.PTR), vector(here, at.LOW), vector(here, at.HIGH), 0.0
    n, P = ints(here, 0, at.HEAD)[at.N], matrix(here, at.P)
    for i in range(ptr[k + 1]):
        if low[i] < high[i]:
            change = along(here, i)
            if i >= ptr[k]:
                reach += max(change * low[i], change * high[i])
            elif (change if high[i] > 0.0 else -change) > BALANCED * length(P[i], n):
                return False
    return reach < left * (left - STATIONARITY)


@inner
def along(here, i):
    """``P_i . d``."""
    n, d, row, total = ints(here, 0, at.HEAD)[at.N], vector(here, at.D), matrix(here, at.P)[i], 0.0
    for j in range(n):
        total += row[j] * d[j]
    return total


@inner
def descent(here, k, before, whole):
    """Write ``allowed``, the direction of the next step; returns the square of the gradient on this face.

    After a `whole` step it is conjugate to the last one, with the squared gradient `before`. Else a new face begins: of
    all values that are not at a bound, or leave it.
    """
    end, way, gradient = marks(here, at.PTR)[k + 1], vector(here, at.ALLOWED), matrix(here, at.HELD_BY)[k]
    low, high, value, square = vector(here, at.LOW), vector(here, at.HIGH), vector(here, at.VALUE), 0.0
    for i in range(end):
        gradient[i] = 0.0
        if low[i] < high[i] and (not whole or way[i] != 0.0):
            change = along(here, i)
            if whole or (value[i] < high[i] if change > 0.0 else value[i] > low[i]):
                gradient[i] = change
                square += change * change
    keeps = square / before if whole else 0.0
    for i in range(end):
        way[i] = gradient[i] + (keeps * way[i] if whole else 0.0)
    return square


@inner
def advance(here, k, square):
    """Go along ``allowed`` to the least ``d``, or to the first bound; whether none was in the way.

    `square` is that of :func:`descent`.
    """
    n, end = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR)[k + 1]
    d, image, way = vector(here, at.D), vector(here, at.SCRATCH), vector(here, at.ALLOWED)
    low, high, value = vector(here, at.LOW), vector(here, at.HIGH), vector(here, at.VALUE)
    P, most, blocks = matrix(here, at.P), math.inf, integer(-1)
    for j in range(n):
        image[j] = 0.0
    for i in range(end):
        if way[i] == 0.0:
            continue
        row, much = P[i], way[i]
        for j in range(n):
            image[j] += much * row[j]
        room = ((high[i] if much > 0.0 else low[i]) - value[i]) / much
        if room < most:
            most, blocks = room, i
    size = length(image, n)
    best = square / (size * size)
    reach = min(best, most)
    for i in range(end):
        if way[i] != 0.0:
            value[i] += reach * way[i]
    for j in range(n):
        d[j] -= reach * image[j]
    if blocks < 0 or best < most:
        return True
    value[blocks] = high[blocks] if way[blocks] > 0.0 else low[blocks]
    return False


@inner
def carried_last(here, base, working, scale):
    """The same of the implicit last level, where each x_j may move within its tolerance ``rhs``.

    The multipliers of the rows behind V[:base] change with it, or stay if one would change its sign.
    """
    side, pivot, multiplier = marks(here, at.SIDE), marks(here, at.PIVOT), vector(here, at.MULTIPLIER)
    left, pulled = shift_last(here, base + working, scale), vector(here, at.BALANCE)
    balance(pulled, base, base + working, here)
    for q in range(base, base + working):
        if multiplier[q] * side[pivot[q]] < 0.0:
            residual(here, base + working)
            return shift_last(here, base, scale)
    return left


@inner
def shift_last(here, c, scale):
    """Reduce ``d`` by such shifts, projected onto the null space of V[:c]: gradients.

    Returns what is left; ``balance`` is the shifted gradient.
    """
    n, d, near = ints(here, 0, at.HEAD)[at.N], vector(here, at.D), vector(here, at.RHS)
    shift, g, pulled = vector(here, at.LENGTHS), vector(here, at.G), vector(here, at.BALANCE)
    left = length(d, n)
    for j in range(n):
        shift[j] = 0.0
    for _ in range(ROUNDS):
        before = left
        for j in range(n):
            most = near[j] / scale
            new = min(max(shift[j] + d[j], -most), most)
            d[j] -= new - shift[j]
            shift[j] = new
        left = clear(here, d, c)
        if left <= ENOUGH * STATIONARITY or not left < (1.0 - GAINS) * before:
            break
    for j in range(n):
        pulled[j] = g[j] + shift[j]
    return left
