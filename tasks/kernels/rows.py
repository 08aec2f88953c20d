r"""The rows of a tick at velocity order, written by one call: what :class:`tasks.PlaceTask`, :class:`tasks.PostureTask`
and the joint limits say, from the joint Jacobians that Pinocchio has computed.

A column of these is the spatial velocity which a joint gives: its angular part :math:`\omega_j`, and the velocity
:math:`v_j` of the point that is passing the origin of the world. A frame at p moves by :math:`v_j + \omega_j \times p`.
"""

from __future__ import annotations

import math

import numpy as np

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from . import layout as at

#: As of :func:`tasks.rotations.log`, :mod:`tasks.limits.position`, :mod:`tasks.robots.frame`.
SMALL, LARGEST, UNLIMITED, NOTHING = 1e-4, 1e15, 1.7976931348623157e308, 1e-13


@inner
def rotation_vector(R, out):
    """The rotation vector of R, by rows (9,), into out[:3]; see :func:`tasks.rotations.log`."""
    a, b, c, d, e, f, g, h, i = R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8]
    trace = a + e + i
    if trace >= a and trace >= e and trace >= i:
        w, x, y, z = 1.0 + trace, h - f, c - g, d - b
    elif a >= e and a >= i:
        w, x, y, z = h - f, 1.0 + a - e - i, b + d, c + g
    elif e >= i:
        w, x, y, z = c - g, b + d, 1.0 + e - a - i, f + h
    else:
        w, x, y, z = d - b, c + g, f + h, 1.0 + i - a - e
    sine = math.sqrt(x * x + y * y + z * z)
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    scale = 2.0 * math.atan2(sine, w) / sine if sine > SMALL * w else 2.0 / w * (1.0 - (sine / w) ** 2 / 3.0)
    out[0], out[1], out[2] = scale * x, scale * y, scale * z


@inner
def turned_back(R, x, y, z, out, first):
    """``R^T (x, y, z)`` for R by rows, into out[first:first + 3]."""
    for k in range(3):
        out[first + k] = R[k] * x + R[3 + k] * y + R[6 + k] * z


@inner
def bounds(part, rows, h):
    """Lower and upper bounds from what the law asks, h (rows,): ``h + K * below`` and ``h + K * above``."""
    lower, upper = floats(part[at.LOWER], 0, rows), floats(part[at.UPPER], 0, rows)
    gain = floats(part[at.GAIN], 0, 3 * rows)
    for r in range(rows):
        lower[r] = h[r] + gain[r] * gain[rows + r]
        upper[r] = h[r] + gain[r] * gain[2 * rows + r]


@inner
def place(part, n, J, work):
    """A frame brought to a place; work (48,)."""
    rows, axes = part[at.ROWS], part[at.AXES]
    linear, angular = part[at.LINEAR] != 0, part[at.ANGULAR] != 0
    carried, origin = floats(part[at.ROTATION], 0, 9), floats(part[at.TRANSLATION], 0, 3)
    mounted, target = floats(part[at.MOUNTED], 0, 12), floats(part[at.TARGET], 0, 18)
    mask, gain = ints(part[at.MASK], 0, rows), floats(part[at.GAIN], 0, rows)
    # Where the frame is: R = carried * mounted, p = origin + carried * offset.
    R, p, full, rate, turn, product = work[0:9], work[9:12], work[12:18], work[18:24], work[24:27], work[27:36]
    for r in range(3):
        p[r] = origin[r]
        for c in range(3):
            p[r] += carried[r + 3 * c] * mounted[9 + c]
            R[3 * r + c] = 0.0
            for k in range(3):
                R[3 * r + c] += carried[r + 3 * k] * mounted[3 * k + c]
    # What is left to go, and what the target does by itself, in the axes of the world.
    for k in range(3):
        full[k], full[3 + k] = target[k] - p[k], 0.0
        rate[k], rate[3 + k] = target[3 + k], target[15 + k]
    if angular:
        for r in range(3):
            for c in range(3):
                product[3 * r + c] = 0.0
                for k in range(3):
                    product[3 * r + c] += target[6 + 3 * r + k] * R[3 * c + k]
        rotation_vector(product, turn)
        full[3], full[4], full[5] = turn[0], turn[1], turn[2]
    first = 0 if linear else 3
    h, wanted = work[36:42], work[42:48]
    along(axes, R, p, full, wanted)
    along(axes, R, p, rate, h)
    for r in range(rows):
        h[r] = h[first + mask[r]] + gain[r] * wanted[first + mask[r]]
    bounds(part, rows, h)
    # And how it follows the joints.
    count = part[at.SUPPORTS]
    column, velocity = ints(part[at.SUPPORT], 0, count), ints(part[at.SUPPORT], count, count)
    A = floats(part[at.A], 0, rows * n)
    for s in range(count):
        for r in range(rows):
            A[r * n + velocity[s]] = 0.0
    for s in range(count):
        j = column[s]
        x, y, z = J[6 * j + 3], J[6 * j + 4], J[6 * j + 5]
        full[0] = J[6 * j] + y * p[2] - z * p[1]
        full[1] = J[6 * j + 1] + z * p[0] - x * p[2]
        full[2] = J[6 * j + 2] + x * p[1] - y * p[0]
        full[3], full[4], full[5] = x, y, z
        along(axes, R, p, full, wanted)
        for r in range(rows):
            entry = wanted[first + mask[r]]
            if abs(entry) >= NOTHING or entry != entry:
                A[r * n + velocity[s]] += entry


