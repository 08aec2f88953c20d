r"""The multipliers by which the rows above balance a level, for whoever reads the certificate.

Those of signed rows are known. Those of free rows, of which some may depend on others, are the shortest that balance
the rest, in units of unit normals: with the coefficients C of these normals along V, and the coefficients b of the
force along V,

.. math:: \lambda = -C z, \qquad C^T C z = b.

It is solved by conjugate gradients, with the triangle T of the pivot rows as preconditioner: :math:`T^{-T} C^T C
T^{-1}` is the identity but for the rows that depend on these.
"""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner
from .memory import ints, marks, matrix, vector
from .orthogonal import length
from .rows import LOWER, UPPER, copy_row
from .working_set import FROZEN

#: Conjugate gradients end at this relative residual, or after two steps for each unknown.
SETTLED = 1e-14


@inner
def tell(here, k, base, working, scale, left):
    """Write what is found of level k to ``verdict``, and the multipliers of all rows above, unweighted, to ``held_by``.

    V[:base] spans the rows that are taken for free, `working` rows follow, with multipliers ``share``; `scale` is the
    sum of the forces of the level, `left` the share of them that nothing balances.
    """
    ptr, pivot, side, weights = (
        marks(here, at.PTR),
        marks(here, at.PIVOT),
        marks(here, at.SIDE),
        vector(here, at.WEIGHTS),
    )
    share, where, slack, room = (
        vector(here, at.SHARE),
        marks(here, at.HELD),
        vector(here, at.W),
        vector(here, at.LAMBDA),
    )
    mine, told = matrix(here, at.HELD_BY)[k], matrix(here, at.VERDICT)[k]
    for i in range(ptr[k]):
        mine[i] = 0.0
    if scale != 0.0:
        for q in range(base, base + working):
            mine[pivot[q]] = share[q] * side[pivot[q]]
        if base > 0:
            balance_free(here, k, base)
    gives = 0.0
    for i in range(ptr[k]):
        mine[i] *= scale
        if where[i] == UPPER or where[i] == LOWER:
            gives += abs(mine[i]) * (abs(slack[i]) + room[i])
        mine[i] *= weights[i]
    told[at.TOTAL], told[at.UNBALANCED], told[at.GIVES] = scale, left, gives
    told[at.RESIDUAL], told[at.REACH] = residual_of(here, k)


@inner
def residual_of(here, k):
    """The length of the weighted slacks of level k, and the largest distance of x from one of its rows."""
    head, ptr, slack, norm = ints(here, 0, at.HEAD), marks(here, at.PTR), vector(here, at.W), vector(here, at.NORM)
    square, reach = 0.0, 0.0
    if k == head[at.LEVELS]:
        x, x_ref = vector(here, at.X), vector(here, at.X_REF)
        for j in range(head[at.N]):
            square += (x[j] - x_ref[j]) ** 2
        return math.sqrt(square), reach
    for i in range(ptr[k], ptr[k + 1]):
        square += slack[i] * slack[i]
        if norm[i] > 0.0:
            reach = max(reach, abs(slack[i]) / norm[i])
    return math.sqrt(square), reach


@inner
def balance_free(here, k, base):
    """Add the multipliers of the free rows above level k, those of kind FROZEN, to ``held_by``; V[:base] spans them."""
    n, end = ints(here, 0, at.HEAD)[at.N], marks(here, at.PTR)[k]
    kind, norm, g, V = marks(here, at.KIND), vector(here, at.NORM), vector(here, at.G), matrix(here, at.V)
    mine, row, force = matrix(here, at.HELD_BY)[k], vector(here, at.SCRATCH), vector(here, at.D)
    rest, way, found = vector(here, at.ANCHOR), vector(here, at.EXACT), vector(here, at.APPROACH)
    for j in range(n):
        force[j] = g[j]
    for i in range(end):
        if mine[i] != 0.0:
            copy_row(i, row, here)
            for j in range(n):
                force[j] += mine[i] * row[j]
    for q in range(base):
        direction, total = V[q], 0.0
        for j in range(n):
            total += direction[j] * force[j]
        rest[q] = total
    solve_transposed(here, base, rest)
    size, square = length(rest, base), 0.0
    for q in range(base):
        way[q], found[q] = rest[q], 0.0
        square += rest[q] * rest[q]
    for _ in range(2 * base + 2):
        if not math.sqrt(square) > SETTLED * size:
            break
        steep = dependent(here, end, base, way)
        reach = square / steep
        image, before, square = vector(here, at.SCRATCH), square, 0.0
        for q in range(base):
            found[q] += reach * way[q]
            rest[q] -= reach * image[q]
            square += rest[q] * rest[q]
        for q in range(base):
            way[q] = rest[q] + square / before * way[q]
    solve_triangle(here, base, found)
    L = matrix(here, at.L)
    for i in range(end):
        if kind[i] == FROZEN and norm[i] > 0.0:
            total, own = 0.0, L[i]
            for q in range(base):
                total += own[q] * found[q]
            mine[i] = -total / (norm[i] * norm[i])


@inner
def dependent(here, end, base, way):
    """Write the image of `way` under the preconditioned :math:`C^T C` to ``scratch``; returns ``way . image``."""
    kind, norm, pivot, chosen = (
        marks(here, at.KIND),
        vector(here, at.NORM),
        marks(here, at.PIVOT),
        vector(here, at.VALUE),
    )
    z, image, L = vector(here, at.MULTIPLIER), vector(here, at.SCRATCH), matrix(here, at.L)
    for q in range(base):
        z[q], image[q] = way[q], 0.0
    solve_triangle(here, base, z)
    for i in range(end):
        chosen[i] = 1.0 if kind[i] == FROZEN and norm[i] > 0.0 else 0.0
    for q in range(base):
        chosen[pivot[q]] = 0.0
    for i in range(end):
        if chosen[i] != 0.0:
            row, total = L[i], 0.0
            for q in range(base):
                total += row[q] * z[q]
            total /= norm[i] * norm[i]
            for q in range(base):
                image[q] += total * row[q]
    solve_transposed(here, base, image)
    steep = 0.0
    for q in range(base):
        image[q] += way[q]
        steep += image[q] * way[q]
    return steep


@inner
def solve_triangle(here, base, y):
    """Solve ``T z = y`` in place, with the triangle T of the unit pivot rows of V[:base]."""
    pivot, norm, L = marks(here, at.PIVOT), vector(here, at.NORM), matrix(here, at.L)
    for q in range(base):
        row, total = L[pivot[q]], y[q] * norm[pivot[q]]
        for p in range(q):
            total -= row[p] * y[p]
        y[q] = total / row[q]


@inner
def solve_transposed(here, base, y):
    """Solve ``T' z = y`` in place."""
    pivot, norm, L = marks(here, at.PIVOT), vector(here, at.NORM), matrix(here, at.L)
    for q in range(base - 1, -1, -1):
        row, size = L[pivot[q]], norm[pivot[q]]
        y[q] *= size / row[q]
        for p in range(q):
            y[p] -= row[p] / size * y[q]
