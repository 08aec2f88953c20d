r"""The certificate: decides level by level whether x is optimal, from the numbers of the hierarchy alone.

See :mod:`hqp.certificate.certificate` for the conditions. With the forces of a level divided by their sum, the rows
above must balance its gradient: *free* rows, equalities and violated ones, with multipliers of either sign; *signed*
rows, inequalities at a bound, with multipliers of one sign. So the free normals are projected out (:mod:`.span`), and a
non-negative least squares over the signed ones follows (:func:`.escape.nonnegative`). Its residual must be round-off,
or must vanish when the slacks of the level shift within their tolerances (:mod:`.shift`).

A signed row that *holds* a level, with a positive multiplier, cannot leave its bound without making that level worse.
So for all levels below it acts as an equality. This follows from the optimality conditions: one can add a large
multiple of the balance of the level that the row holds. So one basis is carried down the levels, of the normals of free
rows and of rows that hold a level above. As a large multiple magnifies the round-off of a balance, a level that is not
balanced so is tried again, with other rows freed, :func:`balanced`. All of this follows from x and the numbers alone.
"""

from __future__ import annotations

import math

from . import layout as at
from .closing import TOLD, variable_of
from .compile import inner, integer
from .definite import cholesky
from .escape import nonnegative
from .forces import as_they_are, gradient
from .members import list_part, prepare
from .memory import ints, marks, matrix, vector
from .multipliers import tell
from .orthogonal import padded, pivots
from .rows import EQUALITY, INACTIVE, LOWER, UPPER
from .shift import STATIONARITY, round_off
from .span import CLEAR, FREE_RANK, SOLVED_RANK, enter, take_up
from .states import find_sides, rely_on
from .working_set import FROZEN, FUTURE, HARD, WORKING, append, balance

#: Round-off of a sum of forces, relative to the forces: where non-negative least squares end.
SETTLED = 1e-13
#: A row at a bound holds a level if its multiplier is more than this share of the forces. If it is less, but the level
#: would not be balanced without it, it holds by a thread.
HOLDS = 1e-8
#: Which rows that hold a level above are taken for free: none, those that hold it clearly, or those by a thread, too.
NONE, CLEARLY, ALL = 0, 1, 2
#: How a level was balanced: with slacks within their tolerances as zero, or as they are.
MET_ARE_ZERO, AS_THEY_ARE = 1.0, 2.0


@inner
def proves(here):
    """Whether x is optimal at all levels, the implicit last one included. Overwrites the basis V, CUT and W.

    FAILS is the first level that fails, or PASSES. If ALL is set, every level is judged, and what is found of it is
    told in VERDICT and HELD_BY; else the first failure is the end.
    """
    head = ints(here, 0, at.HEAD)
    levels, every, told = head[at.LEVELS], head[at.ALL] != 0, matrix(here, at.VERDICT)
    side, saved = marks(here, at.SIDE), marks(here, at.FOLLOW)
    for i in range(head[at.ROWS]):
        saved[i] = side[i]
    size, way = find_sides(here)
    if not size < math.inf:
        head[at.FAILS] = 0
        return False
    rely_on(here, saved)
    forget_parts(here)
    base, taken, head[at.FAILS] = integer(0), integer(0), at.PASSES
    for k in range(levels + 1):
        marks(here, at.CUT)[k] = -1
        if head[at.FAILS] != at.PASSES and not every:
            continue
        scale, exact = gradient(here, k, way), True
        told[k][at.ACCEPTED] = MET_ARE_ZERO
        if scale != 0.0 and not (k == levels and determined(here, taken, base)):
            base, taken = widen(here, taken, k, base, CLEARLY, FREE_RANK), integer(k)
            exact, base = balanced(here, k, base, scale)
            if not exact and as_they_are(here, k, scale):
                exact, base = balanced(here, k, base, scale)
                told[k][at.ACCEPTED] = AS_THEY_ARE
        if not exact:
            told[k][at.ACCEPTED] = 0.0
        if head[at.FAILS] == at.PASSES and not exact:
            head[at.FAILS] = k
    if every:
        tell_all(here, way)
    for i in range(head[at.ROWS]):
        side[i] = saved[i]
    return head[at.FAILS] == at.PASSES


