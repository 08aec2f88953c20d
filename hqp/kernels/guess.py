"""A guess from nothing: which rows are active, from problems that are weighted instead of strict.

The answers are not exact, but which rows are active they mostly get right; the sweep decides. All levels at once, many
decades of softness apart, is quick, and right where at most the last level is out of reach. Where others are, those
below move them by more than decades hide, and the levels are taken one by one.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .dual import settle
from .memory import ints, marks, vector
from .sweep import EQUALITY, INACTIVE

#: Softness of the highest and of the lowest level, relative to the longest row of the level.
HARDEST, SOFTEST = 3e-15, 1e-5
#: Level by level: softness of the one that is being settled, and of those that are. From which slack on a level is not
#: met; and from which multiplier on, relative to the largest, a row holds it back.
OPEN, SETTLED, UNMET, PRESSING = 1e-8, 1e-13, 1e-6, 1e-6


@inner
def soften(here, k, softness):
    """The rows of level k get this softness, relative to the longest of them."""
    ptr, norm, soft = marks(here, at.PTR), vector(here, at.NORM), vector(here, at.VALUE)
    longest = 0.0
    for i in range(ptr[k], ptr[k + 1]):
        longest = max(longest, norm[i])
    for i in range(ptr[k], ptr[k + 1]):
        soft[i] = softness * longest * longest


@inner
def equalities(here, k, count):
    """The equalities of level k, and no others, join W; its rows then, or -1 if there are more than fit."""
    ptr, side, held, rows = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.DECIDED), marks(here, at.MEMBERS)
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    multiplier, goal = vector(here, at.W), vector(here, at.LOW)
    for i in range(ptr[k], ptr[k + 1]):
        multiplier[i] = 0.0
        side[i], held[i] = INACTIVE, 0
        if norm[i] > 0.0 and lo[i] == hi[i]:
            if count == len(rows):
                return integer(-1)
            side[i], held[i] = EQUALITY, 1
            rows[count], goal[i] = i, lo[i]
            count += 1
    return count


@inner
def unmet(here, first, end, count):
    """Whether some row of W, of those from `first` to `end`, is off its bound by more than its softness explains."""
    n, rows = ints(here, 0, at.HEAD)[at.N], marks(here, at.MEMBERS)
    norm, x, soft = vector(here, at.NORM), vector(here, at.X), vector(here, at.VALUE)
    goal, multiplier = vector(here, at.LOW), vector(here, at.W)
    size = 0.0
    for j in range(n):
        size = max(size, abs(x[j]))
    for c in range(count):
        i = rows[c]
        if first <= i < end and soft[i] * abs(multiplier[i]) > UNMET * (abs(goal[i]) + norm[i] * size):
            return True
    return False


@inner
def guess(here, last, staged):
    """Set ``side`` to the active rows of the weighted problem, or to the first of them if they are more than fit.

    All levels at once, or, if `staged`, one by one: what a level leaves unmet, and what holds it back, stays where it
    is for those below, so that no level gives way to another, however far that is from being met.
    """
    head = ints(here, 0, at.HEAD)
    first = 1 if head[at.BOXED] != 0 else 0
    ptr, held, rows = marks(here, at.PTR), marks(here, at.DECIDED), marks(here, at.MEMBERS)
    norm, soft = vector(here, at.NORM), vector(here, at.VALUE)
    multiplier, goal = vector(here, at.W), vector(here, at.LOW)
    count = known = integer(0)
    softness = HARDEST
    step = (SOFTEST / HARDEST) ** (1.0 / max(last - first - 1, 1))
    for k in range(last):
        hard = k < first  # bounds on distinct variables
        soften(here, k, 0.0 if hard else OPEN if staged else softness)
        softness *= 1.0 if hard else step
        count = equalities(here, k, count)
        if count < 0:
            return
        if k < last - 1 and (hard or not staged):
            continue
        count = settle(here, ptr[k + 1], count, known)
        if count < 0 or k == last - 1:
            return
        known = count
        if unmet(here, ptr[k], ptr[k + 1], count):
            strongest = 0.0
            for c in range(count):
                strongest = max(strongest, norm[rows[c]] * abs(multiplier[rows[c]]))
            for c in range(count):
                i = rows[c]
                if norm[i] * abs(multiplier[i]) > PRESSING * strongest:
                    held[i] = 1
                    goal[i] += soft[i] * multiplier[i]
        soften(here, k, SETTLED)
