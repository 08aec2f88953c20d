r"""Loops that write frames of robots into their blocks (:mod:`.block`), each once a tick.

A frame of a Pinocchio robot is fixed to a joint at R_j, p_j, with an offset c. A column of the joint Jacobians is the
spatial velocity that a unit joint velocity causes: its angular part :math:`\omega_j`, and the velocity :math:`v_j` of
the point at the origin of the world. It moves the frame at p by :math:`v_j + \omega_j \times p`. With the velocity
(v, omega) and acceleration (a, alpha) of the joint along its own axes, while the joints do not accelerate,

.. math:: \ddot p = R_j (a + \alpha \times c + \omega \times (v + \omega \times c)), \qquad \dot\omega = R_j \alpha.
"""

from __future__ import annotations

import numpy as np

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.rotation import crossed, turned_back
from . import block as at

#: Table of a frame on a joint: unknowns; its block; whether drifts are needed; pose of the joint (R by columns, p);
#: pose of the frame on the joint (R by rows, p); the joint Jacobians (6 x columns, by columns); how many columns move
#: the frame, which, and the joint velocity of each; velocity and acceleration of the joint (6,).
N, BLOCK, DRIFTS, CARRIED, ORIGIN, MOUNTED, JOINTS, SUPPORTS, SUPPORT, MOTION, CHANGE = range(11)
#: Table of the end of a link of a planar arm, after DRIFTS: lengths of the links, q, v, and the number of the link.
LENGTHS, Q, V, LINKS = range(3, 7)
#: Table of a frame seen from another one, its root, after DRIFTS: the blocks of both in the world.
ROOT, FRAME = range(3, 5)
#: Table of the centre of mass, after DRIFTS: its position, Jacobian (3 x n, by columns), velocity and drift.
POINT, POINT_JACOBIAN, POINT_VELOCITY, POINT_DRIFT = range(3, 7)


@inner
def kept(entry):
    """The entry itself, or 0 if it is round-off."""
    return entry if abs(entry) >= at.NOTHING or entry != entry else 0.0


@stamp
@entry
def joint_frame(here):
    """Write the block of a frame that is fixed to a joint of Pinocchio."""
    told = ints(here, 0, 11)
    n, count = told[N], told[SUPPORTS]
    block = floats(told[BLOCK], 0, at.JACOBIAN)
    carried, origin, mounted = floats(told[CARRIED], 0, 9), floats(told[ORIGIN], 0, 3), floats(told[MOUNTED], 0, 12)
    for r in range(3):
        block[r] = origin[r]
        for c in range(3):
            block[r] += carried[r + 3 * c] * mounted[9 + c]
            total = 0.0
            for k in range(3):
                total += carried[r + 3 * k] * mounted[3 * k + c]
            block[at.ROTATION + 3 * r + c] = total
    column, velocity = ints(told[SUPPORT], 0, count), ints(told[SUPPORT], count, count)
    last = -1
    for s in range(count):
        last = max(last, column[s])
    J, rows = floats(told[JOINTS], 0, 6 * (last + 1)), floats(told[BLOCK], at.JACOBIAN, 6 * n)
    for s in range(count):
        for r in range(6):
            rows[r * n + velocity[s]] = 0.0
    p0, p1, p2 = block[0], block[1], block[2]
    for s in range(count):
        j, i = 6 * column[s], velocity[s]
        x, y, z = J[j + 3], J[j + 4], J[j + 5]
        rows[i] += kept(J[j] + y * p2 - z * p1)
        rows[n + i] += kept(J[j + 1] + z * p0 - x * p2)
        rows[2 * n + i] += kept(J[j + 2] + x * p1 - y * p0)
        rows[3 * n + i] += kept(x)
        rows[4 * n + i] += kept(y)
        rows[5 * n + i] += kept(z)
    if ints(told[DRIFTS], 0, 1)[0] != 0:
        drifts(block, carried, floats(told[MOUNTED], 9, 3), floats(told[MOTION], 0, 6), floats(told[CHANGE], 0, 6))
    return 0


@inner
def drifts(block, carried, c, motion, change):
    """Write velocities and drifts of a frame at the offset c on its joint into its block; see the module."""
    v0, v1, v2, x, y, z = motion[0], motion[1], motion[2], motion[3], motion[4], motion[5]
    v0, v1, v2 = v0 + y * c[2] - z * c[1], v1 + z * c[0] - x * c[2], v2 + x * c[1] - y * c[0]
    a, b, g = change[3], change[4], change[5]
    a0 = change[0] + b * c[2] - g * c[1] + y * v2 - z * v1
    a1 = change[1] + g * c[0] - a * c[2] + z * v0 - x * v2
    a2 = change[2] + a * c[1] - b * c[0] + x * v1 - y * v0
    turned_back(carried, a0, a1, a2, block, at.LINEAR_DRIFT)  # R by columns is R^T by rows, so this multiplies by R
    turned_back(carried, a, b, g, block, at.ANGULAR_DRIFT)
    turned_back(carried, v0, v1, v2, block, at.LINEAR_VELOCITY)
    turned_back(carried, x, y, z, block, at.ANGULAR_VELOCITY)


