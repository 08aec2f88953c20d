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
#: A row may be passed by this share of its tolerance: by round-off.
LATENESS = 1e-3
#: A step that is no longer than this share of x is none; so many members in a row may leave without a step.
STILL, PATIENCE = 1e-12, 6


@inner
def event_of(i, k, start, d, steep, size, here):
    """When row i reaches its bound on the way from `start` along d (n,), which is `steep` long, `size` being that of x.

    Returns
    -------
    ratio : float
        The step length, at least 0; infinite if it is not on the way.
    overdue : float
        The step length at which it is off its bound by LATENESS, as a share of its tolerance.
    rate : float
        How fast its value changes, as a share of its length.
    """
    side, lo, hi = marks(here, at.SIDE)[i], vector(here, at.LO)[i], vector(here, at.HI)[i]
    norm, tol = vector(here, at.NORM)[i], vector(here, at.OPTION)[at.TOL]
    ratio = math.inf
    if norm == 0.0 or marks(here, at.KIND)[i] == FROZEN or side == EQUALITY:
        return ratio, ratio, 0.0
    rate = value_of(i, d, here)
    if abs(rate) <= MOVES * norm * steep:
        return ratio, ratio, 0.0
    value = value_of(i, start, here)
    bound = target(side, lo, hi) if side != INACTIVE else hi if rate > 0.0 else lo
    near = tol * (abs(bound) + norm * size)
    if side == INACTIVE:
        if abs(value + rate - bound) > near:
            ratio = max(0.0, (bound - value) / rate)
    elif i >= marks(here, at.PTR)[k]:  # violated, and within its bounds from this step length on
        slack = (value - bound) * side
        if slack > near and slack + rate * side < -near:
            ratio = -slack / (rate * side)
    return ratio, ratio + LATENESS * near / abs(rate), rate / norm


@inner
def first_event(here, k):
    """The step length from APPROACH towards x to the first row that reaches its bound, from inside or from outside.

    Of those that do so before one of them is too late, it is the one that moves fastest (Harris 1973): a row that hangs
    on others by round-off alone does not stop a step that it hardly feels.

    Returns
    -------
    reach : float
        The step length, at most 1.
    row, side : int
        This row, or -1; and the side that it gets.
    """
    n, end = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR)[k + 1]
    x, start, d = vector(here, at.X), vector(here, at.APPROACH), vector(here, at.D)
    ratios, rates, side = vector(here, at.LOW), vector(here, at.SLOPE), marks(here, at.SIDE)
    for j in range(n):
        d[j] = x[j] - start[j]
    steep, size, latest = length(d, n), extent(start, here), 1.0
    for i in range(end):
        ratios[i], overdue, rates[i] = event_of(i, k, start, d, steep, size, here)
        latest = min(latest, overdue)
    reach, row, becomes, fastest = 1.0, integer(-1), integer(INACTIVE), 0.0
    for i in range(end):
        if ratios[i] < 1.0 and ratios[i] <= latest and abs(rates[i]) > fastest:
            reach, row, fastest = ratios[i], i, abs(rates[i])
    if row >= 0 and side[row] == INACTIVE:
        becomes = integer(UPPER if rates[row] > 0.0 else LOWER)
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
