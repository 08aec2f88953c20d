"""The way out of a degenerate vertex, where every step of the active set has length zero."""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .memory import ints, marks, matrix, vector
from .orthogonal import length, project
from .pull import DUAL
from .rows import LOWER, UPPER, value_of
from .working_set import HARD, WORKING, append, balance, remove


@inner
def escape(here, forces, frozen, working, hard_end):
    """A direction of descent that no row at its bound blocks, by non-negative least squares (Lawson, Hanson).

    Minimises ``||g + sum mu_i s_i a_i||``, mu >= 0, over the hard rows at a bound, s_i = 1 at the upper one, within
    what the frozen rows leave. Its residual, turned round, is the direction; the support is the new working set.
    `d` is zero if there is none: x is optimal.

    Returns
    -------
    working : int
    """
    head = ints(here, 0, at.HEAD)
    n = head[at.N]
    pivot, kind, side = marks(here, at.PIVOT), marks(here, at.KIND), marks(here, at.SIDE)
    norm, g, d, v = vector(here, at.NORM), vector(here, at.G), vector(here, at.D), vector(here, at.VALUE)
    low, high, allowed = vector(here, at.LOW), vector(here, at.HIGH), vector(here, at.ALLOWED)
    share, multiplier, scratch = vector(here, at.SHARE), vector(here, at.MULTIPLIER), vector(here, at.SCRATCH)
    V = matrix(here, at.V)
    for q in range(frozen, frozen + working):
        kind[pivot[q]] = HARD
    working = integer(0)
    for _ in range(3 * hard_end + 10):
        c = frozen + working
        for j in range(n):
            d[j] = -g[j]
        for q in range(c):
            scratch[q] = 0.0
        project(d, n, V, 0, c, scratch)
        project(d, n, V, 0, c, scratch)
        steep = length(d, n)
        if steep <= DUAL * forces:
            for j in range(n):
                d[j] = 0.0
            return working
        worst, enters, bound = 1e-9 * steep, integer(-1), integer(0)
        for i in range(hard_end):
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
            return working
        if not append(enters, c, here, 1e-13):
            for j in range(n):  # a row in the way that depends on those that are kept: nothing can be gained
                d[j] = 0.0
            return working
        kind[enters], side[enters] = WORKING, bound
        share[c] = 0.0
        working += 1
        while working > 0:  # back to where all shares are positive
            c = frozen + working
            balance(frozen, c, n, here)
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
