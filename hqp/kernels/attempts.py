"""The order of the methods that are tried until one gives an answer with its proof.

1. A sweep with the known sides (:mod:`.sweep`); rows that contradict their side change it, and the sweep is repeated.
2. Level by level (:mod:`.levels`): first warm, from the sides at the end of each level of the last solve, then cold.
3. If neither gives an answer, or a rank is in doubt (:mod:`.doubt`) and the compiled certificate (:mod:`.proof`)
   rejects the answer: the same again, with the smallest rank tolerance that round-off allows. This answer counts only
   if the certificate accepts it.
4. The safe method (:mod:`.active_set`), from the last point that is known to be exact.
"""

from __future__ import annotations

from . import layout as at
from .active_set import OPTIMAL, STALLED, SUBOPTIMAL, active_set
from .compile import inner, integer
from .doubt import MOST, SHARPEST, doubtful
from .dual import late
from .levels import levels
from .line_search import best_step
from .memory import ints, marks, vector
from .proof import proves
from .rows import value_of
from .sweep import sweep
from .working_set import FROZEN

#: How an attempt starts: a sweep with the known sides; level by level from the sides at the end of each level of the
#: last solve; level by level from no sides.
SIDES, WARM, COLD = 0, 1, 2

#: How many repairs in a row may fail to reduce the number of contradictions.
PATIENCE = 1
#: Up to so many contradictions are repaired even if a higher level is not met.
FEW = 2
#: Factor on the rank tolerance, down to round-off, each time that a row which counts as dependent proves not to be.
SHARPER = 0.1


@inner
def seed(here, last):
    """Take ``side``, the active set of the last answer, as the sides at the end of every level, ``saved``."""
    m, ptr = ints(here, 0, at.HEAD)[at.ROWS], marks(here, at.PTR)
    side, saved = marks(here, at.SIDE), marks(here, at.SAVED)
    for k in range(last + 1):
        for i in range(ptr[min(k + 1, last)]):
            saved[k * m + i] = side[i]


@inner
def repair(here, last):
    """Set ``side`` to ``follow``: all rows that contradict their side change it."""
    ptr, side, follow = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.FOLLOW)
    for i in range(ptr[last]):
        side[i] = follow[i]


@inner
def first_contradiction(here, last):
    """The highest level with a row that contradicts its side; `last` if there is none."""
    ptr, side, follow = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.FOLLOW)
    for k in range(last):
        for i in range(ptr[k], ptr[k + 1]):
            if side[i] != follow[i]:
                return k
    return last


@inner
def contested(here, last):
    """Whether one of the levels 0 .. last - 2 is not met."""
    forces_of = vector(here, at.FORCES)
    met = True
    for k in range(last - 1):
        met = met and forces_of[k] == 0.0
    return not met


@inner
def verify(here, last):
    """Sweep and repair as long as the contradictions become fewer; returns how many are left, 0 with a proof.

    The rank tolerance is reduced while a row that counts as dependent proves not to be.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    fewest, left, tau = head[at.ROWS] + 1, PATIENCE, option[at.TAU]
    while True:
        faults, blurred = sweep(here, last, tau)
        head[at.SWEEPS] += 1
        if faults == 0 and blurred and tau > SHARPEST:
            tau *= SHARPER
            continue
        if tau < option[at.TAU]:  # the rank tolerance used was smaller than the one set
            head[at.DOUBT] = 1
        left = PATIENCE if faults < fewest else left - 1
        fewest = min(fewest, faults)
        if faults == 0 or left <= 0 or late(here) or (faults > FEW and contested(here, last)):
            return faults
        repair(here, last)


@inner
def stop_early(here, k, last):
    """At the iteration or time limit: set x to EXACT, which is exact above level k, plus a step that improves level k.

    The step goes towards the present x. It ends at the minimum of level k along it, or at the first row of the levels
    above that blocks, so that no level above becomes worse.
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
def attempt(here, last, start, warm):
    """Solve levels 0 .. last from this start (SIDES, WARM or COLD), then from the later ones, until there is a proof.

    `warm` tells whether there are sides at the end of each level; without them WARM is left out.

    Returns
    -------
    faults : int
        0 if x is proved optimal.
    exact_above : int
        EXACT is optimal for all levels above this one.
    """
    head = ints(here, 0, at.HEAD)
    exact_above = integer(0)
    while True:
        level, faults = integer(last + 1), integer(1)
        if start != SIDES:
            level = exact_above = levels(here, last, start == WARM)
            faults = integer(level <= last + 1)
            head[at.SWEEPS] += level == last + 2
        if faults > 0 and level == last + 1:
            faults = verify(here, last)
        if start != SIDES:
            head[at.HISTORY] = faults == 0
        if faults == 0 or start == COLD or (start != SIDES and late(here)):
            return faults, exact_above
        start = integer(COLD) if start == SIDES and not warm else start + 1


