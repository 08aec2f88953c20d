r"""Rows of a wheel on a plane: the slip velocity of the contact point, and the distance of the wheel from the plane.

With the plane :math:`n \cdot x = h`, the hub at p and the radius r, the wheel touches the plane at :math:`p - r n`. The
point of the wheel that is there moves at

.. math:: s = \dot p + \omega \times d, \quad d = -r n, \qquad \dot s = J_s a + (\dot J_p v + \dot J_\omega v \times d).

A slip row is :math:`c \cdot s`, with error 0. For a wheel with an axle a, c turns with the wheel: it is the driving
direction, :math:`u = a \times n / \lVert a \times n \rVert`, rotated about n by a constant angle, and the drift
contains :math:`\dot c \cdot s`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at
from ...rows.kernels import law as of
from .directions import cross_into, dot

#: Table: the table of the law, the block of the hub, the wheel, the number of slip rows, and work space.
LAW, BLOCK, WHEEL, SLIPS, WORK = range(5)
#: Wheel: n; two vectors along which slip is forbidden; the axle in the frame of the hub; r and h [m]; cosine and sine
#: of the angle between u and c; and 1 if c depends on the axle.
NORMAL, FIRST, AXLE, RADIUS, FLOOR, COSINE, SINE, TURNS = 0, 3, 9, 12, 13, 14, 15, 16
WHEEL_SIZE = 17
#: Work space: c of both rows; their rates; d; s; the drift of the contact point; and two vectors.
ALONG, CHANGE, ARM, SLIP, DRIFT, ONE, OTHER = 0, 6, 12, 15, 18, 21, 24


@inner
def rolling_direction(wheel, block, work):
    """Write c of a wheel with an axle, and its rate, to work[ALONG:] and work[CHANGE:]; NaN if the axle is along n."""
    for k in range(3):
        row = block[at.ROTATION + 3 * k : at.ROTATION + 3 * k + 3]
        work[ONE + k] = row[0] * wheel[AXLE] + row[1] * wheel[AXLE + 1] + row[2] * wheel[AXLE + 2]
    cross_into(work, ONE, wheel, NORMAL, 1.0, work, OTHER)
    length = math.sqrt(dot(work, OTHER, work, OTHER))
    scale = 1.0 / length if length > 1e-9 else math.nan
    for k in range(3):
        work[ALONG + k] = scale * work[OTHER + k]
    # Its rate: u' = (a' x n - u (u . a' x n)) / |a x n|, with a' = omega x a.
    cross_into(block, at.ANGULAR_VELOCITY, work, ONE, 1.0, work, OTHER)
    cross_into(work, OTHER, wheel, NORMAL, scale, work, ONE)
    share = dot(work, ALONG, work, ONE)
    for k in range(3):
        work[CHANGE + k] = work[ONE + k] - share * work[ALONG + k]
    for first in (ALONG, CHANGE):  # rotate about n, to which both are perpendicular
        cross_into(wheel, NORMAL, work, first, wheel[SINE], work, ONE)
        for k in range(3):
            work[first + k] = wheel[COSINE] * work[first + k] + work[ONE + k]


@stamp
@entry
def write_rolling(here):
    """Write A and bounds of a wheel that rolls on a plane: no slip along one or two directions, and its height."""
    told = ints(here, 0, 5)
    law = ints(told[LAW], 0, of.LENGTH)
    rows, n, slips = law[of.ROWS], law[of.N], told[SLIPS]
    block, J = floats(told[BLOCK], 0, at.JACOBIAN), floats(told[BLOCK], at.JACOBIAN, 6 * n)
    wheel, work = floats(told[WHEEL], 0, WHEEL_SIZE), floats(told[WORK], 0, 64)
    measured, A = floats(law[of.MEASURED], 0, of.KINDS * rows), floats(law[of.MATRIX], 0, rows * n)
    for k in range(6):
        work[ALONG + k], work[CHANGE + k] = wheel[FIRST + k], 0.0
    if wheel[TURNS] != 0.0:
        rolling_direction(wheel, block, work)
    for k in range(3):
        work[ARM + k] = -wheel[RADIUS] * wheel[NORMAL + k]
    for j in range(n):
        for k in range(3):
            work[OTHER + k] = J[(3 + k) * n + j]
        cross_into(work, OTHER, work, ARM, 1.0, work, ONE)
        for k in range(3):
            work[ONE + k] += J[k * n + j]
        for r in range(slips):
            A[r * n + j] = dot(work, ALONG + 3 * r, work, ONE)
        A[slips * n + j] = dot(wheel, NORMAL, work, ONE)
    for r in range(slips):
        measured[r] = 0.0
    measured[slips] = wheel[FLOOR] + wheel[RADIUS] - dot(wheel, NORMAL, block, at.POSITION)
    for r in range(rows):
        measured[of.RATE * rows + r] = measured[of.CHANGE * rows + r] = 0.0
    if law[of.DRIFTS] != 0:
        cross_into(block, at.ANGULAR_VELOCITY, work, ARM, 1.0, work, SLIP)
        cross_into(block, at.ANGULAR_DRIFT, work, ARM, 1.0, work, DRIFT)
        for k in range(3):
            work[SLIP + k] += block[at.LINEAR_VELOCITY + k]
            work[DRIFT + k] += block[at.LINEAR_DRIFT + k]
        drift = of.DRIFT * rows
        for r in range(slips):
            measured[drift + r] = dot(work, ALONG + 3 * r, work, DRIFT) + dot(work, CHANGE + 3 * r, work, SLIP)
        measured[drift + slips] = dot(wheel, NORMAL, work, DRIFT)
        of.moving(told[LAW])
    of.law(told[LAW])
    return 0
