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

from hqp.kernels.compile import entry, inner, stamp
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
def linear_pairs(frame):
    """F_p: its entries xx, yy, zz, xy, xz, yz."""
    told = ints(frame, 0, bend.LENGTH)
    n, across, down = told[bend.N], told[bend.ACROSS], told[bend.DOWN]
    J = floats(told[bend.BLOCK], at.JACOBIAN, 3 * n)
    z = floats(told[bend.AXES], 0, (n - 1) * across + 2 * down + 1)
    pairs = ints(told[bend.PAIRS], 0, 3 * told[bend.COUNT])
    xx = yy = zz = xy = xz = yz = 0.0
    for k in range(told[bend.COUNT]):
        a, b, one = pairs[3 * k], pairs[3 * k + 1], pairs[3 * k + 2] != 0
        i, twice = a * across, 1.0 if a == b else 2.0
        x, y, w, u, v, t = z[i], z[i + down], z[i + 2 * down], J[b], J[n + b], J[2 * n + b]
        p, q, r = y * t - w * v, w * u - x * t, x * v - y * u
        if one:  # half of both ways round
            j = b * across
            x, y, w, u, v, t = z[j], z[j + down], z[j + 2 * down], J[a], J[n + a], J[2 * n + a]
            p, q, r = 0.5 * (p + y * t - w * v), 0.5 * (q + w * u - x * t), 0.5 * (r + x * v - y * u)
        xx += twice * p * p
        yy += twice * q * q
        zz += twice * r * r
        xy += twice * p * q
        xz += twice * p * r
        yz += twice * q * r
    return xx, yy, zz, xy, xz, yz


@inner
def angular_pairs(frame):
    """F_omega, likewise: nothing of axes of one joint."""
    told = ints(frame, 0, bend.LENGTH)
    n, across, down = told[bend.N], told[bend.ACROSS], told[bend.DOWN]
    z = floats(told[bend.AXES], 0, (n - 1) * across + 2 * down + 1)
    pairs = ints(told[bend.PAIRS], 0, 3 * told[bend.COUNT])
    xx = yy = zz = xy = xz = yz = 0.0
    for k in range(told[bend.COUNT]):
        if pairs[3 * k + 2] != 0:
            continue
        i, j = pairs[3 * k] * across, pairs[3 * k + 1] * across
        x, y, w, u, v, t = z[i], z[i + down], z[i + 2 * down], z[j], z[j + down], z[j + 2 * down]
        p, q, r = y * t - w * v, w * u - x * t, x * v - y * u
        xx += p * p
        yy += q * q
        zz += r * r
        xy += p * q
        xz += p * r
        yz += q * r
    return 0.5 * xx, 0.5 * yy, 0.5 * zz, 0.5 * xy, 0.5 * xz, 0.5 * yz  # a quarter, and every pair twice


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
        add_form(linear_pairs(seen[bend.FRAME]), scale, 0, first, mask, rows, F)
    if angular == 0:
        return 0
    square, turned, axes = 0.0, 0.0, floats(seen[bend.SEEN], at.JACOBIAN + 3 * n, 3 * n)
    for r in range(rows):
        if first + mask[r] >= 3:
            square += error[r] * error[r]
    for k in range(3 * n):
        turned += axes[k] * axes[k]
    beta = told_as.longer(0.5 * math.sqrt(square)) * math.sqrt(square) * turned
    add_form(angular_pairs(seen[bend.FRAME]), scale * (1.0 + SHARE), 3, first, mask, rows, F)
    for r in range(rows):
        if first + mask[r] >= 3:
            F[(rows + 1) * r] += scale * (1.0 + 1.0 / SHARE) * beta * beta
    return 0
