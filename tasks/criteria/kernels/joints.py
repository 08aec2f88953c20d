"""Loops of criteria in joint space: the law of all gradients, joint centring, least motion, energy and torque."""

from __future__ import annotations

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.algebra import root
from ...rows.kernels.law import ACCELERATION

#: Table of every gradient: number of rows; the joint velocity of each; K [1/s] and 1.0 to increase the scalar, or -1.0
#: to decrease it; number of unknowns, velocities; the order; the bounds.
COUNT, COLUMNS, NUMBERS, UNKNOWNS, V, ORDER, LOWER, UPPER = range(8)
CLIMB = 8
#: Table of joint centring, after that: size of a configuration, positions, the place of each row among them; lowest and
#: highest positions (2 rows,); the gradient (nv,).
POSITIONS_SIZE, POSITIONS, PLACES, RANGE, SLOPE = range(CLIMB, CLIMB + 5)
#: Table of a criterion of all joints: number of unknowns; K [1/s], 0 without braking; velocities; bounds; M; A.
ALL, BRAKING, SPEEDS, LOW, HIGH, M, A = range(7)
#: Table of the least torque, after that: the bias, and the middle of the torque range.
BIAS, MIDDLE = range(7, 9)


@inner
def climb(here, slope):
    """Write the bounds ``x = K slope`` for a gradient, slope (nv,); at acceleration order ``x = K^2 slope - 2 K v``."""
    told = ints(here, 0, CLIMB)
    count, n = told[COUNT], told[UNKNOWNS]
    columns, number, v = ints(told[COLUMNS], 0, count), floats(told[NUMBERS], 0, 2), floats(told[V], 0, n)
    lower, upper = floats(told[LOWER], 0, count), floats(told[UPPER], 0, count)
    K = number[0]
    for k in range(count):
        wanted = number[1] * K * slope[columns[k]]
        if told[ORDER] == ACCELERATION:
            wanted = K * wanted - 2.0 * K * v[columns[k]]
        lower[k] = upper[k] = wanted


@stamp
@entry
def write_gradient(here):
    """Write the rows of a criterion from its gradient, which is the entry behind those of every gradient."""
    told = ints(here, 0, CLIMB + 1)
    climb(here, floats(told[CLIMB], 0, told[UNKNOWNS]))
    return 0


@inner
def centring(count, columns, places, positions, ends, slope):
    r"""Write the gradient of the mean squared distance from the middle m of the ranges: :math:`2 (q - m) / (n h^2)`.

    It is relative to half the width of each range, h; `ends` are lowest and highest positions (2 count,).
    """
    for k in range(count):
        half, middle = 0.5 * (ends[count + k] - ends[k]), 0.5 * (ends[count + k] + ends[k])
        slope[columns[k]] = 2.0 * ((positions[places[k]] - middle) / half) / (count * half)


@stamp
@entry
def write_centring(here):
    """Write the rows of joint centring."""
    told = ints(here, 0, SLOPE + 1)
    count = told[COUNT]
    columns, places = ints(told[COLUMNS], 0, count), ints(told[PLACES], 0, count)
    positions, ends = floats(told[POSITIONS], 0, told[POSITIONS_SIZE]), floats(told[RANGE], 0, 2 * count)
    slope = floats(told[SLOPE], 0, told[UNKNOWNS])
    centring(count, columns, places, positions, ends, slope)
    climb(here, slope)
    return 0


@inner
def brake(told, n, lower, upper):
    """Write the bounds of the least motion of each joint: ``-K v``, or 0 without braking."""
    K, v = floats(told[BRAKING], 0, 1)[0], floats(told[SPEEDS], 0, n)
    for j in range(n):
        lower[j] = upper[j] = -K * v[j] if K != 0.0 else 0.0


@stamp
@entry
def write_least_motion(here):
    """Write the rows of least joint motion."""
    told = ints(here, 0, HIGH + 1)
    n = told[ALL]
    brake(told, n, floats(told[LOW], 0, n), floats(told[HIGH], 0, n))
    return 0


@stamp
@entry
def write_kinetic_energy(here):
    """Write the rows ``L^T x = -L^T K v`` for M = L L^T; NaN if M is not positive definite."""
    told = ints(here, 0, A + 1)
    n = told[ALL]
    rows, lower, upper = floats(told[A], 0, n * n), floats(told[LOW], 0, n), floats(told[HIGH], 0, n)
    root(floats(told[M], 0, n * n), n, rows)
    brake(told, n, lower, upper)
    for r in range(n):
        total = 0.0
        for j in range(r, n):  # entries from r on are still those of the joints
            total += rows[r * n + j] * lower[j]
        lower[r] = upper[r] = total
    return 0


@stamp
@entry
def write_minimum_torque(here):
    """Write the rows ``M x = middle - bias``: torques in the middle of their range."""
    told = ints(here, 0, MIDDLE + 1)
    n = told[ALL]
    inertia, rows, lower, upper = (
        floats(told[M], 0, n * n),
        floats(told[A], 0, n * n),
        floats(told[LOW], 0, n),
        floats(told[HIGH], 0, n),
    )
    bias, middle = floats(told[BIAS], 0, n), floats(told[MIDDLE], 0, n)
    for t in range(n * n):
        rows[t] = inertia[t]
    for r in range(n):
        lower[r] = upper[r] = middle[r] - bias[r]
    return 0
