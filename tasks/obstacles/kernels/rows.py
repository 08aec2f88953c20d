"""Loops that write rows of distances: gradients, and the largest approach speed; the parts have the equations."""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at
from ...rows.kernels import law as of
from . import distances as near
from .distances import dot
from .reserve import fastest, reserve

#: Table of every part: the order; number of rows, of unknowns; A and bounds; its numbers; rate and tick; velocities.
ORDER, ROWS, N, MATRIX, LOWER, UPPER, NUMBERS, TICK, V = range(9)
#: Table of a distance limit, after that: the table of its pairs; velocity and acceleration limits of the joints (0:
#: none in the stack), number of velocities of a floating base; work space (3 n,), and a mark for each pair. Its numbers
#: are margin and gain.
PAIRS, VELOCITY, ACCELERATION, BASE, WORK, CHOSEN = range(9, 15)
#: Numbers of an avoidance task, which has PAIRS, too: influence, speed, gain.
INFLUENCE, SPEED, GAIN = range(3)
#: Table of a self-collision limit, after V, with margin and gain as numbers: its contacts, the blocks of both bodies.
CONTACTS, BODIES = range(9, 11)
#: Contact: distance, unit normal from the second body to the first, the witness of each. CONTACT is the size.
DISTANCE, NORMAL, FIRST, SECOND, CONTACT = 0, 1, 4, 7, 10


@inner
def gradient(address, n, normal, point, sign, row):
    """Add ``sign n^T J`` of a point fixed to a frame to row (n,); `address` is that of the block of the frame."""
    block, J = floats(address, 0, at.JACOBIAN), floats(address, at.JACOBIAN, 6 * n)
    r0, r1, r2 = point[0] - block[0], point[1] - block[1], point[2] - block[2]
    a, b, c = sign * normal[0], sign * normal[1], sign * normal[2]
    x, y, z = r1 * c - r2 * b, r2 * a - r0 * c, r0 * b - r1 * a  # n^T (omega x r) is omega^T (r x n)
    for j in range(n):
        linear = a * J[j] + b * J[n + j] + c * J[2 * n + j]
        row[j] += linear + x * J[3 * n + j] + y * J[4 * n + j] + z * J[5 * n + j]


@inner
def drift_along(address, normal, point):
    """The drift ``n^T J' v`` [m/s^2] of a point fixed to a frame: its acceleration at constant joint velocities."""
    block = floats(address, 0, at.JACOBIAN)
    r0, r1, r2 = point[0] - block[0], point[1] - block[1], point[2] - block[2]
    a, b, c = normal[0], normal[1], normal[2]
    spin, change = at.ANGULAR_VELOCITY, at.ANGULAR_DRIFT
    x, y, z = block[spin], block[spin + 1], block[spin + 2]
    turning = block[change] * (r1 * c - r2 * b)
    turning += block[change + 1] * (r2 * a - r0 * c)
    turning += block[change + 2] * (r0 * b - r1 * a)
    # omega x (omega x r) is omega (omega^T r) - r (omega^T omega)
    inwards = (x * a + y * b + z * c) * (x * r0 + y * r1 + z * r2)
    inwards -= (r0 * a + r1 * b + r2 * c) * (x * x + y * y + z * z)
    return dot(block, at.LINEAR_DRIFT, normal, 0) + turning + inwards


@inner
def speed_of(row, v):
    """The rate ``row v`` at which the motion of the joints changes the distance."""
    total = 0.0
    for j in range(len(v)):
        total += row[j] * v[j]
    return total


@inner
def in_time(room, drift, gain, rate, dt):
    """The part of the room that may be used, and the gain, under acceleration limits of the joints.

    The gain is at most `rate`, at which the joints can stop. Room that the drift takes until then is left free.
    """
    if not rate < math.inf:
        return room, gain
    gain = min(gain, rate)
    bend = 0.5 * max(-drift, 0.0) * (1.0 / gain + dt) / gain
    return max(room - bend, min(room, 0.0)), gain


