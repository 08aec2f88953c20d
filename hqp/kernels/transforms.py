"""Orthogonal transformations of the rows of a matrix, a line at a time; written as in :mod:`.lines`."""

from __future__ import annotations

import math

from .lines import add_products
from .vectors import LONG, written


def _rotate(write, one, other, sine, cosine, wide):
    s, c = (write.everywhere(root) for root in write.roots(sine, cosine))
    for (t,) in write.lines(wide, (1,)):
        a, b = one.line(t), other.line(t)
        one.write(t, write.minus(write.times(a, c), write.times(b, s)))
        other.write(t, write.plus(write.times(a, s), write.times(b, c)))


@written(_rotate)
def rotate(one, other, sine, cosine, wide):
    """Rotate two rows in their plane, by the squares of sine and cosine, which have the signs of these."""
    sine, cosine = (math.copysign(math.sqrt(abs(square)), square) for square in (sine, cosine))
    for t in range(wide):
        one[t], other[t] = cosine * one[t] - sine * other[t], sine * one[t] + cosine * other[t]


def _subtract_both(write, rows, count, u, p, wide):
    for (t,) in write.lines(wide, (1,)):
        along_u, along_p = u.line(t), p.line(t)
        for (r,) in write.tiles(LONG(0), count, sizes=(1,)):
            row, mine, other = rows.row(r), write.everywhere(u.entry(r)), write.everywhere(p.entry(r))
            both = write.plus(write.times(along_p, mine), write.times(along_u, other))
            row.write(t, write.minus(row.line(t), both))


@written(_subtract_both)
def subtract_both(rows, count, u, p, wide):
    """Subtract u p' + p u' from rows[:count]."""
    for r in range(count):
        mine, other = u[r], p[r]
        for t in range(wide):
            rows[r][t] -= mine * p[t] + other * u[t]


def _reflect(write, rows, count, u, scale, wide):
    for places in write.tiles(LONG(0), count):
        mine, sums = [rows.row(q) for q in places], write.sums(len(places))
        add_products(write, mine, sums, u, wide)
        along = write.totals([write.together([one]) for one in sums])
        shares = [write.everywhere(write.times(write.number(along, k), scale)) for k in range(len(mine))]
        for (t,) in write.lines(wide, (1,)):
            entries = u.line(t)
            for row, share in zip(mine, shares, strict=True):
                row.write(t, write.minus(row.line(t), write.times(entries, share)))


@written(_reflect)
def reflect(rows, count, u, scale, wide):
    """Multiply rows[:count] by the reflection I - scale u u'."""
    for r in range(count):
        along = scale * sum(rows[r][t] * u[t] for t in range(wide))
        for t in range(wide):
            rows[r][t] -= along * u[t]
