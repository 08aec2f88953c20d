"""Decides whether the strict answer of a curved hierarchy can be taken unchanged, as in almost every tick.

It can if no level needs damping by its curvature, and x does not jump at bounds.
"""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .bend import TRUSTED, bound, contract
from .compile import inner, integer
from .curved_rows import gather, value_at
from .lacking import note_lacking
from .memory import ints, marks, matrix, vector
from .redundant import BALANCED, across, has_unknown, longest, weight_of
from .solver import levels_that_count

#: Share of its range within which a row of the strict answer is near a bound, and the power with which the nearness
#: counts. A smaller power holds back motions in reach that come near a bound.
NEAR, SOONER = 0.2, 3
#: The same of the last x, which leaves a bound. With a larger share a hand that trembles in reach leans, too.
LEFT_BEHIND, EVENLY = 0.4, 1
#: A leap of 1 is the first step of a variable at its bound that dies away at the rate of the fastest task. Up to the
#: first of these leaps the strict answer follows the last x smoothly; from the second on it jumps.
SMOOTH, JUMP = 0.2, 0.7


@inner
def moves_along(value, low, high, share, power):
    """How close a value moves along its bounds low .. high: 0 away from them, or NaN; 1 at one of them.

    It is near within this `share` of its range, and the nearness counts with this `power`.
    """
    room = high - low
    if not room > 0.0 or room == math.inf:
        return 0.0
    near = min(value - low, high - value) / room
    if not near < share:
        return 0.0
    moving = min(1.0, 2.0 * abs(value) / max(abs(low), abs(high)))  # a value at rest at its bound does not count
    return moving * min(1.0, 1.0 - near / share) ** power


@inner
def sign_of(row, other, n):
    """1 if two rows are equal, -1 if they are opposite, else 0."""
    same, opposite = True, True
    for j in range(n):
        same = same and row[j] == other[j]
        opposite = opposite and row[j] == -other[j]
        if not (same or opposite):
            return 0
    return 1 if same else -1


@inner
def ends_of(here, i):
    """The ends of dense row i above the curved levels; where it has but one, the other one from the rows alike it."""
    lower, upper, col = vector(here, plain.LOWER), vector(here, plain.UPPER), marks(here, plain.COL)
    n, row_of, A = ints(here, 0, plain.HEAD)[plain.N], marks(here, plain.ROW_OF), matrix(here, plain.A)
    low, high = lower[i], upper[i]
    if (low == -math.inf) == (high == math.inf):
        return low, high
    for p in range(marks(here, at.OWN_OF)[ints(here, 0, plain.HEAD)[at.TOP]]):
        r = marks(here, at.OWN)[p]
        if col[r] >= 0 or r == i:
            continue
        sign = sign_of(A[row_of[i]], A[row_of[r]], n)
        if sign > 0:
            low, high = max(low, lower[r]), min(high, upper[r])
        elif sign < 0:
            low, high = max(low, -upper[r]), min(high, -lower[r])
    return low, high


@inner
def crowded(here, x):
    """How close x moves along bounds of the levels above the curved ones, by :func:`moves_along`.

    Bounds of a variable count as one pair, however many rows they are told in, and so do the two of a dense row.
    """
    col = marks(here, plain.COL)
    least, most, columns, gate = vector(here, at.LEAST), vector(here, at.MOST), marks(here, at.COLUMNS), 0.0
    for p in range(len(columns)):
        j = columns[p]
        gate = max(gate, moves_along(x[j], least[j], most[j], NEAR, SOONER))
    for p in range(marks(here, at.OWN_OF)[ints(here, 0, plain.HEAD)[at.TOP]]):
        i = marks(here, at.OWN)[p]
        if col[i] < 0:
            low, high = ends_of(here, i)
            gate = max(gate, moves_along(value_at(here, i, x), low, high, NEAR, SOONER))
    return gate


@inner
def jumps(here, x):
    """How much the strict answer x (n,) jumps at bounds: 1 if it has to lean on the last x in full, 0 if not at all.

    It does where it moves along bounds, or the last x does and x leaves them, as far as a variable leaps: what begins
    or ends smoothly is not held back. Without any bound nothing tells what a leap is, and nearness alone counts.
    """
    last, least, most, columns = (
        vector(here, at.LAST),
        vector(here, at.LEAST),
        vector(here, at.MOST),
        marks(here, at.COLUMNS),
    )
    a_tick, farthest, left, bounded = vector(here, at.SHARES)[ints(here, 0, plain.HEAD)[at.TOP]], 0.0, 0.0, False
    for p in range(len(columns)):
        j = columns[p]
        size = a_tick * max(abs(least[j]), abs(most[j]))
        bounded = bounded or 0.0 < size < math.inf
        step = abs(x[j] - last[j])
        if SMOOTH * size < step and size > 0.0:  # an infinite size is passed by
            leap = min(1.0, (step / size - SMOOTH) / (JUMP - SMOOTH))
            farthest = max(farthest, leap)
            left = max(left, leap * moves_along(last[j], least[j], most[j], LEFT_BEHIND, EVENLY))
    return max(left, (farthest if bounded else 1.0) * crowded(here, x))


@inner
def least_of(L, pivot, first, end, column):
    """A lower bound of the smallest squared singular value of the triangle first .. end - 1 of L: 1 / ||inverse||_F^2.

    `column` is work space.
    """
    total = 0.0
    for c in range(first, end):
        for r in range(c, end):
            row = L[pivot[r]]
            value = 1.0 if r == c else 0.0
            for q in range(c, r):
                value -= row[q] * column[q - first]
            value /= row[r]
            column[r - first] = value
            total += value * value
    return 1.0 / total if total > 0.0 else math.inf


