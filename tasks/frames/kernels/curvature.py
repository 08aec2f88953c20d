r"""Curvatures of tasks of a frame, contracted with a weight for every row; see :mod:`tasks.rows.curvature`.

*Placement.* Let u and w be the weights of the linear and the angular rows along the axes of the world, and Q the
projection of a vector onto those coordinates that are not rows of the task (Q = 0 if all three are):

.. math::

    \text{world:}\quad & u \cdot \ddot p + w \cdot (\dot\omega - Q\omega \times \omega) \\
    \text{local:}\quad & u \cdot (\ddot p + 2\, Q\dot p \times \omega) + w \cdot (\dot\omega + Q\omega \times \omega)

and for spatial rows, with :math:`\nu = \dot p + p \times \omega`, and P the projection onto the task's linear rows,

.. math:: u \cdot (\ddot p + 2 \dot p \times \omega + p \times \dot\omega) + w \cdot (\dot\omega - Q\omega \times \omega
    + 2 P\nu \times \dot p + \omega \times (p \times P\nu)) .

If all three angular rows are in the task, a large error e, a rotation vector of the angle :math:`\vartheta`, adds
:math:`c\, w \cdot (\omega \times (e \times \omega))`, :math:`c = (1 - \tfrac\vartheta2 \cot \tfrac\vartheta2) /
\vartheta^2`.

*Directions.* The axis a turns at :math:`W = \omega + d \times \dot p / \rho` relative to the direction d to the target,
which itself turns at :math:`\nu = -d \times \dot p / \rho`. If d is given, both are without the terms in
:math:`1 / \rho`. Then

.. math:: w \cdot \bigl( \dot\omega + d \times \ddot p / \rho + 2 (d \cdot \dot p) (d \times \dot p) / \rho^2
    + W \times \nu + (a \cdot W)\, a \times W + c\, W \times (e \times W_\perp) \bigr), \qquad
    c = (1 - \vartheta \cot \vartheta) / \vartheta^2 .
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at
from ...robots.kernels import curvature as bend
from ...rows.kernels import law as of
from . import placement as frames
from .directions import NEAR, PARALLEL, dot

#: Table of every task: weights of the rows; the sum (n, n) to which the curvature is added; the table SEEN of
#: :mod:`tasks.robots.kernels.curvature`; work space.
WEIGHTS, SUM, SEEN, WORK = range(4)
#: Table of a placement task, after that: the table of its law, its axes, whether rotation counts, the place of its
#: first coordinate among the six, and its coordinates.
LAW, AXES, ANGULAR, FIRST, MASK = range(4, 9)
#: Table of a direction, after LAW: the target, a and U by rows, and whether the target is a point.
TARGET, AXIS, POINT = range(5, 8)
#: Table of a plane, after WORK: its normal.
NORMAL = 4
#: Work space, after that of :mod:`tasks.robots.kernels.curvature`, (6,) each: the weights along the axes of the task;
#: 1 for coordinates that the task has; its error.
GIVEN, CHOSEN, ERROR = 160, 166, 172
WORK_SIZE = 178
#: Below this angle [rad] a series is more accurate than the quotient.
SMALL = 1e-3


@inner
def along_world(axes, block, work, given, out):
    """Rotate both halves of work[given:given + 6] from the task's axes to those of the world, to work[out:out + 6]."""
    for h in range(0, 6, 3):
        x, y, z = work[given + h], work[given + h + 1], work[given + h + 2]
        if axes == frames.LOCAL:
            x, y, z = bend.turned(block[at.ROTATION : at.ROTATION + 9], x, y, z)
        work[out + h], work[out + h + 1], work[out + h + 2] = x, y, z


@inner
def left_free(axes, block, work, half, part, out):
    """Write the map y -> Q y[part:part + 3] to work[out:]: the projection onto coordinates without a row of the task.

    The coordinates are those from `half` on, 0 for linear and 3 for angular ones.
    """
    bend.no_map(work, out)
    for k in range(3):
        if work[CHOSEN + half + k] != 0.0:
            continue
        if axes != frames.LOCAL:
            work[out + bend.Y * k + part + k] = 1.0
            continue
        for r in range(3):
            for c in range(3):
                own = block[at.ROTATION + 3 * r + k] * block[at.ROTATION + 3 * c + k]
                work[out + bend.Y * r + part + c] += own


