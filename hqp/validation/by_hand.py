"""Hierarchies whose answers are known by hand: equalities, inequalities, weights, repeated rows, singularities.

Some are test problems of other solvers, some are worked here; each says where its numbers come from, and how they
follow. Multipliers are positive at an upper bound, see :class:`hqp.solution.LevelSolution`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import Array
from ..hierarchy import Hierarchy, Level
from .answer import KnownAnswer


def _levels(*levels: Level) -> Hierarchy:
    return Hierarchy(levels)


def _box(n: int) -> Level:
    return Level.bounds(-np.ones(n), np.ones(n))


def _numbers(*values: float) -> Array:
    array = np.array(values, dtype=float)
    array.flags.writeable = False
    return array


def _harmonic(n: int) -> KnownAnswer:
    k = np.arange(1, n + 1)
    w = float(np.sum(1 / k[1:]))
    return KnownAnswer(
        name=f"harmonic, n = {n}",
        source="A. Escande, in LexLS (lambda_test.m)",
        why="{k x_k = 1}, k = 1..n > {sum x = 1}: x_k = 1/k, the sum is too large by w = 1/2 + ... + 1/n,"
        " and row k is held with -w/k",
        hierarchy=_levels(
            *(Level.equality(i * np.eye(n)[i - 1 : i], [1.0]) for i in k.tolist()),
            Level.equality(np.ones((1, n)), [1.0]),
        ),
        x=1 / k,
        residuals=np.append(np.zeros(n), w),
        multipliers={n: -w / k},
    )


def _partly_inside(last: bool) -> KnownAnswer:
    """Three pairs of unknowns, decided one after the other; ``mix @ mix.T = 9 I`` leaves the least squares as it is."""
    mix = np.array([[1, 2, 2], [2, 1, -2], [2, -2, 1]])
    first = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [1, 1, 0, 0, 0, 0]]
    second = mix @ [[1, -1, 0, 0, 0, 0], [1, 0, 1, 0, 0, 0], [0, 0, 1, 1, 0, 0]]
    third = [[0, 1, 0, 0, 1, 0], [0, 0, 0, -1, 0, 1], [0, 0, 1, 0, 1, 1]]
    levels = [Level.equality(first, [1, 2, 0]), Level.equality(second, mix @ [1, 1, 0])]
    shape = "A0 of rank 2, one row of A1 inside A0, as in tvm (HierarchicalLeastSquareSolverTest.cpp); numbers our own"
    if not last:
        return KnownAnswer(
            name="rank 2 > rank 2 > min norm",
            source=shape,
            why="x1 = 1, x2 = 2, x1 + x2 = 0: (0, 1); x1 - x2 = 1 is 2 short, 3 times that in the mixture;"
            " x3 = 1, x4 = -1; what is left is 0",
            hierarchy=_levels(*levels),
            x=_numbers(0, 1, 1, -1, 0, 0),
            residuals=_numbers(math.sqrt(3), 6),
            unique=False,
        )
    return KnownAnswer(
        name="rank 2 > rank 2 > rank 2",
        source=shape,
        why="as the one before, then x5 = 0, x6 = 1, x5 + x6 = 2: 1/3 short each",
        hierarchy=_levels(*levels, Level.equality(third, [1, 2, 3])),
        x=_numbers(0, 1, 1, -1, 1 / 3, 4 / 3),
        residuals=_numbers(math.sqrt(3), 6, 1 / math.sqrt(3)),
    )


def _daqp(
    number: str, tasks: str, n: int, x: Array, residuals: Array, multipliers: Mapping[int, Array], why: str
) -> KnownAnswer:
    parts = {
        "box": _box(n),
        "sum": Level(np.ones((1, n)), [-np.inf], [1.0]),
        "difference": Level.equality(np.array([[1.0, -1.0, 0.0]])[:, :n], [0.5]),
        "far": Level(np.array([[3.0, 1.0, -1.0]])[:, :n], [10.0], [20.0]),
    }
    return KnownAnswer(
        name=f"DAQP {number}",
        source="DAQP (daqp-eigen, 01_static_func.cpp, 03_update.cpp); residuals and multipliers our own",
        why=f"{tasks}: {why}",
        hierarchy=_levels(*(parts[task] for task in tasks.split(" > "))),
        x=x,
        residuals=residuals,
        multipliers=multipliers,
    )


#: A planar arm, links of 1 m: the first one up, the others to the right. Rates of the tip's x and y, and of its angle.
ARM, ANGLE = [[-1, 0, 0], [2, 2, 1]], [[1, 1, 1]]
_ARM_STACK = _levels(Level.equality(ARM, [1, 0]), Level.equality(ANGLE, [3]))

#: All of them.
BY_HAND: Sequence[KnownAnswer] = (
    _harmonic(5),
    _harmonic(20),
    _partly_inside(last=False),
    _partly_inside(last=True),
    KnownAnswer(
        name="bounds one after the other",
        source="tvm (HierarchicalLeastSquareSolverTest.cpp); multiplier our own",
        why="-1 <= x <= 1 > 2 <= x <= 3 > -1 <= y <= 1 > x + y <= 0: x is held at 1 with the slack of the second, 1",
        hierarchy=_levels(
            Level([[1, 0]], [-1], [1]),
            Level([[1, 0]], [2], [3]),
            Level([[0, 1]], [-1], [1]),
            Level([[1, 1]], [-np.inf], [0]),
        ),
        x=_numbers(1, -1),
        residuals=_numbers(0, 1, 0, 0),
        multipliers={1: _numbers(1)},
    ),
    _daqp(
        "1",
        "box > sum > difference > far",
        3,
        _numbers(1, 0.5, -1),
        _numbers(0, 0, 0, 5.5),
        {3: _numbers(22, 0, -5.5, 0, -5.5)},
        "3 x1 + x2 - x3 grows until x1 and x3 meet the box, and x2 = x1 - 0.5",
    ),
    _daqp(
        "2",
        "box > far",
        3,
        _numbers(1, 1, -1),
        _numbers(0, 5),
        {1: _numbers(15, 5, -5)},
        "3 x1 + x2 - x3 is largest in a corner of the box",
    ),
    _daqp(
        "3",
        "box > sum > difference > far",
        2,
        _numbers(0.75, 0.25),
        _numbers(0, 0, 0, 7.5),
        {3: _numbers(0, 0, 15, 7.5)},
        "x1 + x2 = 1 and x1 - x2 = 0.5",
    ),
    _daqp(
        "4",
        "sum > far > box > difference",
        3,
        _numbers(2.25, 1, -2.25),
        _numbers(0, 0, 1.25 * math.sqrt(2), 0.75),
        {2: _numbers(0.625, -0.625)},
        "x1 + x2 + x3 <= 1 and 3 x1 + x2 - x3 >= 10 push x1 and x3 out of the box, x2 stays at 1",
    ),
    KnownAnswer(
        name="weighted conflict",
        source="our own",
        why="x = 0, weight 1, and x = 1, weight 2, on one level: slacks as 1/1^2 to 1/2^2",
        hierarchy=_levels(Level.equality([[1], [1]], [0, 1], weights=[1, 2])),
        x=_numbers(0.8),
        residuals=_numbers(math.sqrt(0.8)),
    ),
    KnownAnswer(
        name="weights below a limit",
        source="our own",
        why="x1 + x2 <= 1 > x1 = 1, weight 1, and x2 = 1, weight 2: the missing 1 is shared as 1/1^2 to 1/2^2",
        hierarchy=_levels(
            Level([[1, 1]], [-np.inf], [1]),
            Level.equality(np.eye(2), [1, 1], weights=[1, 2]),
        ),
        x=_numbers(0.2, 0.8),
        residuals=_numbers(0, math.sqrt(0.8)),
        multipliers={1: _numbers(0.8)},
    ),
    KnownAnswer(
        name="rows of different length",
        source="our own",
        why="x1 + x2 <= 1 > 3 x1 = 3 and x2 = 1: a row three times as long is a weight of 3; the missing 1 is shared"
        " as 1 to 9",
        hierarchy=_levels(Level([[1, 1]], [-np.inf], [1]), Level.equality([[3, 0], [0, 1]], [3, 1])),
        x=_numbers(0.9, 0.1),
        residuals=_numbers(0, math.sqrt(0.9)),
        multipliers={1: _numbers(0.9)},
    ),
    KnownAnswer(
        name="limits above a reach",
        source="our own",
        why="-1 <= x <= 1 > 2 x1 + x2 = 4 > x2 = 1/2, x3 = 1/2: the reach gets 3, and needs x2",
        hierarchy=_levels(
            _box(3), Level.equality([[2, 1, 0]], [4]), Level.equality([[0, 1, 0], [0, 0, 1]], [0.5, 0.5])
        ),
        x=_numbers(1, 1, 0.5),
        residuals=_numbers(0, 1, 0.5),
        multipliers={1: _numbers(2, 1, 0)},
    ),
    KnownAnswer(
        name="a row again, elsewhere",
        source="our own",
        why="x1 + x2 = 1 > x1 + x2 = 3 > x1 = 0: the second is 2 short, the third untouched by that",
        hierarchy=_levels(Level.equality([[1, 1]], [1]), Level.equality([[1, 1]], [3]), Level.equality([[1, 0]], [0])),
        x=_numbers(0, 1),
        residuals=_numbers(0, 2, 0),
        multipliers={1: _numbers(2)},
    ),
    KnownAnswer(
        name="arm, Eq. 3.17",
        source="Eq. 3.17 of the thesis, worked",
        why="-q1 = 1, 2 q1 + 2 q2 + q3 = 0, q1 + q2 + q3 = 3: three equations",
        hierarchy=_ARM_STACK,
        x=_numbers(-1, -2, 6),
        residuals=_numbers(0, 0),
    ),
    KnownAnswer(
        name="arm, Eq. 4.8",
        source="Eq. 4.8 of the thesis, worked",
        why="the angle alone: J2# h2 = (1, 1, 1); J1# h1 = (-1, 4/5, 2/5); N1 takes (0, -1/5, 2/5) from the former",
        hierarchy=_levels(Level.equality(ARM, [1, 0]), Level.equality(np.eye(3), [1, 1, 1])),
        x=_numbers(-1, 0.6, 0.8),
        residuals=_numbers(0, math.sqrt(4.2)),
        multipliers={1: _numbers(-1.6, 0.2)},
        stack=_ARM_STACK,
    ),
    KnownAnswer(
        name="arm, algorithmic singularity",
        source="Eq. 3.17 of the thesis, worked",
        why="the second task, q1 = 2, lies inside the first, which has decided q1 = -1; J1# h1 is left",
        hierarchy=_levels(Level.equality(ARM, [1, 0]), Level.equality([[1, 0, 0]], [2])),
        x=_numbers(-1, 0.8, 0.4),
        residuals=_numbers(0, 3),
        multipliers={1: _numbers(-3, 0)},
        unique=False,
    ),
    KnownAnswer(
        name="arm, stretched",
        source="Eq. 3.17 of the thesis, worked",
        why="J1 = (0; 3 2 1), h1 = (1, 14): (3, 2, 1), and 1 out of reach; then 7 J2^ = (-2, 1, 4) makes the angle 9",
        hierarchy=_levels(Level.equality([[0, 0, 0], [3, 2, 1]], [1, 14]), Level.equality(ANGLE, [9])),
        x=_numbers(1, 3, 5),
        residuals=_numbers(1, 0),
        unique=False,
    ),
)
