"""Whether the numbers of a hierarchy are valid, for loops that begin without a solver, which tests them as it loads."""

from __future__ import annotations

import math

from . import layout as at
from .compile import inner
from .memory import ints, marks, matrix, vector
from .solver import LARGEST


@inner
def valid(here):
    """Whether :func:`.solver.load` would take the numbers of the directory."""
    n, col, row_of = ints(here, 0, at.HEAD)[at.N], marks(here, at.COL), marks(here, at.ROW_OF)
    lower, upper, weights, A = (
        vector(here, at.LOWER),
        vector(here, at.UPPER),
        vector(here, at.WEIGHTS),
        matrix(here, at.A),
    )
    good = True
    for i in range(len(lower)):
        below, above, square = lower[i], upper[i], 0.0
        good = good and below <= above and 1.0 / LARGEST <= weights[i] <= LARGEST
        good = good and (abs(below) <= LARGEST or below == -math.inf) and (abs(above) <= LARGEST or above == math.inf)
        if col[i] < 0:
            row = A[row_of[i]]
            for j in range(n):
                square += row[j] * row[j]
            good = good and square <= LARGEST * LARGEST
    return good