@inner
def spatial_curvature(p0, p1, p2, work):
    """Add the terms of spatial rows, of a frame at p, to K and to the angular weights."""
    u0, u1, u2 = work[bend.F], work[bend.F + 1], work[bend.F + 2]
    w0, w1, w2 = work[bend.G], work[bend.G + 1], work[bend.G + 2]
    bend.no_map(work, bend.ONE)
    bend.no_map(work, bend.OTHER)
    bend.add_part(work, bend.ONE, bend.LINEAR, 2.0)
    bend.add_part(work, bend.OTHER, bend.ANGULAR, 1.0)
    bend.add_form(work, u0, u1, u2, 1.0)
    # P nu, then p x P nu
    bend.no_map(work, bend.ONE)
    bend.add_part(work, bend.ONE, bend.LINEAR, 1.0)
    bend.add_cross(work, bend.ONE, p0, p1, p2, bend.ANGULAR, 1.0)
    for k in range(3):
        if work[CHOSEN + k] == 0.0:
            for c in range(bend.Y):
                work[bend.ONE + bend.Y * k + c] = 0.0
    bend.no_map(work, bend.OTHER)
    bend.add_part(work, bend.OTHER, bend.LINEAR, 2.0)
    bend.add_form(work, w0, w1, w2, 1.0)
    bend.crossed_map(work, bend.OTHER, p0, p1, p2, bend.ONE)
    bend.no_map(work, bend.ONE)
    bend.add_part(work, bend.ONE, bend.ANGULAR, 1.0)
    bend.add_form(work, w0, w1, w2, 1.0)
    work[bend.G] += u1 * p2 - u2 * p1  # u . (p x omega')
    work[bend.G + 1] += u2 * p0 - u0 * p2
    work[bend.G + 2] += u0 * p1 - u1 * p0


@inner
def turn_curvature(axes, block, work):
    """Add the terms of angular rows to K: those of Q if a coordinate is missing, else those of a large error."""
    w0, w1, w2 = work[bend.G], work[bend.G + 1], work[bend.G + 2]
    whole = work[CHOSEN + 3] + work[CHOSEN + 4] + work[CHOSEN + 5] == 3.0
    bend.no_map(work, bend.OTHER)
    if not whole:
        left_free(axes, block, work, 3, bend.ANGULAR, bend.ONE)
        bend.add_part(work, bend.OTHER, bend.ANGULAR, 1.0)
        bend.add_form(work, w0, w1, w2, 1.0 if axes == frames.LOCAL else -1.0)
        return
    along_world(axes, block, work, ERROR, ERROR)
    e0, e1, e2 = work[ERROR + 3], work[ERROR + 4], work[ERROR + 5]
    half = 0.5 * math.sqrt(e0 * e0 + e1 * e1 + e2 * e2)
    bend.no_map(work, bend.ONE)
    bend.add_part(work, bend.ONE, bend.ANGULAR, 1.0)
    bend.add_cross(work, bend.OTHER, e0, e1, e2, bend.ANGULAR, 1.0)
    bend.add_form(work, w0, w1, w2, longer(half))


@inner
def longer(half):
    """The c of a rotation vector of twice this length."""
    return (1.0 - half / math.tan(half)) / (4.0 * half * half) if half > SMALL else 1.0 / 12.0 + half * half / 180.0


@stamp
@entry
def placement_curvature(here):
    """Add the curvature of a position, orientation or pose task to SUM."""
    told = ints(here, 0, 9)
    law = ints(told[LAW], 0, of.LENGTH)
    rows, n, axes, first = law[of.ROWS], law[of.N], told[AXES], told[FIRST]
    work, mask = floats(told[WORK], 0, WORK_SIZE), ints(told[MASK], 0, rows)
    given, error = floats(told[WEIGHTS], 0, rows), floats(law[of.MEASURED], 0, rows)
    block = floats(ints(told[SEEN], 0, 3)[bend.SEEN], 0, at.JACOBIAN)
    for k in range(WORK_SIZE):
        work[k] = 0.0
    for r in range(rows):
        k = first + mask[r]
        work[GIVEN + k], work[CHOSEN + k], work[ERROR + k] = given[r], 1.0, error[r]
    along_world(axes, block, work, GIVEN, bend.F)
    if told[ANGULAR] != 0:
        turn_curvature(axes, block, work)
    if axes == frames.SPATIAL:
        spatial_curvature(block[0], block[1], block[2], work)
    elif axes == frames.LOCAL:
        left_free(axes, block, work, 0, bend.LINEAR, bend.ONE)
        bend.no_map(work, bend.OTHER)
        bend.add_part(work, bend.OTHER, bend.ANGULAR, 2.0)
        bend.add_form(work, work[bend.F], work[bend.F + 1], work[bend.F + 2], 1.0)
    bend.seen_curvature(told[SEEN], work, floats(told[SUM], 0, n * n))
    return 0


