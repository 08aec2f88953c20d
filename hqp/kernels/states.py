"""The rows of a hierarchy at x, as the certificate sees them: slacks, tolerances and sides."""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner
from .memory import ints, marks, vector
from .orthogonal import length
from .rows import EQUALITY, INACTIVE, LOWER, UPPER, value_of

#: As in :mod:`hqp.certificate.rows`: round-off of rows, and the share of ``||a_i|| ||x||`` in the tolerance of a row.
ROUND_OFF, LENGTH = 256 * 2.0**-52, 0.1
#: A row that is at a bound up to round-off, and holds no level, as far as is known.
CLOSE = -1


@inner
def measure_rows(here, levels, reference, value, slack):
    """Write the `value` and the `slack`, each (m,), of the rows of levels 0 .. levels - 1.

    Returns ``||x||``, and the distance T of :func:`hqp.certificate.rows.travel`, to which round-off is relative; x_ref
    is the `reference` there.
    """
    ptr, norm, weights = marks(here, at.PTR), vector(here, at.NORM), vector(here, at.WEIGHTS)
    n, lo, hi, x = ints(here, 0, at.HEAD)[at.N], vector(here, at.LO), vector(here, at.HI), vector(here, at.X)
    away, longest = 0.0, 0.0
    for j in range(n):
        away += (x[j] - reference[j]) * (x[j] - reference[j])
    for i in range(ptr[levels]):
        longest = max(longest, norm[i] / weights[i])
    size = length(x, n)
    way = max(size, math.sqrt(away))
    for k in range(levels):
        most, asked, rows = 0.0, 0.0, 0
        for i in range(ptr[k], ptr[k + 1]):
            value[i] = value_of(i, x, here) if norm[i] > 0.0 else 0.0
            slack[i] = value[i] - min(max(value[i], lo[i]), hi[i])
            most, rows = max(most, norm[i]), rows + (norm[i] > 0.0)
            if norm[i] > ROUND_OFF * longest * weights[i]:
                asked = max(asked, abs(slack[i]) * norm[i])
        if rows > 1:
            way = max(way, asked / (most * most))
    return size, way


@inner
def room_of(value, slack, norm, tolerance, size, way):
    """How far a row may be from its bound and still count as on it, :func:`hqp.certificate.rows.allowance`.

    `size` and `way` are those of :func:`measure_rows`.
    """
    return tolerance * (abs(value) + abs(value - slack)) + (tolerance * LENGTH * size + ROUND_OFF * way) * norm


@inner
def find_sides(here):
    """Write the side of every row at x to ``held``, EQUALITY if its multiplier is free, and its violation to ``slope``.

    Also, to ``lambda``, the tolerance of the row, and to ``decided`` CLOSE if it is at a bound up to round-off, else 0.
    Returns as :func:`measure_rows`.
    """
    head, norm, lo, hi = ints(here, 0, at.HEAD), vector(here, at.NORM), vector(here, at.LO), vector(here, at.HI)
    value, slack, side = vector(here, at.VALUE), vector(here, at.W), marks(here, at.HELD)
    violation, room, holds = vector(here, at.SLOPE), vector(here, at.LAMBDA), marks(here, at.DECIDED)
    size, way = measure_rows(here, head[at.LEVELS], vector(here, at.X_REF), value, slack)
    judged = vector(here, at.OPTION)[at.JUDGED]
    for i in range(head[at.ROWS]):
        side[i], room[i], violation[i], holds[i] = INACTIVE, 0.0, 0.0, 0
        if norm[i] == 0.0:
            continue
        near = room[i] = room_of(value[i], slack[i], norm[i], judged, size, way)
        if min(abs(value[i] - lo[i]), abs(value[i] - hi[i])) <= ROUND_OFF * norm[i] * way:
            holds[i] = CLOSE
        over, under = value[i] >= hi[i] - near, value[i] <= lo[i] + near
        if abs(slack[i]) > near:
            side[i], violation[i] = EQUALITY, slack[i]
        elif lo[i] == hi[i] or (over and under):
            side[i] = EQUALITY
        elif over:
            side[i] = UPPER
        elif under:
            side[i] = LOWER
    let_round_off_go(here)
    return size, way


@inner
def rely_on(here, sides):
    """Take the CLOSE mark from rows that are INACTIVE in `sides` (m,), those of a solver, if it has others at a bound.

    Where many rows meet, it has found out which of them balance the levels. Nothing hangs on that but where the search
    begins; without inequalities among the sides, none are known.
    """
    holds, known = marks(here, at.DECIDED), False
    for i in range(ints(here, 0, at.HEAD)[at.ROWS]):
        known = known or sides[i] == LOWER or sides[i] == UPPER
    for i in range(ints(here, 0, at.HEAD)[at.ROWS]):
        if known and sides[i] == INACTIVE and holds[i] == CLOSE:
            holds[i] = 0


@inner
def let_round_off_go(here):
    """Take inequalities for met, at their bound, whose violation may be the round-off of the forces of their level.

    Other rows, that are longer or further off, hide it. At a bound a row has a multiplier of one sign, violated of any.
    """
    head, ptr, norm = ints(here, 0, at.HEAD), marks(here, at.PTR), vector(here, at.NORM)
    lo, hi, side, violation = vector(here, at.LO), vector(here, at.HI), marks(here, at.HELD), vector(here, at.SLOPE)
    for k in range(head[at.LEVELS]):
        forces = 0.0
        for i in range(ptr[k], ptr[k + 1]):
            forces += norm[i] * abs(violation[i])
        for i in range(ptr[k], ptr[k + 1]):
            if violation[i] != 0.0 and lo[i] != hi[i] and norm[i] * abs(violation[i]) <= ROUND_OFF * forces:
                side[i], violation[i] = UPPER if violation[i] > 0.0 else LOWER, 0.0
