"""Ranks that could be others: rows that count as dependent, and yet would move a level if they did not.

Where limits saturate, rows that depend on others in exact arithmetic do so up to round-off, magnified by the condition
of the others. Then the rank is arbitrary, but what follows from it for the levels below is not: what such rows pull
with along what is left of them stays unbalanced, and the certificate has to agree.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner
from .memory import ints, marks, vector
from .signs import CLEAR

#: What round-off leaves of a row that depends on others, at most, where these are well conditioned.
SHARPEST = 2e-12
#: Of rows of which more is left nobody doubts the dependence: a rank tolerance that was set on purpose says so.
MOST = 1e-9
#: A row that is this much shorter than another of its level may disappear in the round-off of that one.
EVEN = 1e-8


@inner
def note_doubt(here, begin, rank, count, pull):
    """Note if the dependent rows of a level that is not met leave too much of its forces unbalanced.

    They are the last of the `count` rows that stand in the list of rows from `begin` on, behind `rank` others.
    """
    ids, lengths, w, norm = marks(here, at.IDS), vector(here, at.LENGTHS), vector(here, at.W), vector(here, at.NORM)
    left = 0.0
    for r in range(begin + rank, begin + count):
        if lengths[r] <= MOST * norm[ids[r]]:
            left += abs(w[ids[r]]) * lengths[r]
    if left > CLEAR * pull > 0.0:
        ints(here, 0, at.HEAD)[at.DOUBT] = 1


@inner
def sharpen(here):
    """Have ranks as sharp as round-off allows from here on: False where they are, or where that is not ours to decide.

    What comes out is in doubt.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    if head[at.DAMPED] != 0 or option[at.TAU] <= SHARPEST or option[at.TAU] > MOST:
        return False
    option[at.TAU], head[at.DOUBT] = SHARPEST, 1
    return True


@inner
def is_even(here):
    """Whether the rows of each level are of comparable length, weights included."""
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
    """Whether an answer that is proved as far as one tolerance goes, or one rank, may be none by others."""
    return ints(here, 0, at.HEAD)[at.DOUBT] != 0 or not is_even(here)
