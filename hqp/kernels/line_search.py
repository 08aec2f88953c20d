r"""How far to go along d, in the safe method: to the exact minimum of the level, or to the first hard row in the way.

.. math:: \varphi(a) = \tfrac12 \sum_{i \in k} \operatorname{dist}(v_i + a\,s_i, [l_i, u_i])^2, \qquad
   v = A x, \quad s = A d,

is piecewise quadratic and convex: its minimum is found exactly, kink by kink.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .memory import ints, marks, vector
from .orthogonal import length
from .rows import value_of
from .working_set import FUTURE, HARD

#: A step changes a row if it does so by more than round-off.
MOVES = 1e-12
#: A step this close to 1 is the whole Newton step.
WHOLE = 1e-9
#: The share of its tolerance by which a hard row may be violated where a steeper one blocks just after it (Harris).
RELAXED = 0.1


@inner
def line_search(here, k, last):
    """The length of the step along d, and the row that blocks it there, or -1."""
    ptr, slope, v = marks(here, at.PTR), vector(here, at.SLOPE), vector(here, at.VALUE)
    lo, hi = vector(here, at.LO), vector(here, at.HI)
    rates(here, k, last)
    limit, blocks = blocking_row(here, ptr[k])
    reach = reach_of_reference(here) if k == last else best_step(ptr[k], ptr[k + 1], v, slope, lo, hi)
    if blocks >= 0 and limit < reach:
        return limit, blocks
    return reach, integer(-1)


@inner
def rates(here, k, last):
    """How fast each row of level k, and each hard row that may block, changes along d; 0 where that is round-off."""
    n, ptr, kind = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR), marks(here, at.KIND)
    norm, slope, d = vector(here, at.NORM), vector(here, at.SLOPE), vector(here, at.D)
    steep = length(d, n)
    for i in range(ptr[min(k + 1, last)]):
        slope[i] = 0.0
        if norm[i] > 0.0 and (kind[i] == HARD or (i >= ptr[k] and kind[i] == FUTURE)):
            s = value_of(i, d, here)
            if abs(s) > MOVES * norm[i] * steep:
                slope[i] = s


@inner
def blocking_row(here, hard_end):
    """The step at which the first hard row, all before `hard_end`, is at its bound, and that row, or -1.

    Of rows that are in the way at about the same place, the steepest: how far one may go if all of them give way a
    little, and then, of those met until there, the one that crosses d at the widest angle (Harris 1973).
    """
    kind, slope, allowed = marks(here, at.KIND), vector(here, at.SLOPE), vector(here, at.ALLOWED)
    norm, low, high, v = vector(here, at.NORM), vector(here, at.LOW), vector(here, at.HIGH), vector(here, at.VALUE)
    nearest = math.inf
    for i in range(hard_end):
        if kind[i] == HARD and slope[i] != 0.0:
            room = (high[i] if slope[i] > 0.0 else low[i]) - v[i]
            nearest = min(nearest, (room + math.copysign(RELAXED * allowed[i], slope[i])) / slope[i])
    limit, blocks, steepest = math.inf, integer(-1), -1.0
    for i in range(hard_end):
        if kind[i] == HARD and slope[i] != 0.0:
            ratio = ((high[i] if slope[i] > 0.0 else low[i]) - v[i]) / slope[i]
            if ratio <= nearest and abs(slope[i]) / norm[i] > steepest:
                limit, blocks, steepest = max(ratio, 0.0), i, abs(slope[i]) / norm[i]
    return limit, blocks


@inner
def reach_of_reference(here):
    """The a that minimises ``||x + a d - x_0||``."""
    n = ints(here, 0, at.HEAD)[at.N]
    x, x0, d = vector(here, at.X), vector(here, at.X0), vector(here, at.D)
    steep, reach = length(d, n), 0.0
    for j in range(n):
        reach += d[j] * (x0[j] - x[j])
    reach /= steep * steep
    return 1.0 if abs(reach - 1.0) < WHOLE else reach


@inner
def best_step(first, end, v, slope, lo, hi):
    r"""The a >= 0 that minimises :math:`\sum_i \operatorname{dist}(v_i + a\,s_i, [l_i, u_i])^2` over rows first .. end.

    The derivative is piecewise linear and increasing: from kink to kink, until it changes sign.
    """
    start = initial = 0.0
    for turn in range(2 * (end - first) + 2):
        value, rate, kink = 0.0, 0.0, math.inf  # the derivative at `start`, its slope beyond, and the next kink
        for i in range(first, end):
            s = slope[i]
            if s == 0.0:
                continue
            at_low, at_high = (lo[i] - v[i]) / s, (hi[i] - v[i]) / s
            if start < at_low < kink:
                kink = at_low
            if start < at_high < kink:
                kink = at_high
            if (start >= at_high) if s > 0.0 else (start < at_high):
                value += s * (v[i] + start * s - hi[i])
                rate += s * s
            elif (start < at_low) if s > 0.0 else (start >= at_low):
                value += s * (v[i] + start * s - lo[i])
                rate += s * s
        if turn == 0:
            initial = value
        if value >= -MOVES * abs(initial):
            return start
        if rate > 0.0:
            stop = start - value / rate
            if stop <= kink:
                return 1.0 if abs(stop - 1.0) < WHOLE else stop
        if kink == math.inf:
            return start
        start = kink
    return start
