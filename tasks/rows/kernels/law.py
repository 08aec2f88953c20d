r"""The control law of every task, for all orders: computes the bounds of its rows from the measured values.

With the error e, the feed-forward velocity and acceleration r', r'', the drift J' v, and the gain K of a row:

.. math::

    \text{velocity}\quad & J v = r' + K e \\
    \text{acceleration}\quad & J a = r'' - J' v + c_1 (r' - J v) + c_2 e \\
    \text{displacement}\quad & J\,dq = e

An inequality has the same with e + below and e + above in place of e. For an equality, e is first multiplied by
:func:`share_of`, which caps its length, and lets the task stop at the target with a given deceleration. If the joints
have acceleration limits, an inequality brakes in time: see :mod:`tasks.rows.inequality`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

#: Table of a law: the order; number of rows, unknowns; A (0 if the rows are plain bounds), lower and upper bounds; the
#: numbers of the rows; the measured values; the velocities; rate and tick; whether it is an inequality; whether drift
#: and speed are measured; the longest error that counts and the deceleration (2,), and whether either is set.
ORDER, ROWS, N, MATRIX, LOWER, UPPER, NUMBERS, MEASURED, V, TICK, BOUNDS, DRIFTS, LONGEST, SHORTENS = range(14)
LENGTH = 14
#: The orders, and their names.
VELOCITY, ACCELERATION, DISPLACEMENT = range(3)
ORDERS = ("velocity", "acceleration", "displacement")
#: Numbers of every row, one kind after the other: K [1/s], c1 [1/s], c2 [1/s^2]; how far below (not positive) and above
#: the target the value may be; the largest error that counts.
GAIN, C1, C2, BELOW, ABOVE, CAP = range(6)
FIELDS = 6
#: Measured values of every row, one kind after the other: e, r', r'', J' v, J v.
ERROR, RATE, CHANGE, DRIFT, NOW = range(5)
KINDS = 5


@inner
def law(table):
    """Write the bounds of all rows of a task from their measured values; `table` is the address of its law's table."""
    told = ints(table, 0, LENGTH)
    rows, order = told[ROWS], told[ORDER]
    number, measured = floats(told[NUMBERS], 0, FIELDS * rows), floats(told[MEASURED], 0, KINDS * rows)
    lower, upper, tick = floats(told[LOWER], 0, rows), floats(told[UPPER], 0, rows), floats(told[TICK], 0, 2)
    if told[SHORTENS] != 0:
        share = share_of(order, rows, number, measured, floats(told[LONGEST], 0, 2))
        for r in range(rows):
            measured[r] *= share
    in_time = told[BOUNDS] != 0 and tick[0] < math.inf and order != DISPLACEMENT
    for r in range(rows):
        e, rate, change = measured[r], measured[rows + r], measured[2 * rows + r]
        drift, now = measured[3 * rows + r], measured[4 * rows + r]
        K, below, above = number[r], number[BELOW * rows + r], number[ABOVE * rows + r]
        if order == DISPLACEMENT:
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
def share_of(order, rows, number, measured, longest):
    r"""The share, up to 1, of an error e that counts: its length is at most a cap, and each entry at most its own.

    With a deceleration a, the task must also be able to stop at the target. The law asks for the speed u = K e
    (at acceleration order :math:`c_2 / c_1 e`), of length :math:`\kappa d`, d being the length of e. It is limited to
    :math:`\|u\| \le \sqrt{2 a (d - a / 2 \kappa^2)}` for :math:`d \ge a / \kappa^2`. Below that distance the
    exponential approach takes over, with the same speed and deceleration at this point.

    Parameters
    ----------
    longest : (2,)
        The cap on the length of e, and the deceleration a; infinite if not set.
    """
    share, square, speed = 1.0, 0.0, 0.0
    for r in range(rows):
        e, most = abs(measured[r]), number[CAP * rows + r]
        rate = number[r] if order != ACCELERATION else number[C2 * rows + r] / number[C1 * rows + r]
        square += e * e
        speed += rate * rate * e * e
        if e > most:
            share = min(share, most / e)
    length = math.sqrt(square)
    if length > longest[0]:
        share = min(share, longest[0] / length)
    if longest[1] < math.inf and speed > 0.0:
        end = longest[1] * square / speed
        if length > end:
            share = min(share, math.sqrt(2.0 * longest[1] * (length - 0.5 * end) / speed))
    return share


@inner
def kept_in_time(order, e, rate, drift, now, K, below, above, dt):
    """Both bounds of a row of an inequality under acceleration limits of joints; see :mod:`tasks.rows.inequality`."""
    known = e + rate + drift + now
    if known != known:
        return math.nan, math.nan
    # Room that the drift takes during a stop of duration 1/K, on the side to which it points: as much as there is, also
    # where the value is on its way back from beyond the other bound, so that the two never exclude each other.
    bend, low, high = 0.5 * (1.0 / K + dt) / K, e + below, e + above
    if drift > 0.0:
        high = max(high - bend * drift, min(high, max(low, 0.0)))
    else:
        low = min(low - bend * drift, max(low, min(high, 0.0)))
    if order == VELOCITY:
        return rate + K * low, rate + K * high
    # The velocity at the end of the tick must obey the same law at the position at that time.
    half = 0.5 * K * dt
    least = (rate + K * low - half * (now - rate)) / (1.0 + half)
    most = (rate + K * high - half * (now - rate)) / (1.0 + half)
    return (least - now) / dt - drift, (most - now) / dt - drift


@inner
def moving(table):
    """Measure the speed J v of every row from A and the velocities."""
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
    """Write the bounds of a task whose A and measured values are written elsewhere; the table has that of its law."""
    law(ints(here, 0, 1)[0])
    return 0
