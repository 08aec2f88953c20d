r"""Damped levels, solved stage by stage (:mod:`hqp.damping.staged`); if all active sets are known, with a single basis.

A stage is a plain hierarchy: the levels down to a damped one, which gets one more bound on every variable, the *rows of
damping* :math:`\lambda (x - r_k) = 0`; the aim :math:`r_k` of the level is :math:`x_\text{ref}` unless given. In the
sweep they cost next to nothing: as :math:`x_0 = r_k` and V is orthonormal, they are :math:`\lambda y = 0` for the
directions that the level itself adds to V. So its least squares gets one more row for each of these directions:

.. math:: \min_y \|L_k y - r\|^2 + \lambda^2 \|y\|^2 .

In the next stage the rows of the level keep their values, with the same directions and the same y. If the guess of that
stage agrees on all rows down to this level, the sweep therefore continues below it, on top of the same basis; if that
stage starts at another :math:`x_0`, y is shifted by :math:`V` times the difference.
Every stage is verified like any hierarchy, with the force of the damping in the balance of its level. If that is in
doubt (:mod:`.doubt`), the rows of damping become ordinary rows, and the compiled certificate judges; if it fails, the
stage is solved so (:mod:`.attempts`) and verified like any hierarchy.
"""

from __future__ import annotations

import math

from . import layout as at
from .active_set import OPTIMAL
from .attempts import FEW, PATIENCE, SHARPER, contested, repair
from .compile import entry, inner, integer, stamp
from .damped_twin import stage_proves, with_rows
from .damping_rules import DEPENDENT, ERROR, FIXED, by_singular_values, lacking, satisfied, tolerance, unequal
from .doubt import SHARPEST, all_even, is_even
from .dual import late
from .memory import given, ints, marks, matrix, vector
from .orthogonal import level_least_squares
from .rows import EQUALITY, INACTIVE, LOWER, UPPER
from .solver import SUSPECT, UNEVEN, levels_that_count, load, note_blur, start_clock
from .states import measure_rows, room_of
from .sums import product
from .sweep import arrive, enter_level, fix_variables, note_level, solve_levels
from .verdict import STRICT, judge_multipliers, judge_rows

#: Value of `count`: the rows of the level were not entered yet.
UNKNOWN = -1
#: As :data:`hqp.hierarchy.LARGEST`.
LARGEST = 1e30


@inner
def solve_damped_level(here, k, c, f, damping, count, rank):
    """Solve level k of the guess with its damping on top of V[:c]; `count`, `rank` are of its rows, if entered already.

    Returns how many rows V gains, and the smallest share of its length that projection left of a row when it became
    one of them.
    """
    m = ints(here, 0, at.HEAD)[at.ROWS]
    ids, y, w, rhs = marks(here, at.IDS), vector(here, at.Y), vector(here, at.W), vector(here, at.RHS)
    norm, L, H = vector(here, at.NORM), matrix(here, at.L), matrix(here, at.H)
    if count == UNKNOWN:
        count, rank = enter_level(here, k, c, f, DEPENDENT)
    weakest = 1.0
    for r in range(rank):
        weakest = min(weakest, L[ids[r]][c + r] / norm[ids[r]])
    for j in range(rank):
        row = L[m + j]
        for q in range(rank):
            row[c + q] = 0.0
        row[c + j] = damping
        ids[count + j], rhs[count + j] = m + j, 0.0
    level_least_squares(ids, count + rank, rank, L, c, rhs, y, w, H)
    note_level(here, c, count, rank)
    return rank, weakest


@inner
def sweep_stage(here, last, level, damping, through, c, count, rank, tau):
    """Solve and judge the guess for levels 0 .. last; those above level `through` are in the basis V[:c] already.

    `level` is the damped one, or STRICT; `count` and `rank` are of its rows if these are entered already.

    Returns
    -------
    faults, blurred
        As of :func:`.sweep.sweep`.
    through, c : int
        The part of the basis that the next stage can use: V[:c], of the levels above `through`.
    """
    f = fix_variables(here)
    if level == STRICT:
        c = solve_levels(here, through, last, c, f, tau)
        arrive(here, last, c, f)
        through = last
    else:
        c = solve_levels(here, through, level, c, f, tau)
        rank, weakest = solve_damped_level(here, level, c, f, damping, count, rank)
        arrive(here, last, c + rank, f)
        through = level
        if weakest > tau:
            through, c = level + 1, c + rank
    faults, undecided, blurred = judge_rows(here, last, level, damping)
    if undecided > 0:
        faults += judge_multipliers(here, last, undecided, level, damping, False)[0]
    if tau < vector(here, at.OPTION)[at.TAU]:
        through, c = integer(0), integer(0)
    return faults, blurred, through, c


