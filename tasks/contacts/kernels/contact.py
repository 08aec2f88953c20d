r"""Loops of a contact: axes of its surface, map from its forces to joint torques, forbidden motion, bounds of forces.

The axes of the surface are the columns of S = (t1, t2, n). A force f along these axes, at a point with the offset r
from the origin of the frame, causes the joint torques :math:`G^T f` with :math:`G = S^T (J_p - r \times J_\omega)`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.rotation import crossed, rotation_vector, turned_back
from ...robots.kernels import block as at
from ...rows.kernels import law as of
from . import layout as own
from .layout import CHANGE, SURFACE_SIZE, P, R, V

#: Table of the map: number of joint velocities; block of the frame; whether forces are one wrench; number of points,
#: the points in the frame, their centre; the surface, its normal, a direction of the frame for t1 (0: none). Out: S by
#: columns and the rotation of the frame by rows (18,); G. Of what rolls: its middle in the frame, and its radius (1,),
#: which is 0 of what does not; its only point, which is its centre, too, is then written.
N, BLOCK, WRENCH, COUNT, POINTS, CENTRE, SURFACE, NORMAL, ALONG, AXES, MAP, MIDDLE, RADIUS = range(13)
#: Table of the motion: the table of its law, the slot; block of the frame, centre of the points, surface, axes S; how
#: many rotations it forbids; the direction of a line; work space of 64 numbers; whether it rolls.
LAW, SLOT, M_BLOCK, M_CENTRE, M_SURFACE, M_AXES, TURNS, M_ALONG, WORK, ROLLS = range(10)


@inner
def unit(x, y, z):
    """The unit vector along (x, y, z); NaN for zero."""
    size = math.sqrt(x * x + y * y + z * z)
    if size == 0.0:
        return math.nan, math.nan, math.nan
    return x / size, y / size, z / size


@inner
def surface_axes(block, surface, normal, along, axes):
    """Write t1, t2, n to axes (9,), one after the other.

    n is `normal` in the axes of the surface; t1 is the projection onto the surface of `along`, a direction of the
    frame, or of an axis of the surface if that is zero.
    """
    a, b, c = normal[0], normal[1], normal[2]
    n0 = surface[R] * a + surface[R + 1] * b + surface[R + 2] * c
    n1 = surface[R + 3] * a + surface[R + 4] * b + surface[R + 5] * c
    n2 = surface[R + 6] * a + surface[R + 7] * b + surface[R + 8] * c
    if along[0] == 0.0 and along[1] == 0.0 and along[2] == 0.0:  # x of the surface, or y if n is nearly along x
        k = 0 if abs(a) < 0.8 else 1
        x, y, z = surface[R + k], surface[R + 3 + k], surface[R + 6 + k]
    else:
        F = at.ROTATION
        x = block[F] * along[0] + block[F + 1] * along[1] + block[F + 2] * along[2]
        y = block[F + 3] * along[0] + block[F + 4] * along[1] + block[F + 5] * along[2]
        z = block[F + 6] * along[0] + block[F + 7] * along[1] + block[F + 8] * along[2]
    dot = x * n0 + y * n1 + z * n2
    x, y, z = unit(x - dot * n0, y - dot * n1, z - dot * n2)
    axes[0], axes[1], axes[2] = x, y, z
    axes[3], axes[4], axes[5] = n1 * z - n2 * y, n2 * x - n0 * z, n0 * y - n1 * x
    axes[6], axes[7], axes[8] = n0, n1, n2


@inner
def from_origin(block, point, out):
    """Write the offset R p of a point p of the frame from its origin to out (3,), along the axes of the world."""
    for r in range(3):
        row = at.ROTATION + 3 * r
        out[r] = block[row] * point[0] + block[row + 1] * point[1] + block[row + 2] * point[2]


@stamp
@entry
def write_contact_map(here):
    """Write the axes S of the surface and the map G: three rows for each point, or six for one wrench at the centre."""
    told = ints(here, 0, RADIUS + 1)
    n, count, wrench = told[N], told[COUNT], told[WRENCH] != 0
    block, J = floats(told[BLOCK], 0, at.JACOBIAN), floats(told[BLOCK], at.JACOBIAN, 6 * n)
    S, rotation = floats(told[AXES], 0, 9), floats(told[AXES], 9, 9)
    surface, normal, along = (
        floats(told[SURFACE], 0, SURFACE_SIZE),
        floats(told[NORMAL], 0, 3),
        floats(told[ALONG], 0, 3),
    )
    surface_axes(block, surface, normal, along, S)
    F = at.ROTATION
    for k in range(9):
        rotation[k] = block[F + k]
    radius = floats(told[RADIUS], 0, 1)[0]
    if radius > 0.0:
        middle, lowest = floats(told[MIDDLE], 0, 3), floats(told[CENTRE], 0, 3)
        for k in range(3):
            lowest[k] = middle[k] - radius * (S[6] * block[F + k] + S[7] * block[F + 3 + k] + S[8] * block[F + 6 + k])
    places = told[CENTRE] if wrench else told[POINTS]
    for i in range(1 if wrench else count):
        point, G = floats(places, 3 * i, 3), floats(told[MAP], 3 * i * n, 3 * n)
        r0 = block[F] * point[0] + block[F + 1] * point[1] + block[F + 2] * point[2]
        r1 = block[F + 3] * point[0] + block[F + 4] * point[1] + block[F + 5] * point[2]
        r2 = block[F + 6] * point[0] + block[F + 7] * point[1] + block[F + 8] * point[2]
        for j in range(n):
            a, b, c = J[3 * n + j], J[4 * n + j], J[5 * n + j]
            x, y, z = J[j] + b * r2 - c * r1, J[n + j] + c * r0 - a * r2, J[2 * n + j] + a * r1 - b * r0
            for k in range(3):
                G[k * n + j] = S[3 * k] * x + S[3 * k + 1] * y + S[3 * k + 2] * z
    if wrench:
        G = floats(told[MAP], 3 * n, 3 * n)
        for j in range(n):
            a, b, c = J[3 * n + j], J[4 * n + j], J[5 * n + j]
            for k in range(3):
                G[k * n + j] = S[3 * k] * a + S[3 * k + 1] * b + S[3 * k + 2] * c
    return 0


@inner
def relative_place(block, p, surface, slot):
    """Store the present pose of the contact, relative to the surface, in its slot: it is held there from now on.

    `p` (3,) is the position of the centre of the contact in the world.
    """
    o = p[0] - surface[P], p[1] - surface[P + 1], p[2] - surface[P + 2]
    turned_back(surface[R : R + 9], o[0], o[1], o[2], slot, own.PLACE)
    for c in range(3):
        for r in range(3):
            total = 0.0
            for k in range(3):
                total += surface[R + 3 * k + r] * block[at.ROTATION + 3 * k + c]
            slot[own.AXES + 3 * r + c] = total
    slot[own.TAKEN] = 1.0


@inner
def held_place(block, p, surface, slot, work):
    """Write the error of the contact from its held pose to work[:6], and the velocity and acceleration of that pose.

    These are in work[6:12] and work[12:18], all along the axes of the world, linear before angular.
    """
    for r in range(3):
        row = R + 3 * r
        work[18 + r] = (
            surface[row] * slot[own.PLACE]
            + surface[row + 1] * slot[own.PLACE + 1]
            + surface[row + 2] * slot[own.PLACE + 2]
        )
        work[r] = surface[P + r] + work[18 + r] - p[r]
        work[6 + r], work[9 + r] = surface[V + r], surface[V + 3 + r]
        work[12 + r], work[15 + r] = surface[CHANGE + r], surface[CHANGE + 3 + r]
        for c in range(3):  # (R_s A) R^T
            total = 0.0
            for k in range(3):
                there = 0.0
                for m in range(3):
                    there += surface[row + m] * slot[own.AXES + 3 * m + k]
                total += there * block[at.ROTATION + 3 * c + k]
            work[24 + 3 * r + c] = total
    rotation_vector(work[24:33], work, 3)
    a, b, c, x, y, z = work[9], work[10], work[11], work[18], work[19], work[20]
    crossed(a, b, c, x, y, z, 1.0, work, 6)
    crossed(work[15], work[16], work[17], x, y, z, 1.0, work, 12)
    crossed(a, b, c, b * z - c * y, c * x - a * z, a * y - b * x, 1.0, work, 12)


@inner
def turning_axes(block, S, along, turns, axes):
    """Write the axes about which the contact cannot turn to axes (9,): S, or the two perpendicular to a line."""
    for k in range(9):
        axes[k] = S[k]
    if turns != 2:
        return
    from_origin(block, along, axes)
    x, y, z = unit(axes[0], axes[1], axes[2])
    a, b, c = unit(S[7] * z - S[8] * y, S[8] * x - S[6] * z, S[6] * y - S[7] * x)
    axes[0], axes[1], axes[2] = a, b, c
    axes[3], axes[4], axes[5] = y * c - z * b, z * a - x * c, x * b - y * a


@stamp
@entry
def write_contact_motion(here):
    """Write the rows that hold the centre of a contact at its place on the surface, and forbid rotations of its frame.

    They are free while the contact is off, and widened by OPEN of its slot. What rolls is held along the normal alone,
    and has no velocity where it touches: that point is fixed to its middle, and is not carried around.
    """
    told = ints(here, 0, ROLLS + 1)
    law = ints(told[LAW], 0, of.LENGTH)
    rows, n, turns = law[of.ROWS], law[of.N], told[TURNS]
    block, J = floats(told[M_BLOCK], 0, at.JACOBIAN), floats(told[M_BLOCK], at.JACOBIAN, 6 * n)
    slot, surface = floats(told[SLOT], 0, own.SLOT_SIZE), floats(told[M_SURFACE], 0, SURFACE_SIZE)
    S, work = floats(told[M_AXES], 0, 9), floats(told[WORK], 0, 64)
    A, measured = floats(law[of.MATRIX], 0, rows * n), floats(law[of.MEASURED], 0, of.KINDS * rows)
    arm, p = work[40:43], work[43:46]
    from_origin(block, floats(told[M_CENTRE], 0, 3), arm)
    for k in range(3):
        p[k] = block[k] + arm[k]
    r0, r1, r2 = arm[0], arm[1], arm[2]
    T = work[46:55]
    turning_axes(block, S, floats(told[M_ALONG], 0, 3), turns, T)
    for j in range(n):
        a, b, c = J[3 * n + j], J[4 * n + j], J[5 * n + j]
        x, y, z = J[j] + b * r2 - c * r1, J[n + j] + c * r0 - a * r2, J[2 * n + j] + a * r1 - b * r0
        for k in range(3):
            A[k * n + j] = S[3 * k] * x + S[3 * k + 1] * y + S[3 * k + 2] * z
        for k in range(turns):
            A[(3 + k) * n + j] = T[3 * k] * a + T[3 * k + 1] * b + T[3 * k + 2] * c
    if slot[own.ON] == 0.0:
        lower, upper = floats(law[of.LOWER], 0, rows), floats(law[of.UPPER], 0, rows)
        for r in range(rows):
            lower[r], upper[r] = -math.inf, math.inf
        return 0
    known = p[0] + p[1] + p[2] + surface[P] + surface[R]
    if slot[own.TAKEN] == 0.0 and known == known:
        relative_place(block, p, surface, slot)
    held_place(block, p, surface, slot, work)
    rolls = told[ROLLS] != 0
    if rolls:
        high = S[6] * work[0] + S[7] * work[1] + S[8] * work[2]
        work[0], work[1], work[2] = high * S[6], high * S[7], high * S[8]
    if law[of.DRIFTS] != 0:
        w = block[at.ANGULAR_VELOCITY : at.ANGULAR_VELOCITY + 3]
        for k in range(6):
            work[18 + k] = block[at.LINEAR_DRIFT + k]
        crossed(work[21], work[22], work[23], r0, r1, r2, 1.0, work, 18)
        x, y, z = w[1] * r2 - w[2] * r1, w[2] * r0 - w[0] * r2, w[0] * r1 - w[1] * r0
        if not rolls:
            crossed(w[0], w[1], w[2], x, y, z, 1.0, work, 18)
    else:
        for k in range(6):
            work[18 + k] = 0.0
    for kind in range(4):  # error, velocity and acceleration of the place, drift
        for r in range(rows):
            first, k = 6 * kind + 3 * (r // 3), 3 * (r % 3)
            axis = S if r < 3 else T
            measured[kind * rows + r] = (
                axis[k] * work[first] + axis[k + 1] * work[first + 1] + axis[k + 2] * work[first + 2]
            )
    of.moving(told[LAW])
    of.law(told[LAW])
    lower, upper = floats(law[of.LOWER], 0, rows), floats(law[of.UPPER], 0, rows)
    for r in range(rows):
        lower[r], upper[r] = lower[r] - slot[own.OPEN], upper[r] + slot[own.OPEN]
    return 0


#: Table of bounds of forces: the slot; the largest normal forces at the points, number of points; whether the contact
#: can also pull; whether forces are one wrench; the bounds.
F_SLOT, CAPS, F_COUNT, PULLS, F_WRENCH, F_LOWER, F_UPPER = range(7)


@stamp
@entry
def write_force_bounds(here):
    """Write bounds of forces: tangential ones are free, normal ones from 0 to their cap; all are 0 if it is not loaded.

    If the contact can pull, normal forces are from minus the cap, and tangential ones have the cap, too.
    """
    told = ints(here, 0, F_UPPER + 1)
    slot, count, pulls = floats(told[F_SLOT], 0, own.SLOT_SIZE), told[F_COUNT], told[PULLS] != 0
    size = 6 if told[F_WRENCH] != 0 else 3 * count
    caps, lower, upper = floats(told[CAPS], 0, count), floats(told[F_LOWER], 0, size), floats(told[F_UPPER], 0, size)
    most = math.inf if slot[own.LOADED] != 0.0 else 0.0
    for i in range(size):
        lower[i], upper[i] = -most, most
    for i in range(1 if told[F_WRENCH] != 0 else count):
        cap = min(most, caps[i])
        lower[3 * i + 2], upper[3 * i + 2] = -cap if pulls else 0.0, cap
        if pulls and cap < math.inf:  # no friction cone relates tangential forces to the normal force
            for k in range(2):
                lower[3 * i + k], upper[3 * i + k] = -cap, cap
    return 0


#: Table of friction: the slot; number of rows, of which the last is the sum of the normal forces; its least and largest
#: value (2,); the bounds.
C_SLOT, C_ROWS, TOTAL, C_LOWER, C_UPPER = range(5)


@stamp
@entry
def write_friction(here):
    """Write the bounds of a friction cone, rows at most 0 while the contact is loaded, and of the normal force sum.

    The least sum grows with the caps while the contact is being made.
    """
    told = ints(here, 0, C_UPPER + 1)
    slot, rows, total = floats(told[C_SLOT], 0, own.SLOT_SIZE), told[C_ROWS], floats(told[TOTAL], 0, 2)
    lower, upper = floats(told[C_LOWER], 0, rows), floats(told[C_UPPER], 0, rows)
    on = slot[own.LOADED] != 0.0
    for r in range(rows - 1):
        lower[r], upper[r] = -math.inf, 0.0 if on else math.inf
    lower[rows - 1] = slot[own.SHARE] * total[0] if slot[own.BEARS] != 0.0 and total[0] > 0.0 else -math.inf
    upper[rows - 1] = total[1] if on else math.inf
    return 0
