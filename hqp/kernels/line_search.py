r"""The step length along d in the safe method: to the exact minimum of the level, or to the first hard row that blocks.

.. math:: \varphi(a) = \tfrac12 \sum_{i \in k} \operatorname{dist}(v_i + a\,s_i, [l_i, u_i])^2, \qquad
   v = A x, \quad s = A d,

is piecewise quadratic and convex, so that its minimum is found exactly, from one kink of its derivative to the next.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .memory import ints, marks, vector
from .orthogonal import length
from .rows import value_of
from .working_set import FUTURE, HARD

#: A change of a row along d below this share of both lengths is round-off.
MOVES = 1e-12
#: A step length this close to 1 is rounded to 1, the whole Newton step.
WHOLE = 1e-9
#: Share of its tolerance by which a hard row may be violated, so that a steeper row just behind it can block (Harris).
RELAXED = 0.1


@inner
def line_search(here, k, last):
    """The step length along ``d`` for level k, and the hard row that blocks it there, or -1."""
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
    """Write ``slope`` = a_i d of each row of level k and of each hard row; 0 where that is round-off."""
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
    """The step length at which the first hard row before `hard_end` reaches its bound, and that row (none: inf, -1).

    Ratio test of Harris (1973): the largest step is computed with slightly widened bounds; of the rows that reach their
    true bound within it, the one with the steepest slope, relative to its length, blocks.
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
    """The step length a that minimises ``||x + a d - x_0||``."""
    n = ints(here, 0, at.HEAD)[at.N]
    x, x0, d = vector(here, at.X), vector(here, at.X0), vector(here, at.D)
    steep, reach = length(d, n), 0.0
    for j in range(n):
        reach += d[j] * (x0[j] - x[j])
    reach /= steep * steep
    return 1.0 if abs(reach - 1.0) < WHOLE else reach


@inner
def best_step(first, end, v, slope, lo, hi):
    r"""The a >= 0 that minimises :math:`\sum_i \operatorname{dist}(v_i + a\,s_i, [l_i, u_i])^2`, i = first .. end - 1.

    The derivative is piecewise linear and increasing; its kinks are visited in turn, until it changes sign.
    `v`, `slope`, `lo`, `hi` have shape (m,).
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
