r"""The certificate, compiled: whether x is optimal, from the numbers of the hierarchy alone, whoever computed it.

It decides as :mod:`hqp.certificate.balance` does, level by level: the forces of the level must be balanced by the
normals of the rows above it, by the free ones either way and by those at a bound inward, up to round-off. What it
accepts the certificate accepts, whose least squares leave no more; what it does not accept may be optimal yet, for it
does not ask which rows at a bound hold a level above and are free therefore: round-off has a say in which these are.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .escape import nonnegative
from .memory import ints, marks, matrix, vector
from .orthogonal import factor, length
from .rows import EQUALITY, INACTIVE, LOWER, UPPER, copy_row, value_of
from .shift import carried, moving
from .working_set import FROZEN, FUTURE, HARD, WORKING, append, balance

#: As in :mod:`hqp.certificate`: the tolerance on rows, round-off of rows and of forces.
JUDGED, ROUND_OFF, BALANCED = 1e-9, 256 * 2.0**-52, 64 * 2.0**-52
#: As there: ranks of free normals; what is asked of the balance, and what at the least.
FREE_RANK, STATIONARITY, BLURRED = 1e-11, 1e-10, 1e-6
#: Rows of which the others leave less do not press from the start, for large forces along them balance very little.
CLEAR = 1e-6
#: By so much of a row's length round-off turns what others leave of it.
TURNS = 8 * 2.0**-52
#: What rounding differently must not turn over: of what is left of forces, and of tolerances.
MARGIN, NEARLY = 0.9, 0.99
#: The share of the length of x that adds to the tolerance of a row that it hardly moves.
LENGTH = 0.1


@inner
def proves(here, last):
    """Whether the certificate accepts x on levels 0 .. last. The basis and its cuts are of no use any more."""
    m = ints(here, 0, at.HEAD)[at.ROWS]
    side, kept = marks(here, at.SIDE), marks(here, at.FOLLOW)
    marks(here, at.CUT)[last] = -1
    for i in range(m):
        kept[i] = side[i]
    size, way = find_sides(here)
    frozen, taken, accepted = integer(0), integer(0), True
    for k in range(last + 1):
        scale = gradient(here, k, last, size, way)
        if scale == 0.0:
            continue
        while taken < k:
            frozen = take_up(here, taken, frozen)
            taken += 1
        if not balanced(here, k, last, frozen, scale):
            accepted = False
            break
    for i in range(m):
        side[i] = kept[i]
    return accepted


@inner
def measure_rows(here):
    """Values and slacks of all rows, and the lengths that round-off is relative to: of x, and of the way it came."""
    head = ints(here, 0, at.HEAD)
    n, ptr, norm, weights = head[at.N], marks(here, at.PTR), vector(here, at.NORM), vector(here, at.WEIGHTS)
    lo, hi, x, x_ref = vector(here, at.LO), vector(here, at.HI), vector(here, at.X), vector(here, at.X_REF)
    value, slack = vector(here, at.VALUE), vector(here, at.SLOPE)
    away, longest = 0.0, 0.0
    for j in range(n):
        away += (x[j] - x_ref[j]) * (x[j] - x_ref[j])
    for i in range(head[at.ROWS]):
        longest = max(longest, norm[i] / weights[i])
    size = length(x, n)
    way = max(size, math.sqrt(away))
    for k in range(head[at.LEVELS]):
        most, asked = 0.0, 0.0
        for i in range(ptr[k], ptr[k + 1]):
            value[i] = slack[i] = 0.0
            if norm[i] > 0.0:
                value[i] = value_of(i, x, here)
                slack[i] = value[i] - min(max(value[i], lo[i]), hi[i])
                most = max(most, norm[i])
                if norm[i] > ROUND_OFF * longest * weights[i]:
                    asked = max(asked, abs(slack[i]) * norm[i])
        if most > 0.0 and ptr[k + 1] - ptr[k] > 1:
            way = max(way, asked / (most * most))
    return size, way


@inner
def find_sides(here):
    """Where x is in every row: ``side``, EQUALITY if it may push either way, and what it is violated by, ``slope``.

    And, in the place of the multipliers, ``lambda``, the force that the tolerance of the row may hide.
    """
    size, way = measure_rows(here)
    norm, lo, hi = vector(here, at.NORM), vector(here, at.LO), vector(here, at.HI)
    value, slack, side = vector(here, at.VALUE), vector(here, at.SLOPE), marks(here, at.HELD)
    room = vector(here, at.LAMBDA)
    flat = JUDGED * LENGTH * size + ROUND_OFF * way
    for i in range(ints(here, 0, at.HEAD)[at.ROWS]):
        side[i], room[i] = INACTIVE, 0.0
        if norm[i] == 0.0:
            continue
        near = JUDGED * (abs(value[i]) + abs(value[i] - slack[i])) + flat * norm[i]
        room[i] = NEARLY * norm[i] * near
        over, under = value[i] >= hi[i] - near, value[i] <= lo[i] + near
        if abs(slack[i]) > near:
            side[i] = EQUALITY
            continue
        slack[i] = 0.0
        if lo[i] == hi[i] or (over and under):
            side[i] = EQUALITY
        elif over:
            side[i] = UPPER
        elif under:
            side[i] = LOWER
    return size, way


@inner
def gradient(here, k, last, size, way):
    """The forces of level k: their sum g, and how much they are together; 0 if the level is met."""
    head = ints(here, 0, at.HEAD)
    n, ptr, col, row_of = head[at.N], marks(here, at.PTR), marks(here, at.COL), marks(here, at.ROW_OF)
    g, norm, slack, B = vector(here, at.G), vector(here, at.NORM), vector(here, at.SLOPE), matrix(here, at.B)
    x, x0, scale = vector(here, at.X), vector(here, at.X0), 0.0
    for j in range(n):
        g[j] = 0.0
    if k == last:
        flat = ROUND_OFF * way
        if k < head[at.LEVELS] and marks(here, at.WHOLE)[k] != 0:  # these are rows, and have the tolerance of rows
            flat += JUDGED * LENGTH * size
        for j in range(n):
            away = x[j] - x0[j]
            if abs(away) > JUDGED * (abs(x[j]) + abs(x0[j])) + flat:
                g[j] = away
                scale += abs(away)
        return scale
    for i in range(ptr[k], ptr[k + 1]):
        much = slack[i]
        if much == 0.0:
            continue
        scale += norm[i] * abs(much)
        if col[i] >= 0:
            g[col[i]] += much * norm[i]
        else:
            row = B[row_of[i]]
            for j in range(n):
                g[j] += much * row[j]
    return scale


@inner
def take_up(here, k, frozen):
    """Put the rows of level k that push either way on top of V[:frozen]: how many rows it has then."""
    ptr, side = marks(here, at.PTR), marks(here, at.HELD)
    ids, R = marks(here, at.IDS), matrix(here, at.R)
    count = integer(0)
    for i in range(ptr[k], ptr[k + 1]):
        if side[i] == EQUALITY:
            ids[count] = i
            copy_row(i, R[count], here)
            count += 1
    return enter(here, count, frozen)


@inner
def enter(here, count, c):
    """Put the rows that are listed on top of V[:c], the longest first: how many rows it has then.

    ``balance`` keeps, of each direction of V, how much all these rows together have along it.
    """
    n, ids, pivot = ints(here, 0, at.HEAD)[at.N], marks(here, at.IDS), marks(here, at.PIVOT)
    norm, spread = vector(here, at.NORM), vector(here, at.BALANCE)
    V, L, R = matrix(here, at.V), matrix(here, at.L), matrix(here, at.R)
    slots, lengths, block = marks(here, at.SLOTS), vector(here, at.LENGTHS), marks(here, at.QUEUE)
    end = c + factor(ids, count, slots, lengths, R, norm, V, L, c, n, FREE_RANK)
    for q in range(c, end):
        spread[q], pivot[q], block[q] = 0.0, ids[q - c], c
    for r in range(count):
        row = L[ids[r]]
        for q in range(end):
            part = row[q] / norm[ids[r]]
            spread[q] += part * part
    return end


@inner
def balanced(here, k, last, frozen, scale):
    """Whether the rows above level k balance its forces g, as far as round-off lets one say."""
    hold(here, k)
    working = begin(here, k, frozen)
    working, rest, _ = nonnegative(here, MARGIN * STATIONARITY * scale, frozen, working, marks(here, at.PTR)[k])
    enough, unsure = MARGIN * STATIONARITY * scale, blur(here, frozen, frozen + working)
    rest += unsure
    if unsure > enough:
        return False
    if rest <= enough:
        return True
    small = rest * weakest(here, frozen, working) <= 0.25 * BALANCED * scale
    if small and rest <= MARGIN * BLURRED * scale:
        return True
    if k == last:
        return False
    if unsure + moving(here, k, frozen + working) <= enough:
        return True
    return carried(here, k, frozen, frozen + working, enough - unsure)


@inner
def hold(here, k):
    """Let the rows above level k that are at a bound press, inward."""
    kind, where = marks(here, at.KIND), marks(here, at.HELD)
    value, allowed = vector(here, at.VALUE), vector(here, at.ALLOWED)
    low, high = vector(here, at.LOW), vector(here, at.HIGH)
    for i in range(marks(here, at.PTR)[k]):
        kind[i] = FROZEN if where[i] == EQUALITY else FUTURE
        if where[i] == UPPER or where[i] == LOWER:
            kind[i], value[i], allowed[i] = HARD, 0.0, 0.0
            high[i] = 0.0 if where[i] == UPPER else math.inf
            low[i] = 0.0 if where[i] == LOWER else -math.inf


@inner
def begin(here, k, base):
    """The rows that the solver has kept at their bound, those of them that press: how many."""
    n, end = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR)[k]
    side, kept, where = marks(here, at.SIDE), marks(here, at.FOLLOW), marks(here, at.HELD)
    kind, pivot = marks(here, at.KIND), marks(here, at.PIVOT)
    share, multiplier = vector(here, at.SHARE), vector(here, at.MULTIPLIER)
    ids, slots, lengths, norm = (
        marks(here, at.IDS),
        marks(here, at.SLOTS),
        vector(here, at.LENGTHS),
        vector(here, at.NORM),
    )
    V, L, R = matrix(here, at.V), matrix(here, at.L), matrix(here, at.R)
    count, wrong = integer(0), integer(0)
    for i in range(end):
        if kind[i] == HARD and kept[i] == where[i] and count < len(R):
            ids[count] = i
            copy_row(i, R[count], here)
            count += 1
    working = factor(ids, count, slots, lengths, R, norm, V, L, base, n, CLEAR)
    for q in range(working):
        i = ids[q]
        pivot[base + q], kind[i], side[i] = i, WORKING, where[i]
    while working > 0:
        balance(base, base + working, n, here)
        wrong, count = integer(0), working
        working = integer(0)
        for q in range(base, base + count):
            i = pivot[q]
            share[base + working] = multiplier[q] * side[i]
            if share[base + working] <= 0.0:
                kind[i] = HARD
                wrong += 1
            elif wrong == 0 or append(i, base + working, here, FREE_RANK):
                working += 1
            else:
                kind[i] = HARD
        if wrong == 0:
            break
    return working


@inner
def blur(here, base, c):
    """What round-off in the directions V[:c] may leave of the forces: the weaker a row was, the more.

    All n together leave nothing, unless one of them may be nothing but what round-off has turned an earlier one by,
    which came in another block of rows.
    """
    n, pivot, norm = ints(here, 0, at.HEAD)[at.N], marks(here, at.PIVOT), vector(here, at.NORM)
    g, V, L, block = vector(here, at.G), matrix(here, at.V), matrix(here, at.L), marks(here, at.QUEUE)
    total, least, before, all_there = 0.0, 1.0, 1.0, c == n
    for q in range(c):
        direction, along, share = V[q], 0.0, L[pivot[q]][q] / norm[pivot[q]]
        for j in range(n):
            along += direction[j] * g[j]
        if q == base or (q < base and q == block[q]):
            before = least
        if share * before <= TURNS:
            all_there, share = False, TURNS
        least = min(least, share)
        total += abs(along) / share
    return 0.0 if all_there else TURNS * total


@inner
def weakest(here, base, working):
    """At least the smallest singular value of the normals that balance the level, by how much they have along V."""
    pivot = marks(here, at.PIVOT)
    norm, spread, along = vector(here, at.NORM), vector(here, at.BALANCE), vector(here, at.SCRATCH)
    L, least = matrix(here, at.L), 1.0
    for q in range(base + working):
        along[q] = spread[q] if q < base else 0.0
    for q in range(base, base + working):
        row, square = L[pivot[q]], 0.0
        for p in range(base, q + 1):
            square += row[p] * row[p]
        for p in range(base, q + 1):
            along[p] += row[p] * row[p] / square
        least = min(least, math.sqrt(square) / norm[pivot[q]])
    for q in range(base + working):
        least = min(least, math.sqrt(along[q]))
    return least
