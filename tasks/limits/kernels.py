"""The loop that writes the rows of torque limits; joint motion limits are in :mod:`tasks.rows.kernels.envelope`."""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ..rows.kernels import motion

#: After what is told of the motion: the bounds, and the largest torques; the speeds of all and of no torque (2 x rows),
#: and the velocities.
LOWER, UPPER, LARGEST, SPEEDS, V = range(motion.LENGTH, motion.LENGTH + 5)


@inner
def share(speed, full, none):
    """Of the largest torque, what a motor gives that turns at this speed in its direction."""
    if speed <= full:
        return 1.0
    return max((none - speed) / (none - full), 0.0)


@stamp
@entry
def write_torque_limit(here):
    r"""``-tau_max - b <= M a - G^T f <= tau_max - b``."""
    told = ints(here, 0, motion.LENGTH + 5)
    rows = told[motion.ROWS]
    motion.motion_rows(here)
    lower, upper = floats(told[LOWER], 0, rows), floats(told[UPPER], 0, rows)
    bias, limit = floats(told[motion.BIAS], told[motion.FIRST], rows), floats(told[LARGEST], 0, rows)
    speeds, v = floats(told[SPEEDS], 0, 2 * rows), floats(told[V], told[motion.FIRST], rows)
    for j in range(rows):
        least, most = limit[j], limit[j]
        if speeds[j] < math.inf:
            least *= share(-v[j], speeds[j], speeds[rows + j])
            most *= share(v[j], speeds[j], speeds[rows + j])
        lower[j], upper[j] = -least - bias[j], most - bias[j]
    return 0
