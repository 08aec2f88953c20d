"""Rows of torque limits. Those of joint motion are in :mod:`tasks.rows.kernels.envelope`."""

from __future__ import annotations

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

from ..rows.kernels import motion

#: After what is told of the motion: the bounds, and the largest torques.
LOWER, UPPER, LARGEST = range(motion.LENGTH, motion.LENGTH + 3)


@stamp
@entry
def write_torque_limit(here):
    r"""``-tau_max - b <= M a - G^T f <= tau_max - b``."""
    told = ints(here, 0, motion.LENGTH + 3)
    rows = told[motion.ROWS]
    motion.motion_rows(here)
    lower, upper = floats(told[LOWER], 0, rows), floats(told[UPPER], 0, rows)
    bias, limit = floats(told[motion.BIAS], told[motion.FIRST], rows), floats(told[LARGEST], 0, rows)
    for j in range(rows):
        lower[j], upper[j] = -limit[j] - bias[j], limit[j] - bias[j]
    return 0
