"""Loops that write the rows of tasks of forces and torques."""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

from ...rows.kernels import motion
from . import layout as own


@stamp
@entry
def write_least_forces(here):
    """Write the bounds 0 of forces. Table: number of forces, lower bounds, upper bounds."""
    told = ints(here, 0, 3)
    lower, upper = floats(told[1], 0, told[0]), floats(told[2], 0, told[0])
    for r in range(told[0]):
        lower[r] = upper[r] = 0.0
    return 0


@stamp
@entry
def write_force_sum(here):
    """Write the bounds of a sum of forces, its target; infinite while the contact is off.

    Table: slot, number of rows, target, lower bounds, upper bounds.
    """
    told = ints(here, 0, 5)
    rows, on = told[1], floats(told[0], 0, own.SLOT_SIZE)[own.ON] != 0.0
    target, lower, upper = floats(told[2], 0, rows), floats(told[3], 0, rows), floats(told[4], 0, rows)
    for r in range(rows):
        lower[r], upper[r] = (target[r], target[r]) if on else (-math.inf, math.inf)
    return 0


#: Table of a centre of pressure: whether forces are one wrench; number of points, the points; the target; number of all
#: unknowns, the first of this contact; A and bounds.
WRENCH, COUNT, POINTS, TARGET, UNKNOWNS, FIRST, MATRIX, LOWER, UPPER = range(9)


@stamp
@entry
def write_pressure(here):
    """Write two rows: the tangential moments about the target are 0. Columns of other unknowns are 0 already."""
    told = ints(here, 0, UPPER + 1)
    n, first, count = told[UNKNOWNS], told[FIRST], told[COUNT]
    A, points, target = floats(told[MATRIX], 0, 2 * n), floats(told[POINTS], 0, 3 * count), floats(told[TARGET], 0, 2)
    for i in range(count):
        for r in range(2):
            A[r * n + first + 3 * i + 2] = points[3 * i + r] - target[r]
    if told[WRENCH] != 0:
        A[first + 4], A[n + first + 3] = -1.0, 1.0
    lower, upper = floats(told[LOWER], 0, 2), floats(told[UPPER], 0, 2)
    for r in range(2):
        lower[r] = upper[r] = 0.0
    return 0


#: Table of torques: after the entries of :mod:`tasks.rows.kernels.motion`, the target, and the bounds.
TAU, T_LOWER, T_UPPER = range(motion.LENGTH, motion.LENGTH + 3)


@stamp
@entry
def write_torques(here):
    """Write the rows ``M a - G^T f = tau - b`` for the target torques tau."""
    told = ints(here, 0, motion.LENGTH + 3)
    rows = told[motion.ROWS]
    motion.motion_rows(here)
    lower, upper, tau = floats(told[T_LOWER], 0, rows), floats(told[T_UPPER], 0, rows), floats(told[TAU], 0, rows)
    bias = floats(told[motion.BIAS], told[motion.FIRST], rows)
    for r in range(rows):
        lower[r] = upper[r] = tau[r] - bias[r]
    return 0
