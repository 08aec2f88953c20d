"""The native solver: loads a hierarchy, chooses how to start, and solves it.

From one tick of a control loop to the next the active rows hardly change: one sweep with those of the last tick mostly
gives the answer, with its proof (:mod:`.sweep`). Without a last tick, small problems start from a guess of all active
rows (:mod:`.guess`), others level by level (:mod:`.levels`). :mod:`.attempts` tells what follows if that fails, or a
rank is in doubt.
"""

from __future__ import annotations

import math

from . import layout as at
from .active_set import OPTIMAL
from .attempts import COLD, SIDES, TURNED, UNKNOWN, WARM, seed, work_out
from .closing import closes
from .compile import entry, inner, integer, stamp, step
from .dual import NEVER
from .guess import guess
from .lines import weigh
from .memory import clock, floats, given, ints, marks, matrix, vector
from .orthogonal import length
from .rows import EQUALITY, INACTIVE, LOWER, UPPER

#: Outcomes in addition to the statuses of :mod:`.active_set`. SUSPECT: nothing was solved, as a number may be invalid.
#: UNEVEN: solved, but a level has rows of very different lengths, or a rank is in doubt. An answer that is STALLED or
#: UNEVEN must be judged by the certificate. LACKING: no answer, as a kernel was needed that is not ready.
SUSPECT, UNEVEN, LACKING = 3, 4, 5

#: As :data:`hqp.hierarchy.LARGEST`. A longer row may have an entry that is too large.
LARGEST = 1e30

#: Round-off in x, relative to the length of its start x_0.
ROUND_OFF = 64 * 2.0**-52


@inner
def load(here, warm, trusted):
    """Write the weighted rows, their bounds and lengths, and correct ``side``; False if a number may be invalid.

    With `warm`, ``side`` is kept where the row has that bound; otherwise only equalities are active. `trusted` tells
    that rows longer than LARGEST were checked before.
    """
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
            size = math.sqrt(weigh(A[row_of[i]], weight, n, B[row_of[i]]))
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
    """The number of levels that count: those above the first level of equally weighted equalities on all variables.

    Such a level is ``min ||x - x_0||`` with its own x_0, which is written; nothing below can change x. Without one, x_0
    is x_ref, and all levels count.
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
def start_clock(here):
    """Set DEADLINE: the time limit after the call began, or after now if that is unknown; NEVER without a limit."""
    head, limit = ints(here, 0, at.HEAD), vector(here, at.OPTION)[at.LIMIT]
    head[at.DEADLINE] = NEVER
    if limit < math.inf:
        head[at.DEADLINE] = (head[at.BEGAN] if head[at.BEGAN] != 0 else clock()) + int(1e9 * limit)
    head[at.BEGAN] = 0


@inner
def note_blur(here):
    """Set BLUR, what the round-off of x_0 adds to the length of x to which tolerances are relative (:mod:`.extent`)."""
    option = vector(here, at.OPTION)
    option[at.BLUR] = ROUND_OFF / option[at.TOL] * length(vector(here, at.X0), ints(here, 0, at.HEAD)[at.N])


@step
def solve_one(here):
    """Solve the one hierarchy that the directory points to; returns as :func:`solve`."""
    head = ints(here, 0, at.HEAD)
    warm = head[at.WARM] != 0
    head[at.WARM] = head[at.SWEEPS] = head[at.ITERATIONS] = 0
    head[at.FAILS], head[at.LACKS] = at.UNJUDGED, 0
    start_clock(here)
    if not load(here, warm, head[at.TRUSTED] != 0):
        return SUSPECT
    last = levels_that_count(here)
    note_blur(here)
    head[at.CLOSES] = vector(here, at.OPTION)[at.BLUR] == 0.0 and closes(here, last)
    if not warm:
        head[at.HISTORY] = UNKNOWN
    elif head[at.HISTORY] == UNKNOWN:
        seed(here, last)
    if warm and head[at.HISTORY] == TURNED and head[at.BASIS] == 0:
        start = integer(WARM)
    else:
        start = integer(SIDES if warm or guess(here, last) else COLD)
    status, level = work_out(here, last, start, warm)
    head[at.LEVEL], head[at.WARM] = min(level, last), 1
    if head[at.LACKS] != 0:
        return LACKING
    return UNEVEN if status == OPTIMAL and head[at.DOUBT] != 0 else status


@stamp
@entry
def solve(here, numbers):
    """Solve the hierarchy at the address `numbers`, in the memory of this directory.

    If COUNT is not 0, so many hierarchies of one structure are solved in turn, each warm from its own last sides.

    Returns
    -------
    outcome : int
        A status of :mod:`.active_set`, or SUSPECT, UNEVEN, LACKING; of many hierarchies, that of the last.
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
            head[at.HISTORY] = UNKNOWN  # SAVED belongs to the hierarchy before this one
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
