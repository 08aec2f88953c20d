"""Writes the joint motion that solves one task alone, for :mod:`tasks.joints.joint_motion`."""

from __future__ import annotations

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.algebra import alone

#: Table: number of rows of the task, of unknowns; its J (rows, n) and h (rows,); lambda; work space; the bounds.
ROWS, N, J, H, DAMPING, WORK, LOWER, UPPER = range(8)


def work_size(rows: int, n: int) -> int:
    """The size of the work space."""
    return rows * (n + rows + 1)


@stamp
@entry
def write_alone(here):
    """Write the bounds ``x = J# h``, damped by lambda."""
    told = ints(here, 0, UPPER + 1)
    rows, n = told[ROWS], told[N]
    matrix, h, damping = floats(told[J], 0, rows * n), floats(told[H], 0, rows), floats(told[DAMPING], 0, 1)
    work, lower, upper = (
        floats(told[WORK], 0, rows * (n + rows + 1)),
        floats(told[LOWER], 0, n),
        floats(told[UPPER], 0, n),
    )
    alone(matrix, rows, n, h, damping[0], lower, work)
    for j in range(n):
        upper[j] = lower[j]
    return 0
