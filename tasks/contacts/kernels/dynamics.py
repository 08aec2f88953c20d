"""The rows of a floating base, and wrenches from outside."""

from __future__ import annotations

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at
from ...rows.kernels import motion

#: After what is told of the motion: the bounds.
LOWER, UPPER = range(motion.LENGTH, motion.LENGTH + 2)


@stamp
@entry
def write_dynamics(here):
    """``M a - G^T f = -b`` of the base."""
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
    """A wrench from outside at a frame, taken off the bias: joint velocities, block, wrench (6,), bias (n,)."""
    told = ints(here, 0, 4)
    n = told[0]
    J, wrench, bias = floats(told[1], at.JACOBIAN, 6 * n), floats(told[2], 0, 6), floats(told[3], 0, n)
    for k in range(6):
        for j in range(n):
            bias[j] -= J[k * n + j] * wrench[k]
    return 0
