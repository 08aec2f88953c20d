r"""Loops of balance: the rows of the centroidal momentum, of the capture point, and of the support polygon.

:mod:`tasks.contacts.balance` has the equations of the capture point and of the pendulum.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at
from ...rows.kernels import law as of
from . import layout as own

#: Acceleration of gravity [m/s^2].
GRAVITY = 9.81
#: Smallest height [m] of the pendulum; a contact whose normal has a smaller cosine with the vertical is a wall.
LOW, WALL = 1e-3, 0.5
#: Points count as the same, or as on a line, up to this squared distance, or twice the area that they span [m^2].
FLAT = 1e-10
#: The first corner of a hull is the farthest along (1, ASLANT), to which few edges of feet are perpendicular.
ASLANT = 0.4142
#: Entries of a contact that may bear: its slot; block of its frame; axes of its surface; its points, and how many.
SLOT, BLOCK, AXES, POINTS, COUNT = range(5)
FIELDS = 5


#: Table of a momentum: the table of its law; the map G (6 x n, by columns) and its drift; the first of the six rows of
#: G that counts; target and its rate.
LAW, MAP, DRIFT, FIRST, TARGET = range(5)


@stamp
@entry
def write_momentum(here):
    """Write the rows G v = target of the centroidal momentum (at acceleration order G a = rate + K e - drift)."""
    told = ints(here, 0, TARGET + 1)
    law = ints(told[LAW], 0, of.LENGTH)
    rows, n, order, first = law[of.ROWS], law[of.N], law[of.ORDER], told[FIRST]
    A, measured = floats(law[of.MATRIX], 0, rows * n), floats(law[of.MEASURED], 0, of.KINDS * rows)
    number = floats(law[of.NUMBERS], 0, of.FIELDS * rows)
    lower, upper = floats(law[of.LOWER], 0, rows), floats(law[of.UPPER], 0, rows)
    G, drift, target = floats(told[MAP], 0, 6 * n), floats(told[DRIFT], 0, 6), floats(told[TARGET], 0, 2 * rows)
    v = floats(law[of.V], 0, n)
    for r in range(rows):
        now = 0.0
        for j in range(n):
            A[r * n + j] = G[6 * j + first + r]
            now += A[r * n + j] * v[j]
        e = target[r] - now
        measured[r], measured[rows + r], measured[of.DRIFT * rows + r] = e, target[rows + r], drift[first + r]
        below, above = number[of.BELOW * rows + r], number[of.ABOVE * rows + r]
        if order == of.ACCELERATION:
            h, K = target[rows + r] - drift[first + r], number[r]
            lower[r], upper[r] = h + K * (e + below), h + K * (e + above)
        else:
            lower[r], upper[r] = target[r] + below, target[r] + above
    return 0


@inner
def bearing(told, count, x, y):
    """Write x and y of all points of contacts that bear; returns how many, and their mean height.

    `told` is the address of the list of `count` contacts.
    """
    found, height = 0, 0.0
    for c in range(count):
        contact = ints(told, FIELDS * c, FIELDS)
        slot, axes = floats(contact[SLOT], 0, own.SLOT_SIZE), floats(contact[AXES], 0, 9)
        if slot[own.BEARS] == 0.0 or not axes[8] > WALL:
            continue
        block = floats(contact[BLOCK], 0, at.JACOBIAN)
        points = floats(contact[POINTS], 0, 3 * contact[COUNT])
        F = at.ROTATION
        for i in range(contact[COUNT]):
            a, b, d = points[3 * i], points[3 * i + 1], points[3 * i + 2]
            x[found] = block[0] + block[F] * a + block[F + 1] * b + block[F + 2] * d
            y[found] = block[1] + block[F + 3] * a + block[F + 4] * b + block[F + 5] * d
            height += block[2] + block[F + 6] * a + block[F + 7] * b + block[F + 8] * d
            found += 1
    return found, height / max(found, 1)


@inner
def rate(centre, height):
    """omega [1/s] of the pendulum; `centre` is the block of the centre of mass, `height` that of the ground."""
    return math.sqrt(GRAVITY / max(centre[2] - height, LOW))


#: Table of a capture point and of a support: the order, number of joint velocities; block of the centre of mass;
#: number of contacts, their list; A and bounds. Then, for a capture point: target, gain; for a support: margin and
#: gain, number of rows, most points, work space.
ORDER, N, CENTRE, CONTACTS, TABLE, MATRIX, LOWER, UPPER = range(8)
GOAL, GAIN = 8, 9
MARGIN, ROWS, MOST, WORK = 8, 9, 10, 11


@stamp
@entry
def write_capture_point(here):
    """Write the two rows that bring the capture point to its target."""
    told = ints(here, 0, GAIN + 1)
    n = told[N]
    centre, J = floats(told[CENTRE], 0, at.JACOBIAN), floats(told[CENTRE], at.JACOBIAN, 2 * n)
    A, lower, upper = floats(told[MATRIX], 0, 2 * n), floats(told[LOWER], 0, 2), floats(told[UPPER], 0, 2)
    target, K = floats(told[GOAL], 0, 4), floats(told[GAIN], 0, 1)[0]
    found, height = 0, 0.0
    for c in range(told[CONTACTS]):  # the mean height of the points that bear
        contact = ints(told[TABLE], FIELDS * c, FIELDS)
        slot, axes = floats(contact[SLOT], 0, own.SLOT_SIZE), floats(contact[AXES], 0, 9)
        block, points = floats(contact[BLOCK], 0, at.JACOBIAN), floats(contact[POINTS], 0, 3 * contact[COUNT])
        if slot[own.BEARS] != 0.0 and axes[8] > WALL:
            F = at.ROTATION + 6
            for i in range(contact[COUNT]):
                height += block[2]
                for k in range(3):
                    height += block[F + k] * points[3 * i + k]
                found += 1
    omega = rate(centre, height / max(found, 1))
    for k in range(2 * n):
        A[k] = J[k]
    for r in range(2):
        speed = centre[at.LINEAR_VELOCITY + r]
        if told[ORDER] == of.ACCELERATION:
            e = target[r] - centre[r] - speed / omega
            h = omega * (target[2 + r] + K * e - speed) - centre[at.LINEAR_DRIFT + r]
        else:
            h = (omega if told[ORDER] == of.VELOCITY else 1.0) * (target[r] - centre[r])
        lower[r] = upper[r] = h
    return 0


@inner
def turn(x, y, i, j, a, b):
    """Twice the area of the triangle of points i, j of x, y and (a, b); positive if it is counter-clockwise [m^2]."""
    return (x[j] - x[i]) * (b - y[i]) - (y[j] - y[i]) * (a - x[i])


@inner
def hull(x, y, count, out_x, out_y):
    """Write the corners of the convex hull of `count` points, counter-clockwise; returns how many: two for a line.

    Monotone chains of the exact hull, without any tolerance: corners would be lost whose order along the sweep is one
    of round-off, as of feet side by side. Then corners are left out that lie on another one, or on a line with their
    neighbours. Sorts the points x, y in place.
    """
    for i in range(1, count):
        a, b, k = x[i], y[i], i
        while k > 0 and (x[k - 1] > a or (x[k - 1] == a and y[k - 1] > b)):
            x[k], y[k] = x[k - 1], y[k - 1]
            k -= 1
        x[k], y[k] = a, b
    size, least = 0, 2
    for step in range(2 * count - 1):  # the lower chain, then the upper one backwards
        i = step if step < count else 2 * count - 2 - step
        while size >= least and turn(out_x, out_y, size - 2, size - 1, x[i], y[i]) <= 0.0:
            size -= 1
        out_x[size], out_y[size] = x[i], y[i]
        size += 1
        if step == count - 1:
            least = size + 1
    return without_flat(out_x, out_y, max(size - 1, 1))  # the last corner is the first one again


@inner
def without_flat(x, y, size):
    """Leave out corners of a hull that lie on another one, or on a line with their neighbours; returns how many stay.

    Of a hull without area the two ends stay, of a point one. The first corner is one that round-off does not change
    from tick to tick, so that each edge keeps its row. Room for twice the corners is needed.
    """
    i, j, most = 0, 0, FLAT
    for a in range(size):  # the ends
        for b in range(a):
            length = (x[a] - x[b]) ** 2 + (y[a] - y[b]) ** 2
            if length > most:
                i, j, most = b, a, length
    first_x, first_y, last_x, last_y = x[i], y[i], x[j], y[j]
    kept = 0
    for k in range(size):
        before, a, b = (kept if kept > 0 else size) - 1, x[k], y[k]
        after = k + 1 if k + 1 < size else 0
        if (a - x[before]) ** 2 + (b - y[before]) ** 2 <= FLAT or turn(x, y, before, k, x[after], y[after]) <= FLAT:
            continue
        x[kept], y[kept] = a, b
        kept += 1
    if kept > 2:
        first = 0
        for k in range(kept):
            x[kept + k], y[kept + k] = x[k], y[k]
            if x[k] + ASLANT * y[k] > x[kept + first] + ASLANT * y[kept + first]:
                first = k
        for k in range(kept):
            x[k], y[k] = x[kept + (first + k) % kept], y[kept + (first + k) % kept]
        return kept
    x[0], y[0], x[1], y[1] = first_x, first_y, last_x, last_y
    return 1 if i == j else 2


@inner
def edge(x, y, size, k):
    """Outward normal (a, b) and distance of edge k of a hull of `size` corners: a x + b y is at most the distance.

    A hull that is a line or a point has four edges. NaN if there is no edge k.
    """
    if size == 0 or k >= max(size, 4 if size < 3 else size):
        return math.nan, math.nan, math.nan
    if size == 1:
        a, b = (1.0, 0.0) if k < 2 else (0.0, 1.0)
        if k % 2:
            a, b = -a, -b
        return a, b, a * x[0] + b * y[0]
    i, j = (k, (k + 1) % size) if size > 2 else (k % 2, (k + 1) % 2)
    dx, dy = x[j] - x[i], y[j] - y[i]
    length = math.sqrt(dx * dx + dy * dy)
    a, b = dy / length, -dx / length
    if size == 2 and k >= 2:  # the ends of a line
        a, b, i = dx / length, dy / length, j
    return a, b, a * x[i] + b * y[i]


@stamp
@entry
def write_support(here):
    """Write a row for every edge of the support polygon: the capture point stays inside it, by a margin."""
    told = ints(here, 0, WORK + 1)
    n, rows, most = told[N], told[ROWS], told[MOST]
    centre, J = floats(told[CENTRE], 0, at.JACOBIAN), floats(told[CENTRE], at.JACOBIAN, 2 * n)
    A, lower, upper = floats(told[MATRIX], 0, rows * n), floats(told[LOWER], 0, rows), floats(told[UPPER], 0, rows)
    margin, K = floats(told[MARGIN], 0, 1)[0], floats(told[MARGIN], 1, 1)[0]
    x, y = floats(told[WORK], 0, most), floats(told[WORK], most, most)
    hull_x, hull_y = floats(told[WORK], 2 * most, 2 * most + 4), floats(told[WORK], 4 * most + 4, 2 * most + 4)
    count, height = bearing(told[TABLE], told[CONTACTS], x, y)
    size = hull(x, y, count, hull_x, hull_y) if count > 0 else 0
    omega = rate(centre, height)
    if size < 3:
        margin = 0.0
    for k in range(size if size > 2 else 0):  # the margin is at most 0.4 of the width in every direction
        a, b, d = edge(hull_x, hull_y, size, k)
        width = 0.0
        for i in range(size):
            width = max(width, d - a * hull_x[i] - b * hull_y[i])
        margin = min(margin, 0.4 * width)
    for r in range(rows):
        a, b, d = edge(hull_x, hull_y, size, r)
        if a != a:
            for j in range(n):
                A[r * n + j] = 0.0
            lower[r], upper[r] = -math.inf, math.inf
            continue
        for j in range(n):
            A[r * n + j] = a * J[j] + b * J[n + j]
        room = d - margin - a * centre[0] - b * centre[1]
        speed = a * centre[at.LINEAR_VELOCITY] + b * centre[at.LINEAR_VELOCITY + 1]
        drift = a * centre[at.LINEAR_DRIFT] + b * centre[at.LINEAR_DRIFT + 1]
        lower[r] = -math.inf
        if told[ORDER] == of.ACCELERATION:
            upper[r] = omega * (K * (room - speed / omega) - speed) - drift
        else:
            upper[r] = K * room if told[ORDER] == of.VELOCITY else room
    return 0
