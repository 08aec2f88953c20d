"""The contents of a file in the text format of LexLS, and the codes that it uses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...hierarchy import LARGEST, Hierarchy, Side

#: The fields in front, and the points behind.
HEADER = ("#HierType", "#nVar", "#nObj", "#nCtr", "#ObjType")
POINTS = ("#SolGuess", "#Solution")

#: Types of a hierarchy.
EQUALITIES, INEQUALITIES, WITH_GUESS = 100, 200, 210

#: Types of an objective.
BOUNDS, ROWS = 100, 200

#: The side that each activation type means.
SIDES = (Side.INACTIVE, Side.LOWER, Side.UPPER, Side.EQUALITY)

#: What an infinite bound is written as.
INFINITE = 10 * LARGEST


@dataclass(frozen=True, eq=False)
class Problem:
    """What a file in the text format of LexLS holds.

    Attributes
    ----------
    hierarchy : Hierarchy
        All its weights are one.
    guess : array of int, shape (m,), or None
        For every row the :class:`hqp.Side` on which it may be active.
    solution_guess, solution : array, shape (n,), or None
        A starting point, and a claimed optimum: if the levels leave x free, one of many.
    """

    hierarchy: Hierarchy
    guess: NDArray[np.int8] | None = None
    solution_guess: Array | None = None
    solution: Array | None = None
