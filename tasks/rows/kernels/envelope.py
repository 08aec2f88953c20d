r"""Writes the bounds of all joint limits of one stack; each is widened just so far that it meets the harder ones.

:mod:`tasks.rows.envelope` explains how the limits are combined, :mod:`tasks.limits.position` how a joint keeps its
range.
"""

from __future__ import annotations

import math

import numpy as np

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from . import law as of

#: Table: the order, number of joints n; velocities; positions, their number, and the place of each joint among them
#: (-1: none); rate and tick; the tightest velocity and acceleration limits (n,), and the deceleration at the ends of
#: ranges (n,); the range of x that the limits so far leave, least and most (2 n,); the addresses of lower and upper
#: bounds that are written, and how many pairs; the claims, one for each limit, and how many.
ORDER, N, V, POSITIONS, NQ, PLACES, TICK = range(7)
VELOCITY, ACCELERATION, ENDS, LEFT, ROWS, ROWS_COUNT, CLAIMS, CLAIMS_COUNT = range(7, 15)
LENGTH = 15
#: Of a claim: its kind; lowest and highest value (2 n,) and the return speed; the lower and upper bounds that it cuts.
KIND, NUMBERS, LOWER, UPPER = range(4)
FIELDS = 4
#: Kinds of claims, the hardest first, and their names.
ACCELERATIONS, RANGE, SPEED = range(3)
KINDS = ("acceleration", "position", "velocity")
#: Room [rad] above which a joint is unbounded; change of speed in a tick [rad/s] of a joint without acceleration limit.
LARGEST, UNLIMITED = 1e15, 1.7976931348623157e308


@inner
def largest_velocity(room, acceleration, dt):
    r"""p_max of :mod:`tasks.limits.position`: the largest velocity [rad/s] from which a joint can stop in time.

    Parameters
    ----------
    room : float
        D [rad], the distance to the limit; infinite if the joint has none, negative outside its range.
    acceleration : float
        a_max [rad/s^2]; infinite if braking is unlimited.
    dt : float
        [s].
    """
    if room > LARGEST:
        return math.inf
    step, rate = min(acceleration * dt, UNLIMITED), room / dt
    steps = np.floor(0.5 * (math.sqrt(1.0 + 8.0 * max(rate, 0.0) / step) - 1.0))
    return (rate + step * (0.5 * steps * (steps + 1.0))) / (steps + 1.0)


@inner
def kept_range(order, q, v, low, high, return_speed, speed, acceleration, dt):
    """The least and the most x with which a joint keeps its range low .. high, or returns to it.

    `speed` is the tightest limit of this joint, `acceleration` that of its braking at the end of the range.
    """
    if order == of.DISPLACEMENT:
        return low - q, high - q
    if order == of.ACCELERATION:
        q = q + 0.5 * dt * v
    below, above = largest_velocity(q - low, acceleration, dt), largest_velocity(high - q, acceleration, dt)
    # A joint that is outside is driven back no faster than `back`, and so that it can stop at the end of its range.
    back = min(return_speed, speed)
    if below < 0.0:
        below = -min(back, largest_velocity(low - q, acceleration, dt), max(above, 0.0))
    elif above < 0.0:
        above = -min(back, largest_velocity(q - high, acceleration, dt), max(below, 0.0))
    least, most = -below, above
    if order == of.ACCELERATION:
        return (least - v) / dt, (most - v) / dt
    return least, most


@inner
def claimed(kind, order, v, low, high, dt):
    """The least and the most x of a joint by an acceleration limit or a velocity limit low .. high."""
    if kind == ACCELERATIONS and order == of.VELOCITY:
        return v + low * dt, v + high * dt
    if kind == SPEED and order == of.ACCELERATION:
        return (low - v) / dt, (high - v) / dt
    if order == of.DISPLACEMENT:
        return -math.inf, math.inf
    return low, high