@inner
def expect(here, slot, last, warm, through):
    """Set ``side`` to the guess for this stage; False if the basis has other active rows above level `through`."""
    m, ptr = ints(here, 0, at.HEAD)[at.ROWS], marks(here, at.PTR)
    side, known = marks(here, at.SIDE), marks(here, at.STAGES)[slot * m :]
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    others, end = integer(0), ptr[through]
    for i in range(ptr[last]):
        was = known[i] if warm else side[i]
        open_ended = (was == LOWER and lo[i] == -math.inf) or (was == UPPER and hi[i] == math.inf)
        if norm[i] == 0.0 or was == EQUALITY or open_ended:
            was = INACTIVE
        if lo[i] == hi[i] and norm[i] > 0.0:
            was = EQUALITY
        others += i < end and was != side[i] and (was != EQUALITY or side[i] == INACTIVE)
        side[i] = was
    return others == 0


@inner
def run_stage(here, slot, last, level, damping, warm, through, c, count, rank):
    """Solve one stage, and keep its ``side`` at place `slot` of STAGES for the next solve; see :func:`sweep_stage`.

    Returns
    -------
    status : int
    through, c : int
    """
    head, tau = ints(here, 0, at.HEAD), vector(here, at.OPTION)[at.TAU]
    m, ptr, side = head[at.ROWS], marks(here, at.PTR), marks(here, at.SIDE)
    known = marks(here, at.STAGES)[slot * m :]
    begin = integer(1 if head[at.BOXED] != 0 else 0)
    known_levels = through if count == UNKNOWN else through + 1
    if not expect(here, slot, last, warm, known_levels) or through < begin:
        through, c, count = begin, integer(0), integer(UNKNOWN)
    fewest, left, status = m + 1, PATIENCE, integer(OPTIMAL)
    while True:
        faults, blurred, reached, rows = sweep_stage(here, last, level, damping, through, c, count, rank, tau)
        head[at.SWEEPS] += 1
        if faults == 0 and blurred and tau > SHARPEST:
            tau, through, c, count = tau * SHARPER, begin, integer(0), integer(UNKNOWN)
            continue
        left = PATIENCE if faults < fewest else left - 1
        fewest = min(fewest, faults)
        if faults == 0 or left <= 0 or late(here) or (faults > FEW and contested(here, last)):
            break
        repair(here, last)
        through, c, count = begin, integer(0), integer(UNKNOWN)
    through, c = reached, rows
    if tau < vector(here, at.OPTION)[at.TAU]:  # smaller than the one set
        head[at.DOUBT] = 1
    if faults == 0 and head[at.DOUBT] != 0 and not stage_proves(here, last, level, damping):
        status = integer(UNEVEN)
    if faults > 0:
        status = with_rows(here, last, level, damping, warm)
        through, c = begin, integer(0)
    for i in range(ptr[last]):
        known[i] = side[i]
    return status, through, c


@inner
def freeze_level(here, level):
    """Freeze equalities and violated rows of a damped level: both bounds become their value at x, :func:`reached`.

    A row whose two bounds are both within the tolerance is an equality, as in :func:`hqp.certificate.row_states`.
    """
    ptr, w, weights = marks(here, at.PTR), vector(here, at.W), vector(here, at.WEIGHTS)
    lo, hi, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM)
    value, slack = vector(here, at.LOW), vector(here, at.HIGH)
    size, way = measure_rows(here, level + 1, vector(here, at.X0), value, slack)
    for i in range(ptr[level], ptr[level + 1]):
        if norm[i] == 0.0:
            continue
        near = room_of(value[i], slack[i], norm[i], tolerance(here), size, way)
        over, under = value[i] - hi[i], lo[i] - value[i]
        if lo[i] == hi[i] or max(over, under) > near or min(over, under) >= -near:
            lo[i] = hi[i] = weights[i] * reached(here, i)
            w[i] = 0.0


@inner
def reached(here, i):
    """The value of row i, unweighted, at x: exact but for one rounding, as :func:`hqp.arrays.products` has it.

    The next stage may end at an x that is shorter by orders of magnitude. There, the round-off of this one would be a
    slack to ask for, and solver and certificate, whose sums differ by round-off, would ask for different ones.
    """
    x, j = vector(here, at.X), marks(here, at.COL)[i]
    if j >= 0:
        return x[j]
    return product(matrix(here, at.A)[marks(here, at.ROW_OF)[i]], x, ints(here, 0, at.HEAD)[at.N])


