r"""The whole solver: guess, solve the equalities, verify, repair; and where repair fails, the safe method.

From one tick of a control loop to the next the active rows hardly change, so that the last ones are the guess and
one sweep is the answer, with its proof (:mod:`.sweep`). Without a last one, or where repair gets nowhere, a weighted
problem makes the guess (:mod:`.dual`). All rows that contradict a guess change sides at once. When that stops making
progress the safe method decides (:mod:`.active_set`), and one more sweep gives its answer the same proof.
"""

from __future__ import annotations

import math

from .active_set import NEVER, OPTIMAL, STALLED, active_set
from .compile import entry, part, stamp
from .dual import weighted_guess
from .layout import BUDGET, ITERATIONS, LEVEL, LIMIT, MARKS_HEAD, MEMORY_HEAD, SWEEPS, TRUSTED, WARM, unpack
from .memory import clock, floats, ints
from .sweep import EQUALITY, INACTIVE, LOWER, UPPER, sweep

#: Outcomes beside the statuses of the safe method: nothing solved, for a number may mean nothing; proved at once.
SUSPECT, CLEAR = 3, 4

#: As :data:`hqp.hierarchy.LARGEST`: a row that is longer has an entry to be looked at.
LARGEST = 1e30

#: How many rounds of repair in a row may fail to bring the number of contradictions down.
PATIENCE = 2
#: Where a row that counts as dependent shows that it is not, less of it has to be left, down to round-off.
SHARPER, SHARPEST = 0.1, 2e-12


@part
def load(problem, work, warm, trusted):
    """Weight the rows, measure them, and make the guess fit them; False if a number may mean nothing."""
    n, col, side = problem.n, problem.col, work.side
    lower, upper, lo, hi, norm = problem.lower, problem.upper, problem.lo, problem.hi, problem.norm
    for i in range(problem.m):
        weight = problem.weights[i]
        size = 1.0
        if col[i] < 0:
            given, row = problem.A[problem.row_of[i]], problem.B[problem.row_of[i]]
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


@part
def levels_that_count(problem):
    """A level of equalities on every variable, all of one weight, is a last level: nothing below can move x.

    It is what ``min ||x - x0||`` says, with its own x0.
    """
    for j in range(problem.n):
        problem.x0[j] = problem.x_ref[j]
    for k in range(problem.levels):
        if problem.whole[k] == 0:
            continue
        first, end = problem.ptr[k], problem.ptr[k + 1]
        alike = True
        for i in range(first, end):
            alike = alike and problem.lower[i] == problem.upper[i] and problem.norm[i] == problem.norm[first]
        if alike:
            for i in range(first, end):
                problem.x0[problem.col[i]] = problem.lower[i]
            return k
    return problem.levels


@part
def repair(problem, work, last):
    """Let all rows that contradict the guess change sides."""
    for i in range(problem.ptr[last]):
        work.side[i] = work.follow[i]


@part
def first_contradiction(problem, work, last):
    """The highest level with a row that contradicts its side."""
    for k in range(last):
        for i in range(problem.ptr[k], problem.ptr[k + 1]):
            if work.side[i] != work.follow[i]:
                return k
    return last


@part
def start(problem, x):
    """Where the safe method starts: at what the last level wants, within the bounds of level 0."""
    for j in range(problem.n):
        x[j] = problem.x0[j]
    if problem.boxed:
        for i in range(problem.ptr[0], problem.ptr[1]):
            j = problem.col[i]
            x[j] = min(max(x[j], problem.lower[i]), problem.upper[i])


@stamp
@entry
def solve(layout, memory, marks, numbers):
    """Solve the hierarchy at the address `numbers`; x is left in `memory`, sides and counts in `marks`.

    Returns
    -------
    outcome : int
        A status of :mod:`.active_set`, or CLEAR, or SUSPECT.
    """
    report, option = ints(marks, 0, MARKS_HEAD), floats(memory, 0, MEMORY_HEAD)
    problem, work = unpack(numbers, layout, memory, marks)
    warm = report[WARM] != 0
    report[WARM] = 0
    if not load(problem, work, warm, report[TRUSTED] != 0):
        return SUSPECT
    last = levels_that_count(problem)

    deadline = NEVER if option[LIMIT] == math.inf else clock() + int(1e9 * option[LIMIT])

    status, level, iterations, sweeps = OPTIMAL, last, 0, 0
    guessed = safe = False
    wanted = not warm
    fewest, patience, tau = problem.m + 1, PATIENCE, problem.tau
    while True:
        if wanted:
            weighted_guess(problem, work, last)
            wanted, guessed = False, True
            fewest, patience = problem.m + 1, PATIENCE
        faults, blurred = sweep(problem, work, last, tau)
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
        if patience > 0 and (safe or not late):
            repair(problem, work, last)
        elif not guessed and not late:
            wanted = True
        else:
            safe = True
            start(problem, work.x)
            status, level, iterations = active_set(problem, work, last, int(option[BUDGET]), deadline)
            for j in range(problem.n):
                work.safe[j] = work.x[j]
            if status != OPTIMAL:
                break
            fewest, patience = problem.m + 1, PATIENCE
    if safe and faults > 0:  # round-off decides what the sweep says: the safe method has the last word
        for j in range(problem.n):
            work.x[j] = work.safe[j]
        if status == OPTIMAL:  # and no proof
            status, level = STALLED, first_contradiction(problem, work, last)
    report[LEVEL], report[SWEEPS], report[ITERATIONS], report[WARM] = level, sweeps, iterations, 1
    return CLEAR if sweeps == 1 and not safe else status
