r"""The safe method: solves one level after the other by a primal active-set method.

Level k starts at the x of the level above, which is feasible for all levels above, and minimises

.. math:: \tfrac12 \sum_{i \in k} \operatorname{dist}(a_i x, [l_i, u_i])^2

subject to the *frozen* rows, whose values no longer change, and the *hard* rows, satisfied inequalities of the levels
above. The *working set* W is the set of hard rows that are kept at a bound. Every iteration

1. takes the Newton step of the violated rows, in the null space of the frozen rows and of W;
2. goes along it to the exact minimum, or to the first hard row that blocks, which then joins W;
3. if nothing is left to gain, drops the row of W whose multiplier has the most wrong sign.

At a degenerate vertex, where steps have length zero, a non-negative least squares over all rows at a bound finds a
direction that none of them blocks, or proves that there is none. So the method cannot cycle.

The method is *anytime*: if it is stopped at level k, all levels above are exactly optimal, and x is feasible for them.
:mod:`.pull` finds the violated rows, :mod:`.line_search` the step length, :mod:`.decide` the rows that a level freezes;
:mod:`.working_set` updates W, :mod:`.escape` leaves degenerate vertices.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .decide import decide
from .dual import late
from .escape import escape, residual
from .extent import extent
from .line_search import line_search
from .memory import ints, marks, matrix, vector
from .orthogonal import factor, length, level_least_squares, padded
from .pull import DUAL, hold, pull, release
from .rows import INACTIVE, LOWER, UPPER, copy_row, value_of
from .working_set import FROZEN, FUTURE, HARD, WORKING, append, balance, remove

OPTIMAL, SUBOPTIMAL, STALLED = 0, 1, 2

#: Nothing is left to gain if the step changes the violated rows by no more than the first share of their slacks, or the
#: second share of the numbers that the slacks are computed from.
GAINS, ROUND_OFF = 1e-11, 1e-15
#: Smaller relative changes count as none: of x, of the objective, and of a row that depends on others.
NOTHING = 1e-14
#: Steps of length zero before :func:`.escape.escape` is called, in addition to one for each row of the working set.
PATIENCE = 3
#: So many iterations in a row that bring nothing are the end; one more for each variable if x may not be optimal yet.
IDLE = 20


@inner
def active_set(here, last, known):
    """Solve levels 0 .. last from ``x``, one after the other, until :func:`.dual.late` returns True.

    The levels above `known` are optimal at x: no patience is spent on them.

    On return ``x`` is the solution and ``side`` its active set.

    Returns
    -------
    status, level : int
        OPTIMAL and last + 1, or the first other status and the level that has it.
    """
    status, level = integer(OPTIMAL), integer(last + 1)
    frozen = working = integer(0)
    forget(here, last)
    for k in range(last + 1):
        patience = IDLE if k < known else IDLE + ints(here, 0, at.HEAD)[at.N]
        said, forces, working = minimise(here, k, last, frozen, working, patience)
        if status == OPTIMAL and said != OPTIMAL:
            status, level = said, integer(k)
        if k < last:
            frozen, working = decide(here, k, forces, frozen, working)
    leave_inactive(here, last)
    return status, level


@inner
def minimise(here, k, last, frozen, working, patience):
    """Solve level k from ``x``, which must be feasible for the levels above; ``x`` is then the solution.

    It has stalled after more than `patience` iterations in a row that bring nothing.

    Returns
    -------
    status : int
    forces : float
        Forces of the level, which the multipliers of the working set balance; 0 if it is met, or not optimal.
    working : int
        Rows of the working set at the end.
    """
    head = ints(here, 0, at.HEAD)
    n, ptr, x, d = head[at.N], marks(here, at.PTR), vector(here, at.X), vector(here, at.D)
    full = False  # whether the last step was a whole Newton step and the violated rows are still the same
    lowest, since, still = math.inf, integer(0), integer(0)  # iterations without progress; steps of length zero
    while True:
        size = measure(here, k, last)
        if late(here):
            return integer(SUBOPTIMAL), 0.0, working
        head[at.ITERATIONS] += 1
        count, forces, square, scale = pull(here, k, last, size)
        if forces == 0.0:
            return integer(OPTIMAL), 0.0, working
        if square < lowest * (1.0 - NOTHING):
            lowest, since = square, integer(0)
        else:
            since += 1
        if since > patience:
            return integer(STALLED), 0.0, working

        gain = 0.0 if full else newton(here, k, last, frozen + working, count)
        # Nothing is left to gain with this W: release a row of this level, or drop one of W; if none, x is optimal.
        if full or gain <= GAINS * math.sqrt(square) or gain <= ROUND_OFF * scale:
            full = False
            if release(here, count, forces):
                continue
            leaves = most_wrong(here, forces, frozen, working)
            if leaves < 0:
                return integer(OPTIMAL), forces, working
            if still <= PATIENCE + working:
                drop(here, leaves, frozen + working)
                working -= 1
                continue
            still = integer(0)
            working = escape(here, forces, frozen, working, ptr[k])
            if length(d, n) == 0.0:
                balance(vector(here, at.G), frozen, frozen + working, here)
                return integer(OPTIMAL), forces, working

        step, blocks = line_search(here, k, last)
        for j in range(n):
            x[j] += step * d[j]
        moved = step * length(d, n)
        still = still + 1 if moved <= NOTHING * (size + moved) else integer(0)
        if blocks >= 0 and join(here, blocks, frozen + working):
            working += 1
        same = hold(here, k, last, size)
        full = same and blocks < 0 and step == 1.0


@inner
def forget(here, last):
    """Reset ``kind``, ``held`` and ``side``: no row is decided, or at a bound, yet."""
    ptr, kind, held, side = marks(here, at.PTR), marks(here, at.KIND), marks(here, at.HELD), marks(here, at.SIDE)
    for i in range(ptr[last]):
        kind[i], held[i], side[i] = FUTURE, INACTIVE, INACTIVE


@inner
def leave_inactive(here, last):
    """Set ``side`` of all hard rows outside the working set to INACTIVE."""
    ptr, kind, side = marks(here, at.PTR), marks(here, at.KIND), marks(here, at.SIDE)
    for i in range(ptr[last]):
        if kind[i] == HARD:
            side[i] = INACTIVE


@inner
def measure(here, k, last):
    """Write ``value`` = a_i x of all rows down to level k that are not frozen; returns :func:`.extent.extent`."""
    ptr, kind, v, x = marks(here, at.PTR), marks(here, at.KIND), vector(here, at.VALUE), vector(here, at.X)
    for i in range(ptr[min(k + 1, last)]):
        if kind[i] != FROZEN:
            v[i] = value_of(i, x, here)
    return extent(x, here)


@inner
def newton(here, k, last, c, count):
    """The Newton step ``d`` of the `count` rows ``ids``: ``min ||S d - missing||`` with d in the null space of V[:c].

    Returns ``||S d||``, by how much the step changes these rows.
    """
    if k == last:
        return residual(here, c)  # of the last level: x_0 - x
    n, tau = ints(here, 0, at.HEAD)[at.N], vector(here, at.OPTION)[at.TAU]
    ids, slots, lengths = marks(here, at.IDS), marks(here, at.SLOTS), vector(here, at.LENGTHS)
    norm, w, missing = vector(here, at.NORM), vector(here, at.W), vector(here, at.SLOPE)
    d, y, rhs = vector(here, at.D), vector(here, at.Y), vector(here, at.RHS)
    V, L, R, H = matrix(here, at.V), matrix(here, at.L), matrix(here, at.R), matrix(here, at.H)
    for r in range(count):
        copy_row(ids[r], R[r], here)
    rank = factor(ids, count, slots, lengths, R, norm, V, L, c, padded(n), tau)
    for r in range(count):
        rhs[r] = missing[ids[r]]
    level_least_squares(ids, count, rank, L, c, rhs, y, w, H)
    for j in range(n):
        d[j] = 0.0
    for q in range(c, c + rank):
        direction, step = V[q], y[q]
        for j in range(n):
            d[j] += step * direction[j]
    gain = 0.0
    for r in range(count):
        change = missing[ids[r]] + w[ids[r]]
        gain += change * change
    return math.sqrt(gain)


@inner
def most_wrong(here, forces, frozen, working):
    """The position in V of the working-set row whose multiplier has the most wrong sign; -1 if all signs are right."""
    pivot, side = marks(here, at.PIVOT), marks(here, at.SIDE)
    norm, multiplier = vector(here, at.NORM), vector(here, at.MULTIPLIER)
    balance(vector(here, at.G), frozen, frozen + working, here)
    worst, leaves = -DUAL * forces, integer(-1)
    for q in range(frozen, frozen + working):
        i = pivot[q]
        says = multiplier[q] * side[i] * norm[i]
        if says < worst:
            worst, leaves = says, q
    return leaves


@inner
def drop(here, place, c):
    """Take the row at position `place` of the basis V[:c] out of the working set."""
    kind, pivot = marks(here, at.KIND), marks(here, at.PIVOT)
    kind[pivot[place]] = HARD
    remove(place, c, here)


@inner
def join(here, i, c):
    """Append hard row i, which blocks the step, to V[:c] and the working set; False if it depends on V[:c]."""
    kind, side, slope = marks(here, at.KIND), marks(here, at.SIDE), vector(here, at.SLOPE)
    if not append(i, c, here, NOTHING):
        return False
    kind[i], side[i] = WORKING, UPPER if slope[i] > 0.0 else LOWER
    return True
