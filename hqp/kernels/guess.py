"""Guesses the active set without a warm start: solves one weighted problem in place of the strict hierarchy.

Its x is approximate. Its active rows are mostly right if only the last level cannot be met; the sweep verifies them. If
higher levels cannot be met either, the guess is poor, because with finite weights lower levels shift higher ones.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .dual import ROUGH, admit, settle
from .memory import ints, marks, vector
from .rows import EQUALITY, INACTIVE, note_spans
from .working_set import HARD

#: Softness of the highest and of the lowest level, relative to the square of the longest row of the level.
HARDEST, SOFTEST = 3e-15, 1e-5
#: Limits of the guess: with more unknowns, or more rounds, it is slow and mostly wrong.
UNKNOWNS, ROUNDS = 12, 16


@inner
def guess(here, last):
    """Set ``side`` to the active rows of the weighted problem; False beyond the limits UNKNOWNS and ROUNDS."""
    head = ints(here, 0, at.HEAD)
    n, first = head[at.N], 1 if head[at.BOXED] != 0 else 0
    ptr, side, kind, depth = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.KIND), marks(here, at.DEPTH)
    lo, hi, norm, soft = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), vector(here, at.VALUE)
    anchor, x0 = vector(here, at.ANCHOR), vector(here, at.X0)
    most = len(marks(here, at.MEMBERS))
    if n > UNKNOWNS:
        return False
    note_spans(here)
    for j in range(n):
        anchor[j] = x0[j]
    count, softness = integer(0), HARDEST
    step = (SOFTEST / HARDEST) ** (1.0 / max(last - first - 1, 1))
    for k in range(last):
        longest = 0.0
        for i in range(ptr[k], ptr[k + 1]):
            longest = max(longest, norm[i])
        for i in range(ptr[k], ptr[k + 1]):
            kind[i], side[i], depth[i] = HARD, INACTIVE, -1
            soft[i] = 0.0 if k < first else softness * longest * longest
            if norm[i] > 0.0 and lo[i] == hi[i]:
                side[i] = EQUALITY
                if count < most and admit(i, integer(0), count, 0.0, here):
                    count += 1
        softness *= 1.0 if k < first else step
    return settle(here, ptr[last], integer(0), count, 0.0, integer(ROUNDS), ROUGH) >= 0
