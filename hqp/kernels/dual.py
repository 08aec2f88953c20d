r"""Finds the active rows of one level by a dual active-set method, in the null space of the frozen rows.

With a softness :math:`\delta_i > 0` for the rows of the level, and 0 for those above, the rows 0 .. end - 1 make one
strictly convex problem,

.. math:: \min_x \tfrac12 \|x - x_E\|^2 + \sum_{i \text{ soft}} \frac{w_i^2}{2 \delta_i}, \qquad
   x = x_E - P_W^T \lambda,

whose slacks are :math:`w = \delta \lambda`; P are the rows projected onto that null space. The *members* W are the
active set. The most violated rows join W, and rows whose multiplier would get the wrong sign leave (Goldfarb and Idnani
1983; in this form Arnstrom, Bemporad and Axehill 2022). A hard row that depends on the members replaces the member
whose multiplier reaches zero first; degenerate vertices need no more than that.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .lines import multiply_chosen, product, subtract_chosen
from .members import (
    enter,
    leave,
    prepare,
    sign_of,
    start_of,
    substitute,
    substitute_back,
    wants,
)
from .memory import clock, ints, marks, matrix, vector
from .metric import displace
from .orthogonal import padded
from .rows import INACTIVE, LOWER, UPPER, target, value_within
from .working_set import FROZEN, IGNORED

#: Value of DEADLINE: there is none.
NEVER = -1
#: Tolerance of violated rows, relative to the bound and the length of x: at first, and once no row exceeds the first.
ROUGH, FINE = 1e-6, 1e-9
#: All rows that are violated by at least this share of the largest violation join in the same round.
SHARE = 0.25
#: Smallest relative rise of the objective that counts as one; and how many rounds in a row may be without.
RISES, IDLE = 1e-12, 4
#: A hard row is dependent if its pivot d is at most the sum of PART times its squared free part and WHOLE times its
#: squared length, or is at most YIELDS times the softness. A member is part of that dependence if its coefficient,
#: relative to both lengths, is above PARTAKES.
PART, WHOLE, YIELDS, PARTAKES = 1e-11, 1e-15, 1e-3, 1e-10


@inner
def late(here):
    """Whether the iterations are spent or the deadline has passed."""
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    if head[at.ITERATIONS] >= option[at.BUDGET]:
        return True
    return head[at.DEADLINE] != NEVER and clock() > head[at.DEADLINE]


@inner
def admit(i, frozen, count, delta, here):
    """Append row i, on its ``side``, as member number `count`; False, and it is no member, if it is hard and dependent.

    `delta` is the softness of the level at hand.
    """
    members, side = marks(here, at.MEMBERS), marks(here, at.SIDE)
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    D, right, soft = vector(here, at.DIAGONAL), vector(here, at.RIGHT), vector(here, at.SOFT)
    force, softness = vector(here, at.FORCE), vector(here, at.VALUE)
    prepare(i, frozen, here)
    members[count], soft[count], force[count] = i, softness[i], 0.0
    right[count] = start_of(i, target(side[i], lo[i], hi[i]), here)
    pivot, square = enter(count, here)
    if soft[count] > 0.0:
        D[count] = max(pivot, 0.1 * soft[count], WHOLE * norm[i] * norm[i])
        return True
    return pivot > max(PART * square + WHOLE * norm[i] * norm[i], YIELDS * delta)


@inner
def gives_way(i, count, here):
    """The member whose multiplier reaches zero first as that of the dependent row i grows, or -1; and how far it grows.

    With p from L^T p = -l, l being the last row of the factor, a change of multipliers by 1 (row i) and p (members)
    does not change x. If several reach zero together, the one with the largest coefficient is taken: row i is then
    independent of the others.
    """
    members, side, norm = marks(here, at.MEMBERS), marks(here, at.SIDE), vector(here, at.NORM)
    p, force, F = vector(here, at.WANTED), vector(here, at.FORCE), matrix(here, at.FACTOR)
    s, row = side[i], F[count]
    for c in range(count):
        p[c] = -row[c]
    substitute_back(F, p, count)
    reach, blocks, most = math.inf, integer(-1), 0.0
    for c in range(count):
        sign, part = sign_of(c, here), abs(p[c]) * norm[members[c]] if members[c] < len(norm) else 0.0
        if sign != 0 and p[c] * s * sign < 0.0 and part > PARTAKES * norm[i]:
            ratio = -force[c] / (p[c] * s)
            if ratio < reach or (ratio == reach and part > most):
                reach, blocks, most = ratio, c, part
    return blocks, reach


@inner
def exchange(i, frozen, count, delta, size, here):
    """Let the dependent row i replace members until it is independent, unless the members meet its bound already.

    `size` is the length of x. Returns the number of members.
    """
    members, side, kind = marks(here, at.MEMBERS), marks(here, at.SIDE), marks(here, at.KIND)
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    z, p, force = vector(here, at.Z), vector(here, at.WANTED), vector(here, at.FORCE)
    s, pressed = side[i], 0.0
    goal = target(s, lo[i], hi[i])
    while pressed > 0.0 or z[count] * s > ROUGH * (abs(goal) + norm[i] * size):  # else the members meet its bound
        blocks, reach = gives_way(i, count, here)
        if blocks < 0:  # violated by round-off only: the point of the level above satisfies this row
            kind[i] = IGNORED
            break
        for c in range(count):
            force[c] += reach * p[c] * s
        pressed += reach
        side[members[blocks]] = INACTIVE
        leave(blocks, count, here)
        count -= 1
        if admit(i, frozen, count, delta, here):
            force[count] = pressed * s
            return count + 1
    side[i] = INACTIVE
    return count


@inner
def move(here, count):
    """Move the multipliers towards those of all members as equalities; members whose sign would become wrong leave.

    Returns
    -------
    count : int
        Members that are left.
    objective : float
        As of :func:`.members.wants`.
    """
    head = ints(here, 0, at.HEAD)
    members, side = marks(here, at.MEMBERS), marks(here, at.SIDE)
    wanted, force = vector(here, at.WANTED), vector(here, at.FORCE)
    while True:
        objective = wants(count, here)
        if late(here):
            return count, objective
        head[at.ITERATIONS] += 1
        reach, blocks = 1.0, integer(-1)
        for c in range(count):
            sign = sign_of(c, here)
            if sign != 0 and wanted[c] * sign < 0.0:
                ratio = force[c] / (force[c] - wanted[c])
                if ratio < reach:
                    reach, blocks = ratio, c
        for c in range(count):
            force[c] += reach * (wanted[c] - force[c])
        if blocks < 0:
            return count, objective
        for c in range(count - 1, -1, -1):
            if c == blocks or (force[c] == 0.0 and wanted[c] * sign_of(c, here) < 0.0):
                side[members[c]] = INACTIVE
                leave(c, count, here)
                count -= 1


@inner
def arrive(here, count):
    """Write ``x`` = x_E - P^T lambda; returns its largest coordinate, plus the blur of :func:`.extent.extent`."""
    head = ints(here, 0, at.HEAD)
    n, wide = head[at.N], padded(head[at.N])
    members, force = marks(here, at.MEMBERS), vector(here, at.FORCE)
    x, anchor, P, moved = vector(here, at.X), vector(here, at.ANCHOR), matrix(here, at.P), vector(here, at.MOVED)
    for j in range(n):
        x[j] = anchor[j]
    for j in range(wide):
        moved[j] = 0.0
    subtract_chosen(P, members, count, force, wide, moved)
    if head[at.METRIC] != 0:
        displace(here, x)
    else:
        for j in range(n):
            x[j] += moved[j]
    size = 0.0
    for j in range(n):
        size = max(size, abs(x[j]))
    return size + vector(here, at.OPTION)[at.BLUR]


@inner
def refine(here, count):
    """One step of iterative refinement of the multipliers: the residual is solved for with the same factor."""
    head = ints(here, 0, at.HEAD)
    wide = padded(head[at.N])
    members, force, wanted = marks(here, at.MEMBERS), vector(here, at.FORCE), vector(here, at.WANTED)
    D, right, soft = vector(here, at.DIAGONAL), vector(here, at.RIGHT), vector(here, at.SOFT)
    moved, P, F = vector(here, at.MOVED), matrix(here, at.P), matrix(here, at.FACTOR)
    multiply_chosen(P, members, count, moved, wide, wanted)
    for c in range(count):
        wanted[c] += right[c] - soft[c] * force[c]
    substitute(F, wanted, integer(0), count)
    for c in range(count):
        wanted[c] /= D[c]
    substitute_back(F, wanted, count)
    for c in range(count):
        force[c] += wanted[c]


@inner
def excesses(here, end, tolerance, size):
    """Write by how much each row before `end` outside the members is violated, over its length; returns the largest.

    It is signed, positive above the upper bound, in ``slope``; 0 within `tolerance`, which is relative to the bound and
    to `size`, the length of x.
    """
    n, first, past = ints(here, 0, at.HEAD)[at.N], marks(here, at.BEGIN), marks(here, at.END)
    col, row_of, side, kind = marks(here, at.COL), marks(here, at.ROW_OF), marks(here, at.SIDE), marks(here, at.KIND)
    lo, hi, norm, x = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), vector(here, at.X)
    excess, B = vector(here, at.SLOPE), matrix(here, at.B)
    worst = 0.0
    for i in range(end):
        excess[i] = 0.0
        if side[i] != INACTIVE or norm[i] == 0.0 or kind[i] == FROZEN or kind[i] == IGNORED:
            continue
        if col[i] >= 0:
            value = norm[i] * x[col[i]]
        elif past[i] - first[i] < n // 2:
            value = value_within(i, x, here)
        else:
            value = product(B[row_of[i]], x, n)
        over, under = value - hi[i], lo[i] - value
        if over > tolerance * (abs(hi[i]) + norm[i] * size):
            excess[i] = over / norm[i]
        elif under > tolerance * (abs(lo[i]) + norm[i] * size):
            excess[i] = -under / norm[i]
        worst = max(worst, abs(excess[i]))
    return worst


@inner
def settle(here, end, frozen, count, delta, rounds, finest):
    """Solve the problem of the rows before `end`, from the first `count` members, which are in the factor.

    `finest` is the tolerance of violated rows at the end, `delta` the softness of the level at hand.

    Returns
    -------
    count : int
        Members at the end; -1 if there are more than fit, or if more than `rounds` rounds would be needed.
    """
    members, side = marks(here, at.MEMBERS), marks(here, at.SIDE)
    excess = vector(here, at.SLOPE)
    most = len(members)
    tolerance, highest, idle = ROUGH, -1.0, 0
    for _ in range(rounds):
        count, objective = move(here, count)
        idle = 0 if objective > highest * (1.0 + RISES) else idle + 1
        highest = max(highest, objective)
        size = arrive(here, count)
        if idle >= IDLE or late(here):
            return count
        worst = excesses(here, end, tolerance, size)
        if worst == 0.0 and tolerance > finest:
            tolerance = finest
            refine(here, count)
            size = arrive(here, count)
            worst = excesses(here, end, tolerance, size)
        if worst == 0.0:
            return count
        for i in range(end):
            if excess[i] != 0.0 and abs(excess[i]) >= SHARE * worst:  # a share of the least number of all is 0
                if count == most:
                    return integer(-1)
                side[i] = UPPER if excess[i] > 0.0 else LOWER
                if admit(i, frozen, count, delta, here):
                    count += 1
                else:
                    count = exchange(i, frozen, count, delta, size, here)
    return integer(-1)
