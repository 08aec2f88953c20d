"""The whole solver: one sweep where the active rows are known, level by level where they are not, and what is behind.

From one tick of a control loop to the next the active rows hardly change, so that one sweep with the last ones is the
answer, with its proof (:mod:`.sweep`); rows that contradict it change sides at once, as long as that makes progress.
Where it does not, or there is no last tick, the levels are solved one after the other (:mod:`.levels`), which is a
proof of its own. A few unknowns are guessed all at once first (:mod:`.guess`). If all that fails, the safe method
decides (:mod:`.active_set`), from the last point that is known to be exact.
"""

from __future__ import annotations

import math

from . import layout as at
from .active_set import OPTIMAL, STALLED, SUBOPTIMAL, active_set
from .compile import entry, inner, integer, stamp, step
from .doubt import SHARPEST
from .dual import NEVER, late
from .guess import guess
from .levels import levels
from .line_search import best_step
from .memory import clock, floats, given, ints, marks, matrix, vector
from .orthogonal import length
from .rows import EQUALITY, INACTIVE, LOWER, UPPER, value_of
from .sweep import sweep
from .working_set import FROZEN

#: Outcomes beside the statuses of the safe method: nothing solved, for a number may mean nothing; and found as far as
#: one tolerance goes, for rows of very different lengths, or as one rank has it that could be another. What is STALLED
#: or UNEVEN the certificate has to judge.
SUSPECT, UNEVEN = 3, 4

#: Where a solve starts: from the sides that are known, by one sweep; level by level, from those at the end of each
#: level or from none; by the safe method, from the last exact point.
SIDES, WARM, COLD, SAFE = 0, 1, 2, 3

#: As :data:`hqp.hierarchy.LARGEST`: a row that is longer has an entry to be looked at.
LARGEST = 1e30

#: Round-off of x, in units of the length of x_0, where it comes from.
ROUND_OFF = 64 * 2.0**-52
#: A row that is this much shorter than another of its level may disappear in the round-off of that one.
EVEN = 1e-8

#: How many rounds of repair in a row may fail to bring the number of contradictions down.
PATIENCE = 1
#: So many contradictions are repaired even where levels above others are not met.
FEW = 2
#: Where a row that counts as dependent shows that it is not, less of it has to be left, down to round-off.
SHARPER = 0.1


@inner
def load(here, warm, trusted):
    """Weight the rows, measure them, and make the guess fit them; False if a number may mean nothing."""
    head = ints(here, 0, at.HEAD)
    n, m = head[at.N], head[at.ROWS]
    col, side, row_of = marks(here, at.COL), marks(here, at.SIDE), marks(here, at.ROW_OF)
    lower, upper, lo, hi = vector(here, at.LOWER), vector(here, at.UPPER), vector(here, at.LO), vector(here, at.HI)
    norm, weights = vector(here, at.NORM), vector(here, at.WEIGHTS)
    A, B = matrix(here, at.A), matrix(here, at.B)
    for i in range(m):
        weight = weights[i]
        size = 1.0
        if col[i] < 0:
            given, row = A[row_of[i]], B[row_of[i]]
            total = 0.0
            for j in range(n):
                row[j] = weight * given[j]
                total += given[j] * given[j]
            size = math.sqrt(total)
        below, above = lower[i], upper[i]
        fits = abs(below) <= LARGEST or below == -math.inf
        fits = fits and (abs(above) <= LARGEST or above == math.inf)
        fits = fits and below <= above and 1.0 / LARGEST <= weight <= LARGEST
        if not (fits and (trusted or size <= LARGEST)):
            return False
        norm[i] = weight * size if size >= 1.0 / LARGEST else 0.0
        lo[i], hi[i] = weight * below, weight * above
        if norm[i] == 0.0:
            side[i] = INACTIVE
        elif below == above:
            side[i] = EQUALITY
        elif (
            not warm
            or side[i] == EQUALITY
            or (side[i] == LOWER and below == -math.inf)
            or (side[i] == UPPER and above == math.inf)
        ):
            side[i] = INACTIVE
    return True


