"""Finds rank decisions that are in doubt: rows count as dependent, but the solution would change if they did not.

Rows that depend on others in exact arithmetic, as where limits saturate, depend on them only up to round-off, magnified
by the condition number of the others. Their rank is then arbitrary, but the levels below depend on it: the forces of
such rows along what projection leaves of them stay unbalanced. So the certificate has to accept the answer.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner
from .memory import ints, marks, vector
from .signs import CLEAR

#: Smallest rank tolerance: well-conditioned others leave no larger share of a dependent row, by round-off.
SHARPEST = 2e-12
#: Dependent rows of which a larger share is left are not in doubt: the user has set such a rank tolerance on purpose.
MOST = 1e-9
#: A row of which a smaller share is left counts, but what it asks for is magnified, and so is the round-off of all rows
#: that are left in its direction: the signs of their multipliers are in doubt.
WEAK = 1e-5
#: A row that is shorter by this factor than another of its level may disappear in the round-off of that one: forces and
#: factors go by squares of lengths.
EVEN = 1e-6


@inner
def note_doubt(here, begin, rank, count, pull):
    """Set DOUBT to 1 if the dependent rows of an unmet level leave too much of its forces, `pull`, unbalanced.

    And if a pivot row is :data:`WEAK`. The `count` active rows of the level are in ``ids`` from place `begin` on: first
    `rank` pivot rows, then dependent ones.
    """
    ids, lengths, w, norm = marks(here, at.IDS), vector(here, at.LENGTHS), vector(here, at.W), vector(here, at.NORM)
    for r in range(begin, begin + rank):
        if lengths[r] < WEAK * norm[ids[r]]:
            ints(here, 0, at.HEAD)[at.DOUBT] = 1
    left = 0.0
    for r in range(begin + rank, begin + count):
        if lengths[r] <= MOST * norm[ids[r]]:
            left += abs(w[ids[r]]) * lengths[r]
    if left > CLEAR * pull > 0.0:
        ints(here, 0, at.HEAD)[at.DOUBT] = 1


@inner
def sharpen(here):
    """Set the rank tolerance to SHARPEST, and DOUBT to 1; False if it is as small already, or was set by the user.

    Neither with damped levels.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    if head[at.DAMPED] != 0 or option[at.TAU] <= SHARPEST or option[at.TAU] > MOST:
        return False
    option[at.TAU], head[at.DOUBT] = SHARPEST, 1
    return True


@inner
def is_even(here):
    """Whether the weighted rows of each level are of comparable length, see :data:`EVEN`."""
    head, ptr, norm = ints(here, 0, at.HEAD), marks(here, at.PTR), vector(here, at.NORM)
    for k in range(head[at.LEVELS]):
        shortest, longest = math.inf, 0.0
        for i in range(ptr[k], ptr[k + 1]):
            if norm[i] > 0.0:
                shortest, longest = min(shortest, norm[i]), max(longest, norm[i])
        if shortest < EVEN * longest:
            return False
    return True


@inner
def doubtful(here):
    """Whether the certificate must judge an answer: a rank is in doubt, or a level has rows of very unequal lengths."""
    return ints(here, 0, at.HEAD)[at.DOUBT] != 0 or not is_even(here)
