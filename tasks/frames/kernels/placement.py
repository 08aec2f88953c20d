r"""Error, rates, Jacobian and drift of position, orientation and pose tasks, from the block of a frame.

The block is that of :mod:`tasks.robots.kernels.block`. Along the axes of the world, with the frame at p, R and its
target at :math:`p^d, R^d`,

.. math:: e = (p^d - p, \; \log(R^d R^T)), \qquad J = (J_p, \; J_\omega).

Along the axes of the frame itself (LOCAL), which turn with it, both halves are multiplied by :math:`R^T`. Linear
SPATIAL rows are those of the point of the frame's body at the origin of the world, :math:`\dot p + p \times \omega`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.rotation import crossed, rotation_vector, turned_back
from ...robots.kernels import block as at
from ...rows.kernels import law as of

#: Table: the table of the law, the block of the frame, the target, and work space of 64 numbers.
LAW, BLOCK, TARGET, WORK = range(4)
#: After that: the axes; whether position and rotation count; whether the target is one angle about z; and the
#: coordinates that count.
AXES, LINEAR, ANGULAR, ABOUT_Z, MASK = range(4, 9)
WORLD, LOCAL, SPATIAL = range(3)
#: Target: p, its velocity and acceleration; R by rows, omega and its rate; the angle about z.
P, R, OMEGA, ALPHA, TURNED = 0, 9, 18, 21, 24
TARGET_SIZE = 25


@inner
def along(axes, block, given, first, out, begin):
    """Write given[first:first + 6], linear before angular, along the axes of the task to out[begin:begin + 6]."""
    if axes == LOCAL:
        frame = block[at.ROTATION : at.ROTATION + 9]
        turned_back(frame, given[first], given[first + 1], given[first + 2], out, begin)
        turned_back(frame, given[first + 3], given[first + 4], given[first + 5], out, begin + 3)
        return
    for k in range(6):
        out[begin + k] = given[first + k]
    if axes == SPATIAL:
        crossed(block[0], block[1], block[2], given[first + 3], given[first + 4], given[first + 5], 1.0, out, begin)


@inner
def target_error(block, target, linear, angular, about_z, work):
    """Write the error of position and orientation along the axes of the world to work[:6]; overwrites work[6:15].

    `linear`, `angular` tell which half counts, `about_z` that the target is one angle about z.
    """
    for k in range(6):
        work[k] = 0.0
    if linear:
        for k in range(3):
            work[k] = target[k] - block[k]
    if angular and about_z and block[at.PLANAR] != 0.0:
        work[5] = target[TURNED] - block[at.ANGLE]
    elif angular:
        if about_z:
            cosine, sine = math.cos(target[TURNED]), math.sin(target[TURNED])
            target[R], target[R + 1], target[R + 3], target[R + 4], target[R + 8] = cosine, -sine, sine, cosine, 1.0
        for r in range(3):
            for c in range(3):
                total = 0.0
                for k in range(3):
                    total += target[R + 3 * r + k] * block[at.ROTATION + 3 * c + k]
                work[6 + 3 * r + c] = total
        rotation_vector(work[6:15], work, 3)


@inner
def target_motion(block, target, linear, angular, work):
    """Write velocity (work[6:12]) and acceleration (work[12:18]) of the target, along the axes of the world."""
    for k in range(6, 18):
        work[k] = 0.0
    if linear:
        for k in range(3):
            work[6 + k], work[12 + k] = target[3 + k], target[6 + k]
    if angular:
        for k in range(3):
            work[9 + k], work[15 + k] = target[OMEGA + k], target[ALPHA + k]
        w = block[at.ANGULAR_VELOCITY : at.ANGULAR_VELOCITY + 3]
        crossed(target[OMEGA], target[OMEGA + 1], target[OMEGA + 2], w[0], w[1], w[2], 1.0, work, 15)


@inner
def turning(axes, block, out):
    """Write the acceleration terms from the motion of the axes, or of the origin, of the task to out[:6]."""
    for k in range(6):
        out[k] = 0.0
    v, w = block[at.LINEAR_VELOCITY : at.LINEAR_VELOCITY + 3], block[at.ANGULAR_VELOCITY : at.ANGULAR_VELOCITY + 3]
    if axes == SPATIAL:
        crossed(v[0], v[1], v[2], w[0], w[1], w[2], 1.0, out, 0)
    elif axes == LOCAL:  # R^T p' x R^T omega is R^T (p' x omega)
        a, b, c = v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]
        for k in range(3):
            frame = at.ROTATION + k
            out[k] += block[frame] * a + block[frame + 3] * b + block[frame + 6] * c


@inner
def jacobian(axes, block, J, n, mask, first, rows, A, work):
    """Write the rows of the Jacobian (6, n) that count, along the axes of the task, to A; overwrites work[32:44]."""
    for j in range(n):
        for k in range(6):
            work[32 + k] = J[k * n + j]
        along(axes, block, work, 32, work, 38)
        for r in range(rows):
            A[r * n + j] = work[38 + first + mask[r]]


@stamp
@entry
def write_placement(here):
    """Write A and bounds of a position, orientation or pose task, from its error, rates, Jacobian and drift."""
    told = ints(here, 0, 9)
    law = ints(told[LAW], 0, of.LENGTH)
    rows, n, axes = law[of.ROWS], law[of.N], told[AXES]
    linear, angular = told[LINEAR] != 0, told[ANGULAR] != 0
    block, J = floats(told[BLOCK], 0, at.JACOBIAN), floats(told[BLOCK], at.JACOBIAN, 6 * n)
    target, work = floats(told[TARGET], 0, TARGET_SIZE), floats(told[WORK], 0, 64)
    mask, first = ints(told[MASK], 0, rows), 0 if linear else 3
    measured = floats(law[of.MEASURED], 0, of.KINDS * rows)
    A = floats(law[of.MATRIX], 0, rows * n)
    target_error(block, target, linear, angular, told[ABOUT_Z] != 0, work)
    target_motion(block, target, linear, angular, work)
    count = 4 if law[of.DRIFTS] != 0 else 2
    for k in range(6):
        work[18 + k] = block[at.LINEAR_DRIFT + k]
    # Error, velocity and acceleration of the target, drift, and the n columns of J, each along the axes of the task.
    for s in range(count + n):
        for k in range(6):
            work[24 + k] = work[6 * s + k] if s < count else J[k * n + s - count]
        along(axes, block, work, 24, work, 30)
        for r in range(rows):
            entry = work[30 + first + mask[r]]
            if s < count:
                measured[s * rows + r] = entry
            else:
                A[r * n + s - count] = entry
    if law[of.DRIFTS] != 0:
        turning(axes, block, work)
        for r in range(rows):
            for s in range(of.CHANGE, of.DRIFT + 1):
                measured[s * rows + r] += work[first + mask[r]]
        of.moving(told[LAW])
    of.law(told[LAW])
    return 0
