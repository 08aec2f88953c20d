"""Criteria in joint space as loops: the law of all gradients, joint centring, least motion, energy and torque."""

from __future__ import annotations

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.algebra import root
from ...rows.kernels.law import ACCELERATION

#: Of every gradient: how many rows; which velocities they are; K [1/s] and 1.0 where the scalar is to rise, -1.0 where
#: it is to fall; unknowns, and velocities; the order; the bounds.
COUNT, COLUMNS, NUMBERS, UNKNOWNS, V, ORDER, LOWER, UPPER = range(8)
CLIMB = 8
#: Of joint centring besides: numbers of a configuration, positions, where that of each row is; lowest and highest
#: position of each row; the gradient (nv,).
POSITIONS_SIZE, POSITIONS, PLACES, RANGE, SLOPE = range(CLIMB, CLIMB + 5)
#: Of a criterion of all joints: unknowns; K [1/s], 0 where nothing brakes; velocities; bounds; M; the rows.
ALL, BRAKING, SPEEDS, LOW, HIGH, M, A = range(7)
#: Of the least torque besides: the bias, and the middle of the range.
BIAS, MIDDLE = range(7, 9)


@inner
def climb(here, slope):
    """Bounds of a gradient, slope (nv,): ``x = K slope``, or at acceleration order ``K^2 slope - 2 K v``."""
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
    """Writes the rows of a criterion from its gradient, whatever measured it."""
    told = ints(here, 0, CLIMB + 1)
    climb(here, floats(told[CLIMB], 0, told[UNKNOWNS]))
    return 0


@inner
def centring(count, columns, places, positions, ends, slope):
    r"""The gradient of the mean squared distance from the middle of the ranges: :math:`2 (q - m) / (n h^2)`."""
    for k in range(count):
        half, middle = 0.5 * (ends[count + k] - ends[k]), 0.5 * (ends[count + k] + ends[k])
        slope[columns[k]] = 2.0 * ((positions[places[k]] - middle) / half) / (count * half)


@stamp
@entry
def write_centring(here):
    """Rows of joint centring."""
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
    """Bounds of the least motion of each joint: 0, or ``-K v``."""
    K, v = floats(told[BRAKING], 0, 1)[0], floats(told[SPEEDS], 0, n)
    for j in range(n):
        lower[j] = upper[j] = -K * v[j] if K != 0.0 else 0.0


@stamp
@entry
def write_least_motion(here):
    """Rows of least joint motion."""
    told = ints(here, 0, HIGH + 1)
    n = told[ALL]
    brake(told, n, floats(told[LOW], 0, n), floats(told[HIGH], 0, n))
    return 0


@stamp
@entry
def write_kinetic_energy(here):
    """Rows ``L^T x = -L^T K v`` for M = L L^T; NaN where M has no root."""
    told = ints(here, 0, A + 1)
    n = told[ALL]
    rows, lower, upper = floats(told[A], 0, n * n), floats(told[LOW], 0, n), floats(told[HIGH], 0, n)
    root(floats(told[M], 0, n * n), n, rows)
    brake(told, n, lower, upper)
    for r in range(n):
        total = 0.0
        for j in range(r, n):  # later entries are still those of the joints
            total += rows[r * n + j] * lower[j]
        lower[r] = upper[r] = total
    return 0


@stamp
@entry
def write_minimum_torque(here):
    """Rows ``M x = middle - bias``."""
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
