"""Loops that write the motion equation of a floating base, add external wrenches, and compute joint torques."""

from __future__ import annotations

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at
from ...rows.kernels import motion

#: Table of the dynamics: after the entries of :mod:`tasks.rows.kernels.motion`, the bounds.
LOWER, UPPER = range(motion.LENGTH, motion.LENGTH + 2)


@stamp
@entry
def write_dynamics(here):
    """Write the rows ``M a - G^T f = -b`` of the base."""
    told = ints(here, 0, motion.LENGTH + 2)
    rows = told[motion.ROWS]
    motion.motion_rows(here)
    lower, upper, bias = floats(told[LOWER], 0, rows), floats(told[UPPER], 0, rows), floats(told[motion.BIAS], 0, rows)
    for r in range(rows):
        lower[r] = upper[r] = -bias[r]
    return 0


@stamp
@entry
def add_wrench(here):
    """Subtract the joint torques J^T w of an external wrench w on a frame from the bias.

    Table: number n of joint velocities, block of the frame, w (6,), bias (n,).
    """
    told = ints(here, 0, 4)
    n = told[0]
    J, wrench, bias = floats(told[1], at.JACOBIAN, 6 * n), floats(told[2], 0, 6), floats(told[3], 0, n)
    for k in range(6):
        for j in range(n):
            bias[j] -= J[k * n + j] * wrench[k]
    return 0


@stamp
@entry
def add_damping(here):
    """Add the torques D v that viscous damping takes to the bias.

    Table: number n of joint velocities, D, v and the bias (n,).
    """
    told = ints(here, 0, 4)
    n = told[0]
    damping, v, bias = floats(told[1], 0, n), floats(told[2], 0, n), floats(told[3], 0, n)
    for j in range(n):
        bias[j] += damping[j] * v[j]
    return 0


@stamp
@entry
def add_springs(here):
    """Add the torques K (q - rest) against which springs push to the bias.

    Table: number of springs; for each, which velocity is its joint's, and where its position is among the positions; K
    and rest; the positions; the bias.
    """
    told = ints(here, 0, 7)
    count = told[0]
    joints, places = ints(told[1], 0, count), ints(told[2], 0, count)
    stiffness, rest = floats(told[3], 0, count), floats(told[4], 0, count)
    for i in range(count):
        q, bias = floats(told[5] + 8 * places[i], 0, 1), floats(told[6] + 8 * joints[i], 0, 1)
        bias[0] += stiffness[i] * (q[0] - rest[i])
    return 0


#: Table of torques: after the entries of :mod:`tasks.rows.kernels.motion`, of which the matrix is not used, all
#: unknowns x = (a, f), and the torques.
X, TORQUES = range(motion.LENGTH, motion.LENGTH + 2)


@stamp
@entry
def compute_torques(here):
    """Compute the torques ``M a + b - G^T f`` of the rows of the motion equation; 1 if all are finite, else 0."""
    told = ints(here, 0, motion.LENGTH + 2)
    n, first, rows = told[motion.N], told[motion.FIRST], told[motion.ROWS]
    forces = told[motion.UNKNOWNS] - n
    M, bias = floats(told[motion.MASSES], first * n, rows * n), floats(told[motion.BIAS], first, rows)
    a, f = floats(told[X], 0, n), floats(told[X], n, forces)
    torques = floats(told[TORQUES], 0, rows)
    for r in range(rows):
        total = bias[r]
        for j in range(n):
            total += M[r * n + j] * a[j]
        torques[r] = total
    for i in range(forces):
        G = floats(told[motion.WRENCHES], i * n + first, rows)
        for r in range(rows):
            torques[r] -= f[i] * G[r]
    nothing = 0.0
    for r in range(rows):
        nothing += 0.0 * torques[r]  # NaN where a torque is not finite
    return 1 if nothing == 0.0 else 0
