r"""Finds the active rows level by level, from the highest to the lowest; each level is exact before the next begins.

V spans the rows that the levels above k have frozen, and x_E is the point nearest to x_0 with the values of these rows.
W is the active set of level k: rows at a bound, of this level and of those above.

1. The level is solved exactly with the rows of W as equalities (:mod:`.polish`); mostly that is all.
2. If rows contradict this, a dual active-set method finds W in the null space of V (:mod:`.dual`), and the level is
   solved again with it: at first with softer rows, for which x moves less, and fewer rows come and go.
3. If the softness in the dual method still hides a wrong row, exact primal steps finish the level (:mod:`.primal`).
4. The rows that the level decides are frozen (:mod:`.freeze`). Once these determine x, nothing is left to solve.

W at the end of every level is saved: the next solve starts there. A solve is *anytime*: EXACT is optimal for all levels
above the one that is being solved.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer, step
from .doubt import note_doubt, sharpen
from .dual import FINE, admit, late, settle
from .extent import extent, far
from .freeze import freeze
from .level_end import advance, conclude, keep, remember
from .members import enter, list_part, prepare, start_of
from .memory import ints, marks, matrix, vector
from .metric import change_metric, put_back
from .orthogonal import padded, pivots, triangle
from .polish import holds, judge
from .primal import polish_again, primal
from .rows import EQUALITY, INACTIVE, LOWER, UPPER, note_spans, value_of
from .working_set import FROZEN, FUTURE, HARD, IGNORED

#: Softness of the level that is being solved, relative to the square of its longest row: at first, as the active set of
#: softer rows is found in fewer steps; and where that is not the right one.
SOFT, HARDER = 1e-6, 1e-9
#: Where a level begins: with its active rows as equalities, with the soft dual, or with the harder one.
POLISH, SOFTLY, FIRMLY = 0, 1, 2
#: Relative tolerance within which a starting point must satisfy the levels above.
FEASIBLE = 1e-7
#: If more rows contradict the saved W than this share of its rows from the levels above, most of these would have to go
#: one by one: the level begins as in a cold start.
FAULTY = 0.25


@step
def levels(here, last, warm):
    """Find ``side`` for levels 0 .. last; with `warm`, from the sides at the end of each level of the last solve.

    Returns
    -------
    level : int
        The level that could not be solved: EXACT is optimal for those above. `last` + 1 if all were solved; `last` + 2
        if x also keeps all that they decided, which is a proof.
    """
    ptr, rounds = marks(here, at.PTR), 4 * len(marks(here, at.MEMBERS)) + 4
    k, frozen = begin(here, last)
    head, whole, n = ints(here, 0, at.HEAD), last, ints(here, 0, at.HEAD)[at.N]
    while k <= last and not late(here):
        if k == last - 1 and head[at.CLOSES] != 0:
            changed = change_metric(here, k, frozen)
            if changed >= 0:  # level k is the last one now
                frozen, last = changed, k
        longest, equalities, bounded = take_up(here, k, last, warm)
        faults, hard = integer(0), integer(0)
        end, pivoted = ptr[min(k + 1, last)], integer(0)  # rows of V that one polish leaves to the next
        # The last level has no rows of its own, and is hardly ever met: dual at once.
        for turn in range(POLISH if k < last else SOFTLY, FIRMLY + 1):
            if turn == SOFTLY and not bounded:
                continue
            if turn > POLISH:
                if warm and turn == (SOFTLY if bounded else FIRMLY) and faults > FAULTY * hard:
                    start_cold(here, k)
                delta = soften(here, k, last, (SOFT if turn == SOFTLY else HARDER) * longest * longest)
                count = assemble(here, k, last, frozen, delta)
                count = settle(here, end, frozen, count, delta, rounds, FINE)
                remember(here, k, last, count)
            hard, rank, own, own_rank = polish_again(here, k, last, frozen, pivoted)
            faults, _, pull = judge(here, k, last, frozen, hard, rank, own)
            if faults == 0:
                break
            pivoted = rank if equalities <= n - frozen else integer(0)  # else :func:`condense` takes the room
        for again in range(2):
            if k == last or faults == 0 or late(here) or (again == 0 and not feasible(here, k)):
                continue
            if again == 1:
                start_again(here, k)
            known = again == 0
            while True:
                faults, circles, hard, rank, own, own_rank, pull = primal(
                    here, k, last, frozen, hard, rank, own, own_rank, known
                )
                known = False
                if not (circles and sharpen(here)):  # what was let go is needed: it matters what counts as dependent
                    break
        if faults > 0 and (k < last or late(here)):
            break
        if head[at.METRIC] != 0:
            put_back(here, frozen, rank)
        keep(here, k, last)
        note_doubt(here, hard, rank, own, own_rank, pull, frozen)
        if k < last:
            frozen = freeze(here, k, frozen, hard, rank, own, own_rank, pull)
            advance(here)
            if frozen == n:
                conclude(here, k + 1, last)
                k = last
        if k == last and faults == 0 and not far(here) and holds(here, last):
            k += 1
        k += 1
    if last < whole and k > last:
        keep(here, whole, whole)
        k += 1
    head[at.METRIC] = 0
    return k


@inner
def begin(here, last):
    """Reset the state; a level 0 of plain bounds on distinct variables is solved here, as these can all be met.

    Returns
    -------
    k : int
        The first level to be solved: 1 with such bounds, else 0.
    frozen : int
        How many variables these bounds fix.
    """
    head = ints(here, 0, at.HEAD)
    head[at.DOUBT] = 0
    n, boxed = head[at.N], head[at.BOXED] != 0 and last > 0
    ptr, col, depth = marks(here, at.PTR), marks(here, at.COL), marks(here, at.DEPTH)
    kind, side, pivot = marks(here, at.KIND), marks(here, at.SIDE), marks(here, at.PIVOT)
    lower, upper, norm = vector(here, at.LOWER), vector(here, at.UPPER), vector(here, at.NORM)
    w, x0, anchor, exact = vector(here, at.W), vector(here, at.X0), vector(here, at.ANCHOR), vector(here, at.EXACT)
    softness, carried, saved = vector(here, at.VALUE), vector(here, at.LAMBDA), marks(here, at.SAVED)
    V, L = matrix(here, at.V), matrix(here, at.L)
    for i in range(ptr[last]):
        kind[i], side[i], depth[i] = FUTURE, INACTIVE, -1
        softness[i] = carried[i] = w[i] = 0.0
    note_spans(here)
    for j in range(n):
        anchor[j] = exact[j] = x0[j]
    if not boxed:
        return integer(0), integer(0)
    frozen = integer(0)
    for i in range(ptr[0], ptr[1]):
        j, kind[i], saved[i] = col[i], HARD, INACTIVE
        exact[j] = min(max(x0[j], lower[i]), upper[i])
        if lower[i] == upper[i] and norm[i] > 0.0:
            for q in range(padded(n)):
                V[frozen][q] = 0.0
            for q in range(frozen):
                L[i][q] = 0.0
            V[frozen][j], L[i][frozen], pivot[frozen] = 1.0, norm[i], i
            anchor[j] = lower[i]
            kind[i], side[i] = FROZEN, EQUALITY
            frozen += 1
    return integer(1), frozen


@inner
def take_up(here, k, last, warm):
    """Begin level k: its equalities join W, ``side``; with `warm`, W is what the last solve saved for this level.

    Returns
    -------
    longest : float
        Length of the longest row of this level.
    equalities : int
        How many of its rows are equalities.
    bounded : bool
        Whether it has inequalities.
    """
    m, ptr = ints(here, 0, at.HEAD)[at.ROWS], marks(here, at.PTR)
    side, kind, saved = marks(here, at.SIDE), marks(here, at.KIND), marks(here, at.SAVED)
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    first, end, longest, bounded, equalities = ptr[k], ptr[min(k + 1, last)], 0.0, False, integer(0)
    for i in range(first, end):
        longest, bounded = max(longest, norm[i]), bounded or lo[i] != hi[i]
        equalities += norm[i] > 0.0 and lo[i] == hi[i]
    for i in range(end):
        if kind[i] == FROZEN or norm[i] == 0.0:
            continue
        if kind[i] == IGNORED:
            kind[i] = HARD
        if warm:
            was = saved[k * m + i]
            fits = (was == LOWER and lo[i] != -math.inf) or (was == UPPER and hi[i] != math.inf)
            side[i] = was if fits else INACTIVE
        if i >= first and lo[i] == hi[i]:
            side[i] = EQUALITY
    return longest, equalities, bounded


@inner
def soften(here, k, last, delta):
    """Make `delta` the softness of the rows of level k; returns it."""
    ptr, softness = marks(here, at.PTR), vector(here, at.VALUE)
    for i in range(ptr[k], ptr[min(k + 1, last)]):
        softness[i] = delta
    return delta


@inner
def condense(here, k, frozen, delta):
    """Replace the equalities of level k, more rows than directions, by as many members as they have rank; returns that.

    Householder reflections turn them into rows with the same least squares. These members have the numbers m, m + 1 ...
    """
    head = ints(here, 0, at.HEAD)
    n, m = head[at.N], head[at.ROWS]
    ptr, side = marks(here, at.PTR), marks(here, at.SIDE)
    ids, slots, members = marks(here, at.IDS), marks(here, at.SLOTS), marks(here, at.MEMBERS)
    lo, norm, lengths, rhs = vector(here, at.LO), vector(here, at.NORM), vector(here, at.LENGTHS), vector(here, at.RHS)
    y, right, soft, force = vector(here, at.Y), vector(here, at.RIGHT), vector(here, at.SOFT), vector(here, at.FORCE)
    P, V, L, R, H = matrix(here, at.P), matrix(here, at.V), matrix(here, at.L), matrix(here, at.R), matrix(here, at.H)
    tau = vector(here, at.OPTION)[at.TAU]
    count = integer(0)
    for i in range(ptr[k], ptr[k + 1]):
        if side[i] == EQUALITY:
            list_part(i, count, count, here)
            count += 1
    rank = pivots(ids, count, slots, lengths, R, norm, V, L, frozen, padded(n), tau)
    for r in range(count):
        rhs[r] = start_of(ids[r], lo[ids[r]], here)
    triangle(ids, count, rank, L, frozen, rhs, y, H)
    for c in range(rank):
        row, direction = P[m + c], V[frozen + c]
        for j in range(padded(n)):
            row[j] = y[frozen + c] * direction[j]
        for q in range(c):
            direction, much = V[frozen + q], H[q][c]
            for j in range(n):
                row[j] += much * direction[j]
        members[c], right[c], soft[c], force[c] = m + c, rhs[c], delta, 0.0
        enter(c, here)
    return rank


@inner
def assemble(here, k, last, frozen, delta):
    """Factor W: first the equalities of level k, then hard rows above, then its inequalities; returns how many members.

    Rows that depend on the members before them, or find no room, become inactive.
    """
    n = ints(here, 0, at.HEAD)[at.N]
    ptr, side, kind = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.KIND)
    force, carried, norm = vector(here, at.FORCE), vector(here, at.LAMBDA), vector(here, at.NORM)
    most = len(marks(here, at.MEMBERS))
    first, end = ptr[k], ptr[min(k + 1, last)]
    equalities = integer(0)
    for i in range(first, end):
        if side[i] == EQUALITY:
            prepare(i, frozen, here)
            equalities += 1
    count = integer(0)
    if equalities > n - frozen:
        count = condense(here, k, frozen, delta)
    elif equalities > 0:
        for i in range(first, end):
            if side[i] == EQUALITY and admit(i, frozen, count, delta, here):
                count += 1
    for i in range(end):
        if side[i] == INACTIVE or side[i] == EQUALITY or kind[i] == FROZEN or norm[i] == 0.0:
            continue
        if count < most and admit(i, frozen, count, delta, here):
            force[count] = carried[i] if carried[i] * side[i] > 0.0 else 0.0
            count += 1
        else:
            side[i] = INACTIVE
    return count


@inner
def start_cold(here, k):
    """Begin level k with W as the level above has left it, ``saved``, in place of what the last solve has saved."""
    m, ptr, saved = ints(here, 0, at.HEAD)[at.ROWS], marks(here, at.PTR), marks(here, at.SAVED)
    side, kind = marks(here, at.SIDE), marks(here, at.KIND)
    for i in range(ptr[k + 1]):
        if kind[i] != FROZEN and side[i] != EQUALITY:
            side[i] = saved[(k - 1) * m + i] if i < ptr[k] and k > 0 else INACTIVE


@inner
def feasible(here, k):
    """Whether APPROACH satisfies the hard rows of the levels above k, within FEASIBLE."""
    ptr, kind, norm = marks(here, at.PTR), marks(here, at.KIND), vector(here, at.NORM)
    lo, hi, point = vector(here, at.LO), vector(here, at.HI), vector(here, at.APPROACH)
    size = extent(point, here)
    for i in range(ptr[k]):
        if kind[i] != FROZEN and norm[i] > 0.0:
            value, near = value_of(i, point, here), FEASIBLE * norm[i] * size
            if value > hi[i] + near + FEASIBLE * abs(hi[i]) or value < lo[i] - near - FEASIBLE * abs(lo[i]):
                return False
    return True


@inner
def start_again(here, k):
    """Start level k again: APPROACH = EXACT, and W that of the level above plus the rows of level k violated there."""
    head, tol = ints(here, 0, at.HEAD), vector(here, at.OPTION)[at.TOL]
    n, m, ptr, saved = head[at.N], head[at.ROWS], marks(here, at.PTR), marks(here, at.SAVED)
    side, kind, norm = marks(here, at.SIDE), marks(here, at.KIND), vector(here, at.NORM)
    lo, hi = vector(here, at.LO), vector(here, at.HI)
    point, exact = vector(here, at.APPROACH), vector(here, at.EXACT)
    for j in range(n):
        point[j] = exact[j]
    size = extent(point, here)
    for i in range(ptr[k + 1]):
        if kind[i] == FROZEN or norm[i] == 0.0 or side[i] == EQUALITY:
            continue
        if i < ptr[k]:
            side[i] = saved[(k - 1) * m + i] if kind[i] == HARD else INACTIVE
            continue
        value, near = value_of(i, point, here), tol * norm[i] * size
        side[i] = INACTIVE
        if value > hi[i] + near + tol * abs(hi[i]):
            side[i] = UPPER
        elif value < lo[i] - near - tol * abs(lo[i]):
            side[i] = LOWER
