"""Which rows a solved level of the safe method freezes, and which become hard, for the levels below.

Frozen are its equalities and violated rows, and those rows of the working set whose multiplier is clearly positive:
any change of them would make this level worse. All other rows of the level become hard: satisfied, and to stay so.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .extent import extent
from .memory import ints, marks, matrix, vector
from .orthogonal import factor, padded
from .pull import tolerances
from .rows import EQUALITY, LOWER, UPPER, copy_row
from .working_set import FROZEN, HARD, WORKING, append

#: A row of the working set is frozen if its multiplier, times its length, is more than this share of the forces.
CLEAR = 1e-8


@inner
def decide(here, k, forces, frozen, working):
    """Freeze level k at x, and rebuild the working set from the rows of the old one that are not frozen.

    Returns
    -------
    frozen, working : int
        Rows of V that span the frozen rows, and rows of the new working set.
    """
    n, tau = ints(here, 0, at.HEAD)[at.N], vector(here, at.OPTION)[at.TAU]
    ids, pivot, slots = marks(here, at.IDS), marks(here, at.PIVOT), marks(here, at.SLOTS)
    norm, lengths = vector(here, at.NORM), vector(here, at.LENGTHS)
    V, L, R = matrix(here, at.V), matrix(here, at.L), matrix(here, at.R)
    count = implicit_equalities(here, forces, frozen, working)
    count = decide_rows(here, k, count)
    for r in range(count):
        copy_row(ids[r], R[r], here)
    rank = factor(ids, count, slots, lengths, R, norm, V, L, frozen, padded(n), tau)
    for r in range(rank):
        pivot[frozen + r] = ids[r]
    return frozen + rank, rejoin(here, frozen + rank, working)


@inner
def implicit_equalities(here, forces, frozen, working):
    """Freeze the rows of the working set that hold the level back; returns how many.

    These are listed in ``ids``, the whole working set in ``queue``.
    """
    pivot, ids, queue = marks(here, at.PIVOT), marks(here, at.IDS), marks(here, at.QUEUE)
    kind, side, norm = marks(here, at.KIND), marks(here, at.SIDE), vector(here, at.NORM)
    multiplier, count = vector(here, at.MULTIPLIER), integer(0)
    for q in range(frozen, frozen + working):
        i = pivot[q]
        queue[q - frozen] = i
        kind[i] = HARD
        if forces > 0.0 and multiplier[q] * side[i] * norm[i] > CLEAR * forces:
            kind[i] = FROZEN
            ids[count] = i
            count += 1
    return count


@inner
def decide_rows(here, k, count):
    """Freeze violated rows and equalities of level k, and append them to the `count` rows in ``ids``; returns the sum.

    All others become hard, with the bounds ``low``, ``high`` and the tolerance ``allowed``.
    """
    tol, ptr, ids = vector(here, at.OPTION)[at.TOL], marks(here, at.PTR), marks(here, at.IDS)
    kind, side, norm, w = marks(here, at.KIND), marks(here, at.SIDE), vector(here, at.NORM), vector(here, at.W)
    lo, hi, v = vector(here, at.LO), vector(here, at.HI), vector(here, at.VALUE)
    low, high, allowed = vector(here, at.LOW), vector(here, at.HIGH), vector(here, at.ALLOWED)
    size = extent(vector(here, at.X), here)
    for i in range(ptr[k], ptr[k + 1]):
        w[i], kind[i] = 0.0, FROZEN
        if norm[i] == 0.0:
            continue
        t_low, t_high = tolerances(i, size, here)
        over, under = v[i] - hi[i], v[i] - lo[i]
        if lo[i] == hi[i]:
            side[i] = EQUALITY
            if abs(over) > t_high:
                w[i] = over
        elif over > t_high:
            side[i], w[i] = UPPER, over
        elif under < -t_low:
            side[i], w[i] = LOWER, under
        else:
            kind[i] = HARD
            high[i], low[i] = max(hi[i], v[i]), min(lo[i], v[i])
            allowed[i] = tol * norm[i] * size + tol * abs(v[i])
            continue
        ids[count] = i
        count += 1
    return count


@inner
def rejoin(here, frozen, candidates):
    """Rebuild the working set from the first `candidates` rows of ``queue``; returns how many rows it has.

    A row joins if it is still hard, and independent of the frozen rows and of those that joined before.
    """
    kind, queue, tau = marks(here, at.KIND), marks(here, at.QUEUE), vector(here, at.OPTION)[at.TAU]
    working = integer(0)
    for q in range(candidates):
        i = queue[q]
        if kind[i] == HARD and append(i, frozen + working, here, tau):
            kind[i] = WORKING
            working += 1
    return working
