r"""Writes the rows of joints with a desired velocity, one row of the identity for each.

.. math:: \text{velocity}\quad v = v^d \qquad \text{acceleration}\quad a = \dot v^d + K (v^d - v)

With K = 1/dt the velocity is reached at the end of the tick.
"""

from __future__ import annotations

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

from ...rows.kernels import law as of

#: Table: the order, number of rows, of joint velocities; the joint of each row; joint velocities; desired velocities
#: and their rates (2 x rows); K of every row [1/s]; and the bounds.
ORDER, ROWS, N, COLUMNS, V, TARGET, GAIN, LOWER, UPPER = range(9)


@stamp
@entry
def write_speeds(here):
    """Write the bounds of joints with a desired velocity."""
    told = ints(here, 0, UPPER + 1)
    rows = told[ROWS]
    columns, v, target = ints(told[COLUMNS], 0, rows), floats(told[V], 0, told[N]), floats(told[TARGET], 0, 2 * rows)
    gain, lower, upper = floats(told[GAIN], 0, rows), floats(told[LOWER], 0, rows), floats(told[UPPER], 0, rows)
    for r in range(rows):
        h = target[r]
        if told[ORDER] == of.ACCELERATION:
            h = target[rows + r] + gain[r] * (target[r] - v[columns[r]])
        lower[r] = upper[r] = h
    return 0
