"""Writes the rows of a velocity limit of a frame."""

from __future__ import annotations

from hqp.kernels.compile import entry, integer, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at
from ...rows.kernels import law as of
from . import placement as frames

#: Table: the table of the law, the block of the frame, work space of 64 numbers, the axes, coordinates and limits.
LAW, BLOCK, WORK, AXES, MASK, LIMIT = range(6)


@stamp
@entry
def write_speed_limit(here):
    """Write rows that keep the velocity of each coordinate within its limit (at acceleration order: after the tick)."""
    told = ints(here, 0, 6)
    law = ints(told[LAW], 0, of.LENGTH)
    rows, n, axes = law[of.ROWS], law[of.N], told[AXES]
    block, J = floats(told[BLOCK], 0, at.JACOBIAN), floats(told[BLOCK], at.JACOBIAN, 6 * n)
    work, mask, limit = floats(told[WORK], 0, 64), ints(told[MASK], 0, rows), floats(told[LIMIT], 0, rows)
    lower, upper = floats(law[of.LOWER], 0, rows), floats(law[of.UPPER], 0, rows)
    frames.jacobian(axes, block, J, n, mask, integer(0), rows, floats(law[of.MATRIX], 0, rows * n), work)
    if law[of.ORDER] == of.VELOCITY:
        for r in range(rows):
            lower[r], upper[r] = -limit[r], limit[r]
        return 0
    frames.along(axes, block, block, at.LINEAR_DRIFT, work, 32)
    frames.turning(axes, block, work)
    of.moving(told[LAW])
    dt, now = floats(law[of.TICK], 1, 1)[0], floats(law[of.MEASURED], of.NOW * rows, rows)
    for r in range(rows):
        drift = work[32 + mask[r]] + work[mask[r]]
        lower[r], upper[r] = (-limit[r] - now[r]) / dt - drift, (limit[r] - now[r]) / dt - drift
    return 0
