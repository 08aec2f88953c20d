"""The order of the methods that are tried until one gives an answer with its proof.

1. A sweep with the known sides (:mod:`.sweep`); rows that contradict their side change it, and the sweep is repeated.
   Left out where the last solve has come to 2, and found other sides than it began with.
2. Level by level (:mod:`.levels`): first warm, from the sides at the end of each level of the last solve, then cold.
   From the first level on that needs it, ranks are as sharp as round-off allows.
3. If a rank is in doubt (:mod:`.doubt`), the compiled certificate (:mod:`.proof`) decides.
4. If that fails, the safe method (:mod:`.active_set`), from the last point that is known to be exact.
5. If there is still no answer, or the certificate rejects it, and ranks were not sharpened yet: all levels once more
   with sharp ranks, cold if the first start has failed. This answer counts only if the certificate accepts it.
"""

from __future__ import annotations

from . import layout as at
from .active_set import OPTIMAL, STALLED, SUBOPTIMAL
from .apart import active_set, proves
from .compile import inner, integer
from .doubt import SHARPEST, doubtful, sharpen
from .dual import NEVER, late
from .extent import extent
from .levels import levels
from .line_search import best_step
from .memory import ints, marks, vector
from .rows import INACTIVE, value_of
from .sweep import sweep
from .working_set import FROZEN

#: How an attempt starts: a sweep with the known sides; level by level from the sides at the end of each level of the
#: last solve; level by level from no sides.
SIDES, WARM, COLD = 0, 1, 2

#: How many repairs in a row may fail to reduce the number of contradictions.
PATIENCE = 1
#: Up to so many contradictions are repaired, if a higher level is not met, and if all are.
FEW, MANY = 2, 7
#: Factor on the rank tolerance, down to round-off, each time that a row which counts as dependent proves not to be.
SHARPER = 0.1
#: What is known of the last solve, HISTORY: nothing; the sides at the end of each level; and that these were not those
#: of the solve before. Rows that have just changed sides mostly change them again: the next sweep would be in vain.
UNKNOWN, KNOWN, TURNED = 0, 1, 2
#: What another try has come to.
PROVED, FAILED, LATE = 0, 1, 2
#: What moves x by no more than this share of its length does not move it.
UNMOVED = 1e-13


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
def note_sides(here, last):
    """Set ``follow`` to ``side``: a row that then changes its side contradicts it, for :func:`first_contradiction`."""
    ptr, side, follow = marks(here, at.PTR), marks(here, at.SIDE), marks(here, at.FOLLOW)
    for i in range(ptr[last]):
        follow[i] = side[i]


@inner
def contested(here, last):
    """Whether one of the levels 0 .. last - 2 is not met."""
    forces_of = vector(here, at.FORCES)
    met = True
    for k in range(last - 1):
        met = met and forces_of[k] == 0.0
    return not met


@inner
def only_contradiction(here, last):
    """The row that contradicts its side, if there is one only."""
    side, follow = marks(here, at.SIDE), marks(here, at.FOLLOW)
    for i in range(marks(here, at.PTR)[last]):
        if side[i] != follow[i]:
            return i
    return integer(-1)


@inner
def is_needed(here, i):
    """Whether the certificate accepts APPROACH, solved with row i at its bound; then it is x, and ``side`` has i again.

    Not for callers who need the basis of the sweep.
    """
    head, side, follow = ints(here, 0, at.HEAD), marks(here, at.SIDE), marks(here, at.FOLLOW)
    if head[at.BASIS] != 0 or late(here):
        return False
    exchange(here, at.X, at.APPROACH)
    side[i] = follow[i]
    if proves(here):
        head[at.DOUBT] = 0
        return True
    exchange(here, at.X, at.APPROACH)
    side[i], head[at.FAILS] = INACTIVE, at.UNJUDGED
    return False


@inner
def exchange(here, one, other):
    """Exchange the vectors (n,) at two places of the directory."""
    x, y = vector(here, one), vector(here, other)
    for j in range(ints(here, 0, at.HEAD)[at.N]):
        x[j], y[j] = y[j], x[j]