@inner
def pushed(here, there, k, c, f):
    """Write the multipliers of the rows above level k as weights ``wanted`` of their curvatures; whether there are any.

    As :func:`.bend.multipliers`, but from the triangle of the first c rows of V, over the f free variables, in the
    directory `there`.
    """
    V, L, pivot, free = (
        matrix(there, plain.V),
        matrix(there, plain.L),
        marks(there, plain.PIVOT),
        marks(there, plain.FREE),
    )
    pull, mu, wanted = vector(here, at.PULL), vector(here, at.MU), vector(here, at.WANTED)
    ptr, weights, some = marks(here, plain.PTR), vector(here, plain.WEIGHTS), False
    for i in range(ptr[ints(here, 0, plain.HEAD)[at.TOP]], ptr[k]):
        wanted[i] = 0.0
    for t in range(f):
        some = some or pull[free[t]] != 0.0
    if not some:
        return False
    for q in range(c):
        direction, total = V[q], 0.0
        for t in range(f):
            total += direction[t] * pull[free[t]]
        mu[q] = total
    for q in range(c - 1, -1, -1):
        row = L[pivot[q]]
        mu[q] /= row[q]
        for r in range(q):
            mu[r] -= row[r] * mu[q]
        wanted[pivot[q]] = mu[q] * weights[pivot[q]]
    return True


@inner
def leave_off(here, there, c, f):
    """Write to ``reach`` where the levels above leave off: the strict x along the first c rows of V alone.

    Variables that are not among the f free ones are held.
    """
    V, x, out, free = matrix(there, plain.V), vector(there, plain.X), vector(here, at.REACH), marks(there, plain.FREE)
    for j in range(ints(here, 0, plain.HEAD)[plain.N]):
        out[j] = x[j]
    for t in range(f):
        out[free[t]] = 0.0
    for q in range(c):
        direction, along = V[q], 0.0
        for t in range(f):
            along += direction[t] * x[free[t]]
        for t in range(f):
            out[free[t]] += along * direction[t]


@inner
def repeated(here, there, k, count, first, end, f):
    """Whether those of the `count` rows of level k that are none of its rows first .. end - 1 of V repeat others.

    As :func:`.redundant.least_apart` decides, but by the triangle in the directory `there`; f as in :func:`pushed`.
    """
    n, J, ids = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.J), marks(here, at.IDS)
    pivot, free, weights, size = marks(there, plain.PIVOT), marks(there, plain.FREE), vector(here, plain.WEIGHTS), 0.0
    pull, wanted, S = vector(here, at.PULL), vector(here, at.WANTED), matrix(here, at.S)
    for j in range(n):
        pull[j] = 0.0
    for r in range(count):
        u = weight_of(r)
        for q in range(first, end):
            if pivot[q] == ids[r]:
                u = 0.0
        wanted[ids[r]] = -u * weights[ids[r]]
        size += u * u
        for j in range(n):
            pull[j] += u * J[r][j]
    pushed(here, there, k, end, f)
    most = BALANCED * math.sqrt(longest(here, count) * size)
    balanced = has_unknown(here, k) or contract(here, ints(here, 0, plain.HEAD)[at.TOP], k + 1) <= most
    if not balanced:
        for i in range(f):
            for j in range(f):
                S[i][j] = S[free[i]][free[j]]
        balanced = across(here, matrix(there, plain.V), 0, first, f) <= most
    gather(here, k)  # as it was
    return balanced


@inner
def quiet(here, there):
    """Whether the strict answer needs no damping, from the basis that the solver has left in the directory `there`.

    It must come from one sweep, with no active inequality. The ratios are those of :func:`.bend.bend`, but computed
    from the triangles of that basis, which costs less than the sweep.
    """
    head, ptr = ints(here, 0, plain.HEAD), marks(here, plain.PTR)
    n, levels, last, cut = head[plain.N], head[plain.LEVELS], levels_that_count(there), marks(there, plain.CUT)
    pivot, L, weights = marks(there, plain.PIVOT), matrix(there, plain.L), vector(here, plain.WEIGHTS)
    lower, upper, ids, f = vector(here, plain.LOWER), vector(here, plain.UPPER), marks(here, at.IDS), integer(0)
    if cut[last] < 0 or ints(there, 0, plain.HEAD)[plain.SWEEPS] != 1:  # no basis, or one of another guess
        return False
    for q in range(cut[last]):
        if lower[pivot[q]] != upper[pivot[q]]:
            return False
    for j in range(n):
        pinned = marks(there, plain.PINNED)[j]
        if pinned < 0:
            f += 1
        elif lower[pinned] != upper[pinned]:
            return False
    for k in range(head[at.TOP], levels):
        if head[at.LOOKS_AHEAD] != 0 and k > head[at.TOP]:
            leave_off(here, there, cut[min(k, last)], f)
            for block in marks(here, at.BLOCKS):
                note_lacking(block, k)
        count, least = gather(here, k), math.inf
        if marks(here, at.CURVED)[k] == at.SPARED:
            continue
        for r in range(count):
            if lower[ids[r]] != upper[ids[r]]:
                return False
        first = cut[min(k, last)]
        if k >= last:
            for i in range(ptr[k], ptr[k + 1]):
                least = min(least, weights[i] * weights[i])
        elif cut[k + 1] - first < count and not repeated(here, there, k, count, first, cut[k + 1], f):
            return False
        else:
            least = least_of(L, pivot, first, cut[k + 1], vector(here, at.VALUES))
        some = first > 0 and pushed(here, there, k, first, f)
        if bound(here, k, k + 1) + (bound(here, head[at.TOP], k) if some else 0.0) <= TRUSTED * least:
            continue
        bent = contract(here, k, k + 1)
        if some:
            bent += contract(here, head[at.TOP], k)
        if bent > TRUSTED * least:
            return False
    return True