@inner
def levels_that_count(here):
    """A level of equalities on every variable, all of one weight, is a last level: nothing below can move x.

    It is what ``min ||x - x0||`` says, with its own x0.
    """
    head = ints(here, 0, at.HEAD)
    n, levels = head[at.N], head[at.LEVELS]
    whole, ptr, col = marks(here, at.WHOLE), marks(here, at.PTR), marks(here, at.COL)
    x0, x_ref, lower = vector(here, at.X0), vector(here, at.X_REF), vector(here, at.LOWER)
    upper, norm = vector(here, at.UPPER), vector(here, at.NORM)
    for j in range(n):
        x0[j] = x_ref[j]
    for k in range(levels):
        if whole[k] == 0:
            continue
        first, end = ptr[k], ptr[k + 1]
        alike = True
        for i in range(first, end):
            alike = alike and lower[i] == upper[i] and norm[i] == norm[first]
        if alike:
            for i in range(first, end):
                x0[col[i]] = lower[i]
            return k
    return levels


@inner
def is_even(here):
    """Whether the rows of each level are of comparable length, weights included."""
    head, ptr, norm = ints(here, 0, at.HEAD), marks(here, at.PTR), vector(here, at.NORM)
    for k in range(head[at.LEVELS]):
        shortest, longest = math.inf, 0.0
        for i in range(ptr[k], ptr[k + 1]):
            if norm[i] > 0.0:
                shortest, longest = min(shortest, norm[i]), max(longest, norm[i])
        if shortest < EVEN * longest:
            return False
    return True


@inner
def repair(here, last):
    """Let all rows that contradict the guess change sides."""
    ptr, side, follow = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.FOLLOW)
    for i in range(ptr[last]):
        side[i] = follow[i]


@inner
def first_contradiction(here, last):
    """The highest level with a row that contradicts its side."""
    ptr, side, follow = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.FOLLOW)
    for k in range(last):
        for i in range(ptr[k], ptr[k + 1]):
            if side[i] != follow[i]:
                return k
    return last


@inner
def contested(here, last):
    """Whether a level above the last one that counts is not met."""
    forces_of = vector(here, at.FORCES)
    met = True
    for k in range(last - 1):
        met = met and forces_of[k] == 0.0
    return not met


@inner
def verify(here, last):
    """Sweep, and let contradictions change sides as long as that makes progress: the number of those that are left."""
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    fewest, left, tau = head[at.ROWS] + 1, PATIENCE, option[at.TAU]
    while True:
        faults, blurred = sweep(here, last, tau)
        head[at.SWEEPS] += 1
        if faults == 0 and blurred and tau > SHARPEST:
            tau *= SHARPER
            continue
        left = PATIENCE if faults < fewest else left - 1
        fewest = min(fewest, faults)
        if faults == 0 or left <= 0 or late(here) or (faults > FEW and contested(here, last)):
            return faults
        repair(here, last)


@inner
def stop_early(here, k, last):
    """At the limit: the point that is exact above level k, and one step from it that makes k better, and nothing worse.

    The step ends at the first row of the levels above that is in the way, or where the level is best.
    """
    n, ptr = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR)
    kind, norm = marks(here, at.KIND), vector(here, at.NORM)
    lo, hi, v, slope = vector(here, at.LO), vector(here, at.HI), vector(here, at.LOW), vector(here, at.SLOPE)
    x, exact, x0, d = vector(here, at.X), vector(here, at.EXACT), vector(here, at.X0), vector(here, at.D)
    for j in range(n):
        d[j] = x[j] - exact[j]
    limit = 1.0
    for i in range(ptr[min(k + 1, last)]):
        v[i], slope[i] = value_of(i, exact, here), value_of(i, d, here)
        if i < ptr[k] and norm[i] > 0.0 and kind[i] != FROZEN and slope[i] != 0.0:
            limit = min(limit, max(0.0, ((hi[i] if slope[i] > 0.0 else lo[i]) - v[i]) / slope[i]))
    if k < last:
        reach = best_step(ptr[k], ptr[k + 1], v, slope, lo, hi)
    else:
        gain, steep = 0.0, 0.0
        for j in range(n):
            gain += d[j] * (x0[j] - exact[j])
            steep += d[j] * d[j]
        reach = max(0.0, gain / steep) if steep > 0.0 else 0.0
    reach = min(reach, limit)
    for j in range(n):
        x[j] = exact[j] + reach * d[j]


@inner
def seed(here, last):
    """Nothing is known of the end of each level: the sides of the last answer are taken for it."""
    m, ptr = ints(here, 0, at.HEAD)[at.ROWS], marks(here, at.PTR)
    side, saved = marks(here, at.SIDE), marks(here, at.SAVED)
    for k in range(last + 1):
        for i in range(ptr[min(k + 1, last)]):
            saved[k * m + i] = side[i]


