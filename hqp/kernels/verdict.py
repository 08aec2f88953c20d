r"""Checks a guess of the active set that :mod:`.sweep` has solved: the whole certificate, from the basis of the sweep.

Inactive rows must be inside their bounds, and the multipliers of each level must have the right signs,

.. math:: g = \sum_i w_i a_i, \qquad g + \sum_i \lambda_i a_i = 0, \qquad \lambda_i \ge 0\;(\le 0)
   \text{ at an upper (lower) bound.}

They follow by back substitution in the triangle of the sweep. Whether an active inequality row is right is decided by
the sign of its slack on its own level, then by its multipliers on the levels below, in turn; the first clear sign
decides (lexicographic multipliers).
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .doubt import may_be_met, turns
from .extent import extent
from .lines import product
from .memory import ints, marks, matrix, vector
from .rows import EQUALITY, INACTIVE, LOWER, UPPER, target
from .signs import CLEAR, HELD_FIRMLY, clear_sign
from .threads import told

#: In place of the damped level: none is damped.
STRICT = -1
#: What the levels so far tell of an active row: no clear sign; right, but by a multiplier so small that the certificate
#: may not count it; or a clear sign.
UNDECIDED, BY_A_THREAD, DECIDED = 0, 1, 2


@inner
def damping_pulls(here, damping, size):
    r"""The sum of the forces :math:`\lambda^2 |x_j - x_{0j}|` of the damping of a level, and whether it counts as zero.

    :math:`\lambda` is `damping`, x_0 the aim of the level, `size` the length of x.
    """
    n, tol = ints(here, 0, at.HEAD)[at.N], vector(here, at.OPTION)[at.TOL]
    x, x0 = vector(here, at.X), vector(here, at.X0)
    pull, met = 0.0, True
    for j in range(n):
        away = abs(x[j] - x0[j])
        met = met and away <= tol * (abs(x0[j]) + size)
        pull += damping * damping * away
    return pull, met


@inner
def judge_rows(here, last, damped, damping):
    """Count inactive rows that are violated, and active inequalities whose slack is on the wrong side.

    `damped` is the damped level, or STRICT: the forces of its damping belong to its forces.

    Returns
    -------
    faults : int
        How many there are; ``follow`` has the sides that they suggest.
    undecided : int
        Active inequality rows whose slack is too small for a sign: the levels below decide.
    blurred : bool
        As of :func:`.sweep.sweep`.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    n, tol, first = head[at.N], option[at.TOL], 1 if head[at.BOXED] != 0 else 0
    col, row_of, ptr, side = marks(here, at.COL), marks(here, at.ROW_OF), marks(here, at.PTR), marks(here, at.SIDE)
    follow, decided, dependent = marks(here, at.FOLLOW), marks(here, at.DECIDED), marks(here, at.KIND)
    cut, lo, hi = marks(here, at.CUT), vector(here, at.LO), vector(here, at.HI)
    norm, x = vector(here, at.NORM), vector(here, at.X)
    w, forces_of, left, B = vector(here, at.W), vector(here, at.FORCES), vector(here, at.VALUE), matrix(here, at.B)
    size = extent(x, here)
    faults, undecided, blurred, turned = 0, 0, False, False
    for k in range(last):
        pull, met, unbalanced, unpaid = 0.0, True, 0.0, 0.0
        if k == damped:
            pull, met = damping_pulls(here, damping, size)
        for i in range(ptr[k], ptr[k + 1]):
            follow[i] = side[i]
            decided[i] = DECIDED
            if norm[i] == 0.0:
                continue
            near = tol * norm[i] * size
            if side[i] != INACTIVE:
                bound = target(side[i], lo[i], hi[i])
                met = met and abs(w[i]) <= near + tol * abs(bound)
                pull += norm[i] * abs(w[i])
                if k < first or dependent[i] == 0:
                    continue
                unbalanced += abs(w[i]) * left[i]
                if side[i] == EQUALITY or abs(w[i]) > near + tol * abs(bound):
                    turned = turned or turns(here, i, left[i], integer(0), cut[k + 1])
            value = norm[i] * x[col[i]] if col[i] >= 0 else product(B[row_of[i]], x, n)
            if side[i] != INACTIVE:
                bound = target(side[i], lo[i], hi[i])
                blurred = blurred or abs(value - bound - w[i]) > near + tol * abs(bound)
                continue
            out = max(value - hi[i], lo[i] - value)
            if out > 0.0:
                unpaid += norm[i] * out
                if out > near + tol * abs(hi[i] if value > hi[i] else lo[i]):
                    follow[i] = UPPER if value > hi[i] else LOWER
                    faults += 1
        forces_of[k] = 0.0 if met else pull
        clear = CLEAR * pull
        if turned or (not met and max(unpaid, unbalanced) > clear):
            head[at.DOUBT] = 1
        for i in range(ptr[k], ptr[k + 1]):
            if side[i] == INACTIVE:
                continue
            if met:
                w[i] = 0.0
            counts = norm[i] * abs(w[i]) > clear
            if side[i] == EQUALITY and not counts:
                continue
            felt = abs(w[i]) > tol * (norm[i] * size + abs(target(side[i], lo[i], hi[i])))
            if counts != felt or (felt and may_be_met(here, i, size)):
                head[at.DOUBT] = 1  # of the level, the row and the certificate, not all tell this slack from round-off
            if not counts:
                decided[i], undecided = UNDECIDED, undecided + 1
            elif side[i] != EQUALITY and w[i] * side[i] < 0.0:
                follow[i] = INACTIVE
                faults += 1
    return faults, undecided, blurred


