"""What is tried, one after the other, until there is an answer with its proof.

One sweep with the sides that are known, whose contradictions change sides at once; level by level, warm, then cold
(:mod:`.levels`). Where a rank is in doubt (:mod:`.doubt`), the compiled certificate decides (:mod:`.proof`). If it does
not accept the answer, or there is none, the same is tried with ranks as sharp as round-off allows, from there on; only
what the certificate accepts counts. What is left is for the safe method (:mod:`.active_set`), from the last point that
is known to be exact.
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

#: Where an attempt starts: from the sides that are known, by one sweep; level by level, from those at the end of each
#: level or from none.
SIDES, WARM, COLD = 0, 1, 2

#: How many rounds of repair in a row may fail to bring the number of contradictions down.
PATIENCE = 1
#: So many contradictions are repaired even where levels above others are not met.
FEW = 2
#: Where a row that counts as dependent shows that it is not, less of it has to be left, down to round-off.
SHARPER = 0.1


@inner
def seed(here, last):
    """Nothing is known of the end of each level: the sides of the last answer are taken for it."""
    m, ptr = ints(here, 0, at.HEAD)[at.ROWS], marks(here, at.PTR)
    side, saved = marks(here, at.SIDE), marks(here, at.SAVED)
    for k in range(last + 1):
        for i in range(ptr[min(k + 1, last)]):
            saved[k * m + i] = side[i]


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
        if tau < option[at.TAU]:  # ranks were as sharp as was needed, and not as was asked for
            head[at.DOUBT] = 1
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
def attempt(here, last, start, warm):
    """Solve for levels 0 .. last from this start on, and from those behind it.

    Returns
    -------
    faults : int
        0 where x is proved.
    exact_above : int
        The levels above this one are exact at EXACT.
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
    """Copy a point."""
    x, y = vector(here, source), vector(here, into)
    for j in range(ints(here, 0, at.HEAD)[at.N]):
        y[j] = x[j]


@inner
def accepted(here, last):
    """Whether what has just been proved is beyond doubt, or the certificate accepts it. DOUBT tells."""
    head = ints(here, 0, at.HEAD)
    if head[at.DAMPED] == 0:  # else the stages of the damped levels are judged together
        head[at.DOUBT] = doubtful(here) and not proves(here, last)
    else:
        head[at.DOUBT] = 0
    return head[at.DOUBT] == 0


@inner
def work_out(here, last, start, warm):
    """Solve for levels 0 .. last from this start on: a status of :mod:`.active_set`, and the level of it.

    DOUBT is set where an answer that is OPTIMAL is yet to be accepted by the certificate.
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
    """Solve for levels 0 .. last from EXACT by the safe method, and prove it: as :func:`work_out`."""
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
        copy(here, at.SAFE, at.X)  # where round-off decides what the sweep says, it has the last word
        if status == OPTIMAL:  # and no proof
            status, level = STALLED, first_contradiction(here, last)
    head[at.HISTORY] = 0
    if status == STALLED and head[at.DAMPED] == 0 and proves(here, last):
        head[at.DOUBT] = 0
        return OPTIMAL, integer(last + 1)
    return status, level