@inner
def solve_stages(here):
    """Solve all stages, one after the other; returns a status of :mod:`.active_set`, SUSPECT or UNEVEN."""
    head = ints(here, 0, at.HEAD)
    n, levels, damped, warm = head[at.N], head[at.LEVELS], head[at.DAMPED], head[at.WARM] != 0
    head[at.WARM] = head[at.SWEEPS] = head[at.ITERATIONS] = 0
    start_clock(here)
    if not load(here, False, head[at.TRUSTED] != 0):
        return SUSPECT
    head[at.DOUBT] = not all_even(here)
    ptr, which = marks(here, at.PTR), marks(here, at.WHICH)
    x, x_ref, x0 = vector(here, at.X), vector(here, at.X_REF), vector(here, at.X0)
    tau, rules, passed = vector(here, at.OPTION)[at.TAU], matrix(here, at.RULES), matrix(here, at.PASSED)
    aimed, aims, moved = head[at.AIMED] != 0, matrix(here, at.AIMS), False
    if aimed and not bounded(aims, damped, n):
        return SUSPECT
    for j in range(n):
        x[j] = x0[j] = x_ref[j]
    note_blur(here)
    decided, through, c, status, none = integer(0), integer(0), integer(0), OPTIMAL, integer(UNKNOWN)
    for d in range(damped):
        k, kind, note = which[d], rules[d][0], passed[d]
        note[1] = 0.0
        if aimed:
            moved = start_at(here, aims[d], c)
        if (decided != k or moved) and (kind == ERROR or (kind != FIXED and unequal(here, ptr[k + 1]))):
            if satisfied(here, ptr[k], x0):
                for j in range(n):
                    x[j] = x0[j]
            else:
                status, through, c = run_stage(here, 2 * d, k, STRICT, 0.0, warm, through, c, none, none)
                if status != OPTIMAL:
                    return status
                note[1] = 1.0
                for j in range(n):
                    note[2 + j] = x[j]
        damping, count, rank = rules[d][1], none, none
        if kind == ERROR:
            away, shortest = lacking(here, k)
            damping = min(math.hypot(rules[d][2], 0.5 / rules[d][1] * away), LARGEST)
            if damping < 0.1 * tau * shortest:
                damping = 0.0
        elif kind != FIXED:
            damping, through, c, count, rank = by_singular_values(here, d, k, through, c)
        note[0] = damping
        if damping < 1.0 / LARGEST:
            continue
        if not is_even(here, k, damping):
            head[at.DOUBT] = 1
        status, through, c = run_stage(here, 2 * d + 1, k + 1, k, damping, warm, through, c, count, rank)
        if status != OPTIMAL:
            return status
        for j in range(n):
            note[2 + n + j] = x[j]
        freeze_level(here, k)
        decided = k + 1
    if decided < levels or decided == 0:
        if aimed:
            start_at(here, x_ref, c)
        last = levels_that_count(here)
        if last < levels:
            shift(here, c, x_ref, x0)
            note_blur(here)
        status, through, c = run_stage(here, 2 * damped, last, STRICT, 0.0, warm, through, c, none, none)
    head[at.WARM] = 1
    return status


@inner
def bounded(numbers, rows, n):
    """Whether all entries of `numbers`, shape (rows, n), are finite and of a size up to LARGEST."""
    good = True
    for d in range(rows):
        for j in range(n):
            good = good and abs(numbers[d][j]) <= LARGEST
    return good


@inner
def start_at(here, reference, c):
    """Let x start at this reference, ``x0``, and shift y[:c] accordingly; whether the reference has changed."""
    n, x0, same = ints(here, 0, at.HEAD)[at.N], vector(here, at.X0), True
    for j in range(n):
        same = same and x0[j] == reference[j]
    if not same:
        shift(here, c, x0, reference)
        for j in range(n):
            x0[j] = reference[j]
        note_blur(here)
    return not same


@inner
def shift(here, c, old, new):
    """Add V (old - new) to y[:c]: so x = x_0 + V' y keeps its part along V[:c] when x_0 changes from `old` to `new`."""
    n = ints(here, 0, at.HEAD)[at.N]
    pinned, free = marks(here, at.PINNED), marks(here, at.FREE)
    y, V = vector(here, at.Y), matrix(here, at.V)
    f = integer(0)
    for j in range(n):
        if pinned[j] < 0:
            free[f] = j
            f += 1
    for q in range(c):
        direction, along = V[q], 0.0
        for t in range(f):
            along += direction[t] * (old[free[t]] - new[free[t]])
        y[q] += along


@stamp
@entry
def solve_damped(here, numbers):
    """Solve the hierarchy at the address `numbers`, with the damped levels of the directory; returns the outcome."""
    head = ints(here, 0, at.HEAD)
    given(here, numbers)
    head[at.OUTCOME] = solve_stages(here)
    return head[at.OUTCOME]
