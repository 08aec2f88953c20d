r"""The safe method: one level after the other, each by a primal active set in what the levels above leave free.

Level k starts at the x of the level above, feasible for all that is decided, and minimises

.. math:: \tfrac12 \sum_{i \in k} \operatorname{dist}(a_i x, [l_i, u_i])^2

subject to the *frozen* rows, whose value no longer changes, and the *hard* rows, inequalities above that are met.
Every iteration takes the Newton step of the rows that are violated, inside the frozen rows and the *working set*
W of hard rows that are kept at their bound; goes along it to the exact minimum or to the first hard row in the
way, which joins W; and drops the row of W whose multiplier is most wrong, once nothing is left to gain. At a
degenerate vertex, where steps have length zero, a non-negative least squares over all rows at their bound finds a
direction that none of them blocks, or proves that there is none: no cycles.

So the method is *anytime*: stopped at level k, all levels above are exactly optimal, and x is feasible for them.
W is kept by :mod:`.working_set`, and left by :mod:`.escape` where it blocks itself.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .dual import late
from .escape import escape
from .freeze import CLEAR
from .memory import ints, marks, matrix, vector
from .orthogonal import factor, length, level_least_squares, project
from .sweep import DUAL, EQUALITY, INACTIVE, LOWER, UPPER, extent, value_of
from .working_set import FROZEN, FUTURE, HARD, WORKING, append, balance, copy_row, remove

OPTIMAL, SUBOPTIMAL, STALLED = 0, 1, 2

#: In a level that is not met, what a row misses carries a multiplier if it is more than this share of its tolerance.
CARRIES = 1e-4
#: A gain below this share of all targets is round-off.
ROUND_OFF = 1e-15
#: A step changes a row if it does so by more than round-off.
MOVES = 1e-12


@inner
def best_step(first, end, v, slope, lo, hi):
    r"""The a >= 0 that minimises :math:`\sum_i \operatorname{dist}(v_i + a\,s_i, [l_i, u_i])^2` over rows first .. end.

    The derivative is piecewise linear and increasing: from kink to kink, until it changes sign.
    """
    start = initial = 0.0
    for turn in range(2 * (end - first) + 2):
        value, rate, kink = (
            0.0,
            0.0,
            math.inf,
        )  # derivative at `start`, its slope beyond, and the next kink
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
                return 1.0 if abs(stop - 1.0) < 1e-9 else stop
        if kink == math.inf:
            return start
        start = kink
    return start


@inner
def release(count, forces, here):
    """Let go of the row of this level that is held at its bound from within and pulls most; False if there is none."""
    ids, held = marks(here, at.IDS), marks(here, at.HELD)
    lo, hi, v, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.VALUE), vector(here, at.NORM)
    worst, leaves = DUAL * forces, integer(-1)
    for r in range(count):
        i = ids[r]
        if lo[i] != hi[i]:
            bound = hi[i] if held[i] > 0 else lo[i]
            inward = (bound - v[i]) * held[i] * norm[i]
            if inward > worst:
                worst, leaves = inward, i
    if leaves >= 0:
        held[leaves] = 0
    return leaves >= 0


@inner
def active_set(here, last):
    """Solve levels 0 .. last from ``x``, one after the other, until :func:`.dual.late` says stop.

    On return ``side`` is the active set at ``x``.

    Returns
    -------
    status, level : int
        The level is that of the first status which is not OPTIMAL.
    """
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    option = vector(here, at.OPTION)
    tol, tau = option[at.TOL], option[at.TAU]
    kind, side, held, ptr = marks(here, at.KIND), marks(here, at.SIDE), marks(here, at.HELD), marks(here, at.PTR)
    col, pivot, ids, row_of = marks(here, at.COL), marks(here, at.PIVOT), marks(here, at.IDS), marks(here, at.ROW_OF)
    slots, queue = marks(here, at.SLOTS), marks(here, at.QUEUE)
    low, high, allowed = vector(here, at.LOW), vector(here, at.HIGH), vector(here, at.ALLOWED)
    slope, lo, hi, norm = vector(here, at.SLOPE), vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    x0, x, w, v = vector(here, at.X0), vector(here, at.X), vector(here, at.W), vector(here, at.VALUE)
    g, d, y, rhs = vector(here, at.G), vector(here, at.D), vector(here, at.Y), vector(here, at.RHS)
    multiplier, scratch, lengths = vector(here, at.MULTIPLIER), vector(here, at.SCRATCH), vector(here, at.LENGTHS)
    V, L, B, R, H = matrix(here, at.V), matrix(here, at.L), matrix(here, at.B), matrix(here, at.R), matrix(here, at.H)
    frozen = working = integer(0)
    status, where = OPTIMAL, last + 1
    for i in range(ptr[last]):
        kind[i] = FUTURE
        held[i] = 0
        side[i] = INACTIVE
    for k in range(last + 1):
        first = ptr[k] if k < last else 0
        end = ptr[k + 1] if k < last else 0
        hard_end = ptr[k]
        still = 0  # zero-length steps in a row
        full = False
        lowest, since = math.inf, 0
        forces = 0.0
        while True:
            size = extent(x, here)
            for i in range(ptr[min(k + 1, last)]):
                if kind[i] != FROZEN:
                    v[i] = value_of(i, x, here)
            if late(here):
                if where > k:
                    status, where = SUBOPTIMAL, k
                forces = 0.0
                break
            head[at.ITERATIONS] += 1

            # Which rows pull, and how much.
            count, met = integer(0), True
            forces = wanted = pull = 0.0
            for j in range(n):
                g[j] = 0.0
            if k == last:
                for j in range(n):
                    d[j] = x0[j] - x[j]
                    g[j] = -d[j]
                    pull += d[j] * d[j]
                    wanted += abs(x0[j]) + size
                    if abs(d[j]) > tol * (abs(x0[j]) + size):
                        forces += abs(d[j])
                for q in range(frozen + working):
                    scratch[q] = 0.0
                project(d, n, V, 0, frozen + working, scratch)
                project(d, n, V, 0, frozen + working, scratch)
                gain = length(d, n)
            else:
                for i in range(first, end):
                    if norm[i] == 0.0:
                        continue
                    near = tol * norm[i] * size
                    t_low, t_high = tol * abs(lo[i]) + near, tol * abs(hi[i]) + near
                    if lo[i] == hi[i]:
                        bound = lo[i]
                    elif v[i] > hi[i] + CARRIES * t_high or (held[i] > 0 and v[i] >= hi[i] - t_high):
                        bound = hi[i]
                        held[i] = 1
                    elif v[i] < lo[i] - CARRIES * t_low or (held[i] < 0 and v[i] <= lo[i] + t_low):
                        bound = lo[i]
                        held[i] = -1
                    else:
                        continue
                    r = bound - v[i]
                    ids[count] = i
                    rhs[count] = r
                    slope[i] = r
                    count += 1
                    pull += r * r
                    wanted += abs(bound) + norm[i] * size
                    met = met and abs(r) <= tol * abs(bound) + near
                    if abs(r) > CARRIES * (tol * abs(bound) + near):
                        forces += norm[i] * abs(r)
                        if col[i] >= 0:
                            g[col[i]] -= norm[i] * r
                        else:
                            given = B[row_of[i]]
                            for j in range(n):
                                g[j] -= given[j] * r
                if met:
                    forces = 0.0
                gain = 0.0
                if not full and forces > 0.0:
                    c = frozen + working
                    for r in range(count):
                        copy_row(ids[r], R[r], here)
                    rank = factor(ids, count, slots, lengths, R, norm, V, L, c, n, tau)
                    for r in range(count):
                        rhs[r] = slope[ids[r]]
                    level_least_squares(ids, count, rank, L, c, rhs, y, w, H)
                    for j in range(n):
                        d[j] = 0.0
                    for q in range(c, c + rank):
                        direction, step = V[q], y[q]
                        for j in range(n):
                            d[j] += step * direction[j]
                    for r in range(count):
                        change = slope[ids[r]] + w[ids[r]]
                        gain += change * change
                    gain = math.sqrt(gain)

            if forces == 0.0:
                break
            if pull < lowest * (1.0 - 1e-14):
                lowest, since = pull, 0
            else:
                since += 1
                if since > 2 * (n + hard_end) + 20:
                    if where > k:
                        status, where = STALLED, k
                    forces = 0.0
                    break
            if full or gain <= 1e-11 * math.sqrt(pull) or gain <= ROUND_OFF * wanted:
                full = False
                if release(count, forces, here):
                    continue
                if working == 0:
                    break
                balance(frozen, frozen + working, n, here)
                worst, leaves = -DUAL * forces, integer(-1)
                for q in range(frozen, frozen + working):
                    i = pivot[q]
                    says = multiplier[q] * side[i] * norm[i]
                    if says < worst:
                        worst, leaves = says, q
                if leaves < 0:
                    break
                if still <= 3 + working:
                    kind[pivot[leaves]] = HARD
                    remove(leaves, frozen + working, here)
                    working -= 1
                    continue
                still = 0
                working = escape(here, forces, frozen, working, hard_end)
                if length(d, n) == 0.0:
                    balance(frozen, frozen + working, n, here)
                    break

            # How far: to the minimum, or to the first hard row in the way (two passes: Harris).
            steep = length(d, n)
            for i in range(ptr[min(k + 1, last)]):
                slope[i] = 0.0
                if norm[i] > 0.0 and (kind[i] == HARD or (i >= first and kind[i] == FUTURE)):
                    s = value_of(i, d, here)
                    if abs(s) > MOVES * norm[i] * steep:
                        slope[i] = s
            nearest = math.inf
            for i in range(hard_end):
                if kind[i] == HARD and slope[i] != 0.0:
                    room = (high[i] if slope[i] > 0.0 else low[i]) - v[i]
                    nearest = min(
                        nearest,
                        (room + math.copysign(0.1 * allowed[i], slope[i])) / slope[i],
                    )
            limit, blocks, steepest = math.inf, integer(-1), -1.0
            for i in range(hard_end):
                if kind[i] == HARD and slope[i] != 0.0:
                    ratio = ((high[i] if slope[i] > 0.0 else low[i]) - v[i]) / slope[i]
                    if ratio <= nearest and abs(slope[i]) / norm[i] > steepest:
                        limit, blocks, steepest = (
                            max(ratio, 0.0),
                            i,
                            abs(slope[i]) / norm[i],
                        )
            if k == last:
                reach = 0.0  # the minimum along d
                for j in range(n):
                    reach += d[j] * (x0[j] - x[j])
                reach /= steep * steep
                if abs(reach - 1.0) < 1e-9:
                    reach = 1.0
            else:
                reach = best_step(first, end, v, slope, lo, hi)
            blocked = blocks >= 0 and limit < reach
            step = limit if blocked else reach
            for j in range(n):
                x[j] += step * d[j]
            still = still + 1 if step * steep <= 1e-14 * (size + step * steep) else 0
            if blocked and append(blocks, frozen + working, here, 1e-14):
                kind[blocks] = WORKING
                side[blocks] = UPPER if slope[blocks] > 0.0 else LOWER
                working += 1
            full = not blocked and reach == 1.0
            for i in range(first, end):
                if norm[i] == 0.0 or lo[i] == hi[i]:
                    continue
                now = value_of(i, x, here)
                near = tol * norm[i] * size
                t_low, t_high = tol * abs(lo[i]) + near, tol * abs(hi[i]) + near
                was = held[i]
                pulled = v[i] > hi[i] + CARRIES * t_high or v[i] < lo[i] - CARRIES * t_low or was != 0
                held[i] = 0
                if abs(now - hi[i]) <= t_high and (slope[i] > 0.0 or was > 0):
                    held[i] = 1
                elif abs(now - lo[i]) <= t_low and (slope[i] < 0.0 or was < 0):
                    held[i] = -1
                outside = now > hi[i] + CARRIES * t_high or now < lo[i] - CARRIES * t_low
                if outside != pulled and not (pulled and held[i] != 0):
                    full = False
        if k == last:
            break

        # Freeze the level: what is violated or an equality keeps its value, the rest becomes hard.
        c, candidates, count = frozen, working, integer(0)
        for q in range(c, c + candidates):
            i = pivot[q]
            queue[q - c] = i
            kind[i] = HARD
            if forces > 0.0 and multiplier[q] * side[i] * norm[i] > CLEAR * forces:  # an implicit equality
                kind[i] = FROZEN
                ids[count] = i
                count += 1
        size = extent(x, here)
        for i in range(first, end):
            w[i] = 0.0
            kind[i] = FROZEN
            if norm[i] == 0.0:
                continue
            near = tol * norm[i] * size
            over, under = v[i] - hi[i], v[i] - lo[i]
            if lo[i] == hi[i]:
                side[i] = EQUALITY
                if abs(over) > near + tol * abs(hi[i]):
                    w[i] = over
            elif over > near + tol * abs(hi[i]):
                side[i] = UPPER
                w[i] = over
            elif under < -near - tol * abs(lo[i]):
                side[i] = LOWER
                w[i] = under
            else:
                kind[i] = HARD
                high[i], low[i] = max(hi[i], v[i]), min(lo[i], v[i])
                allowed[i] = near + tol * abs(v[i])
                continue
            ids[count] = i
            count += 1
        for r in range(count):
            copy_row(ids[r], R[r], here)
        frozen += factor(ids, count, slots, lengths, R, norm, V, L, c, n, tau)
        for r in range(frozen - c):
            pivot[c + r] = ids[r]
        working = integer(0)
        for q in range(candidates):
            i = queue[q]
            if kind[i] == HARD and append(i, frozen + working, here, tau):
                kind[i] = WORKING
                working += 1
    for i in range(ptr[last]):
        if kind[i] == HARD:
            side[i] = INACTIVE
    return status, where