@inner
def along(axes, R, p, given, out):
    """A velocity (6,), linear before angular, along the axes of the task."""
    if axes == at.LOCAL:
        turned_back(R, given[0], given[1], given[2], out, 0)
        turned_back(R, given[3], given[4], given[5], out, 3)
        return
    for k in range(6):
        out[k] = given[k]
    if axes == at.SPATIAL:
        out[0] += p[1] * given[5] - p[2] * given[4]
        out[1] += p[2] * given[3] - p[0] * given[5]
        out[2] += p[0] * given[4] - p[1] * given[3]


@inner
def point(part, n, work):
    """A point, such as the centre of mass, brought to a place."""
    rows = part[at.ROWS]
    mask, gain, A = ints(part[at.MASK], 0, rows), floats(part[at.GAIN], 0, rows), floats(part[at.A], 0, rows * n)
    where, target = floats(part[at.TRANSLATION], 0, 3), floats(part[at.TARGET], 0, 6)
    J = floats(part[at.POINT_JACOBIAN], 0, 3 * n)
    for r in range(rows):
        i = mask[r]
        work[r] = target[3 + i] + gain[r] * (target[i] - where[i])
        for j in range(n):
            A[r * n + j] = J[3 * j + i]
    bounds(part, rows, work)


@inner
def posture(part, q, work):
    """Joints brought to positions."""
    rows = part[at.ROWS]
    places, wanted = ints(part[at.PLACES], 0, rows), floats(part[at.WANTED], 0, 2 * rows)
    lower, upper = floats(part[at.LOWER], 0, rows), floats(part[at.UPPER], 0, rows)
    gain = floats(part[at.GAIN], 0, 3 * rows)
    for r in range(rows):
        h = wanted[rows + r] + gain[r] * (wanted[r] - q[places[r]])
        lower[r] = h + gain[r] * gain[rows + r]
        upper[r] = h + gain[r] * gain[2 * rows + r]


@inner
def largest_velocity(room, braking, dt):
    """See :func:`tasks.limits.position.largest_velocity`."""
    if room > LARGEST:
        return math.inf
    step, rate = min(braking * dt, UNLIMITED), room / dt
    steps = np.floor(0.5 * (math.sqrt(1.0 + 8.0 * max(rate, 0.0) / step) - 1.0))
    return (rate + step * (0.5 * steps * (steps + 1.0))) / (steps + 1.0)


@inner
def limits(part, n, q, v):
    """All joint limits, each relaxed so far that it meets the harder ones: see :mod:`tasks.limits.envelope`."""
    places, numbers = ints(part[at.PLACES], 0, n), floats(part[at.NUMBERS], 0, 8 * n)
    lower, upper = floats(part[at.LOWER], 0, n), floats(part[at.UPPER], 0, n)
    for j in range(n):
        low, high, speed, back_speed = numbers[j], numbers[n + j], numbers[2 * n + j], numbers[3 * n + j]
        acceleration, braking = numbers[4 * n + j], numbers[5 * n + j]
        return_speed, dt = numbers[6 * n + j], numbers[7 * n + j]
        least, most = v[j] - braking * dt, v[j] + braking * dt  # what is within reach
        down, up = -math.inf, math.inf
        if places[j] >= 0:
            below = largest_velocity(q[places[j]] - low, braking, dt)
            above = largest_velocity(high - q[places[j]], braking, dt)
            back = min(return_speed, back_speed)
            under, over = max(below, -min(back, max(above, 0.0))), max(above, -min(back, max(below, 0.0)))
            down, up = min(-under, most), max(over, least)
            least, most = max(least, down), min(most, up)
        slow, fast = min(-speed, most), max(speed, least)
        if acceleration < math.inf:
            slow, fast = max(slow, v[j] - acceleration * dt), min(fast, v[j] + acceleration * dt)
        lower[j], upper[j] = max(down, slow), min(up, fast)
        if v[j] != v[j] or (places[j] >= 0 and q[places[j]] != q[places[j]]):
            lower[j] = math.nan  # for the solver to report


@stamp
@entry
def write_rows(here, scratch):
    """Write all parts; `here` is the address of the first list of :mod:`.layout`, `scratch` that of 48 numbers."""
    head = ints(here, 0, 6)
    n = head[at.N]
    q, v, J = floats(head[at.Q], 0, 1), floats(head[at.V], 0, n), floats(head[at.JOINTS], 0, 1)
    for k in range(head[at.PARTS]):
        part = ints(head[at.LISTS], k * at.LENGTH, at.LENGTH)
        kind = part[at.KIND]
        if kind == at.PLACE:
            place(part, n, J, floats(scratch, 0, 48))
        elif kind == at.POINT:
            point(part, n, floats(scratch, 0, 48))
        elif kind == at.POSTURE:
            posture(part, q, floats(scratch, 0, 48))
        else:
            limits(part, n, q, v)
    return 0
