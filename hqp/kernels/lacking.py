"""Looks ahead at acceleration order: how far a level is from being met at the x of the levels above it.

While a task is followed its error is small, even just before its rows can no longer be met. What the rows lack at that
x, divided by the square of the gain, is the error that the task will come to have.
"""

from __future__ import annotations

from . import curved_layout as at
from . import layout as plain
from .compile import inner
from .curved_rows import value_at
from .directions import take_along
from .memory import marks, vector


@inner
def note_lacking(here, k):
    """Replace ``errors`` e of the rows of level k that look ahead by e + l |l|^2 / (|l|^2 + |e|^2).

    e + l is what the rows lack at the x of ``reach``, times their ``worth``; rows with a worth of 0 do not look ahead.
    Where a task is far from its target already, |e| is large, and e counts.
    """
    lower, upper, worth = vector(here, plain.LOWER), vector(here, plain.UPPER), vector(here, at.WORTH)
    errors, x = vector(here, at.ERRORS), vector(here, at.REACH)
    more, mine, of, square, longer = vector(here, at.WANTED), marks(here, at.OWN), marks(here, at.OWN_OF), 0.0, 0.0
    for p in range(of[k], of[k + 1]):
        i = mine[p]
        more[i] = 0.0
        if worth[i] == 0.0:
            continue
        value = value_at(here, i, x)
        low, high = lower[i] - value, upper[i] - value
        more[i] = worth[i] * (low if low > 0.0 else high if high < 0.0 else 0.0) - errors[i]
        square += errors[i] * errors[i]
        longer += more[i] * more[i]
    if longer > 0.0:
        for p in range(of[k], of[k + 1]):
            i = mine[p]
            errors[i] += more[i] * longer / (longer + square)


@inner
def leave_off_above(here, x, d):
    """Write to ``reach`` what x (n,) is without its part along the d directions that are left."""
    take_along(here, x, d, vector(here, at.VALUES), vector(here, at.REACH))