@stamp
@entry
def planar_frame(here):
    """Write the block of the end of a link of a planar arm: each joint rotates all links after it about itself."""
    told = ints(here, 0, 7)
    n, links = told[N], told[LINKS]
    lengths, q, v = floats(told[LENGTHS], 0, n), floats(told[Q], 0, n), floats(told[V], 0, n)
    block, rows = floats(told[BLOCK], 0, at.JACOBIAN), floats(told[BLOCK], at.JACOBIAN, 6 * n)
    x, y, angle, spin, vx, vy, ax, ay = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(links):
        rows[i], rows[n + i], rows[5 * n + i] = y, -x, 1.0  # position of the joint; completed below
        angle += q[i]
        spin += v[i]
        dx, dy = lengths[i] * np.cos(angle), lengths[i] * np.sin(angle)  # those of math refuse infinite angles
        x, y, vx, vy = x + dx, y + dy, vx - spin * dy, vy + spin * dx
        ax, ay = ax - spin * spin * dx, ay - spin * spin * dy
    for i in range(links):
        rows[i], rows[n + i] = kept(rows[i] - y), kept(x + rows[n + i])
    cosine, sine = np.cos(angle), np.sin(angle)
    block[0], block[1], block[at.ANGLE], block[at.PLANAR] = x, y, angle, 1.0
    block[at.ROTATION], block[at.ROTATION + 1] = cosine, -sine
    block[at.ROTATION + 3], block[at.ROTATION + 4], block[at.ROTATION + 8] = sine, cosine, 1.0
    block[at.LINEAR_VELOCITY], block[at.LINEAR_VELOCITY + 1], block[at.ANGULAR_VELOCITY + 2] = vx, vy, spin
    block[at.LINEAR_DRIFT], block[at.LINEAR_DRIFT + 1] = ax, ay
    return 0


@stamp
@entry
def point_frame(here):
    """Write the block of the centre of mass, whose axes are those of the world."""
    told = ints(here, 0, 7)
    n = told[N]
    block, rows = floats(told[BLOCK], 0, at.JACOBIAN), floats(told[BLOCK], at.JACOBIAN, 3 * n)
    where, J = floats(told[POINT], 0, 3), floats(told[POINT_JACOBIAN], 0, 3 * n)
    for r in range(3):
        block[r] = where[r]
        block[at.ROTATION + 4 * r] = 1.0
        for j in range(n):
            rows[r * n + j] = J[3 * j + r]
    if ints(told[DRIFTS], 0, 1)[0] != 0:
        rate, drift = floats(told[POINT_VELOCITY], 0, 3), floats(told[POINT_DRIFT], 0, 3)
        for r in range(3):
            block[at.LINEAR_VELOCITY + r], block[at.LINEAR_DRIFT + r] = rate[r], drift[r]
    return 0


@stamp
@entry
def relative_frame(here):
    r"""Write the block of a frame relative to another frame, the root: in its coordinates, without its motion.

    With :math:`r = R_0^T (p - p_0)`, :math:`\omega_0` in the coordinates of the root, and joint velocities v,

    .. math::

        \dot r = R_0^T (\dot p - \dot p_0) - \omega_0 \times r, \qquad
        \ddot r = R_0^T (\ddot p - \ddot p_0) - \dot\omega_0 \times r - 2 \omega_0 \times \dot r
            - \omega_0 \times (\omega_0 \times r).
    """
    told = ints(here, 0, 5)
    n = told[N]
    out, rows = floats(told[BLOCK], 0, at.JACOBIAN), floats(told[BLOCK], at.JACOBIAN, 6 * n)
    root, fixed = floats(told[ROOT], 0, at.JACOBIAN), floats(told[ROOT], at.JACOBIAN, 6 * n)
    frame, moved = floats(told[FRAME], 0, at.JACOBIAN), floats(told[FRAME], at.JACOBIAN, 6 * n)
    R = floats(told[ROOT], at.ROTATION, 9)
    turned_back(R, frame[0] - root[0], frame[1] - root[1], frame[2] - root[2], out, 0)
    for c in range(3):
        for r in range(3):
            total = 0.0
            for k in range(3):
                total += R[3 * k + r] * frame[at.ROTATION + 3 * k + c]
            out[at.ROTATION + 3 * r + c] = total
    r0, r1, r2 = out[0], out[1], out[2]
    for j in range(n):
        # The rotation of the root adds -omega_0 x r = r x omega_0 to the relative velocity.
        x, y, z = fixed[3 * n + j], fixed[4 * n + j], fixed[5 * n + j]
        a, b, c = moved[j] - fixed[j], moved[n + j] - fixed[n + j], moved[2 * n + j] - fixed[2 * n + j]
        d, e, f = moved[3 * n + j] - x, moved[4 * n + j] - y, moved[5 * n + j] - z
        x, y, z = R[0] * x + R[3] * y + R[6] * z, R[1] * x + R[4] * y + R[7] * z, R[2] * x + R[5] * y + R[8] * z
        for k in range(3):
            rows[k * n + j] = R[k] * a + R[3 + k] * b + R[6 + k] * c
            rows[(3 + k) * n + j] = R[k] * d + R[3 + k] * e + R[6 + k] * f
        rows[j] -= y * r2 - z * r1
        rows[n + j] -= z * r0 - x * r2
        rows[2 * n + j] -= x * r1 - y * r0
    if ints(told[DRIFTS], 0, 1)[0] != 0:
        relative_drifts(out, root, frame, R)
    return 0


