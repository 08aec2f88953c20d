r"""The sweep: solves the hierarchy for a guess of its active set, in one pass, and checks its whole certificate.

With the active rows of the guess as equalities, the hierarchy is a lexicographic least squares, solved in one pass from
the highest level to the lowest. Active bounds of level 0 fix their variables, whose columns leave the problem. The
implicit last level costs nothing: :math:`x = x_0 + V^T y` *is* the point nearest to :math:`x_0` that solves the levels.
Then :mod:`.verdict` checks the result.
"""

from __future__ import annotations

from . import layout as at
from .closing import close, spans_all
from .compile import inner, integer
from .doubt import WEAK, weakest_share
from .extent import far
from .lines import add_lines, pick_entries, product
from .memory import ints, marks, matrix, vector
from .orthogonal import level_least_squares, padded, pivots, separate
from .rows import INACTIVE, target, value_of
from .verdict import STRICT, judge_multipliers, judge_rows


@inner
def sweep(here, last, tau):
    """Solve levels 0 .. last for the guess ``side``, and count the rows that contradict it; none is a proof.

    Writes the point ``x``, the weighted slacks ``w``, and to ``follow`` the sides that the contradictions suggest.

    Returns
    -------
    faults : int
        How many rows contradict the guess.
    blurred : bool
        Whether a row that counts as dependent proves not to be: its value at x is off by more than its tolerance,
        because its remainder was neglected.
    """
    head = ints(here, 0, at.HEAD)
    closing = head[at.CLOSES] != 0
    while True:
        head[at.DOUBT] = 0
        closing = solve_equalities(here, last, tau, closing)
        faults, undecided, blurred = judge_rows(here, last, STRICT, 0.0)
        if undecided > 0:
            wrong, undecided = judge_multipliers(here, last, undecided, STRICT, 0.0, closing)
            faults += wrong
        if not closing or undecided == 0 or faults > 0 or spans_all(here, last):
            return faults, blurred
        closing = False  # what is left for the implicit last level to decide needs a basis of all


@inner
def fix_variables(here):
    """Set ``x`` to x_0, with variables of active bounds of level 0 at these bounds; returns how many are free.

    ``pinned`` has the row that fixes a variable, or -1; ``free`` lists the free variables.
    """
    head = ints(here, 0, at.HEAD)
    n, boxed = head[at.N], head[at.BOXED] != 0
    col, ptr, side = marks(here, at.COL), marks(here, at.PTR), marks(here, at.SIDE)
    pinned, free = marks(here, at.PINNED), marks(here, at.FREE)
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    x, x0, w = vector(here, at.X), vector(here, at.X0), vector(here, at.W)
    for j in range(n):
        pinned[j] = -1
        x[j] = x0[j]
    if boxed:
        for i in range(ptr[0], ptr[1]):
            w[i] = 0.0
            if side[i] != INACTIVE:
                pinned[col[i]] = i
                x[col[i]] = target(side[i], lo[i], hi[i]) / norm[i]
    f = integer(0)
    for j in range(n):
        if pinned[j] < 0:
            free[f] = j
            f += 1
    return f


@inner
def gather(here, k, f):
    """Write the active rows of level k, restricted to the f free variables, to ``ids`` and R; returns how many.

    Their right-hand sides, bound less a_i x, go to ``value``.
    """
    n = ints(here, 0, at.HEAD)[at.N]
    col, row_of, ptr, side = marks(here, at.COL), marks(here, at.ROW_OF), marks(here, at.PTR), marks(here, at.SIDE)
    free, ids = marks(here, at.FREE), marks(here, at.IDS)
    lo, hi, norm, x = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), vector(here, at.X)
    w, given_rhs = vector(here, at.W), vector(here, at.VALUE)
    B, R = matrix(here, at.B), matrix(here, at.R)
    count = integer(0)
    for i in range(ptr[k], ptr[k + 1]):
        w[i] = 0.0
        if side[i] == INACTIVE:
            continue
        row = R[count]
        bound = target(side[i], lo[i], hi[i])
        if col[i] >= 0:
            for t in range(f):
                row[t] = 0.0
                if free[t] == col[i]:
                    row[t] = norm[i]
            given_rhs[i] = bound - norm[i] * x[col[i]]
        else:
            given = B[row_of[i]]
            given_rhs[i] = bound - product(given, x, n)
            pick_entries(given, free, f & -at.PAD, row)
            for t in range(f & -at.PAD, f):
                row[t] = given[free[t]]
        for t in range(f, padded(f)):
            row[t] = 0.0
        ids[count] = i
        count += 1
    return count