@inner
def choose(pairs, found, rows, chosen):
    """Mark the `rows` nearest pairs in `chosen`; of pairs at the same distance, the first."""
    for k in range(pairs):
        chosen[k] = 1 if rows >= pairs else 0
    if rows >= pairs:
        return
    for _ in range(rows):
        best = -1
        for k in range(pairs):
            if chosen[k] == 0:
                d = found[near.PAIR * k + near.DISTANCE]
                if best < 0 or d < found[near.PAIR * best + near.DISTANCE]:
                    best = k
        chosen[best] = 1


@inner
def least(told, address, found, shape, row, w):
    """The least n^T J x [m/s], [m/s^2] that a distance limit allows; NaN if the reserve is infinite or an input NaN."""
    number, tick, v = floats(told[NUMBERS], 0, 2), floats(told[TICK], 0, 2), floats(told[V], 0, told[N])
    dt, accelerating = tick[1], told[ORDER] == of.ACCELERATION
    shift = math.sqrt(dot(shape, near.SHIFT, shape, near.SHIFT))
    rho = reserve(address, told[N], told[BASE], found, shape, shift, w, dt, floats(told[WORK], told[N], 2 * told[N]))
    drift, now = 0.0, 0.0
    if accelerating or tick[0] < math.inf:
        drift = drift_along(address, found[near.NORMAL :], found[near.WITNESS :])
    if accelerating:
        now = speed_of(row, v)
    known = found[near.DISTANCE] + drift + now
    if not rho < math.inf or known != known:
        return math.nan
    along = dot(found, near.NORMAL, shape, near.SHIFT) / dt
    e, gain = in_time(found[near.DISTANCE] - number[0] - rho, drift, number[1], tick[0], dt)
    back = min(max(-e, 0.0), rho) / dt + gain * max(-e - rho, 0.0)
    end = along + back - gain * max(e, 0.0)
    if not accelerating:
        return end
    mean = along + back - max(e, 0.0) / dt
    return max((end - now) / dt - drift, 2.0 * (mean - now) / dt)


