"""How close x moves along its bounds: there the strict answer of a curved hierarchy is not taken unchanged."""

from __future__ import annotations

import math

from . import curved_layout as at
from . import layout as plain
from .active_set import OPTIMAL
from .compile import inner
from .curved_rows import note_bounds, value_at
from .memory import ints, marks, matrix, vector

#: Share of its range within which a row is near a bound, and the power with which the nearness counts. With a smaller
#: power the lean lets go of x more slowly as it leaves a bound, and holds back motions in reach that come near one: by
#: 0.6 mm the centre of mass of a humanoid that squats.
NEAR, SOONER = 0.2, 3
#: Larger values of the last x count as unknown: their squares are too large for a hierarchy.
FASTEST = 1e12


@inner
def moves_along(value, low, high):
    """How close a value moves along its bounds low .. high: 0 away from them, or NaN; 1 at one of them."""
    room = high - low
    if not room > 0.0 or room == math.inf:
        return 0.0
    near = min(value - low, high - value) / room
    if not near < NEAR:
        return 0.0
    moving = min(1.0, 2.0 * abs(value) / max(abs(low), abs(high)))  # a value at rest at its bound does not count
    return moving * min(1.0, 1.0 - near / NEAR) ** SOONER


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
        gate = max(gate, moves_along(x[j], least[j], most[j]))
    for p in range(marks(here, at.OWN_OF)[ints(here, 0, plain.HEAD)[at.TOP]]):
        i = marks(here, at.OWN)[p]
        if col[i] < 0:
            low, high = ends_of(here, i)
            gate = max(gate, moves_along(value_at(here, i, x), low, high))
    return gate


@inner
def knows_last(here):
    """Whether the last x is known, and all its numbers mean something."""
    last, known = vector(here, at.LAST), True
    for j in range(ints(here, 0, plain.HEAD)[plain.N]):
        known = known and abs(last[j]) <= FASTEST
    return known


@inner
def crowd(here, strict):
    """Set the gate of every block: how close the strict answer moves along bounds; returns the largest."""
    x, gate = vector(marks(here, at.DIRECTORIES)[ints(here, 0, plain.HEAD)[plain.LEVELS]], plain.X), 0.0
    known = knows_last(here)
    for block in marks(here, at.BLOCKS):
        note_bounds(block)
        own = 0.0 if not known else crowded(block, x) if strict == OPTIMAL else 1.0
        vector(block, at.SO_FAR)[at.GATE] = own
        gate = max(gate, own)
    return gate