@inner
def judge_multipliers(here, last, undecided, damped, damping, closed):
    """Count undecided rows whose first multiplier with a clear sign has the wrong one, and those that stay undecided.

    `damped` is as of :func:`judge_rows`; if it is a level, the implicit last level is not judged, as rows of damping
    determine x. `closed` tells that the level above it was solved by :mod:`.closing`, which leaves ``multiplier``, its
    forces along V: they are not judged below it.
    """
    head = ints(here, 0, at.HEAD)
    n, boxed = head[at.N], head[at.BOXED] != 0
    col, row_of, ptr, side = marks(here, at.COL), marks(here, at.ROW_OF), marks(here, at.PTR), marks(here, at.SIDE)
    decided, cut = marks(here, at.DECIDED), marks(here, at.CUT)
    pivot = marks(here, at.PIVOT)
    norm, x0, x, w = vector(here, at.NORM), vector(here, at.X0), vector(here, at.X), vector(here, at.W)
    y, g, G, forces_of = vector(here, at.Y), vector(here, at.G), vector(here, at.BALANCE), vector(here, at.FORCES)
    B, L = matrix(here, at.B), matrix(here, at.L)
    option, along, faults = vector(here, at.OPTION), vector(here, at.MULTIPLIER), 0
    queue, some = marks(here, at.QUEUE), undecided
    for k in range(last + 1 if damped == STRICT and not closed else last):
        if undecided == 0:
            break
        forces = 0.0
        if k < last:
            forces = forces_of[k]
            if forces == 0.0:
                continue
            c = cut[k]
            closing = closed and k == last - 1
            for q in range(c):
                g[q] = along[q] if closing else 0.0
            for j in range(n):
                G[j] = 0.0
            for i in range(ptr[k], ptr[k + 1]):
                if w[i] != 0.0:
                    push(i, w[i], integer(0) if closing else c, col, row_of, B, norm, L, g, G, n)
            if k == damped:
                for q in range(c):
                    g[q] += damping * damping * y[q]
                for j in range(n):
                    G[j] += damping * damping * (x[j] - x0[j])
        else:
            c = cut[last]
            for q in range(c):
                g[q] = y[q]
            for j in range(n):
                G[j] = x[j] - x0[j]
                forces += abs(G[j])
        total, weakest, threads, first = 0.0, 1.0, integer(0), undecided == some
        blur = option[at.TOL] * option[at.BLUR] if k == last else 0.0
        for q in range(c - 1, -1, -1):
            i = pivot[q]
            multiplier, weakest = -g[q] / L[i][q], min(weakest, L[i][q] / norm[i])
            if multiplier == 0.0:
                continue
            push(i, multiplier, q, col, row_of, B, norm, L, g, G, n)
            total += abs(multiplier) * norm[i]
            if decided[i] != DECIDED:
                clear = clear_sign(forces, total, weakest) + blur
                before = decided[i]
                wrong, decides = read_sign(here, i, multiplier * side[i] * norm[i], clear, forces)
                faults, undecided = faults + wrong, undecided - decides
                if before == UNDECIDED and decided[i] == BY_A_THREAD:
                    queue[threads] = q
                    threads += 1
        if boxed:
            clear = clear_sign(forces, total, weakest) + blur
            for i in range(ptr[0], ptr[1]):
                if decided[i] != DECIDED:
                    before = decided[i]
                    wrong, decides = read_sign(here, i, -G[col[i]] * side[i], clear, forces)
                    faults, undecided = faults + wrong, undecided - decides
                    if before == UNDECIDED and decided[i] == BY_A_THREAD:
                        queue[threads] = -1 - i
                        threads += 1
        if threads > 0 and k < last - closed and k != damped:
            undecided -= tell(here, k, threads, first)
    return faults, undecided


