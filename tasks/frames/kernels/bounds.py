r"""Bounds of the curvature of placement tasks along the axes of the world, at a fraction of its cost.

In a pair of joints (a, b) the form of :mod:`tasks.robots.kernels.curvature` is :math:`c_{ab} \cdot (f, g)` with
:math:`c_{ab} = (z_a \times J_b, \tfrac12 z_a \times z_b)`. Its Frobenius norm over all pairs is therefore the root
of a quadratic form of the weights, with the matrix

.. math:: F = \sum_{ab} c_{ab} c_{ab}^T .

What a rotation vector e adds, being longer than its square tells, is at most :math:`\beta |w|`, with :math:`\beta = c
|e| \sum_b |z_b|^2` (c of :mod:`.curvature`), and :math:`(\sqrt{w^T F w} + \beta |w|)^2 \le
(1 + \epsilon) w^T F w + (1 + 1 / \epsilon) \beta^2 |w|^2`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at
from ...robots.kernels import curvature as bend
from ...rows.kernels import law as of
from . import curvature as told_as

#: Of the table of a curvature, the first entry: F (rows, rows), which is written.
BOUND = 0
#: The epsilon above.
SHARE = 0.05


@inner
def add_pairs(frame, first, mask, rows, c, F):
    """Add F of all pairs of joints, for rows along the coordinates ``first + mask`` of six; `c` (6,) is work space."""
    told = ints(frame, 0, bend.LENGTH)
    n, across, down = told[bend.N], told[bend.ACROSS], told[bend.DOWN]
    J = floats(told[bend.BLOCK], at.JACOBIAN, 3 * n)
    z = floats(told[bend.AXES], 0, (n - 1) * across + 2 * down + 1)
    pairs = ints(told[bend.PAIRS], 0, 3 * told[bend.COUNT])
    for k in range(told[bend.COUNT]):
        a, b, one = pairs[3 * k], pairs[3 * k + 1], pairs[3 * k + 2] != 0
        i, j = a * across, b * across
        x, y, w = z[i], z[i + down], z[i + 2 * down]
        p, q, r = z[j], z[j + down], z[j + 2 * down]
        u, v, t = J[b], J[n + b], J[2 * n + b]
        c[0], c[1], c[2] = y * t - w * v, w * u - x * t, x * v - y * u
        c[3], c[4], c[5] = 0.5 * (y * r - w * q), 0.5 * (w * p - x * r), 0.5 * (x * q - y * p)
        if one:
            u, v, t = J[a], J[n + a], J[2 * n + a]
            c[0], c[1], c[2] = (
                0.5 * (c[0] + q * t - r * v),
                0.5 * (c[1] + r * u - p * t),
                0.5 * (c[2] + p * v - q * u),
            )
            c[3] = c[4] = c[5] = 0.0
        twice = 1.0 if a == b else 2.0
        for s in range(rows):
            own = twice * c[first + mask[s]]
            for other in range(rows):
                F[rows * s + other] += own * c[first + mask[other]]


@stamp
@entry
def bound_placement(here):
    """F of a position, orientation or pose task along the axes of the world, in the table of its curvature."""
    told = ints(here, 0, 9)
    law = ints(told[told_as.LAW], 0, of.LENGTH)
    rows, n, first = law[of.ROWS], law[of.N], told[told_as.FIRST]
    work, mask = floats(told[told_as.WORK], 0, told_as.WORK_SIZE), ints(told[told_as.MASK], 0, rows)
    error, F = floats(law[of.MEASURED], 0, rows), floats(told[BOUND], 0, rows * rows)
    for k in range(rows * rows):
        F[k] = 0.0
    seen = ints(told[told_as.SEEN], 0, 3)
    add_pairs(seen[bend.FRAME], first, mask, rows, work, F)
    if told[told_as.ANGULAR] == 0:
        return 0
    square, axes = 0.0, floats(seen[bend.SEEN], at.JACOBIAN + 3 * n, 3 * n)
    for r in range(rows):
        if first + mask[r] >= 3:
            square += error[r] * error[r]
    beta = 0.0
    for k in range(3 * n):
        beta += axes[k] * axes[k]
    beta *= told_as.longer(0.5 * math.sqrt(square)) * math.sqrt(square)
    for k in range(rows * rows):
        F[k] *= 1.0 + SHARE
    for r in range(rows):
        F[(rows + 1) * r] += (1.0 + 1.0 / SHARE) * beta * beta
    return 0
