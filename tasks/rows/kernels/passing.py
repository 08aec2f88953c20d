"""Whether an answer passes rows."""

from __future__ import annotations

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

#: By more than this share of its value, or of a unit, a row counts as passed, not as met up to round-off.
PASSED = 1e-9


@stamp
@entry
def passes(here):
    """1 if x passes a row, else 0.

    Table: number of unknowns n, x, number of blocks of rows; of each block the number of rows, A (rows, n), the lower
    and the upper bounds.
    """
    told = ints(here, 0, 3)
    n, x, blocks = told[0], floats(told[1], 0, told[0]), told[2]
    told = ints(here, 0, 3 + 4 * blocks)
    for p in range(3, 3 + 4 * blocks, 4):
        rows = told[p]
        A, lower, upper = floats(told[p + 1], 0, rows * n), floats(told[p + 2], 0, rows), floats(told[p + 3], 0, rows)
        for r in range(rows):
            value = 0.0
            for j in range(n):
                value += A[r * n + j] * x[j]
            if max(lower[r] - value, value - upper[r]) > PASSED * (1.0 + abs(value)):
                return 1
    return 0
