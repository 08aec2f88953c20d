r"""The control law of every task, for all orders: from what is measured to the bounds of its rows.

With the error e, its feed-forwards r', r'' and the drift J' v of a row, and the gain K:

.. math::

    \text{velocity}\quad & J v = r' + K e \\
    \text{acceleration}\quad & J a = r'' - J' v + c_1 (r' - J v) + c_2 e \\
    \text{step}\quad & J\,dq = e

and for an inequality the same of e + below and e + above. Where the joints brake by no more than a limit, an inequality
is kept in time: see :mod:`tasks.rows.inequality`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

#: Of the table of a law: the order; how many rows, unknowns; the rows that it owns (MATRIX is 0 where they are plain),
#: its numbers, what is measured, the velocities; rate and tick; whether it only bounds, and whether drift and speed are
#: measured.
ORDER, ROWS, N, MATRIX, LOWER, UPPER, NUMBERS, MEASURED, V, TICK, BOUNDS, DRIFTS = range(12)
LENGTH = 12
#: The orders, and their names.
VELOCITY, ACCELERATION, STEP = range(3)
ORDERS = ("velocity", "acceleration", "step")
#: Numbers of every row: K [1/s], c1 [1/s], c2 [1/s^2]; how far below and above the target.
GAIN, C1, C2, BELOW, ABOVE = range(5)
FIELDS = 5
#: What is measured of every row.
ERROR, RATE, CHANGE, DRIFT, NOW = range(5)
KINDS = 5


@inner
def law(table):
    """Bounds of all rows of a task from what is measured of them; `table` is the address of what it is told."""
    told = ints(table, 0, LENGTH)
    rows, order = told[ROWS], told[ORDER]
    number, measured = floats(told[NUMBERS], 0, FIELDS * rows), floats(told[MEASURED], 0, KINDS * rows)
    lower, upper, tick = floats(told[LOWER], 0, rows), floats(told[UPPER], 0, rows), floats(told[TICK], 0, 2)
    in_time = told[BOUNDS] != 0 and tick[0] < math.inf and order != STEP
    for r in range(rows):
        e, rate, change = measured[r], measured[rows + r], measured[2 * rows + r]
        drift, now = measured[3 * rows + r], measured[4 * rows + r]
        K, below, above = number[r], number[BELOW * rows + r], number[ABOVE * rows + r]
        if order == STEP:
            lower[r], upper[r] = e + below, e + above
        elif in_time:
            lower[r], upper[r] = kept_in_time(order, e, rate, drift, now, min(K, tick[0]), below, above, tick[1])
        elif order == VELOCITY:
            h = rate + K * e
            lower[r], upper[r] = h + K * below, h + K * above
        else:
            c2 = number[C2 * rows + r]
            h = number[C1 * rows + r] * (rate - now) + c2 * e - drift + change
            lower[r], upper[r] = h + c2 * below, h + c2 * above


@inner
def kept_in_time(order, e, rate, drift, now, K, below, above, dt):
    """Both bounds of an inequality whose joints brake by no more than a limit; see :mod:`tasks.rows.inequality`."""
    known = e + rate + drift + now
    if known != known:
        return math.nan, math.nan
    # What the bend of the way takes, on each side: half of what a stop of the length 1/K makes of it.
    bend = 0.5 * (1.0 / K + dt) / K
    high, low = e + above, e + below
    high = max(high - bend * max(drift, 0.0), min(high, 0.0))
    low = min(low + bend * max(-drift, 0.0), max(low, 0.0))
    if order == VELOCITY:
        return rate + K * low, rate + K * high
    # The velocity at the end of the tick obeys the same law, at the place where it then is.
    half = 0.5 * K * dt
    least = (rate + K * low - half * (now - rate)) / (1.0 + half)
    most = (rate + K * high - half * (now - rate)) / (1.0 + half)
    return (least - now) / dt - drift, (most - now) / dt - drift


@inner
def moving(table):
    """How fast the value of every row moves, J v, from the rows of A."""
    told = ints(table, 0, LENGTH)
    rows, n = told[ROWS], told[N]
    A, v = floats(told[MATRIX], 0, rows * n), floats(told[V], 0, n)
    now = floats(told[MEASURED], NOW * rows, rows)
    for r in range(rows):
        total = 0.0
        for j in range(n):
            total += A[r * n + j] * v[j]
        now[r] = total


@stamp
@entry
def write_law(here):
    """The rows of a task that measures itself: all but the bounds are there."""
    law(ints(here, 0, 1)[0])
    return 0
