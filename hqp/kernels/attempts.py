"""What is tried, one after the other, until there is an answer with its proof.

One sweep with the sides that are known, whose contradictions change sides at once; then level by level
(:mod:`.levels`), where ranks are as sharp as round-off allows from the first level on that needs it. Where a rank is in
doubt (:mod:`.doubt`), the compiled certificate decides (:mod:`.proof`). What has failed so far is for the safe method
(:mod:`.active_set`), from the last point that is known to be exact. If there is still no answer, or the certificate
does not accept it, and ranks were not sharpened yet, all levels are solved once more with sharp ones, from a cold start
if the first one has failed; only what the certificate accepts counts then.
"""

from __future__ import annotations

from . import layout as at
from .active_set import OPTIMAL, STALLED, SUBOPTIMAL, active_set
from .compile import inner, integer
from .doubt import SHARPEST, doubtful, sharpen
from .dual import NEVER, late
from .extent import extent
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
#: What another try has come to.
PROVED, FAILED, LATE = 0, 1, 2
#: What moves x by no more than this share of its length does not move it.
UNMOVED = 1e-13


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
    """Solve for levels 0 .. last from this start on: where the sides alone are no answer, level by level.

    Returns
    -------
    faults : int
        0 where x is proved.
    exact_above : int
        The levels above this one are exact at EXACT.
    sharpened : bool
        Whether ranks were sharper than asked for from one level on.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    exact_above, tau = integer(0), option[at.TAU]
    while True:
        level, faults = integer(last + 1), integer(1)
        if start != SIDES:
            level = exact_above = levels(here, last, start == WARM)
            faults = integer(level <= last + 1)
            head[at.SWEEPS] += level == last + 2
        if faults > 0 and level == last + 1:
            faults = verify(here, last)
        sharpened = option[at.TAU] < tau
        if sharpened:
            option[at.TAU], head[at.DOUBT] = tau, 1
        if start != SIDES:
            head[at.HISTORY] = faults == 0
        if faults == 0 or start != SIDES:
            return faults, exact_above, sharpened
        start = integer(WARM if warm else COLD)


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
    head = ints(here, 0, at.HEAD)
    status, level = integer(OPTIMAL), integer(last + 1)
    faults, exact_above, sharpened = attempt(here, last, start, warm)
    if faults == 0 and accepted(here, last):
        return status, level
    if faults > 0 and late(here):
        stop_early(here, exact_above, last)
        return integer(SUBOPTIMAL), exact_above
    failed = faults > 0 or sharpened
    if (failed or vector(here, at.OPTION)[at.TAU] <= SHARPEST) and not late(here):
        status, level = play_safe(here, last)
        if status == SUBOPTIMAL or (status == OPTIMAL and head[at.DOUBT] == 0):
            return status, level
    # Without a time limit the caller asks for a cold start himself, if `certify` refuses what is left.
    if not late(here) and not (sharpened and head[at.DEADLINE] == NEVER):
        again, stopped = try_again(here, last, failed, warm)
        if again == PROVED:
            return integer(OPTIMAL), integer(last + 1)
        if again == LATE and status == STALLED:
            stop_early(here, stopped, last)
            return integer(SUBOPTIMAL), stopped
        copy(here, at.SAFE, at.X)
    head[at.DOUBT] = 1
    return status, level


@inner
def try_again(here, last, failed, warm):
    """Once more with ranks as sharp as can be, from the sides that are known or, if these have `failed`, from none.

    Where the user has set the ranks, they stay, and only a warm start that has failed is tried cold; DOUBT tells
    whether the certificate has accepted what is PROVED. SAFE is the x of before.

    Returns
    -------
    outcome : int
        PROVED, FAILED or LATE.
    exact_above : int
        As of :func:`attempt`.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    tau, known = option[at.TAU], warm or head[at.HISTORY] != 0
    copy(here, at.X, at.SAFE)
    sharper = sharpen(here)
    if not sharper and not (failed and warm):
        return integer(FAILED), integer(0)
    faults, exact_above, _ = attempt(here, last, integer(COLD if failed else SIDES), known)
    option[at.TAU] = tau
    if faults > 0:
        return integer(LATE if late(here) else FAILED), exact_above
    if sharper:
        head[at.DOUBT] = 1
        if unmoved(here) or not accepted(here, last):
            return integer(FAILED), exact_above
    else:
        accepted(here, last)
    return integer(PROVED), exact_above


@inner
def unmoved(here):
    """Whether x is SAFE up to round-off: the certificate has judged it."""
    n, x, y = ints(here, 0, at.HEAD)[at.N], vector(here, at.X), vector(here, at.SAFE)
    away = 0.0
    for j in range(n):
        away = max(away, abs(x[j] - y[j]))
    return away <= UNMOVED * extent(x, here)


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
            status, level = integer(STALLED), first_contradiction(here, last)
    head[at.HISTORY] = 0
    if status == STALLED and head[at.DAMPED] == 0 and proves(here, last):
        head[at.DOUBT] = 0
        return integer(OPTIMAL), integer(last + 1)
    return status, level
