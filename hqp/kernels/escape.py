"""Leaves a degenerate vertex, where every step of the active-set method has length zero."""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .memory import ints, marks, matrix, vector
from .orthogonal import length, project
from .pull import DUAL
from .rows import LOWER, UPPER, value_of
from .working_set import HARD, WORKING, append, balance, remove

#: A row blocks a direction if the direction violates it by more than the first share of both lengths; and it counts as
#: dependent if projection leaves no more than the second share of its length.
LEAVES, DEPENDENT = 1e-9, 1e-13
#: So many steps in a row that shorten the residual by less than this share are the end: what is left is round-off.
IDLE, GAINS = 8, 1e-9


@inner
def escape(here, forces, frozen, working, hard_end):
    """Find a descent direction ``d`` that no hard row at its bound blocks: the residual of :func:`nonnegative`.

    If there is none, x is optimal and ``d`` is zero. The rows with positive multipliers are the new working set.
    `forces` are those of the level, `hard_end` is the end of the levels above.

    Returns
    -------
    working : int
        Rows of the new working set.
    """
    n, d = ints(here, 0, at.HEAD)[at.N], vector(here, at.D)
    pivot, kind = marks(here, at.PIVOT), marks(here, at.KIND)
    for q in range(frozen, frozen + working):
        kind[pivot[q]] = HARD
    working, steep, stuck = nonnegative(here, DUAL * forces, LEAVES, frozen, integer(0), hard_end)
    if stuck or steep <= DUAL * forces:
        for j in range(n):
            d[j] = 0.0
    return working


@inner
def nonnegative(here, enough, leaves, frozen, working, hard_end):
    """Minimise ``||g + sum mu_i s_i a_i||``, mu >= 0, over the hard rows at a bound (Lawson and Hanson 1974).

    s_i is 1 at the upper bound and -1 at the lower one; all vectors are projected onto the null space of the frozen
    rows. It starts from a working set with positive multipliers ``share``. ``d`` is minus the residual. Only the rows
    before `hard_end` take part, and only those that d would violate by more than the share `leaves` of both lengths.

    Returns
    -------
    working : int
        Rows with a positive multiplier.
    steep : float
        The length of d; the iteration ends when it is at most `enough`.
    stuck : bool
        Whether it ended because a row that blocks d depends on the working set: nothing can be gained.
    """
    n, v, d = ints(here, 0, at.HEAD)[at.N], vector(here, at.VALUE), vector(here, at.D)
    kind, side, norm = marks(here, at.KIND), marks(here, at.SIDE), vector(here, at.NORM)
    low, high, allowed = vector(here, at.LOW), vector(here, at.HIGH), vector(here, at.ALLOWED)
    share, V = vector(here, at.SHARE), matrix(here, at.V)
    steep, fresh = residual(here, frozen + working), True
    lowest, idle = math.inf, integer(0)
    for _ in range(3 * hard_end + 10):
        c = frozen + working
        lowest, idle = min(steep, lowest), integer(0) if steep < (1.0 - GAINS) * lowest else idle + 1
        if idle > IDLE:
            break
        worst, enters, bound = leaves * steep, integer(-1), integer(0)
        for i in range(hard_end if steep > enough else 0):
            if kind[i] != HARD or norm[i] == 0.0:
                continue
            where = 0
            if v[i] >= high[i] - 10.0 * allowed[i]:
                where = UPPER
            if v[i] <= low[i] + 10.0 * allowed[i]:
                where = LOWER if where == 0 or value_of(i, d, here) < 0.0 else UPPER
            if where == 0:
                continue
            outward = where * value_of(i, d, here) / norm[i]
            if outward > worst:
                worst, enters, bound = outward, i, where
        if enters < 0:
            if fresh:
                return working, steep, False
            steep, fresh = residual(here, c), True  # what the steps below have left out may be round-off
            continue
        if not append(enters, c, here, DEPENDENT):
            if fresh:
                return working, steep, True
            steep, fresh = residual(here, c), True
            continue
        kind[enters], side[enters] = WORKING, bound
        share[c] = 0.0
        kept = step_back(here, frozen, working + 1)
        if kept == working + 1:  # d less its part along the direction that the row has added
            direction, along = V[c], 0.0
            for j in range(n):
                along += direction[j] * d[j]
            for j in range(n):
                d[j] -= along * direction[j]
            steep, fresh = length(d, n), False
        else:
            steep, fresh = residual(here, frozen + kept), True
        working = kept
    return working, residual(here, frozen + working), False


@inner
def residual(here, c):
    """Write ``d`` = -g, projected onto the null space of V[:c]; returns its length."""
    d, g = vector(here, at.D), vector(here, at.G)
    for j in range(len(d)):
        d[j] = -g[j]
    return clear(here, d, c)


@inner
def clear(here, d, c):
    """Project d (n,) onto the null space of V[:c], twice; returns its length."""
    n, scratch, V = ints(here, 0, at.HEAD)[at.N], vector(here, at.SCRATCH), matrix(here, at.V)
    for q in range(c):
        scratch[q] = 0.0
    project(d, n, V, integer(0), c, scratch)
    project(d, n, V, integer(0), c, scratch)
    return length(d, n)


@inner
def step_back(here, frozen, working):
    """Move ``share`` towards the least-squares multipliers, until one reaches zero; its row leaves the working set.

    Repeated until all least-squares multipliers are positive. Returns how many rows the working set then has.
    """
    pivot, kind, side = marks(here, at.PIVOT), marks(here, at.KIND), marks(here, at.SIDE)
    share, multiplier = vector(here, at.SHARE), vector(here, at.MULTIPLIER)
    while working > 0:
        c = frozen + working
        balance(vector(here, at.G), frozen, c, here)
        reach, leaves = 1.0, integer(-1)
        for q in range(frozen, c):
            wanted = multiplier[q] * side[pivot[q]]
            if wanted <= 0.0 and q != c - 1:
                ratio = share[q] / (share[q] - wanted) if share[q] > wanted else 0.0
                if ratio < reach:
                    reach, leaves = ratio, q
        for q in range(frozen, c):
            share[q] += reach * (multiplier[q] * side[pivot[q]] - share[q])
        if leaves < 0:
            break
        kind[pivot[leaves]] = HARD
        for q in range(leaves, c - 1):
            share[q] = share[q + 1]
        remove(leaves, c, here)
        working -= 1
    return working
