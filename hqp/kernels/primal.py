"""Primal active-set steps from a point that satisfies the levels above to the optimum of a level."""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .dual import late
from .extent import extent
from .memory import ints, marks, vector
from .orthogonal import length
from .polish import judge, polish
from .rows import EQUALITY, INACTIVE, LOWER, UPPER, target, value_of
from .working_set import FROZEN

#: The most steps of one level.
STEPS = 60
#: A change of a row along a step below this share of both lengths is round-off.
MOVES = 1e-12
#: A step that is no longer than this share of x is none; so many members in a row may leave without a step.
STILL, PATIENCE = 1e-12, 6


@inner
def first_event(here, k):
    """The step length from APPROACH towards x to the first row that reaches its bound, from inside or from outside.

    Returns
    -------
    reach : float
        The step length, at most 1.
    row, side : int
        This row, or -1; and the side that it gets.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    n, tol = head[at.N], option[at.TOL]
    ptr, side, kind = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.KIND)
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    x, start, d = vector(here, at.X), vector(here, at.APPROACH), vector(here, at.D)
    steep = 0.0
    for j in range(n):
        d[j] = x[j] - start[j]
        steep += d[j] * d[j]
    steep, size = math.sqrt(steep), extent(start, here)
    reach, row, becomes = 1.0, integer(-1), integer(INACTIVE)
    for i in range(ptr[k + 1]):
        if norm[i] == 0.0 or kind[i] == FROZEN or side[i] == EQUALITY:
            continue
        rate = value_of(i, d, here)
        if abs(rate) <= MOVES * norm[i] * steep:
            continue
        value = value_of(i, start, here)
        if side[i] == INACTIVE:
            bound = hi[i] if rate > 0.0 else lo[i]
            ratio = max(0.0, (bound - value) / rate)
            if ratio < reach and abs(value + rate - bound) > tol * (abs(bound) + norm[i] * size):
                reach, row, becomes = ratio, i, integer(UPPER if rate > 0.0 else LOWER)
        elif i >= ptr[k]:  # violated, and within its bounds from this step length on
            bound = target(side[i], lo[i], hi[i])
            slack = (value - bound) * side[i]
            near = tol * (abs(bound) + norm[i] * size)
            if slack > near and slack + rate * side[i] < -near:
                ratio = -slack / (rate * side[i])
                if ratio < reach:
                    reach, row, becomes = ratio, i, integer(INACTIVE)
    return reach, row, becomes


@inner
def polish_again(here, k, last, frozen, known):
    """Solve level k as :func:`.polish.polish`, with what is known of the last time where ranks allow it."""
    hard, rank, own, own_rank = polish(here, k, last, frozen, known)
    if known > 0 and rank < hard:  # which rows are the dependent ones is for all of them to decide
        hard, rank, own, own_rank = polish(here, k, last, frozen, integer(0))
    return hard, rank, own, own_rank


@inner
def primal(here, k, last, frozen, hard, rank, own, own_rank, known):
    """Take primal steps from APPROACH until level k is optimal, or STEPS are spent.

    `hard`, `rank`, `own` and `own_rank` are those of :func:`.polish.polish`, which has just solved the level: its first
    pivot rows stay those of V. `known` tells that it did so with the present ``side``.

    Each step goes towards the x of :func:`.polish.polish`, up to the first event; then one row changes its side. A
    member that leaves the working set because of the sign of its multiplier, and blocks the next step at once, stays:
    as far as ranks can tell, the level gains nothing without it. If nothing else contradicts the level, it is optimal,
    and in doubt.

    Returns
    -------
    faults : int
    circles : bool
        Whether the steps went round in a circle: something else contradicts the level, or members left one after the
        other without a step.
    hard, rank, own, own_rank, pull
        What :func:`.polish.polish` and :func:`.polish.judge` return at the end.
    """
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    side, start, d = marks(here, at.SIDE), vector(here, at.APPROACH), vector(here, at.D)
    left, still, circles = integer(-1), integer(0), False
    for steps in range(STEPS + 1):
        if steps > 0 or not known:
            hard, rank, own, own_rank = polish_again(here, k, last, frozen, rank)
        faults, worst, pull = judge(here, k, last, frozen, hard, rank, own)
        if faults == 0 or steps == STEPS or late(here):
            break
        head[at.ITERATIONS] += 1
        reach, row, becomes = first_event(here, k)
        if reach * length(d, n) > STILL * extent(start, here):
            left, still = integer(-1), integer(0)
        for j in range(n):
            start[j] += reach * d[j]
        if row < 0 and (worst < 0 or still == PATIENCE):
            circles = worst >= 0
            break
        if row >= 0:
            side[row] = becomes
            if row == left:
                hard, rank, own, own_rank = polish_again(here, k, last, frozen, rank)
                faults, worst, pull = judge(here, k, last, frozen, hard, rank, own)
                circles = faults != 1 or worst != row
                if not circles:
                    faults, head[at.DOUBT] = integer(0), 1
                break
            left = integer(-1)
        else:
            side[worst] = INACTIVE
            left = worst
            still += 1
    return faults, circles, hard, rank, own, own_rank, pull
