"""Loops of inverse kinematics: norms of the errors, and the largest step of every joint."""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

#: Of a judge: how many rows, groups (the rows of one task in one unit) and levels; the bounds of the rows; the group of
#: each, or -1, and its level; whether it is of the goal; its squared weight; what a group may be off, squared; and what
#: is found: 1 if the goal is reached, the norm of all errors of the goal, the squares of the groups, the weighted
#: norms of the levels.
ROWS, GROUPS, LEVELS, LOWER, UPPER, GROUP, LEVEL, GOAL, SQUARED, MOST, FOUND = range(11)
#: Of a room: how many joints; the positions, and where among them that of each joint is, or -1; their ranges; radius
#: and share; the bounds of the step.
JOINTS, POSITIONS, PLACES, LOW, HIGH, REACH, LEAST, FARTHEST = range(8)


@stamp
@entry
def judge(here):
    """How much is missing, by groups, levels, and of the goal."""
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
    """A share of what is left to the limits, within the radius."""
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
