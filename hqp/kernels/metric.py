r"""The last level of :mod:`.levels` where its rows ask for single variables: the implicit last level in another metric.

Rows :math:`d_j (x_j - b_j)`, one for each asked variable, say :math:`\min \|S^{-1} (x - b)\|` with
:math:`s_j \propto 1 / d_j`: what the implicit last level, :math:`\min \|x - x_0\|`, says with S = I. So its rows need
be no members: with all other rows in the coordinates :math:`S^{-1} x`, what serves that level serves this one. x_E is
then the optimum without inequalities.

A variable that is not asked is eliminated first: the rows E of the frozen ones' span, with :math:`E_U = I`, tell how it
follows the others, :math:`\Delta x_U = -E \Delta x`. There must be such rows; then nothing is left to the level below.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .memory import ints, marks, matrix, vector
from .orthogonal import CANCELLED, length, padded, project
from .rows import EQUALITY, copy_row, target, value_of

#: The least part of its length that reflections must leave of a column of V for a variable that is not asked.
FOLLOWS = 1e-3


@inner
def change_metric(here, k, frozen):
    """Enter the metric of level k: V becomes an orthonormal basis in it, and x_E the optimum without inequalities.

    The rows of V until then are kept behind those of P, for :func:`put_back`.

    Returns
    -------
    frozen : int
        Rows of V that span the frozen rows now; -1, with V as it was, if a variable that is not asked does not clearly
        follow the others.
    """
    head = ints(here, 0, at.HEAD)
    n, m, ptr = head[at.N], head[at.ROWS], marks(here, at.PTR)
    asks, side, depth = marks(here, at.ASKS), marks(here, at.SIDE), marks(here, at.DEPTH)
    lo, norm, anchor = vector(here, at.LO), vector(here, at.NORM), vector(here, at.ANCHOR)
    scale, gap, scratch = vector(here, at.SCALE), vector(here, at.MOVED), vector(here, at.SCRATCH)
    V, P, wide = matrix(here, at.V), matrix(here, at.P), padded(n)
    for q in range(frozen):
        row, kept = V[q], P[m + q]
        for j in range(n):
            kept[j] = row[j]
    u = eliminate(here, frozen)
    if u < 0:  # V as it was: its rows of fixed variables are unit vectors, which keep these exactly where they are
        for q in range(frozen):
            row, kept = V[q], P[m + q]
            for j in range(n):
                row[j] = kept[j]
        return integer(-1)
    even = True
    for j in range(n):
        even = even and (asks[j] < 0 or scale[j] == 1.0)
    for q in range(u, frozen):
        row, source = V[q - u], V[q]
        for j in range(n):
            row[j] = scale[j] * source[j] if asks[j] >= 0 else 0.0
        before, left = 1.0, 1.0
        for _ in range(0 if even else 3):  # reflections keep rows orthonormal, equal weights do, too
            project(row, wide, V, integer(0), q - u, scratch)
            left = length(row, wide)
            if left > CANCELLED * before:
                break
            before = left
        for j in range(n):
            row[j] /= left
    for j in range(n):
        i = asks[j]
        gap[j] = (lo[i] / norm[i] - anchor[j]) / scale[j] if i >= 0 else 0.0
    for j in range(n, wide):
        gap[j] = 0.0
    for _ in range(2):  # what the first leaves is round-off of the whole gap, not of the part that is left
        project(gap, wide, V, integer(0), frozen - u, scratch)
    head[at.METRIC] = u + 1
    displace(here, anchor)
    for i in range(m):
        depth[i] = -1
    for i in range(ptr[k], ptr[k + 1]):
        side[i] = EQUALITY
    return frozen - u


@inner
def put_back(here, frozen, rank):
    """Take away the round-off that the metric has magnified, where weights differ; `frozen` is as of change_metric.

    x moves to the nearest point at which the frozen rows have their values, those of ``exact``. If it is at bounds, of
    the `rank` pivot rows behind V[:frozen], it moves there by one step of iterative refinement, which the metric
    magnifies less, and back once more.
    """
    return_to_frozen(here, frozen)
    if rank > 0:
        return_to_bounds(here, frozen, rank)
        return_to_frozen(here, frozen)


@inner
def return_to_frozen(here, frozen):
    """Move x to the nearest point at which the frozen rows have their values, in the metric of x itself."""
    head = ints(here, 0, at.HEAD)
    n, m, c = head[at.N], head[at.ROWS], frozen + head[at.METRIC] - 1
    x, exact, P = vector(here, at.X), vector(here, at.EXACT), matrix(here, at.P)
    for q in range(c):
        row, off = P[m + q], 0.0
        for j in range(n):
            off += row[j] * (exact[j] - x[j])
        for j in range(n):
            x[j] += off * row[j]


@inner
def return_to_bounds(here, frozen, rank):
    """Refine x where the `rank` pivot rows behind V[:frozen] are off their bounds, in the metric of the level."""
    n = ints(here, 0, at.HEAD)[at.N]
    pivot, side, lo, hi = marks(here, at.PIVOT), marks(here, at.SIDE), vector(here, at.LO), vector(here, at.HI)
    x, moved, more = vector(here, at.X), vector(here, at.MOVED), vector(here, at.G)
    V, L = matrix(here, at.V), matrix(here, at.L)
    for j in range(n):
        moved[j] = 0.0
    for r in range(rank):
        i = pivot[frozen + r]
        row, direction, total = L[i], V[frozen + r], target(side[i], lo[i], hi[i]) - value_of(i, x, here)
        for q in range(r):
            total -= row[frozen + q] * more[q]
        more[r] = total / row[frozen + r]
        for j in range(n):
            moved[j] += more[r] * direction[j]
    displace(here, x)


@inner
def eliminate(here, frozen):
    """Write the rows E to H, one for each variable that is not asked; returns how many, or -1 if there are none such.

    Reflections of the rows V[:frozen] make the columns of these variables a triangle.
    """
    n, asks, others = ints(here, 0, at.HEAD)[at.N], marks(here, at.ASKS), marks(here, at.QUEUE)
    V, E, work, wide = matrix(here, at.V), matrix(here, at.H), vector(here, at.SCRATCH), padded(n)
    u = integer(0)
    for t in range(n):
        if asks[t] >= 0:
            continue
        if u == frozen:
            return integer(-1)
        total = 0.0
        for q in range(u, frozen):
            total += V[q][t] * V[q][t]
        size = math.sqrt(total)
        if size < FOLLOWS:
            return integer(-1)
        if V[u][t] > 0.0:
            size = -size
        first = V[u][t] - size
        V[u][t] = first  # column t is the vector of the reflection now
        for j in range(wide):
            work[j] = 0.0
        for q in range(u, frozen):
            row, part = V[q], V[q][t]
            for j in range(wide):
                work[j] += part * row[j]
        by = -1.0 / (size * first)
        for q in range(u, frozen):
            row, part = V[q], by * V[q][t]
            for j in range(wide):
                row[j] -= part * work[j]
            row[t] = 0.0
        V[u][t] = size
        others[u] = t
        u += 1
    for a in range(u - 1, -1, -1):
        row, own, by = V[a], E[a], 1.0 / V[a][others[a]]
        for j in range(n):
            own[j] = by * row[j]
        for b in range(a + 1, u):
            below, much = E[b], own[others[b]]
            for j in range(n):
                own[j] -= much * below[j]
            own[others[b]] = 0.0
        own[others[a]] = 1.0
    return u


@inner
def convert(i, out, here):
    """As :func:`.rows.copy_row`, in the coordinates of the metric: variables that are not asked are left out."""
    head = ints(here, 0, at.HEAD)
    n, u = head[at.N], head[at.METRIC] - 1
    others, scale, E = marks(here, at.QUEUE), vector(here, at.SCALE), matrix(here, at.H)
    copy_row(i, out, here)
    for a in range(u):
        row, much = E[a], out[others[a]]
        if much != 0.0:
            for j in range(n):
                out[j] -= much * row[j]
            out[others[a]] = 0.0
    for j in range(n):
        out[j] *= scale[j]


@inner
def displace(here, x):
    """Add to x the displacement ``moved``, which is in the coordinates of the metric."""
    head = ints(here, 0, at.HEAD)
    n, u = head[at.N], head[at.METRIC] - 1
    moved, scale, step = vector(here, at.MOVED), vector(here, at.SCALE), vector(here, at.SCRATCH)
    others, E = marks(here, at.QUEUE), matrix(here, at.H)
    for j in range(n):
        step[j] = scale[j] * moved[j]
        x[j] += step[j]
    for a in range(u):
        row, total = E[a], 0.0
        for j in range(n):
            total += row[j] * step[j]
        x[others[a]] -= total


@inner
def pull_in_metric(here, size):
    """Write the gradient ``g`` of the level in its metric; returns the sum of its forces, and whether it is met.

    `size` is the length of x.
    """
    n, tol, asks = ints(here, 0, at.HEAD)[at.N], vector(here, at.OPTION)[at.TOL], marks(here, at.ASKS)
    lo, norm, x = vector(here, at.LO), vector(here, at.NORM), vector(here, at.X)
    g, scale, pull, met = vector(here, at.G), vector(here, at.SCALE), 0.0, True
    for j in range(n):
        i, g[j] = asks[j], 0.0
        if i >= 0:
            goal = lo[i] / norm[i]
            g[j] = (x[j] - goal) / scale[j]
            pull += abs(g[j]) / scale[j]
            met = met and abs(x[j] - goal) <= tol * (abs(goal) + size)
    return pull, met