@inner
def tell_all(here, way):
    """Write to VERDICT and HELD_BY how all levels are balanced, if possible without freeing rows that hold others.

    Then all multipliers have the signs of their rows. `way` is as in :func:`gradient`.
    """
    base, taken = integer(0), integer(0)
    forget_parts(here)
    for k in range(ints(here, 0, at.HEAD)[at.LEVELS] + 1):
        scale, left, free, working = gradient(here, k, way), 0.0, integer(0), integer(0)
        if matrix(here, at.VERDICT)[k][at.ACCEPTED] == AS_THEY_ARE:
            as_they_are(here, k, scale)
        if scale != 0.0:
            base, taken = widen(here, taken, k, base, NONE, FREE_RANK), integer(k)
            free = base
            working, left = attempt(here, k, base, NONE)
            if left > STATIONARITY and matrix(here, at.VERDICT)[k][at.ACCEPTED] != 0.0:
                free = append_holding(here, 0, k, base)
                working, left = attempt(here, k, free, CLEARLY)
                forget_parts(here)
        tell(here, k, free, working, scale, left)


@inner
def widen(here, taken, k, base, held, tau):
    """Append the free rows of levels `taken` .. k - 1 to V[:base], each with the rows that hold it; `held` tells which.

    All rows of a level are pivoted together, as a solver freezes them: a row that those above hold depends on them, and
    what is left of it must not go before those of which more is left. Returns how many rows V then has.
    """
    ptr, side, holds, room = marks(here, at.PTR), marks(here, at.HELD), marks(here, at.DECIDED), len(matrix(here, at.R))
    for level in range(taken, k):
        count = integer(0)
        for i in range(ptr[level + 1]):
            free = side[i] == EQUALITY and i >= ptr[level]
            if (free or holds_one(holds[i], level, level + 1, held)) and count < room:
                take_up(here, i, count)
                count += 1
        base = enter(here, count, base, tau)
    return base


@inner
def determined(here, taken, base):
    """Whether V[:base] and those free rows from level `taken` on that tell single variables clearly span all of x.

    They balance any gradient, so that the implicit last level needs no basis.
    """
    head = ints(here, 0, at.HEAD)
    n, ptr, side, norm = head[at.N], marks(here, at.PTR), marks(here, at.HELD), vector(here, at.NORM)
    told, others, V, F = marks(here, at.FREE), marks(here, at.QUEUE), matrix(here, at.V), matrix(here, at.FACTOR)
    for j in range(n):
        told[j] = 0
    for i in range(ptr[taken], ptr[head[at.LEVELS]]):
        j = variable_of(i, here) if side[i] == EQUALITY and norm[i] > 0.0 else integer(-1)
        if j >= 0:
            told[j] = 1
    u = integer(0)
    for j in range(n):
        if told[j] == 0:
            if u == base or u == len(F):
                return False
            others[u], u = j, u + 1
    for a in range(u):
        for b in range(a + 1):
            total = 0.0
            for q in range(base):
                total += V[q][others[a]] * V[q][others[b]]
            F[a][b] = total
    clear = cholesky(F, F, u)
    for a in range(u):
        clear = clear and F[a][a] * F[a][a] > TOLD
    return clear


@inner
def append_holding(here, first, k, base):
    """Append the rows that hold one of the levels first .. k - 1, and none before, to V[:base]; how many V then has."""
    holds, room, count = marks(here, at.DECIDED), len(matrix(here, at.R)), integer(0)
    for i in range(marks(here, at.PTR)[k]):
        if holds_one(holds[i], first, k, CLEARLY) and count < room:
            take_up(here, i, count)
            count += 1
    return enter(here, count, base, FREE_RANK)


@inner
def forget_parts(here):
    """Forget the projections P of all rows: V is another."""
    depth = marks(here, at.DEPTH)
    for i in range(len(depth)):
        depth[i] = -1


@inner
def balanced(here, k, base, scale):
    """Whether the rows above level k balance its gradient ``g``, up to round-off.

    V[:base] spans the normals of the free rows, and of those that clearly hold a level above: the others have least to
    do. If round-off or ranks forbid it, also of those that hold one by a thread, or of none; and all three again with
    ranks as a solver decides them. `scale` is the sum of the forces of the level.

    Returns
    -------
    exact : bool
    base : int
        As given, but V may be another.
    """
    exact, working = settles(here, k, base, CLEARLY, scale)
    if exact:
        note_holding(here, k, base, working)
        return True, base
    for again in range(1, 6):  # ALL, NONE, then CLEARLY, ALL, NONE
        held, tau = (again + 1) % 3, FREE_RANK if again < 3 else SOLVED_RANK
        other = widen(here, integer(0), k, integer(0), held, tau)
        exact, working = settles(here, k, other, held, scale)
        if exact:
            note_holding(here, k, other, working)
            break
    return exact, widen(here, integer(0), k, integer(0), CLEARLY, FREE_RANK)


@inner
def settles(here, k, base, held, scale):
    """Whether :func:`attempt` leaves but round-off of ``g``, and how many rows have a multiplier."""
    working, left = attempt(here, k, base, held)
    exact = left <= STATIONARITY
    if not exact:
        exact = round_off(here, k, base, working, left, scale)
        forget_parts(here)
    return exact, working