@inner
def relative_drifts(out, root, frame, R):
    """Write velocities and drifts relative to the root into the block `out`; R is the rotation of the root."""
    for kind in (at.LINEAR_DRIFT, at.ANGULAR_DRIFT, at.LINEAR_VELOCITY, at.ANGULAR_VELOCITY):
        a, b, c = frame[kind] - root[kind], frame[kind + 1] - root[kind + 1], frame[kind + 2] - root[kind + 2]
        turned_back(R, a, b, c, out, kind)
    x, y, z = root[at.ANGULAR_VELOCITY], root[at.ANGULAR_VELOCITY + 1], root[at.ANGULAR_VELOCITY + 2]
    x, y, z = R[0] * x + R[3] * y + R[6] * z, R[1] * x + R[4] * y + R[7] * z, R[2] * x + R[5] * y + R[8] * z
    a, b, c = root[at.ANGULAR_DRIFT], root[at.ANGULAR_DRIFT + 1], root[at.ANGULAR_DRIFT + 2]
    a, b, c = R[0] * a + R[3] * b + R[6] * c, R[1] * a + R[4] * b + R[7] * c, R[2] * a + R[5] * b + R[8] * c
    r0, r1, r2 = out[0], out[1], out[2]
    crossed(x, y, z, r0, r1, r2, -1.0, out, at.LINEAR_VELOCITY)
    u0, u1, u2 = out[at.LINEAR_VELOCITY], out[at.LINEAR_VELOCITY + 1], out[at.LINEAR_VELOCITY + 2]
    crossed(a, b, c, r0, r1, r2, -1.0, out, at.LINEAR_DRIFT)
    crossed(x, y, z, u0, u1, u2, -2.0, out, at.LINEAR_DRIFT)
    s0, s1, s2 = y * r2 - z * r1, z * r0 - x * r2, x * r1 - y * r0
    crossed(x, y, z, s0, s1, s2, -1.0, out, at.LINEAR_DRIFT)
    w0, w1, w2 = out[at.ANGULAR_VELOCITY], out[at.ANGULAR_VELOCITY + 1], out[at.ANGULAR_VELOCITY + 2]
    crossed(x, y, z, w0, w1, w2, -1.0, out, at.ANGULAR_DRIFT)


@stamp
@entry
def symmetric(here):
    """Write a symmetric matrix from its upper triangle. Table: n, the triangle (by columns), the matrix (n, n)."""
    told = ints(here, 0, 3)
    n = told[0]
    half, whole = floats(told[1], 0, n * n), floats(told[2], 0, n * n)
    for i in range(n):
        for j in range(i, n):
            whole[i * n + j] = whole[j * n + i] = half[i + n * j]
    return 0


@stamp
@entry
def momentum_map(here):
    """Copy the map G of the centroidal momentum, and write its drift G' v (6,).

    Table: n; G and its rate G' (6 x n, by columns); v; the copy of G; the drift.
    """
    told = ints(here, 0, 6)
    n = told[0]
    G, change, v = floats(told[1], 0, 6 * n), floats(told[2], 0, 6 * n), floats(told[3], 0, n)
    out, drift = floats(told[4], 0, 6 * n), floats(told[5], 0, 6)
    for r in range(6):
        drift[r] = 0.0
    for j in range(n):
        for r in range(6):
            out[6 * j + r] = G[6 * j + r]
            drift[r] += change[6 * j + r] * v[j]
    return 0
