"""How much x jumps at its bounds: there the strict answer of a curved hierarchy is not taken unchanged."""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .active_set import OPTIMAL
from .compile import inner
from .curved_rows import note_bounds, only_entry, value_at
from .memory import ints, marks, matrix, vector

#: Share of its range within which a row of the strict answer is near a bound, and the power with which the nearness
#: counts. A smaller power holds back motions in reach that come near a bound.
NEAR, SOONER = 0.2, 3
#: The same of the last x, which leaves a bound. With a larger share a hand that trembles in reach leans, too.
LEFT_BEHIND, EVENLY = 0.4, 1
#: A leap of 1 is the first step of a variable at its bound that dies away at the rate of the fastest task. Up to the
#: first of these leaps the strict answer follows the last x smoothly; from the second on it jumps.
SMOOTH, JUMP = 0.2, 0.7
#: A gate below this is that of a row at rest near its bound, but for round-off: a lean of such a weight means nothing.
AT_REST = 1e-12
#: Larger values of the last x count as unknown: their squares are too large for a hierarchy.
FASTEST = 1e12


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
    least, most, columns, gate = vector(here, at.LEAST), vector(here, at.MOST), marks(here, at.COLUMNS), 0.0
    for p in range(len(columns)):
        j = columns[p]
        gate = max(gate, moves_along(x[j], least[j], most[j], NEAR, SOONER))
    for p in range(marks(here, at.OWN_OF)[ints(here, 0, plain.HEAD)[at.TOP]]):
        i = marks(here, at.OWN)[p]
        if only_entry(here, i) < 0:
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
def knows_last(here):
    """Whether the last x is known, and all its numbers mean something."""
    last, known = vector(here, at.LAST), True
    for j in range(ints(here, 0, plain.HEAD)[plain.N]):
        known = known and abs(last[j]) <= FASTEST
    return known


@inner
def crowd(here, strict):
    """Set the gate of every block: how much the strict answer jumps at bounds; returns the largest."""
    x, gate = vector(marks(here, at.DIRECTORIES)[ints(here, 0, plain.HEAD)[plain.LEVELS]], plain.X), 0.0
    known = knows_last(here)
    for block in marks(here, at.BLOCKS):
        note_bounds(block)
        own = 0.0 if not known else jumps(block, x) if strict == OPTIMAL else 1.0
        if own < AT_REST:
            own = 0.0
        vector(block, at.SO_FAR)[at.GATE] = own
        gate = max(gate, own)
    return gate