@inner
def start_clock(here):
    """The time limit counts from when the call began, if that is known."""
    head, limit = ints(here, 0, at.HEAD), vector(here, at.OPTION)[at.LIMIT]
    head[at.DEADLINE] = NEVER
    if limit < math.inf:
        head[at.DEADLINE] = (head[at.BEGAN] if head[at.BEGAN] != 0 else clock()) + int(1e9 * limit)
    head[at.BEGAN] = 0


@inner
def note_blur(here):
    """What round-off in x0 adds to the length of x where a tolerance is relative to it."""
    option = vector(here, at.OPTION)
    option[at.BLUR] = ROUND_OFF / option[at.TOL] * length(vector(here, at.X0), ints(here, 0, at.HEAD)[at.N])


@inner
def work_out(here, last, start, warm):
    """Solve for levels 0 .. last from this start on: a status of :mod:`.active_set`, and the level of it."""
    head = ints(here, 0, at.HEAD)
    n, x, exact, safe_x = head[at.N], vector(here, at.X), vector(here, at.EXACT), vector(here, at.SAFE)
    status, faults, level, exact_above = OPTIMAL, integer(1), integer(last), integer(0)
    while True:
        level = integer(last + 1)
        if start == SAFE:
            for j in range(n):
                x[j] = exact[j]
            status, level = active_set(here, last)
            for j in range(n):
                safe_x[j] = x[j]
            faults = integer(1)
        elif start != SIDES:
            level = exact_above = levels(here, last, start == WARM)
            faults = integer(level <= last + 1)
            head[at.SWEEPS] += level == last + 2
        if faults > 0 and level == last + 1:
            faults = verify(here, last)
        if start != SIDES:
            head[at.HISTORY] = faults == 0
        if faults == 0 or start == SAFE or (start != SIDES and late(here)):
            break
        start = integer(COLD) if start == SIDES and not warm else start + 1
    if faults > 0 and start == SAFE:  # where round-off decides what the sweep says, it has the last word
        for j in range(n):
            x[j] = safe_x[j]
        if status == OPTIMAL:  # and no proof
            status, level = STALLED, first_contradiction(here, last)
    elif faults > 0:
        stop_early(here, exact_above, last)
        status, level = SUBOPTIMAL, exact_above
    return status, level


@step
def solve_one(here):
    """Solve the hierarchy of the directory; see :func:`solve`."""
    head = ints(here, 0, at.HEAD)
    warm = head[at.WARM] != 0
    head[at.WARM] = head[at.SWEEPS] = head[at.ITERATIONS] = 0
    start_clock(here)
    if not load(here, warm, head[at.TRUSTED] != 0):
        return SUSPECT
    last = levels_that_count(here)
    note_blur(here)
    if warm and head[at.HISTORY] == 0:
        seed(here, last)
    start = integer(SIDES if warm or guess(here, last) else COLD)
    status, level = work_out(here, last, start, warm)
    head[at.LEVEL], head[at.WARM] = min(level, last), 1
    if status == OPTIMAL and (head[at.DOUBT] != 0 or not is_even(here)):
        return UNEVEN
    return status


@stamp
@entry
def solve(here, numbers):
    """Solve the hierarchy at the address `numbers`, in the memory of this directory.

    Or many hierarchies of one structure, one after the other, each warm from its own sides of the last time.

    Returns
    -------
    outcome : int
        A status of :mod:`.active_set`, or SUSPECT, UNEVEN; of many, that of the last.
    """
    head = ints(here, 0, at.HEAD)
    n, m, count, warm = head[at.N], head[at.ROWS], head[at.COUNT], head[at.WARM]
    side = marks(here, at.SIDE)
    x, x_ref = vector(here, at.X), vector(here, at.X_REF)
    for b in range(max(count, 1)):
        given(here, numbers + 8 * b * head[at.STRIDE])
        point, sides = floats(head[at.POINTS], b * n, n), ints(head[at.SIDES], b * m, m)
        if count > 0:
            for i in range(m):
                side[i] = sides[i]
            head[at.HISTORY] = 0  # of a neighbour
            head[at.WARM] = warm
            if head[at.REFERENCES] != 0:
                reference = floats(head[at.REFERENCES], b * n, n)
                for j in range(n):
                    x_ref[j] = reference[j]
        head[at.OUTCOME] = solve_one(here)
        if count > 0:
            for j in range(n):
                point[j] = x[j]
            for i in range(m):
                sides[i] = side[i]
            said = ints(head[at.OUTCOMES], 4 * b, 4)
            said[0], said[1], said[2], said[3] = (
                head[at.OUTCOME],
                head[at.LEVEL],
                head[at.SWEEPS],
                head[at.ITERATIONS],
            )
    return head[at.OUTCOME]
