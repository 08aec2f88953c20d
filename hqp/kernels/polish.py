r"""Solves one level exactly with its active rows as equalities, and counts the rows that contradict the result.

In the null space of the frozen rows V[:frozen], with C the active rows of the levels above and S those of the level,

.. math:: \min_x \|S x - g_S\|^2 \quad \text{subject to} \quad C x = g_C, \qquad x = x_E + V^T y,

is solved by pivoted Gram-Schmidt and reflections (:mod:`.orthogonal`), without softness. If the level is not met,
multipliers of C must balance :math:`g = S^T w`; they and the slacks w of inequality rows must have the right signs. No
inactive row may be violated. If no row contradicts this, the level is proved optimal, given those above.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .doubt import may_be_met
from .extent import extent
from .lines import add_lines
from .members import list_part, prepare, start_of
from .memory import ints, marks, matrix, vector
from .metric import displace, pull_in_metric
from .orthogonal import NONE, level_least_squares, padded, pivots, separate
from .rows import EQUALITY, INACTIVE, target, value_of
from .signs import CLEAR, clear_of_basis
from .working_set import FROZEN, balance

#: A pivot row of which projection leaves a smaller share is not kept from one primal step to the next.
FIRM = 1e-2


@inner
def list_members(here, first, end, frozen, begin, room):
    """List the active rows of first .. end - 1 from place `begin` on, and their projections P in R; returns how many.

    At most `room` are listed; the others become inactive. Rows that :func:`recall` has listed are left out.
    """
    n = ints(here, 0, at.HEAD)[at.N]
    side, kind, listed, R = marks(here, at.SIDE), marks(here, at.KIND), marks(here, at.DECIDED), matrix(here, at.R)
    norm, lengths, tau = vector(here, at.NORM), vector(here, at.LENGTHS), vector(here, at.OPTION)[at.TAU]
    count = integer(begin)
    for i in range(first, end):
        if side[i] == INACTIVE or kind[i] == FROZEN or norm[i] == 0.0 or listed[i] != 0:
            continue
        if count - begin == room:
            side[i] = INACTIVE
            continue
        prepare(i, frozen, here)
        list_part(i, count, count - begin, here)
        if not lengths[count] > min(NONE, tau) * norm[i]:
            lengths[count] = 0.0
            row = R[count]
            for j in range(padded(n)):
                row[j] = 0.0
        count += 1
    return count - begin


@inner
def recall(here, end, frozen, known):
    """How many of the first `known` rows in ``ids`` are still active and firm, up to the first that is not.

    Their part of V stays; all others are pivoted anew, so that no row stands behind one of which less is left.
    ``decided`` marks those that stay, among the rows before `end`.
    """
    side, ids, listed = marks(here, at.SIDE), marks(here, at.IDS), marks(here, at.DECIDED)
    norm, L = vector(here, at.NORM), matrix(here, at.L)
    for i in range(end):
        listed[i] = 0
    kept = integer(0)
    while kept < known and side[ids[kept]] != INACTIVE and L[ids[kept]][frozen + kept] > FIRM * norm[ids[kept]]:
        listed[ids[kept]] = 1
        kept += 1
    return kept


@inner
def polish(here, k, last, frozen, known):
    """Solve level k with its active rows as equalities: x, y and the slacks w. For the last level S is empty.

    `known` pivot rows of C are in ``ids``, V and L from the last time, of which a few may have left since; 0 if not.

    Returns
    -------
    hard, rank, own, own_rank : int
        Rows of C, their rank, rows of S, their rank. V then has `rank` rows from C, and `own_rank` from S behind them;
        ``ids`` lists the rows of C, then those of S, each with its pivot rows first.
    """
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    ptr, side, pivot = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.PIVOT)
    ids, slots = marks(here, at.IDS), marks(here, at.SLOTS)
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    x, w, y, anchor = vector(here, at.X), vector(here, at.W), vector(here, at.Y), vector(here, at.ANCHOR)
    rhs, lengths, tau = vector(here, at.RHS), vector(here, at.LENGTHS), vector(here, at.OPTION)[at.TAU]
    V, L, R, H = matrix(here, at.V), matrix(here, at.L), matrix(here, at.R), matrix(here, at.H)
    moved, wide = vector(here, at.MOVED), padded(n)
    known = recall(here, ptr[min(k + 1, last)], frozen, known)
    more, c = list_members(here, integer(0), ptr[k], frozen, known, n - known), frozen + known
    mine, places, sizes, rows = ids[known:], slots[known:], lengths[known:], R[known:]
    if known > 0:
        separate(mine, more, places, sizes, rows, norm, V, L, frozen, c, wide, tau)
    hard, rank = known + more, known + pivots(mine, more, places, sizes, rows, norm, V, L, c, wide, tau)
    for r in range(rank):
        i = ids[r]
        row, total = L[i], -start_of(i, target(side[i], lo[i], hi[i]), here)
        for q in range(frozen, frozen + r):
            total -= row[q] * y[q]
        y[frozen + r] = total / row[frozen + r]
        pivot[frozen + r] = i

    c = frozen + rank
    own = list_members(here, ptr[k], ptr[min(k + 1, last)], frozen, hard, head[at.ROWS])
    mine, places, sizes, rows, right = ids[hard:], slots[hard:], lengths[hard:], R[hard:], rhs[hard:]
    separate(mine, own, places, sizes, rows, norm, V, L, frozen, c, wide, tau)
    own_rank = pivots(mine, own, places, sizes, rows, norm, V, L, c, wide, tau)
    for r in range(own):
        i = mine[r]
        row, total = L[i], -start_of(i, target(side[i], lo[i], hi[i]), here)
        for q in range(frozen, c):
            total -= row[q] * y[q]
        right[r] = total
    level_least_squares(mine, own, own_rank, L, c, right, y, w, H)
    for r in range(own_rank):
        pivot[c + r] = mine[r]
    for j in range(n):
        x[j] = anchor[j]
    for j in range(wide):
        moved[j] = 0.0
    add_lines(V, frozen, c + own_rank, y, wide, moved)
    if head[at.METRIC] != 0:
        displace(here, x)
    else:
        for j in range(n):
            x[j] += moved[j]
    return hard, rank, own, own_rank


@inner
def judge(here, k, last, frozen, hard, rank, own):
    """Count the rows that contradict the active set of level k, at the x of :func:`polish`.

    Returns
    -------
    faults : int
        Active rows with a multiplier, or a slack, of the wrong sign; inactive rows that are violated; and dependent
        rows of C that are not at their bound. DOUBT is set if inactive rows would pull, though within their tolerance.
    worst : int
        The active row whose multiplier, or slack, has the most wrong sign, or -1.
    pull : float
        The forces of the level; 0 if it is met.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    n, tol, blur = head[at.N], option[at.TOL], option[at.TOL] * option[at.BLUR]
    ptr, col, row_of, side = marks(here, at.PTR), marks(here, at.COL), marks(here, at.ROW_OF), marks(here, at.SIDE)
    kind, ids, pivot = marks(here, at.KIND), marks(here, at.IDS), marks(here, at.PIVOT)
    lo, hi, norm, B = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), matrix(here, at.B)
    x, w, g, multiplier = vector(here, at.X), vector(here, at.W), vector(here, at.G), vector(here, at.MULTIPLIER)
    x0 = vector(here, at.X0)
    size, met, pull = extent(x, here), True, 0.0
    if head[at.METRIC] != 0:
        pull, met = pull_in_metric(here, size)
        blur = 0.0
    elif k == last:  # min ||x - x_0||, which is met at x_0 alone
        for j in range(n):
            g[j] = x[j] - x0[j]
            pull += abs(g[j])
        met = pull <= blur
    for r in range(hard, hard + own):
        i = ids[r]
        goal = target(side[i], lo[i], hi[i])
        met = met and abs(w[i]) <= tol * (abs(goal) + norm[i] * size)
        pull += norm[i] * abs(w[i])
    faults, worst, unpaid = integer(0), integer(-1), 0.0
    least = wrong = 0.0
    if met:
        pull = 0.0
    else:
        if k < last:
            for j in range(n):
                g[j] = 0.0
        for r in range(hard, hard + own):
            i = ids[r]
            much = w[i]
            if col[i] >= 0:
                g[col[i]] += much * norm[i]
            elif much != 0.0:
                row = B[row_of[i]]
                for j in range(n):
                    g[j] += much * row[j]
        balance(vector(here, at.G), frozen, frozen + rank, here)
        least = wrong = -clear_of_basis(here, frozen, frozen + rank, pull) - (blur if k == last else 0.0)
        for q in range(frozen, frozen + rank):
            i = pivot[q]
            says = multiplier[q] * side[i] * norm[i]
            faults += says < wrong
            if says < least:
                worst, least = i, says
        for r in range(hard, hard + own):
            i = ids[r]
            if side[i] != EQUALITY:
                says = w[i] * side[i] * norm[i]
                faults += says < wrong
                if says < least:
                    worst, least = i, says
    for i in range(ptr[k + 1] if k < last else 0):  # at the last level :func:`holds` looks at all rows
        if side[i] == INACTIVE and kind[i] != FROZEN and norm[i] > 0.0:
            value = value_of(i, x, here)
            out = max(value - hi[i], lo[i] - value)
            if out > 0.0:
                faults += out > tol * (norm[i] * size + abs(hi[i] if value > hi[i] else lo[i]))
                unpaid += norm[i] * out if i >= ptr[k] else 0.0
    for r in range(rank, hard):  # rows of C that depend on the pivot rows must be at their bound, too
        i = ids[r]
        goal = target(side[i], lo[i], hi[i])
        faults += abs(value_of(i, x, here) - goal) > tol * (abs(goal) + norm[i] * size)
    if faults == 0 and unpaid > CLEAR * pull > 0.0:
        head[at.DOUBT] = 1
    return faults, worst, pull


@inner
def holds(here, last):
    """Whether x keeps the slacks of active rows and the bounds of inactive ones on all levels above the last.

    DOUBT is set if the certificate may take one of these slacks for round-off.
    """
    ptr, side, x = marks(here, at.PTR), marks(here, at.SIDE), vector(here, at.X)
    tol = vector(here, at.OPTION)[at.TOL]
    lo, hi, norm, w = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), vector(here, at.W)
    size = extent(x, here)
    for i in range(ptr[last]):
        if norm[i] == 0.0:
            continue
        value, near = value_of(i, x, here), tol * norm[i] * size
        low, high = lo[i], hi[i]
        if side[i] != INACTIVE:
            low = high = target(side[i], lo[i], hi[i])
            low, high = low + w[i], high + w[i]
            if may_be_met(here, i, size):
                ints(here, 0, at.HEAD)[at.DOUBT] = 1
        if value > high + near + tol * abs(high) or value < low - near - tol * abs(low):
            return False
    return True
