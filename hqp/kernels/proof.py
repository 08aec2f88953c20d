r"""The compiled certificate: decides whether x is optimal from the numbers of the hierarchy alone.

As in :mod:`hqp.certificate.balance`, level by level, the normals of the rows above must balance the forces of the level
up to round-off: free normals (equalities and violated rows) with multipliers of either sign, normals of rows at a bound
with multipliers of one sign. What it accepts, the certificate accepts too, as its least squares leave no larger
residual. What it rejects may still be optimal: it does not ask which rows at a bound hold a level above and are
therefore free, which depends on round-off.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .escape import nonnegative
from .lift import choose, lift, note_shares, press
from .memory import ints, marks, matrix, vector
from .orthogonal import factor, length
from .round_off import blur, weakest
from .rows import EQUALITY, INACTIVE, LOWER, UPPER, copy_row, value_of
from .shift import carried, moving
from .working_set import FROZEN, FUTURE, HARD, WORKING, append, balance

#: As in :mod:`hqp.certificate`: the tolerance on rows, round-off of rows and of forces.
JUDGED, ROUND_OFF, BALANCED = 1e-9, 256 * 2.0**-52, 64 * 2.0**-52
#: As there: the rank tolerance of free normals; the residual that is allowed, and its upper limit for badly conditioned
#: rows.
FREE_RANK, STATIONARITY, BLURRED = 1e-11, 1e-10, 1e-6
#: Factors on the residual of forces and on tolerances, so that other rounding in the certificate cannot reverse an
#: acceptance.
MARGIN, NEARLY = 0.9, 0.99
#: Share of the length of x in the tolerance of a row, for rows that x hardly changes.
LENGTH = 0.1


@inner
def proves(here, last):
    """Whether the certificate accepts x on levels 0 .. last. Overwrites the basis V, and CUT."""
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
            note_shares(here, k, frozen, integer(0))
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
    """Write ``value`` and slack (to ``slope``) of all rows.

    Returns ``||x||``, and the distance T of :func:`hqp.certificate.rows.travel`, to which round-off is relative.
    """
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
    """Write the side of every row at x to ``held``, EQUALITY if its multiplier is free, and its violation to ``slope``.

    Also, to ``lambda``, the force that the tolerance of the row may hide. Returns as :func:`measure_rows`.
    """
    size, way = measure_rows(here)
    norm, lo, hi = vector(here, at.NORM), vector(here, at.LO), vector(here, at.HI)
    value, slack, side = vector(here, at.VALUE), vector(here, at.SLOPE), marks(here, at.HELD)
    room, depth = vector(here, at.LAMBDA), marks(here, at.DEPTH)
    flat = JUDGED * LENGTH * size + ROUND_OFF * way
    for i in range(ints(here, 0, at.HEAD)[at.ROWS]):
        side[i], room[i], depth[i] = INACTIVE, 0.0, -1
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
    """Write the gradient ``g`` of level k; returns the sum of its forces, 0 if the level is met.

    `size` and `way` are those of :func:`measure_rows`.
    """
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
    """Append the free rows of level k (``held`` = EQUALITY) to V[:frozen]; returns how many rows it then has."""
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
    """Append the `count` rows in ``ids`` and R to V[:c], the longest first; returns how many rows V then has.

    ``balance[q]`` is the sum of the squared coefficients along V[q] of all rows so far, each divided by its length.
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
    """Whether the rows above level k balance its gradient ``g``, up to round-off; `scale` is the sum of its forces."""
    enough = MARGIN * STATIONARITY * scale
    choose(here, k)
    if lift(here, k, frozen, press(here, k, frozen), scale, enough):
        return True
    working = press(here, k, frozen)  # without the rows that lifting has left with no multiplier
    hold(here, k)
    working = begin(here, k, frozen, working)
    working, rest, _ = nonnegative(here, enough, frozen, working, marks(here, at.PTR)[k])
    note_shares(here, k, frozen, working)
    unsure = blur(here, vector(here, at.G), frozen, frozen + working)
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
    """Prepare the rows above level k for :func:`.escape.nonnegative`: those at a bound are hard, free ones frozen."""
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
def begin(here, k, base, working):
    """Start the working set with those rows of :func:`.lift.press` whose multipliers are positive without the others.

    `base` is the number of rows of V that span the free normals. Returns how many rows the working set has.
    """
    side, where = marks(here, at.SIDE), marks(here, at.HELD)
    kind, pivot = marks(here, at.KIND), marks(here, at.PIVOT)
    share, multiplier = vector(here, at.SHARE), vector(here, at.MULTIPLIER)
    for q in range(base, base + working):
        kind[pivot[q]], side[pivot[q]] = WORKING, where[pivot[q]]
    while working > 0:
        balance(vector(here, at.G), base, base + working, here)
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
