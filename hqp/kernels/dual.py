r"""Which rows are active, by a dual active set, in what the frozen rows leave free.

With softness :math:`\delta_i > 0` for the rows of one level, and 0 for those above, the rows before `end` become one
strictly convex problem,

.. math:: \min_x \tfrac12 \|x - x_E\|^2 + \sum_{i \text{ soft}} \frac{w_i^2}{2 \delta_i}, \qquad
   x = x_E - P_W^T \lambda,

whose slacks are :math:`w = \delta \lambda`. Rows that are violated most join the members W, and rows whose multiplier
comes to push the wrong way leave (Goldfarb and Idnani 1983; in this form Arnstrom, Bemporad and Axehill 2022). A hard
row that depends on the members is exchanged for the one that gives way first: that is all that degenerate cones need.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .members import enter, leave, prepare, sign_of, start_of, wants
from .memory import clock, ints, marks, matrix, vector
from .rows import INACTIVE, LOWER, UPPER, target
from .working_set import FROZEN, IGNORED

#: A deadline that never comes.
NEVER = -1
#: What counts as violated, relative to the bound and the length of x: at first, and when nothing is any more.
ROUGH, FINE = 1e-6, 1e-9
#: Rows join together if they are violated by at least this share of the worst.
SHARE = 0.5
#: Objectives that rise by less have not risen; and how often that may happen in a row.
RISES, IDLE = 1e-12, 4
#: A hard row of which the members leave no more than these shares of its part, of its length, of the softness, is
#: dependent; and a member takes no part in that if its share is below the last.
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
    """Row i, on its side, becomes member number `count`; False, and it is none, if it is hard and depends on them."""
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
    """The member that gives way first when row i, which depends on the members, comes to press, or -1; and how far.

    L^T p = -l: the row, and p times the members, are no change of x at all. Of members that give way together the one
    that takes most part leaves, so that the row depends on the others no more.
    """
    members, side, norm = marks(here, at.MEMBERS), marks(here, at.SIDE), vector(here, at.NORM)
    p, force, F = vector(here, at.WANTED), vector(here, at.FORCE), matrix(here, at.FACTOR)
    s, row = side[i], F[count]
    for c in range(count):
        p[c] = -row[c]
    for c in range(count - 1, -1, -1):
        above, own = F[c], p[c]
        for r in range(c):
            p[r] -= above[r] * own
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
    """Let row i, which was just refused, take the place of the member that gives way first, if it is needed at all."""
    members, side, kind = marks(here, at.MEMBERS), marks(here, at.SIDE), marks(here, at.KIND)
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    z, p, force = vector(here, at.Z), vector(here, at.WANTED), vector(here, at.FORCE)
    s, pressed = side[i], 0.0
    goal = target(s, lo[i], hi[i])
    while pressed > 0.0 or z[count] * s > ROUGH * (abs(goal) + norm[i] * size):  # else what the members want meets it
        blocks, reach = gives_way(i, count, here)
        if blocks < 0:  # round-off, for the point of the level above satisfies it
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
    """Let the multipliers go to what the members want; members that come to push the wrong way leave.

    Returns
    -------
    count : int
    objective : float
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
    """x = x_E - P^T lambda; the length of its longest coordinate."""
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    members, force = marks(here, at.MEMBERS), vector(here, at.FORCE)
    x, anchor, P = vector(here, at.X), vector(here, at.ANCHOR), matrix(here, at.P)
    for j in range(n):
        x[j] = anchor[j]
    for c in range(count):
        row, much = P[members[c]], force[c]
        for j in range(n):
            x[j] -= much * row[j]
    size = 0.0
    for j in range(n):
        size = max(size, abs(x[j]))
    return size + vector(here, at.OPTION)[at.BLUR]


@inner
def refine(here, count):
    """One step of iterative refinement of the multipliers: what the factor left of r goes through it again."""
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    members, force, wanted = marks(here, at.MEMBERS), vector(here, at.FORCE), vector(here, at.WANTED)
    D, right, soft = vector(here, at.DIAGONAL), vector(here, at.RIGHT), vector(here, at.SOFT)
    x, anchor = vector(here, at.X), vector(here, at.ANCHOR)
    P, F = matrix(here, at.P), matrix(here, at.FACTOR)
    for c in range(count):
        row, mine = F[c], P[members[c]]
        total = right[c] - soft[c] * force[c]
        for j in range(n):
            total += mine[j] * (x[j] - anchor[j])
        for r in range(c):
            total -= row[r] * wanted[r]
        wanted[c] = total
    for c in range(count):
        wanted[c] /= D[c]
    for c in range(count - 1, -1, -1):
        row, own = F[c], wanted[c]
        for r in range(c):
            wanted[r] -= row[r] * own
    for c in range(count):
        force[c] += wanted[c]


@inner
def excesses(here, end, tolerance, size):
    """By how much rows before `end` that are no members are violated, over their length: the largest."""
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
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
        else:
            given, value = B[row_of[i]], 0.0
            for j in range(n):
                value += given[j] * x[j]
        over, under = value - hi[i], lo[i] - value
        if over > tolerance * (abs(hi[i]) + norm[i] * size):
            excess[i] = over / norm[i]
        elif under > tolerance * (abs(lo[i]) + norm[i] * size):
            excess[i] = -under / norm[i]
        worst = max(worst, abs(excess[i]))
    return worst


@inner
def settle(here, end, frozen, count, delta, rounds, finest):
    """Solve the problem of the rows before `end` from the `count` members that are listed, all in the factor.

    Returns
    -------
    count : int
        Of the members then, or -1 if there are more than fit, or more than so many `rounds` are needed. In the end no
        row is violated by more than the share `finest`.
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
            if abs(excess[i]) >= SHARE * worst:
                if count == most:
                    return integer(-1)
                side[i] = UPPER if excess[i] > 0.0 else LOWER
                if admit(i, frozen, count, delta, here):
                    count += 1
                else:
                    count = exchange(i, frozen, count, delta, size, here)
    return integer(-1)