@inner
def copy(here, source, into):
    """Copy the vector (n,) at one place of the directory to another."""
    x, y = vector(here, source), vector(here, into)
    for j in range(ints(here, 0, at.HEAD)[at.N]):
        y[j] = x[j]


@inner
def accepted(here, last):
    """Whether no rank of the proved answer is in doubt, or the certificate accepts it; DOUBT is set to 1 if neither."""
    head = ints(here, 0, at.HEAD)
    if head[at.DAMPED] == 0:  # the stages of damped levels are judged together, later
        head[at.DOUBT] = doubtful(here) and not proves(here, last)
    else:
        head[at.DOUBT] = 0
    return head[at.DOUBT] == 0


@inner
def work_out(here, last, start, warm):
    """Solve levels 0 .. last by all methods in turn, from this start on (see :func:`attempt`).

    DOUBT is 1 if the answer is OPTIMAL but the certificate must still judge it.

    Returns
    -------
    status, level : int
        As of :func:`.active_set.active_set`.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    faults, exact_above = attempt(here, last, start, warm)
    if faults == 0 and accepted(here, last):
        return OPTIMAL, integer(last + 1)
    tau = option[at.TAU]
    if head[at.DAMPED] == 0 and SHARPEST < tau <= MOST and not late(here):
        kept = at.X if faults == 0 else at.EXACT
        copy(here, kept, at.SAFE)
        option[at.TAU] = SHARPEST
        again, above = attempt(here, last, integer(SIDES if faults == 0 else COLD), False)
        option[at.TAU] = tau
        if again == 0 and proves(here, last):
            head[at.DOUBT] = 0
            return OPTIMAL, integer(last + 1)
        if faults > 0 and again > 0 and late(here):
            exact_above = above
        else:
            copy(here, at.SAFE, kept)
    if faults == 0:
        head[at.DOUBT] = 1
        return OPTIMAL, integer(last + 1)
    if late(here):
        stop_early(here, exact_above, last)
        return SUBOPTIMAL, exact_above
    return play_safe(here, last)


@inner
def play_safe(here, last):
    """Solve levels 0 .. last by the safe method from EXACT, and prove the answer; returns as :func:`work_out`."""
    head = ints(here, 0, at.HEAD)
    copy(here, at.EXACT, at.X)
    status, level = active_set(here, last)
    copy(here, at.X, at.SAFE)
    if level == last + 1:
        faults = verify(here, last)
        head[at.HISTORY] = faults == 0
        if faults == 0:
            accepted(here, last)
            return status, level
        copy(here, at.SAFE, at.X)  # the sweep contradicts by round-off: the answer of the safe method stays
        if status == OPTIMAL:  # but it has no proof
            status, level = STALLED, first_contradiction(here, last)
    head[at.HISTORY] = 0
    if status == STALLED and head[at.DAMPED] == 0 and proves(here, last):
        head[at.DOUBT] = 0
        return OPTIMAL, integer(last + 1)
    return status, level