@inner
def enter_level(here, k, c, f, tau):
    """Factor the active rows of level k on top of V[:c], and write their right-hand sides for y[c:] to ``rhs``.

    Returns their number and their rank.
    """
    ids, slots, lengths = marks(here, at.IDS), marks(here, at.SLOTS), vector(here, at.LENGTHS)
    norm, y, rhs, given_rhs = vector(here, at.NORM), vector(here, at.Y), vector(here, at.RHS), vector(here, at.VALUE)
    V, L, R = matrix(here, at.V), matrix(here, at.L), matrix(here, at.R)
    marks(here, at.CUT)[k] = c
    count, rank = gather(here, k, f), integer(0)
    if count > 0:
        wide = padded(f)
        # The literal 0 here and in `pivots` makes a variant of `project` for the sweep alone: 3 % of a solve.
        separate(ids, count, slots, lengths, R, norm, V, L, 0, c, wide, tau)
        rank = pivots(ids, count, slots, lengths, R, norm, V[:f], L, c, wide, tau)
        for r in range(count):
            rhs[r] = given_rhs[ids[r]] - product(L[ids[r]], y, c)
    return count, rank


@inner
def note_level(here, c, count, rank):
    """Record which of the `count` rows in ``ids`` are pivot rows of V[c:], and the remainders of the dependent ones.

    Sets DOUBT if a pivot row is :data:`.doubt.WEAK`, on top of those above.
    """
    pivot, ids, dependent = marks(here, at.PIVOT), marks(here, at.IDS), marks(here, at.KIND)
    lengths, left, L, norm = vector(here, at.LENGTHS), vector(here, at.VALUE), matrix(here, at.L), vector(here, at.NORM)
    weakest = weakest_share(here, c) if rank > 0 else 1.0
    for r in range(rank):
        share = abs(L[ids[r]][c + r]) / norm[ids[r]]
        if share * weakest < WEAK:
            ints(here, 0, at.HEAD)[at.DOUBT] = 1
        weakest = min(weakest, share)
        pivot[c + r] = ids[r]
        dependent[ids[r]] = 0
    for r in range(rank, count):
        dependent[ids[r]] = 1
        left[ids[r]] = lengths[r]


@inner
def solve_levels(here, k, end, c, f, tau):
    """Solve levels k .. end - 1 in turn for their active rows, on top of V[:c]; returns how many rows V then has."""
    ids, y, w, rhs = marks(here, at.IDS), vector(here, at.Y), vector(here, at.W), vector(here, at.RHS)
    L, H = matrix(here, at.L), matrix(here, at.H)
    while k < end:
        count, rank = enter_level(here, k, c, f, tau)
        if count > 0:
            level_least_squares(ids, count, rank, L, c, rhs, y, w, H)
            note_level(here, c, count, rank)
        c += rank
        k += 1
    return c


@inner
def arrive(here, last, c, f):
    """Add V[:c]' y to the ``x`` of :func:`fix_variables`, with one step of refinement if round-off of x_0 matters."""
    free, x, y, V = marks(here, at.FREE), vector(here, at.X), vector(here, at.Y), matrix(here, at.V)
    moved, wide = vector(here, at.MOVED), padded(f)
    marks(here, at.CUT)[last] = c
    for t in range(wide):
        moved[t] = 0.0
    add_lines(V, integer(0), c, y, wide, moved)
    for t in range(f):
        x[free[t]] += moved[t]
    if far(here):
        refine(here, c, f)


@inner
def solve_equalities(here, last, tau, closing):
    """Solve levels 0 .. last for the guess ``side``: writes x, the slacks w, and the basis V with its pivot rows.

    Returns whether the level above the last was solved without a basis of its own, as may be if `closing`.
    """
    f = fix_variables(here)
    first, cut = integer(1 if ints(here, 0, at.HEAD)[at.BOXED] != 0 else 0), marks(here, at.CUT)
    end = last - 1 if closing else last
    c = solve_levels(here, first, end, integer(0), f, tau)
    if closing:
        cut[end] = cut[last] = c
        if close(here, c, f):
            return True
        c = solve_levels(here, end, last, c, f, tau)
    arrive(here, last, c, f)
    return False


@inner
def refine(here, c, f):
    """One step of iterative refinement of x, along V[:c]: removes the round-off of a large x_0."""
    pivot, side, free = marks(here, at.PIVOT), marks(here, at.SIDE), marks(here, at.FREE)
    lo, hi, x, w = vector(here, at.LO), vector(here, at.HI), vector(here, at.X), vector(here, at.W)
    y, more = vector(here, at.Y), vector(here, at.G)
    V, L = matrix(here, at.V), matrix(here, at.L)
    for q in range(c):
        i = pivot[q]
        row, total = L[i], target(side[i], lo[i], hi[i]) + w[i] - value_of(i, x, here)
        for r in range(q):
            total -= row[r] * more[r]
        more[q] = total / row[q]
    for q in range(c):
        direction, step = V[q], more[q]
        y[q] += step
        for t in range(f):
            x[free[t]] += step * direction[t]