@stamp
@entry
def write_limit(here):
    """Write the rows of a distance limit: one for each of the nearest pairs, in the order of the pairs.

    So a pair seldom changes its row.
    """
    told = ints(here, 0, 15)
    n, rows, step = told[N], told[ROWS], told[ORDER] == of.DISPLACEMENT
    near.measure(told[PAIRS])
    scene = ints(told[PAIRS], 0, near.LENGTH)
    obstacles = scene[near.OBSTACLES]
    pairs = scene[near.LINKS] * obstacles
    chosen, blocks = ints(told[CHOSEN], 0, pairs), ints(scene[near.BLOCKS], 0, scene[near.LINKS])
    choose(pairs, floats(scene[near.FOUND], 0, near.PAIR * pairs), rows, chosen)
    lower, upper, w = floats(told[LOWER], 0, rows), floats(told[UPPER], 0, rows), floats(told[WORK], 0, n)
    if not step:
        limited, braked = told[VELOCITY] != 0, told[ACCELERATION] != 0
        v, tick = floats(told[V], 0, n), floats(told[TICK], 0, 2)
        velocity = floats(told[VELOCITY] if limited else told[V], 0, n)
        acceleration = floats(told[ACCELERATION] if braked else told[V], 0, n)
        fastest(v, velocity, limited, acceleration, braked, tick[1], told[ORDER] == of.ACCELERATION, w)
    r = 0
    for k in range(pairs):
        if chosen[k] == 0:
            continue
        found, address = floats(scene[near.FOUND], near.PAIR * k, near.PAIR), blocks[k // obstacles]
        row = floats(told[MATRIX], r * n, n)
        for j in range(n):
            row[j] = 0.0
        gradient(address, n, found[near.NORMAL :], found[near.WITNESS :], 1.0, row)
        if step:
            lower[r] = floats(told[NUMBERS], 0, 1)[0] - found[near.DISTANCE]
        else:
            shape = floats(scene[near.SHAPES], near.SHAPE * (k % obstacles), near.SHAPE)
            lower[r] = least(told, address, found, shape, row, w)
        upper[r] = math.inf
        r += 1
    return 0


@stamp
@entry
def write_avoidance(here):
    """Write the row of an avoidance task, that of the closest pair."""
    told = ints(here, 0, 10)
    n, accelerating = told[N], told[ORDER] == of.ACCELERATION
    near.measure(told[PAIRS])
    scene = ints(told[PAIRS], 0, near.LENGTH)
    obstacles = scene[near.OBSTACLES]
    pairs, best = scene[near.LINKS] * obstacles, 0
    every = floats(scene[near.FOUND], 0, near.PAIR * pairs)
    for k in range(1, pairs):
        d, so_far = every[near.PAIR * k + near.DISTANCE], every[near.PAIR * best + near.DISTANCE]
        if d < so_far or (d != d and so_far == so_far):  # NaN comes first, so that the solver reports it
            best = k
    found = every[near.PAIR * best : near.PAIR * (best + 1)]
    shape = floats(scene[near.SHAPES], near.SHAPE * (best % obstacles), near.SHAPE)
    address = ints(scene[near.BLOCKS], 0, scene[near.LINKS])[best // obstacles]
    number, row = floats(told[NUMBERS], 0, 3), floats(told[MATRIX], 0, n)
    for j in range(n):
        row[j] = 0.0
    gradient(address, n, found[near.NORMAL :], found[near.WITNESS :], 1.0, row)
    near_by = 1.0 - found[near.DISTANCE] / number[INFLUENCE]
    s = near.share(near_by) if near_by == near_by else near_by
    fade = s * s * (3.0 - 2.0 * s)
    wanted = dot(found, near.NORMAL, shape, near.VELOCITY) + fade * number[SPEED]
    if accelerating:
        wanted = number[GAIN] * (wanted - speed_of(row, floats(told[V], 0, n)))
        wanted -= drift_along(address, found[near.NORMAL :], found[near.WITNESS :])
        wanted += dot(found, near.NORMAL, shape, near.ACCELERATION)
    for j in range(n):
        row[j] *= fade
    floats(told[LOWER], 0, 1)[0] = fade * wanted
    floats(told[UPPER], 0, 1)[0] = fade * wanted
    return 0


@stamp
@entry
def write_bodies(here):
    """Write the rows of a self-collision limit, from the distances and normals of its pairs."""
    told = ints(here, 0, 11)
    n, rows, order = told[N], told[ROWS], told[ORDER]
    lower, upper, v = floats(told[LOWER], 0, rows), floats(told[UPPER], 0, rows), floats(told[V], 0, n)
    number, tick = floats(told[NUMBERS], 0, 2), floats(told[TICK], 0, 2)
    bodies = ints(told[BODIES], 0, 2 * rows)
    for r in range(rows):
        contact, row = floats(told[CONTACTS], CONTACT * r, CONTACT), floats(told[MATRIX], r * n, n)
        first, second, normal = bodies[2 * r], bodies[2 * r + 1], contact[NORMAL:]
        for j in range(n):
            row[j] = 0.0
        gradient(first, n, normal, contact[FIRST:], 1.0, row)
        gradient(second, n, normal, contact[SECOND:], -1.0, row)
        room, upper[r] = contact[DISTANCE] - number[0], math.inf
        if order == of.DISPLACEMENT:
            lower[r] = -room
            continue
        drift = 0.0
        if order == of.ACCELERATION or tick[0] < math.inf:
            drift = drift_along(first, normal, contact[FIRST:]) - drift_along(second, normal, contact[SECOND:])
        room, gain = in_time(room, drift, number[1], tick[0], tick[1])
        lower[r] = -gain * room
        if order == of.ACCELERATION:
            lower[r] = (lower[r] - speed_of(row, v)) / tick[1] - drift
    return 0
