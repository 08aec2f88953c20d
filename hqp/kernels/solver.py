r"""The whole solver: guess, solve the equalities, verify, repair; and where repair fails, the safe method.

From one tick of a control loop to the next the active rows hardly change, so that the last ones are the guess and
one sweep is the answer, with its proof (:mod:`.sweep`). Where there is no last one, a weighted problem makes the guess
(:mod:`.guess`). All rows that contradict a guess change sides at once. Where that makes no progress, or where many do
although levels above others are out of reach, so that it would make none, a more careful guess is made, level by level.
If that fails, too, the safe method decides (:mod:`.active_set`), and one more sweep gives its answer the same proof.
"""

from __future__ import annotations

import math

from . import layout as at
from .active_set import NEVER, OPTIMAL, STALLED, active_set
from .compile import entry, inner, stamp
from .guess import guess
from .memory import clock, floats, given, ints, marks, matrix, vector
from .sweep import EQUALITY, INACTIVE, LOWER, UPPER, sweep

#: Outcomes beside the statuses of the safe method: nothing solved, for a number may mean nothing; proved at once;
#: proved as far as one tolerance goes for rows of very different lengths.
SUSPECT, CLEAR, UNEVEN = 3, 4, 5

#: As :data:`hqp.hierarchy.LARGEST`: a row that is longer has an entry to be looked at.
LARGEST = 1e30

#: A row that is this much shorter than another of its level may disappear in the round-off of that one.
EVEN = 1e-8

#: How many rounds of repair in a row may fail to bring the number of contradictions down.
PATIENCE = 2
#: So many contradictions are repaired even where levels above others are not met.
FEW = 2
#: Where a row that counts as dependent shows that it is not, less of it has to be left, down to round-off.
SHARPER, SHARPEST = 0.1, 2e-12


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
def start(here):
    """Where the safe method starts: at what the last level wants, within the bounds of level 0."""
    head = ints(here, 0, at.HEAD)
    n, boxed = head[at.N], head[at.BOXED] != 0
    ptr, col = marks(here, at.PTR), marks(here, at.COL)
    x, x0, lower, upper = vector(here, at.X), vector(here, at.X0), vector(here, at.LOWER), vector(here, at.UPPER)
    for j in range(n):
        x[j] = x0[j]
    if boxed:
        for i in range(ptr[0], ptr[1]):
            j = col[i]
            x[j] = min(max(x[j], lower[i]), upper[i])


@inner
def solve_one(here):
    """Solve the hierarchy of the directory; see :func:`solve`."""
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    n, m = head[at.N], head[at.ROWS]
    x, safe_x = vector(here, at.X), vector(here, at.SAFE)
    warm = head[at.WARM] != 0
    head[at.WARM] = 0
    if not load(here, warm, head[at.TRUSTED] != 0):
        return SUSPECT
    last = levels_that_count(here)
    deadline = NEVER if option[at.LIMIT] == math.inf else clock() + int(1e9 * option[at.LIMIT])

    status, level, iterations, sweeps = OPTIMAL, last, 0, 0
    wanted, guesses, safe = not warm, 1 if warm else 2, False
    fewest, patience, tau = m + 1, PATIENCE, option[at.TAU]
    while True:
        if wanted:
            guess(here, last, guesses == 1)
            wanted, guesses = False, guesses - 1
            fewest, patience = m + 1, PATIENCE
        faults, blurred = sweep(here, last, tau)
        sweeps += 1
        if faults == 0 and blurred and tau > SHARPEST:
            tau *= SHARPER
            continue
        if faults == 0:
            break
        patience = PATIENCE if faults < fewest else patience - 1
        fewest = min(fewest, faults)
        if safe and patience <= 0:
            break
        late = deadline != NEVER and clock() > deadline
        hopeless = patience <= 0 or (faults > FEW and contested(here, last))
        if guesses > 0 and hopeless and not (safe or late):
            wanted = True
        elif patience > 0 and (safe or not late):
            repair(here, last)
        else:
            safe = True
            start(here)
            status, level, iterations = active_set(here, last, int(option[at.BUDGET]), deadline)
            for j in range(n):
                safe_x[j] = x[j]
            if status != OPTIMAL:
                break
            fewest, patience = m + 1, PATIENCE
    if safe and faults > 0:  # round-off decides what the sweep says: the safe method has the last word
        for j in range(n):
            x[j] = safe_x[j]
        if status == OPTIMAL:  # and no proof
            status, level = STALLED, first_contradiction(here, last)
    head[at.LEVEL], head[at.SWEEPS], head[at.ITERATIONS], head[at.WARM] = (
        level,
        sweeps,
        iterations,
        1,
    )
    if status == OPTIMAL and not is_even(here):
        return UNEVEN
    return CLEAR if sweeps == 1 and not safe else status


@stamp
@entry
def solve(here, numbers):
    """Solve the hierarchy at the address `numbers`, in the memory of this directory.

    Or many hierarchies of one structure, one after the other, each warm from its own sides of the last time.

    Returns
    -------
    outcome : int
        A status of :mod:`.active_set`, or SUSPECT, CLEAR, UNEVEN; of many, that of the last.
    """
    head = ints(here, 0, at.HEAD)
    n, m, count, warm = head[at.N], head[at.ROWS], head[at.COUNT], head[at.WARM]
    if count == 0:
        given(here, numbers)
        head[at.OUTCOME] = solve_one(here)
        return head[at.OUTCOME]
    side = marks(here, at.SIDE)
    x, x_ref = vector(here, at.X), vector(here, at.X_REF)
    outcome = OPTIMAL
    for b in range(count):
        given(here, numbers + 8 * b * head[at.STRIDE])
        point, sides = floats(head[at.POINTS], b * n, n), ints(head[at.SIDES], b * m, m)
        for i in range(m):
            side[i] = sides[i]
        if head[at.REFERENCES] != 0:
            reference = floats(head[at.REFERENCES], b * n, n)
            for j in range(n):
                x_ref[j] = reference[j]
        head[at.WARM] = warm
        outcome = solve_one(here)
        for j in range(n):
            point[j] = x[j]
        for i in range(m):
            sides[i] = side[i]
        said = ints(head[at.OUTCOMES], 4 * b, 4)
        said[0], said[1], said[2], said[3] = (
            outcome,
            head[at.LEVEL],
            head[at.SWEEPS],
            head[at.ITERATIONS],
        )
    return outcome
