"""The aim of damping: at acceleration order it brakes the joints, so that they do not oscillate."""

from __future__ import annotations

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints


@stamp
@entry
def write_damping(here):
    """Write the aim -2 r v of damping (0 if r is not positive) as lower and upper bounds.

    Table: number of joints, the rate r [1/s] of each, v, lower bounds, upper bounds.
    """
    told = ints(here, 0, 5)
    rows, rate = told[0], floats(told[1], 0, told[0])
    v, lower, upper = floats(told[2], 0, rows), floats(told[3], 0, rows), floats(told[4], 0, rows)
    for r in range(rows):
        lower[r] = upper[r] = -2.0 * rate[r] * v[r] if rate[r] > 0.0 else 0.0
    return 0