@inner
def direction_maps(x, y, z, share, work):
    """Write the map of W, and add the terms of a target point at the distance rho = 1 / share: f, and forms of K.

    (x, y, z) is the direction d to the point; the map of W is the second one.
    """
    w0, w1, w2 = work[bend.G], work[bend.G + 1], work[bend.G + 2]
    work[bend.F] = share * (w1 * z - w2 * y)
    work[bend.F + 1] = share * (w2 * x - w0 * z)
    work[bend.F + 2] = share * (w0 * y - w1 * x)
    bend.no_map(work, bend.ONE)  # d d . p'
    bend.add_outer(work, bend.ONE, x, y, z, bend.LINEAR)
    bend.no_map(work, bend.OTHER)
    bend.add_part(work, bend.OTHER, bend.LINEAR, 2.0 * share * share)
    bend.add_form(work, w0, w1, w2, 1.0)
    bend.no_map(work, bend.ONE)  # nu
    bend.add_cross(work, bend.ONE, x, y, z, bend.LINEAR, -share)
    bend.no_map(work, bend.OTHER)  # W
    bend.add_part(work, bend.OTHER, bend.ANGULAR, 1.0)
    bend.add_cross(work, bend.OTHER, x, y, z, bend.LINEAR, share)
    bend.add_form(work, w0, w1, w2, -1.0)  # W x nu


@inner
def axis_curvature(a, e, work):
    """Add the terms of the rotation about the axis itself, and of a large error, to K.

    The axis is work[a:a + 3], the error work[e:e + 3], and the second map is that of W.
    """
    w0, w1, w2 = work[bend.G], work[bend.G + 1], work[bend.G + 2]
    for c in range(bend.Y):
        spin = 0.0
        for r in range(3):
            spin += work[a + r] * work[bend.OTHER + bend.Y * r + c]
        for r in range(3):
            work[bend.ONE + bend.Y * r + c] = spin * work[a + r]
    bend.add_form(work, w0, w1, w2, 1.0)
    turn = math.sqrt(dot(work, e, work, e))
    longer = 1.0 / 3.0 + turn * turn / 45.0
    if turn > SMALL:
        longer = (1.0 - turn / math.tan(turn)) / (turn * turn) if math.pi - turn > PARALLEL else 0.0
    for k in range(3 * bend.Y):
        work[bend.OTHER + k] -= work[bend.ONE + k]
    bend.crossed_map(work, bend.ONE, work[e], work[e + 1], work[e + 2], bend.OTHER)
    bend.add_form(work, w0, w1, w2, -longer)


@stamp
@entry
def direction_curvature(here):
    """Add the curvature of a task that points an axis of a frame in a direction, or at a point, to SUM."""
    told = ints(here, 0, 8)
    law = ints(told[LAW], 0, of.LENGTH)
    n = law[of.N]
    work, given, error = floats(told[WORK], 0, WORK_SIZE), floats(told[WEIGHTS], 0, 2), floats(law[of.MEASURED], 0, 2)
    target, axis = floats(told[TARGET], 0, 3), floats(told[AXIS], 0, 9)
    block = floats(ints(told[SEEN], 0, 3)[bend.SEEN], 0, at.JACOBIAN)
    for k in range(WORK_SIZE):
        work[k] = 0.0
    R = block[at.ROTATION : at.ROTATION + 9]
    for k in range(3):
        for c in range(3):
            work[bend.G + k] += R[3 * k + c] * (given[0] * axis[3 + c] + given[1] * axis[6 + c])
            work[GIVEN + k] += R[3 * k + c] * axis[c]
            work[ERROR + k] += R[3 * k + c] * (error[0] * axis[3 + c] + error[1] * axis[6 + c])
    if told[POINT] != 0:
        x, y, z = target[0] - block[0], target[1] - block[1], target[2] - block[2]
        share = 1.0 / max(math.sqrt(x * x + y * y + z * z), NEAR)
        direction_maps(share * x, share * y, share * z, share, work)
    else:
        bend.add_part(work, bend.OTHER, bend.ANGULAR, 1.0)
    axis_curvature(GIVEN, ERROR, work)
    bend.seen_curvature(told[SEEN], work, floats(told[SUM], 0, n * n))
    return 0


@stamp
@entry
def plane_curvature(here):
    """Add the curvature of the distance of the origin of a frame from a plane to SUM."""
    told = ints(here, 0, 5)
    n = ints(ints(told[SEEN], 0, 3)[bend.FRAME], 0, bend.LENGTH)[bend.N]
    work, normal = floats(told[WORK], 0, WORK_SIZE), floats(told[NORMAL], 0, 3)
    weight = floats(told[WEIGHTS], 0, 1)[0]
    for k in range(WORK_SIZE):
        work[k] = 0.0
    for k in range(3):
        work[bend.F + k] = weight * normal[k]
    bend.seen_curvature(told[SEEN], work, floats(told[SUM], 0, n * n))
    return 0
