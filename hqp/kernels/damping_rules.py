"""The damping of a level by the rules of :mod:`hqp.damping` that depend on its rows, and tests of rows at x."""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner, integer
from .memory import ints, marks, matrix, vector
from .rows import EQUALITY, INACTIVE, LOWER, UPPER, value_of
from .singular import share_of_smallest, volume
from .states import measure_rows, room_of
from .sweep import enter_level, fix_variables, solve_levels

#: Kinds of rules, see :mod:`hqp.damping`.
FIXED, MANIPULABILITY, SINGULAR_VALUE, ERROR = 0, 1, 2, 3

#: Rank tolerance of a damped level: near round-off, because damping bounds what nearly dependent rows can do.
DEPENDENT = 1e-14
#: Rows are solved to the tolerance of the settings, and judged by this multiple of it.
JUDGED = 10.0


@inner
def satisfied(here, end, x):
    """Whether x violates none of the rows 0 .. end - 1, without any tolerance."""
    lo, hi = vector(here, at.LO), vector(here, at.HI)
    for i in range(end):
        value = value_of(i, x, here)
        if value < lo[i] or value > hi[i]:
            return False
    return True


@inner
def unequal(here, end):
    """Whether there is an inequality among the rows 0 .. end - 1."""
    lo, hi, some = vector(here, at.LO), vector(here, at.HI), False
    for i in range(end):
        some = some or (lo[i] != hi[i] and (lo[i] != -math.inf or hi[i] != math.inf))
    return some


@inner
def lacking(here, level):
    """``||D_k w_k||`` of the level at x, and the length of its shortest row."""
    lo, hi, norm, x = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), vector(here, at.X)
    total, shortest, ptr = 0.0, math.inf, marks(here, at.PTR)
    for i in range(ptr[level], ptr[level + 1]):
        value = value_of(i, x, here) if norm[i] > 0.0 else 0.0
        away = max(value - hi[i], lo[i] - value, 0.0)
        total += away * away
        shortest = min(shortest, norm[i])
    return math.sqrt(total), shortest


@inner
def tolerance(here):
    """The tolerance by which rows count as met or active, as :func:`hqp.damping.level.tolerance`."""
    return JUDGED * vector(here, at.OPTION)[at.TOL]


@inner
def activate(here, level, through):
    """Set ``side`` of the rows of levels 0 .. level by their value at x.

    False if a row above level `through` gets another side than it has in the present basis.
    """
    ptr, side = marks(here, at.PTR), marks(here, at.SIDE)
    lo, hi, norm, same = vector(here, at.LO), vector(here, at.HI), vector(here, at.NORM), True
    value, slack = vector(here, at.LOW), vector(here, at.HIGH)
    size, way = measure_rows(here, level + 1, vector(here, at.X0), value, slack)
    for i in range(ptr[level + 1]):
        now = integer(INACTIVE)
        if norm[i] > 0.0:
            near = room_of(value[i], slack[i], norm[i], tolerance(here), size, way)
            if lo[i] == hi[i]:
                now = integer(EQUALITY)
            elif value[i] >= hi[i] - near:
                now = integer(UPPER)
            elif value[i] <= lo[i] + near:
                now = integer(LOWER)
        if i < ptr[through]:
            same = same and (now == side[i] or (now == EQUALITY and side[i] != INACTIVE))
        side[i] = now
    return same


@inner
def by_singular_values(here, d, level, through, c):
    """The damping of a level by rule number d, from the singular values of its active rows in the remaining null space.

    The levels above `through` are in V[:c] already.

    Returns
    -------
    damping : float
        lambda.
    through, c : int
        The levels above `through` = `level` are then in V[:c].
    count, rank : int
        Active rows of the level, and their rank; they are entered on top of V[:c].
    """
    head, tau = ints(here, 0, at.HEAD), vector(here, at.OPTION)[at.TAU]
    ids, rule = marks(here, at.IDS), matrix(here, at.RULES)[d]
    L, H, R = matrix(here, at.L), matrix(here, at.H), matrix(here, at.R)
    begin = integer(1 if head[at.BOXED] != 0 else 0)
    if not activate(here, level, through) or through < begin:
        through, c = begin, integer(0)
    f = fix_variables(here)
    c = solve_levels(here, through, level, c, f, tau)
    count, rank = enter_level(here, level, c, f, DEPENDENT)
    largest, threshold, share = rule[1], rule[2], 1.0
    if count > 0:
        if rule[0] == MANIPULABILITY:
            share = volume(ids, rank, L, c) / threshold if rank == count else 0.0
            return largest * max(1.0 - share, 0.0), level, c, count, rank
        share = share_of_smallest(ids, rank, L, c, H, R, threshold) if rank == count else 0.0
    elif rule[0] == MANIPULABILITY:
        return 0.0, level, c, count, rank
    return largest * math.sqrt(1.0 - share * share), level, c, count, rank
