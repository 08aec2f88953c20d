"""Coordinates along Z, the directions that are left to a curved level."""

from __future__ import annotations

from . import curved_layout as at
from . import layout as plain
from .compile import inner
from .memory import ints, marks, matrix
from .sums import add_rows, multiply


@inner
def untouched(here, d):
    """Whether Z is still the identity on the variables of the block, as no direction was taken out."""
    return d == len(matrix(here, at.BASIS))


@inner
def along(here, row, d, out):
    """Write out[:d] = Z row, the coordinates of a row (n,) along Z."""
    if untouched(here, d):
        columns = marks(here, at.COLUMNS)
        for p in range(d):
            out[p] = row[columns[p]]
        return
    n = ints(here, 0, plain.HEAD)[plain.N]
    multiply(matrix(here, at.BASIS), d, row, n, out)


@inner
def add_along(here, y, first, d, out):
    """Add Z' y to out (n,), for a y (d,) that begins with `first` zeros."""
    if untouched(here, d):
        columns = marks(here, at.COLUMNS)
        for p in range(first, d):
            out[columns[p]] += y[p]
        return
    n = ints(here, 0, plain.HEAD)[plain.N]
    add_rows(y, matrix(here, at.BASIS), first, d, n, out)


@inner
def take_along(here, x, d, part, out):
    """Write to out what x (n,) is without its part along Z, whose coordinates, negative, go to ``part``."""
    along(here, x, d, part)
    for p in range(d):
        part[p] = -part[p]
    for j in range(ints(here, 0, plain.HEAD)[plain.N]):
        out[j] = x[j]
    add_along(here, part, 0, d, out)
