r"""Multipliers with the right signs for a level, in the compiled certificate (:mod:`.proof`).

Least squares give one choice of multipliers that balance level k. Rows at a bound that hold a level j above have
multipliers :math:`\mu > 0` there, and the violated rows of level j are free below. So in the null space of the free
rows

.. math:: \sum_i \mu_i s_i P a_i = 0, \qquad s_i = 1 \text{ at an upper bound, } -1 \text{ at a lower one:}

any multiple of this may be added to the multipliers of level k, and lifts those that are negative. ``pressed`` has
:math:`\mu` of every level, in units of its sum.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .escape import clear
from .members import list_part, prepare
from .memory import ints, marks, matrix, vector
from .orthogonal import pivots
from .round_off import TURNS, blur
from .rows import LOWER, UPPER, copy_row
from .working_set import balance

#: Rows at a bound with a smaller remainder are not in the first working set: they need huge multipliers for little.
CLEAR = 1e-6
#: Multipliers, times the length of their row, below this share of the sum of their level count as zero.
NOTHING = 1e-12
#: How often all levels above lift what is negative.
LIFTS = 2


@inner
def choose(here, k):
    """Set ``value`` to 1 for the rows above level k that the solver has at their bound, and to 0 for all others."""
    kept, where, chosen = marks(here, at.FOLLOW), marks(here, at.HELD), vector(here, at.VALUE)
    for i in range(marks(here, at.PTR)[k]):
        chosen[i] = 1.0 if (where[i] == UPPER or where[i] == LOWER) and kept[i] == where[i] else 0.0


@inner
def press(here, k, base):
    """Least-squares multipliers of level k for the rows above whose ``value`` is positive, by place in V.

    `base` is the number of rows of V that span the free normals. Returns how many rows follow them in V.
    """
    n, end, chosen = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR)[k], vector(here, at.VALUE)
    ids, slots, lengths = marks(here, at.IDS), marks(here, at.SLOTS), vector(here, at.LENGTHS)
    norm, V, L, R = vector(here, at.NORM), matrix(here, at.V), matrix(here, at.L), matrix(here, at.R)
    count, pivot = integer(0), marks(here, at.PIVOT)
    if base == n:
        return count
    for i in range(end):
        if chosen[i] > 0.0 and count < len(R):
            prepare(i, base, here)
            list_part(i, count, count, here)
            count += 1
    working = pivots(ids, count, slots, lengths, R, norm, V, L, base, n, CLEAR)
    for q in range(working):
        pivot[base + q] = ids[q]
    balance(vector(here, at.G), base, base + working, here)
    return working


@inner
def lift(here, k, base, working, scale, enough):
    """Whether the multipliers of :func:`press`, lifted, balance level k up to a residual of at most `enough`.

    They are in ``value``. `scale` is the sum of the forces of the level. What lifting adds is not quite balanced
    itself: least squares of the residual correct that once.
    """
    end, where, pivot = marks(here, at.PTR)[k], marks(here, at.HELD), marks(here, at.PIVOT)
    mine, multiplier, norm = vector(here, at.VALUE), vector(here, at.MULTIPLIER), vector(here, at.NORM)
    for i in range(end):
        mine[i] = 0.0
    for q in range(base, base + working):
        mine[pivot[q]] = multiplier[q] * where[pivot[q]]
    note_pressed(here, k, end)
    for _ in range(LIFTS):
        for j in range(k - 1, -1, -1):
            lift_by(here, j, k, scale)
    for i in range(end):
        if mine[i] * norm[i] <= NOTHING * scale:
            mine[i] = 0.0
    if left_over(here, end, base) <= enough:
        return True
    balance(vector(here, at.D), base, base + working, here)
    for q in range(base, base + working):
        i = pivot[q]
        mine[i] = max(mine[i] - multiplier[q] * where[i], 0.0) if mine[i] > 0.0 else 0.0
    return left_over(here, end, base) <= enough


@inner
def lift_by(here, j, k, scale):
    """Add as much of the multipliers of level j as lifts those of level k, ``value``, that it can lift best."""
    mine, pressed, norm = vector(here, at.VALUE), matrix(here, at.PRESSED), vector(here, at.NORM)
    times, own = 0.0, pressed[j]
    for i in range(marks(here, at.PTR)[j]):
        if mine[i] * norm[i] < -NOTHING * scale and own[i] * norm[i] > NOTHING:
            best = True
            for other in range(k):
                best = best and (i >= marks(here, at.PTR)[other] or pressed[other][i] <= own[i])
            if best:
                times = max(times, -mine[i] / own[i])
    if times > 0.0:
        for i in range(marks(here, at.PTR)[j]):
            mine[i] += times * own[i]


@inner
def left_over(here, end, base):
    """A bound of what the multipliers ``value`` of rows before `end` leave unbalanced, with the best ones of free rows.

    ``d`` is minus that residual.
    """
    n, norm, where = ints(here, 0, at.HEAD)[at.N], vector(here, at.NORM), marks(here, at.HELD)
    g, d, row, mine = vector(here, at.G), vector(here, at.D), vector(here, at.SHARE), vector(here, at.VALUE)
    total = 0.0
    for j in range(n):
        d[j] = -g[j]
    for i in range(end):
        if mine[i] > 0.0:
            copy_row(i, row, here)
            much = mine[i] * where[i]
            total += mine[i] * norm[i]
            for j in range(n):
                d[j] -= much * row[j]
    unsure = TURNS * total + blur(here, d, base, base)
    return clear(here, d, base) + unsure


@inner
def note_pressed(here, k, end):
    """Write the multipliers ``value`` of level k for the rows before `end`, in units of their sum."""
    mine, norm, total = vector(here, at.VALUE), vector(here, at.NORM), 0.0
    if k == ints(here, 0, at.HEAD)[at.LEVELS]:
        return
    own = matrix(here, at.PRESSED)[k]
    for i in range(end):
        total += abs(mine[i]) * norm[i]
    for i in range(end):
        own[i] = mine[i] / total if total > 0.0 else 0.0


@inner
def note_shares(here, k, base, working):
    """The same of the multipliers ``share`` of the working set behind V[:base]; 0 if there is none."""
    pivot, share, mine, end = (
        marks(here, at.PIVOT),
        vector(here, at.SHARE),
        vector(here, at.VALUE),
        marks(here, at.PTR)[k],
    )
    for i in range(end):
        mine[i] = 0.0
    for q in range(base, base + working):
        mine[pivot[q]] = share[q]
    note_pressed(here, k, end)
