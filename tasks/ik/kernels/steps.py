"""Loops of inverse kinematics: norms of the errors, and bounds of the step of every joint."""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

#: Table of :func:`judge`: number of rows, of groups (rows of one task in one unit), of levels; bounds of the rows; of
#: each row its group (-1: none), its level, whether it belongs to the goal, its squared weight; the squared tolerance
#: of each group. Out: 1 if the goal is reached; the norm of all errors of the goal; the squared norm of each group;
#: the weighted norm of each level.
ROWS, GROUPS, LEVELS, LOWER, UPPER, GROUP, LEVEL, GOAL, SQUARED, MOST, FOUND = range(11)
#: Table of :func:`open_room`: number of joints; positions, and the place of each joint among them (-1: none); lowest
#: and highest positions; radius and share (2,). Out: lowest and highest step.
JOINTS, POSITIONS, PLACES, LOW, HIGH, REACH, LEAST, FARTHEST = range(8)


@stamp
@entry
def judge(here):
    """Measure the errors at step 0, the violations of the bounds: by group, by level, and of the whole goal."""
    told = ints(here, 0, 11)
    rows, groups, levels = told[ROWS], told[GROUPS], told[LEVELS]
    lower, upper, squared = floats(told[LOWER], 0, rows), floats(told[UPPER], 0, rows), floats(told[SQUARED], 0, rows)
    group, level, goal = ints(told[GROUP], 0, rows), ints(told[LEVEL], 0, rows), ints(told[GOAL], 0, rows)
    most, found = floats(told[MOST], 0, groups), floats(told[FOUND], 0, 2 + groups + levels)
    for k in range(2 + groups + levels):
        found[k] = 0.0
    for r in range(rows):
        missing = max(lower[r], 0.0) + min(upper[r], 0.0)
        if lower[r] != lower[r] or upper[r] != upper[r]:
            missing = math.nan
        square = missing * missing
        if goal[r] != 0:
            found[1] += square
        if group[r] >= 0:
            found[2 + group[r]] += square
        found[2 + groups + level[r]] += squared[r] * square
    found[0], found[1] = 1.0, math.sqrt(found[1])
    for k in range(groups):
        if not found[2 + k] <= most[k]:
            found[0] = 0.0
    for k in range(2 + groups, 2 + groups + levels):
        found[k] = math.sqrt(found[k])
    return 0


@stamp
@entry
def open_room(here):
    """Write bounds of the step of each joint: a share of the distance to its limits, and at most the radius."""
    told = ints(here, 0, 8)
    n = told[JOINTS]
    places, low, high = ints(told[PLACES], 0, n), floats(told[LOW], 0, n), floats(told[HIGH], 0, n)
    reach, least, farthest = floats(told[REACH], 0, 2), floats(told[LEAST], 0, n), floats(told[FARTHEST], 0, n)
    radius, share = reach[0], reach[1]
    for j in range(n):
        where = 0.0
        if places[j] >= 0:
            where = floats(told[POSITIONS], places[j], 1)[0]
        least[j] = min(max(share * (low[j] - where), -radius), 0.0)
        farthest[j] = max(min(share * (high[j] - where), radius), 0.0)
    return 0