@inner
def tell(here, k, threads, first):
    """Decide the rows that hold level k by a thread, ``queue[:threads]``, if its rows tell them; returns how many.

    Of the rows above, and of its own, those that are not decided yet are open: see :func:`.threads.told`. `first` tells
    that no multiplier has decided a row on the levels above.
    """
    head, ptr, cut = ints(here, 0, at.HEAD), marks(here, at.PTR), marks(here, at.CUT)
    n, ids, side, decided = head[at.N], marks(here, at.IDS), marks(here, at.SIDE), marks(here, at.DECIDED)
    pivot, pinned, dependent = marks(here, at.PIVOT), marks(here, at.PINNED), marks(here, at.KIND)
    queue, many, opens = marks(here, at.QUEUE), integer(0), integer(0)
    for i in range(ptr[k], ptr[k + 1]):
        if side[i] != INACTIVE and dependent[i] != 0:
            ids[many] = i
            many += 1
    for t in range(threads):
        decided[row_at(queue[t], pivot)] = DECIDED
    for q in range(cut[k + 1]):
        if decided[pivot[q]] != DECIDED:
            opens += 1
            queue[n - opens] = q
    f = integer(0)
    for j in range(n):
        if pinned[j] < 0:
            f += 1
        elif decided[pinned[j]] != DECIDED:
            opens += 1
            queue[n - opens] = -1 - pinned[j]
    if told(here, threads, opens, integer(0), many, integer(0), cut[k + 1], first and cut[k + 1] == f):
        return threads
    for t in range(threads):
        decided[row_at(queue[t], pivot)] = BY_A_THREAD
    return integer(0)


@inner
def row_at(place, pivot):
    """The row at a place of the basis, or the active bound i that -1 - i stands for."""
    return pivot[place] if place >= 0 else -1 - place


@inner
def read_sign(here, i, says, clear, forces):
    """Read the sign of a multiplier of an undecided row: returns 1 if it is wrong, else 0; and 1 if it decides, else 0.

    `says` is the multiplier times the length of the row, positive if right; `clear` the size from which it has a sign;
    `forces` are those of the level. A row that holds a level back by a tiny multiplier may have any sign on the levels
    below; but if it has the wrong one there, the answer is in doubt.
    """
    decided = marks(here, at.DECIDED)
    if abs(says) <= clear:
        return 0, 0
    if 0.0 < says <= HELD_FIRMLY * forces:
        decided[i] = BY_A_THREAD
        return 0, 0
    thread, decided[i] = decided[i] == BY_A_THREAD, DECIDED
    if says > 0.0:
        return 0, 1
    if thread:
        ints(here, 0, at.HEAD)[at.DOUBT] = 1
        return 0, 1
    marks(here, at.FOLLOW)[i] = INACTIVE
    return 1, 1


@inner
def push(i, force, c, col, row_of, B, norm, L, g, G, n):
    """Add `force` times row i to a gradient: to its coordinates along V, g[:c], and to its entries G (n,)."""
    row = L[i]
    for q in range(c):
        g[q] += force * row[q]
    if col[i] >= 0:
        G[col[i]] += force * norm[i]
    else:
        given = B[row_of[i]]
        for j in range(n):
            G[j] += force * given[j]