@inner
def verify(here, last):
    """Sweep and repair as long as the contradictions become fewer; returns how many are left, 0 with a proof.

    The rank tolerance is reduced while a row that counts as dependent proves not to be. A row that was let go because
    of the sign of its multiplier, and alone contradicts the next sweep, is needed: its multiplier is not unique, as it
    depends on other rows, and the certificate decides whether others of the right sign balance the levels.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    fewest, left, tau, gone = head[at.ROWS] + 1, PATIENCE, option[at.TAU], integer(-1)
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
        alone = only_contradiction(here, last) if faults == 1 else integer(-1)
        if alone >= 0 and alone == gone and is_needed(here, alone):
            return integer(0)
        gone = alone if alone >= 0 and marks(here, at.FOLLOW)[alone] == INACTIVE else integer(-1)
        if gone >= 0:
            copy(here, at.X, at.APPROACH)
        if faults == 0 or left <= 0 or late(here) or faults > (FEW if contested(here, last) else MANY):
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
        EXACT is optimal for all levels above this one; -1 if it was not written.
    sharpened : bool
        Whether ranks were sharper than asked for from one level on.
    """
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    exact_above, tau = integer(-1), option[at.TAU]
    while True:
        level, faults, found = integer(last + 1), integer(1), integer(KNOWN)
        if start != SIDES:
            note_sides(here, last)
            level = exact_above = levels(here, last, start == WARM)
            if start == WARM and first_contradiction(here, last) < last:
                found = integer(TURNED)
            faults = integer(level <= last + 1)
            head[at.SWEEPS] += level == last + 2
        if faults > 0 and level == last + 1:
            faults = verify(here, last)
        sharpened = option[at.TAU] < tau
        if sharpened:
            option[at.TAU], head[at.DOUBT] = tau, 1
        if start != SIDES:
            head[at.HISTORY] = found if faults == 0 else UNKNOWN
        if faults == 0 or start != SIDES:
            return faults, exact_above, sharpened
        start = integer(WARM if warm else COLD)


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
    head[at.FAILS] = at.UNJUDGED
    head[at.DOUBT] = doubtful(here) and not proves(here)
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
    head = ints(here, 0, at.HEAD)
    status, level = integer(OPTIMAL), integer(last + 1)
    if start != SIDES:  # no sweep writes x: it is what another solve has left there, or nothing
        copy(here, at.X0, at.X)
    faults, exact_above, sharpened = attempt(here, last, start, warm)
    if faults == 0 and accepted(here, last):
        return status, level
    if faults > 0 and late(here):
        stop_early(here, exact_above, last)
        return integer(SUBOPTIMAL), exact_above
    failed = faults > 0 or sharpened
    if (failed or vector(here, at.OPTION)[at.TAU] <= SHARPEST) and not late(here):
        status, level = play_safe(here, last, exact_above)
        if status == SUBOPTIMAL or (status == OPTIMAL and head[at.DOUBT] == 0):
            return status, level
    # Without a time limit the caller asks for a cold start himself, if `certify` refuses what is left.
    if not late(here) and not (sharpened and head[at.DEADLINE] == NEVER):
        fails = head[at.FAILS]
        again, stopped = try_again(here, last, failed, warm)
        if again == PROVED:
            return integer(OPTIMAL), integer(last + 1)
        if again == LATE and status == STALLED:
            stop_early(here, stopped, last)
            return integer(SUBOPTIMAL), stopped
        copy(here, at.SAFE, at.X)
        head[at.FAILS] = fails
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
    tau, known = option[at.TAU], warm or head[at.HISTORY] != UNKNOWN
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
def play_safe(here, last, exact_above):
    """Solve levels 0 .. last by the safe method from EXACT, and prove the answer; returns as :func:`work_out`.

    `exact_above` is that of :func:`attempt`.
    """
    head = ints(here, 0, at.HEAD)
    head[at.FAILS] = at.UNJUDGED
    copy(here, at.EXACT if exact_above >= 0 else at.X0, at.X)
    status, level = active_set(here, last, exact_above)
    copy(here, at.X, at.SAFE)
    if level == last + 1:
        faults = verify(here, last)
        head[at.HISTORY] = KNOWN if faults == 0 else UNKNOWN
        if faults == 0:
            accepted(here, last)
            return status, level
        copy(here, at.SAFE, at.X)  # the sweep contradicts by round-off: the answer of the safe method stays
        if status == OPTIMAL:  # but it has no proof
            status, level = integer(STALLED), first_contradiction(here, last)
    head[at.HISTORY] = UNKNOWN
    if status == STALLED and proves(here):
        head[at.DOUBT] = 0
        return integer(OPTIMAL), integer(last + 1)
    return status, level
