"""Products and sums of rows: of long ones by whole lines, for which they have room; see :mod:`.lines`."""

from __future__ import annotations

from .compile import inner, precise
from .layout import PAD
from .lines import add_lines_behind, add_to_lines, multiply_first
from .orthogonal import padded
from .single_lines import add_line, multiply_line

#: Rows of up to so many entries are faster entry by entry, as part of the loops around them, than by lines.
SHORT = PAD
#: Splits a number into two of half its digits (Veltkamp 1968).
SPLIT = 2.0**27 + 1.0


@precise
def product(row, x, n):
    """The product of row[:n] and x[:n] as if computed with twice the digits, and rounded (Ogita, Rump and Oishi 2005).

    Every product, and every sum, comes with its round-off, which is summed up besides.
    """
    total, rest = 0.0, 0.0
    for j in range(n):
        a, b = row[j], x[j]
        above = SPLIT * a
        a_high = above - (above - a)
        above = SPLIT * b
        b_high = above - (above - b)
        a_low, b_low, term = a - a_high, b - b_high, a * b
        rest += a_low * b_low - (((term - a_high * b_high) - a_low * b_high) - a_high * b_low)
        new = total + term
        back = new - total
        rest += (total - (new - back)) + (term - back)
        total = new
    return total + rest


@inner
def multiply_long(rows, count, x, n, out):
    """As :func:`multiply`, by lines, for rows that are not SHORT. They have room for whole lines."""
    multiply_first(rows, count, x, n, out)


@inner
def add_long(shares, rows, first, end, begin, n, out):
    """As :func:`add_rows`, by lines, to out[begin:n]; the rest of the lines that these are in becomes anything."""
    add_lines_behind(rows, first, end, shares, begin, padded(n), out)


@inner
def multiply(rows, count, x, n, out):
    """Write the products of rows[:count], which have room for whole lines, with x[:n] to out[:count]."""
    if n > PAD:
        multiply_long(rows, count, x, n, out)
    else:
        multiply_line(rows, count, x, n, out)


@inner
def add_rows(shares, rows, first, end, n, out):
    """Add the rows first .. end - 1, each times its share, to out[:n]; the rest of its last line becomes anything."""
    if n > PAD:
        add_long(shares, rows, first, end, 0, n, out)
    else:
        add_line(shares, rows, first, end, out)


@inner
def add_to_each(rows, count, shares, x, n):
    """Add x[:n], times its share, to each of rows[:count]; the rest of their last lines may become anything."""
    add_to_lines(rows, count, shares, x, padded(n))


@inner
def add_squares(shares, rows, count, n, weight, out):
    """Add the symmetric matrix weight * R' R of the rows R = rows[:count] to out[:n, :n]; `shares` is work space."""
    for i in range(n):
        for r in range(count):
            shares[r] = weight * rows[r][i]
        add_rows(shares, rows, 0, count, n, out[i])
