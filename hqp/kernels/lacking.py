"""What a level lacks where the levels above it leave off: at acceleration order its error in the long run.

A measured error is small as long as a task is followed, however fast its rows turn to where they cannot be met. At
acceleration order those above tell: what they leave to the level, over the square of its gain, is the error that it
will come to have unless it can be met.
"""

from __future__ import annotations

from . import curved_layout as at
from . import layout as plain
from .compile import inner
from .memory import ints, marks, matrix, vector


@inner
def note_lacking(here, k):
    """Let ``errors`` of the rows of level k that have a worth look ahead: from e towards what they lack, times that.

    They lack it at the x of ``reach``. With l the difference from e, errors become e + l |l|^2 / (|l|^2 + |e|^2): where
    a task has lost its target already, e says more.
    """
    n, col, row_of = ints(here, 0, plain.HEAD)[plain.N], marks(here, plain.COL), marks(here, plain.ROW_OF)
    lower, upper, worth = vector(here, plain.LOWER), vector(here, plain.UPPER), vector(here, at.WORTH)
    errors, x, ptr, A = vector(here, at.ERRORS), vector(here, at.REACH), marks(here, plain.PTR), matrix(here, plain.A)
    more, square, longer = vector(here, at.WANTED), 0.0, 0.0
    for i in range(ptr[k], ptr[k + 1]):
        more[i] = 0.0
        if worth[i] == 0.0:
            continue
        value = 0.0
        if col[i] >= 0:
            value = x[col[i]]
        else:
            row = A[row_of[i]]
            for j in range(n):
                value += row[j] * x[j]
        low, high = lower[i] - value, upper[i] - value
        more[i] = worth[i] * (low if low > 0.0 else high if high < 0.0 else 0.0) - errors[i]
        square += errors[i] * errors[i]
        longer += more[i] * more[i]
    if longer > 0.0:
        for i in range(ptr[k], ptr[k + 1]):
            errors[i] += more[i] * longer / (longer + square)


@inner
def leave_off_above(here, x, d):
    """Write to ``reach`` what x (n,) is without its part along the d directions that are left."""
    n, basis, out = ints(here, 0, plain.HEAD)[plain.N], matrix(here, at.BASIS), vector(here, at.REACH)
    for j in range(n):
        out[j] = x[j]
    for p in range(d):
        direction, along = basis[p], 0.0
        for j in range(n):
            along += direction[j] * x[j]
        for j in range(n):
            out[j] -= along * direction[j]