@inner
def reach(told, least, most):
    """Write the range of x that the acceleration limits leave, to `least` and `most` (n,)."""
    n, order, dt = told[N], told[ORDER], floats(told[TICK], 1, 1)[0]
    v, acceleration = floats(told[V], 0, n), floats(told[ACCELERATION], 0, n)
    for j in range(n):
        least[j], most[j] = -math.inf, math.inf
        if acceleration[j] < math.inf and order == of.VELOCITY:
            least[j], most[j] = v[j] - acceleration[j] * dt, v[j] + acceleration[j] * dt
        elif order == of.ACCELERATION:
            least[j], most[j] = -acceleration[j], acceleration[j]


@inner
def write_claim(told, claim, least, most):
    """Cut the bounds of one limit down to its claim, widened to meet `least` and `most`, and then these as well."""
    n, order, kind, dt = told[N], told[ORDER], claim[KIND], floats(told[TICK], 1, 1)[0]
    v, q, places = floats(told[V], 0, n), floats(told[POSITIONS], 0, told[NQ]), ints(told[PLACES], 0, n)
    speed, ends = floats(told[VELOCITY], 0, n), floats(told[ENDS], 0, n)
    number, lower, upper = floats(claim[NUMBERS], 0, 2 * n + 1), floats(claim[LOWER], 0, n), floats(claim[UPPER], 0, n)
    for j in range(n):
        low, high = -math.inf, math.inf
        if kind != RANGE:
            low, high = claimed(kind, order, v[j], number[j], number[n + j], dt)
        elif places[j] >= 0:
            position, back = q[places[j]], number[2 * n]
            low, high = kept_range(order, position, v[j], number[j], number[n + j], back, speed[j], ends[j], dt)
        low, high = min(low, most[j]), max(high, least[j])
        least[j], most[j] = max(least[j], low), min(most[j], high)
        lower[j], upper[j] = max(lower[j], low), min(upper[j], high)


@inner
def braking_rate(told):
    """The largest rate [1/s] at which a bound may be approached; see :mod:`tasks.rows.envelope`."""
    n, dt = told[N], floats(told[TICK], 1, 1)[0]
    v, speed, acceleration = floats(told[V], 0, n), floats(told[VELOCITY], 0, n), floats(told[ACCELERATION], 0, n)
    longest = -math.inf
    for j in range(n):
        if acceleration[j] < math.inf and told[ORDER] != of.DISPLACEMENT:
            from_speed = speed[j] if speed[j] < math.inf else abs(v[j]) + acceleration[j] * dt
            longest = max(longest, from_speed / acceleration[j])
    return 1.0 / (longest + dt) if longest + dt > 0.0 else math.inf


@stamp
@entry
def write_joint_limits(here):
    """Write the bounds of all joint limits, and the braking rate (:func:`braking_rate`)."""
    told = ints(here, 0, LENGTH)
    n, rows, claims = told[N], told[ROWS_COUNT], told[CLAIMS_COUNT]
    least, most = floats(told[LEFT], 0, n), floats(told[LEFT], n, n)
    reach(told, least, most)
    places = ints(told[ROWS], 0, 2 * rows)
    for k in range(rows):
        lower, upper = floats(places[2 * k], 0, n), floats(places[2 * k + 1], 0, n)
        for j in range(n):
            lower[j], upper[j] = -math.inf, math.inf
    positioned = False
    for k in range(claims):
        claim = ints(told[CLAIMS], k * FIELDS, FIELDS)
        positioned = positioned or claim[KIND] == RANGE
        write_claim(told, claim, least, most)
    # min and max lose NaN: write it into the bounds again, so that the solver reports it.
    v, q, own = floats(told[V], 0, n), floats(told[POSITIONS], 0, told[NQ]), ints(told[PLACES], 0, n)
    for j in range(n):
        known = v[j]
        if positioned and own[j] >= 0:
            known = known + q[own[j]]
        if known != known:
            for k in range(rows):
                floats(places[2 * k], 0, n)[j] = floats(places[2 * k + 1], 0, n)[j] = math.nan
    floats(told[TICK], 0, 1)[0] = braking_rate(told)
    return 0
