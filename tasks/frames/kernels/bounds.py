r"""Bounds of the curvature of placement tasks along the axes of the world, at a fraction of its cost.

In a pair of joints (a, b) the form of :mod:`tasks.robots.kernels.curvature` is :math:`f \cdot (z_a \times J_b)` of
linear rows and :math:`g \cdot \tfrac12 (z_a \times z_b)` of angular ones. The Frobenius norm over all pairs is
therefore the root of a quadratic form of the weights, with the matrices

.. math:: F_p = \sum_{ab} (z_a \times J_b) (z_a \times J_b)^T, \qquad
    F_\omega = \tfrac14 \sum_{ab} (z_a \times z_b) (z_a \times z_b)^T .

The norm of the sum of both is at most the root of twice the sum of both squares. What a rotation vector e adds, being
longer than its square tells, is at most :math:`\beta |w|`, with :math:`\beta = c |e| \sum_b |z_b|^2` (c of
:mod:`.curvature`), and :math:`(\sqrt{w^T F w} + \beta |w|)^2 \le (1 + \epsilon) w^T F w + (1 + 1 / \epsilon) \beta^2
|w|^2`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, integer, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at
from ...robots.kernels import curvature as bend
from ...rows.kernels import law as of
from . import curvature as told_as

#: In the table of a curvature, the first entry is here F (rows, rows), which is written.
BOUND = 0
#: The epsilon above.
SHARE = 0.05


@inner
def outer(x, y, z):
    """The symmetric matrix c c' of c = (x, y, z), by its entries xx, yy, zz, xy, xz, yz."""
    return x * x, y * y, z * z, x * y, x * z, y * z


@inner
def plus(one, share, other):
    """A symmetric matrix, and a share of another one."""
    (a, b, c, d, e, f), (g, h, k, o, p, q) = one, other
    return a + share * g, b + share * h, c + share * k, d + share * o, e + share * p, f + share * q


@inner
def crossed(x, y, z, form):
    """The matrix C W C' of a symmetric matrix W, where C v = (x, y, z) x v."""
    xx, yy, zz, xy, xz, yz = form
    return (
        y * (y * zz - z * yz) - z * (y * yz - z * yy),
        z * (z * xx - x * xz) - x * (z * xz - x * zz),
        x * (x * yy - y * xy) - y * (x * xy - y * xx),
        z * (y * xz - z * xy) - x * (y * zz - z * yz),
        x * (y * yz - z * yy) - y * (y * xz - z * xy),
        x * (z * xy - x * yz) - y * (z * xx - x * xz),
    )


@inner
def form_of(frame, angular):
    """F_p, or 4 F_omega, by its entries.

    For each b the z_a that carry it count as one matrix, which is handed on from joint to joint: only the axes of one
    joint are met in pairs.
    """
    told = ints(frame, 0, bend.LENGTH)
    n, across, down, count = told[bend.N], told[bend.ACROSS], told[bend.DOWN], told[bend.JOINTS]
    z, sums = floats(told[bend.AXES], 0, (n - 1) * across + 2 * down + 1), floats(told[bend.SUMS], 0, 6 * count + 6)
    chain, velocities = ints(told[bend.CHAIN], 0, 3 * count), ints(told[bend.VELOCITIES], 0, n)
    J, along, apart = floats(told[bend.BLOCK], at.JACOBIAN, 3 * n), integer(1), n
    if angular:
        J, along, apart = z, across, down
    form = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for joint in range(count):
        i, begin, end = 6 * chain[3 * joint] + 6, chain[3 * joint + 1], chain[3 * joint + 2]
        above = sums[i], sums[i + 1], sums[i + 2], sums[i + 3], sums[i + 4], sums[i + 5]
        total = above
        for m in range(begin, end):
            i, j = velocities[m] * across, velocities[m] * along
            x, y, w, u, v, t = z[i], z[i + down], z[i + 2 * down], J[j], J[j + apart], J[j + 2 * apart]
            own = outer(x, y, w)
            total = plus(total, 1.0, own)
            form = plus(form, 1.0, crossed(u, v, t, plus(own, 2.0, above)))
            for o in range(end if angular else m + 1, end):  # half of both ways round, and twice its square
                i, j = velocities[o] * across, velocities[o] * along
                a, b, c, d, e, f = z[i], z[i + down], z[i + 2 * down], J[j], J[j + apart], J[j + 2 * apart]
                p, q, r = y * f - w * e + b * t - c * v, w * d - x * f + c * u - a * t, x * e - y * d + a * v - b * u
                form = plus(form, 0.5, outer(p, q, r))
        i = 6 * joint + 6
        sums[i], sums[i + 1], sums[i + 2], sums[i + 3], sums[i + 4], sums[i + 5] = total
    return form


@inner
def add_form(form, scale, half, first, mask, rows, F):
    """Add three coordinates of six, those from `half` on, times `scale`, to the rows that have them."""
    xx, yy, zz, xy, xz, yz = form
    for r in range(rows):
        a = first + mask[r] - half
        for s in range(rows):
            b = first + mask[s] - half
            if 0 <= a < 3 and 0 <= b < 3:
                own = (xx if a == 0 else yy if a == 1 else zz) if a == b else xy if a + b == 1 else xz
                F[rows * r + s] += scale * (yz if a + b == 3 else own)


@stamp
@entry
def bound_placement(here):
    """F of a position, orientation or pose task along the axes of the world, in the table of its curvature."""
    told = ints(here, 0, 9)
    law = ints(told[told_as.LAW], 0, of.LENGTH)
    rows, n, first = law[of.ROWS], law[of.N], told[told_as.FIRST]
    mask, error = ints(told[told_as.MASK], 0, rows), floats(law[of.MEASURED], 0, rows)
    F, seen = floats(told[BOUND], 0, rows * rows), ints(told[told_as.SEEN], 0, 3)
    for k in range(rows * rows):
        F[k] = 0.0
    linear, angular = 0, 0
    for r in range(rows):
        linear += first + mask[r] < 3
        angular += first + mask[r] >= 3
    scale = 2.0 if linear > 0 and angular > 0 else 1.0
    if linear > 0:
        add_form(form_of(seen[bend.FRAME], False), scale, 0, first, mask, rows, F)
    if angular == 0:
        return 0
    square, turned, axes = 0.0, 0.0, floats(seen[bend.SEEN], at.JACOBIAN + 3 * n, 3 * n)
    for r in range(rows):
        if first + mask[r] >= 3:
            square += error[r] * error[r]
    for k in range(3 * n):
        turned += axes[k] * axes[k]
    beta = told_as.longer(0.5 * math.sqrt(square)) * math.sqrt(square) * turned
    add_form(form_of(seen[bend.FRAME], True), 0.25 * scale * (1.0 + SHARE), 3, first, mask, rows, F)
    for r in range(rows):
        if first + mask[r] >= 3:
            F[(rows + 1) * r] += scale * (1.0 + 1.0 / SHARE) * beta * beta
    return 0
