r"""The rows S in the least squares of a level of the safe method: which they are at x, and how a step changes them.

With the bounds b that these rows are pulled to, objective and gradient of the level are

.. math:: \tfrac12 \|S x - b\|^2, \qquad g = S^T (S x - b).

A row *pulls*, that is, belongs to S, if it is an equality, violated, or *held*: a row that a step brings to its bound
is held there, so that the next Newton step does not leave the bound again. It is released once nothing else is left to
gain.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .memory import ints, marks, matrix, vector
from .rows import INACTIVE, LOWER, UPPER, value_of

#: A slack counts as a force on an unmet level if it is more than this share of the tolerance of its row.
CARRIES = 1e-4
#: The safe method takes multipliers below this share of the forces of the level for zero.
DUAL = 1e-9


@inner
def tolerances(i, size, here):
    """The tolerances of row i at its lower and its upper bound; `size` is the length of x."""
    tol, norm = vector(here, at.OPTION)[at.TOL], vector(here, at.NORM)
    lo, hi = vector(here, at.LO), vector(here, at.HI)
    near = tol * norm[i] * size
    return tol * abs(lo[i]) + near, tol * abs(hi[i]) + near


@inner
def pulls(i, size, here):
    """Whether row i pulls, to which bound, and its tolerance there; an inequality that pulls is held from now on."""
    held, v = marks(here, at.HELD), vector(here, at.VALUE)
    lo, hi = vector(here, at.LO), vector(here, at.HI)
    t_low, t_high = tolerances(i, size, here)
    if lo[i] == hi[i]:
        return True, lo[i], t_low
    if v[i] > hi[i] + CARRIES * t_high or (held[i] == UPPER and v[i] >= hi[i] - t_high):
        held[i] = UPPER
        return True, hi[i], t_high
    if v[i] < lo[i] - CARRIES * t_low or (held[i] == LOWER and v[i] <= lo[i] + t_low):
        held[i] = LOWER
        return True, lo[i], t_low
    return False, 0.0, 0.0


@inner
def pull(here, k, last, size):
    r"""Write the rows of level k that pull, ``ids``, their :math:`b_i - a_i x`, ``slope`` by row number, and ``g``.

    Returns
    -------
    count : int
        How many rows pull.
    forces : float
        :math:`\sum \|a_i\| |b_i - a_i x|`; 0 if the level is met.
    square : float
        :math:`\|S x - b\|^2`.
    scale : float
        Sum of the sizes of the terms :math:`b_i` and :math:`a_i x`, to which round-off is relative.
    """
    if k == last:
        return pull_of_reference(here, size)
    n, ptr = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR)
    col, row_of, ids = marks(here, at.COL), marks(here, at.ROW_OF), marks(here, at.IDS)
    norm, v, g, B = vector(here, at.NORM), vector(here, at.VALUE), vector(here, at.G), matrix(here, at.B)
    missing = vector(here, at.SLOPE)
    count, met = integer(0), True
    forces = square = scale = 0.0
    for j in range(n):
        g[j] = 0.0
    for i in range(ptr[k], ptr[k + 1]):
        if norm[i] == 0.0:
            continue
        does, bound, near = pulls(i, size, here)
        if not does:
            continue
        miss = bound - v[i]
        ids[count], missing[i] = i, miss
        count += 1
        square += miss * miss
        scale += abs(bound) + norm[i] * size
        met = met and abs(miss) <= near
        if abs(miss) > CARRIES * near:
            forces += norm[i] * abs(miss)
            if col[i] >= 0:
                g[col[i]] -= norm[i] * miss
            else:
                given = B[row_of[i]]
                for j in range(n):
                    g[j] -= given[j] * miss
    return count, 0.0 if met else forces, square, scale


@inner
def pull_of_reference(here, size):
    """:func:`pull` for the last level, ``min ||x - x_0||``, which has no rows: count is 0."""
    n, tol = ints(here, 0, at.HEAD)[at.N], vector(here, at.OPTION)[at.TOL]
    x, x0, g = vector(here, at.X), vector(here, at.X0), vector(here, at.G)
    forces = square = scale = 0.0
    for j in range(n):
        g[j] = x[j] - x0[j]
        square += g[j] * g[j]
        scale += abs(x0[j]) + size
        if abs(g[j]) > tol * (abs(x0[j]) + size):
            forces += abs(g[j])
    return integer(0), forces, square, scale


@inner
def release(here, count, forces):
    """Release the held row among the `count` in ``ids`` that pulls most from inside; False if there is none."""
    ids, held = marks(here, at.IDS), marks(here, at.HELD)
    lo, hi, v, norm = vector(here, at.LO), vector(here, at.HI), vector(here, at.VALUE), vector(here, at.NORM)
    worst, leaves = DUAL * forces, integer(-1)
    for r in range(count):
        i = ids[r]
        if lo[i] != hi[i]:
            bound = hi[i] if held[i] == UPPER else lo[i]
            inward = (bound - v[i]) * held[i] * norm[i]
            if inward > worst:
                worst, leaves = inward, i
    if leaves >= 0:
        held[leaves] = INACTIVE
    return leaves >= 0


@inner
def hold(here, k, last, size):
    """Hold the rows of level k that the step has brought to a bound; returns whether the same rows pull as before.

    ``x`` is the point after the step; ``value`` and `size` still belong to the x before it.
    """
    ptr, held = marks(here, at.PTR), marks(here, at.HELD)
    lo, hi, norm, v = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), vector(here, at.VALUE)
    x, slope = vector(here, at.X), vector(here, at.SLOPE)
    same = True
    for i in range(ptr[k], ptr[min(k + 1, last)]):
        if norm[i] == 0.0 or lo[i] == hi[i]:
            continue
        now, was = value_of(i, x, here), held[i]
        t_low, t_high = tolerances(i, size, here)
        pulled = v[i] > hi[i] + CARRIES * t_high or v[i] < lo[i] - CARRIES * t_low or was != INACTIVE
        held[i] = INACTIVE
        if abs(now - hi[i]) <= t_high and (slope[i] > 0.0 or was == UPPER):
            held[i] = UPPER
        elif abs(now - lo[i]) <= t_low and (slope[i] < 0.0 or was == LOWER):
            held[i] = LOWER
        outside = now > hi[i] + CARRIES * t_high or now < lo[i] - CARRIES * t_low
        if outside != pulled and not (pulled and held[i] != INACTIVE):
            same = False
    return same