@inner
def attempt(here, k, base, held):
    """Balance ``g`` by the signed rows above level k, in the null space of V[:base]; those that are `held` are free.

    Returns how many rows have a multiplier ``share``, and the length of what is left of g, minus ``d``.
    """
    hold(here, k, held)
    working, left, _ = nonnegative(here, SETTLED, FREE_RANK, base, begin(here, k, base), marks(here, at.PTR)[k])
    return working, left


@inner
def hold(here, k, held):
    """Prepare the rows above level k for :func:`.escape.nonnegative`: signed ones are hard, free ones frozen."""
    kind, where, holds = marks(here, at.KIND), marks(here, at.HELD), marks(here, at.DECIDED)
    value, allowed = vector(here, at.VALUE), vector(here, at.ALLOWED)
    low, high = vector(here, at.LOW), vector(here, at.HIGH)
    for i in range(marks(here, at.PTR)[k]):
        kind[i] = FUTURE
        if where[i] == EQUALITY or holds_one(holds[i], integer(0), k, held):
            kind[i] = FROZEN
        elif where[i] != INACTIVE:
            kind[i], value[i], allowed[i] = HARD, 0.0, 0.0
            high[i] = 0.0 if where[i] == UPPER else math.inf
            low[i] = 0.0 if where[i] == LOWER else -math.inf


@inner
def note_holding(here, k, base, working):
    """Mark the rows of V behind V[:base] that hold level k, clearly with k + 1, and by a thread with -(k + 2)."""
    pivot, holds = marks(here, at.PIVOT), marks(here, at.DECIDED)
    share, norm, L = vector(here, at.SHARE), vector(here, at.NORM), matrix(here, at.L)
    for q in range(base, base + working):
        i = pivot[q]
        if share[q] * norm[i] > HOLDS and holds[i] <= 0:
            holds[i] = k + 1
        elif share[q] * L[i][q] > STATIONARITY and -1 <= holds[i] <= 0:
            holds[i] = -(k + 2)


@inner
def holds_one(mark, first, end, held):
    """Whether a row with this mark of :func:`note_holding` is `held` by one of the levels first .. end - 1."""
    level = mark - 1 if mark > 0 else -mark - 2
    return first <= level < end and (held == ALL or (held == CLEARLY and mark > 0))


@inner
def begin(here, k, base):
    """Start the working set with hard rows above level k whose least-squares multipliers, ``share``, are all positive.

    `base` is the number of rows of V that span the free normals. Returns how many rows the working set has.
    """
    side, where = marks(here, at.SIDE), marks(here, at.HELD)
    kind, pivot = marks(here, at.KIND), marks(here, at.PIVOT)
    share, multiplier = vector(here, at.SHARE), vector(here, at.MULTIPLIER)
    working = press(here, k, base)
    for q in range(base, base + working):
        kind[pivot[q]], side[pivot[q]] = WORKING, where[pivot[q]]
    while working > 0:
        balance(vector(here, at.G), base, base + working, here)
        wrong, count = integer(0), working
        working = integer(0)
        for q in range(base, base + count):
            i = pivot[q]
            share[base + working] = multiplier[q] * side[i]
            if share[base + working] <= 0.0:
                kind[i] = HARD
                wrong += 1
            elif wrong == 0 or append(i, base + working, here, FREE_RANK):
                working += 1
            else:
                kind[i] = HARD
        if wrong == 0:
            break
    return working


@inner
def press(here, k, base):
    """Append hard rows above level k to V[:base] while they are clearly independent; returns how many there are.

    Only those that are there up to round-off, and active for a solver that tells its sides, or that hold a level.
    """
    n, kind, pivot = ints(here, 0, at.HEAD)[at.N], marks(here, at.KIND), marks(here, at.PIVOT)
    holds = marks(here, at.DECIDED)
    ids, slots, lengths = marks(here, at.IDS), marks(here, at.SLOTS), vector(here, at.LENGTHS)
    norm, V, L, R = vector(here, at.NORM), matrix(here, at.V), matrix(here, at.L), matrix(here, at.R)
    count = integer(0)
    if base == n:
        return count
    for i in range(marks(here, at.PTR)[k]):
        if kind[i] == HARD and holds[i] != 0 and count < len(R):
            prepare(i, base, here)
            list_part(i, count, count, here)
            count += 1
    working = pivots(ids, count, slots, lengths, R, norm, V, L, base, padded(n), CLEAR)
    for q in range(working):
        pivot[base + q] = ids[q]
    return working
