"""Products and sums of rows: of long ones by whole lines, for which they have room; see :mod:`.lines`."""

from __future__ import annotations

from .compile import inner, precise
from .layout import PAD
from .lines import add_lines_behind, add_to_lines, multiply_first
from .orthogonal import padded

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
    """Write the products of rows[:count] with x[:n] to out[:count]."""
    p = 0
    while p + 3 < count:  # four rows in each pass, so that x is read once
        r0, r1, r2, r3 = rows[p], rows[p + 1], rows[p + 2], rows[p + 3]
        d0 = d1 = d2 = d3 = 0.0
        for j in range(n):
            d0 += r0[j] * x[j]
            d1 += r1[j] * x[j]
            d2 += r2[j] * x[j]
            d3 += r3[j] * x[j]
        out[p], out[p + 1], out[p + 2], out[p + 3] = d0, d1, d2, d3
        p += 4
    while p < count:
        r0, d0 = rows[p], 0.0
        for j in range(n):
            d0 += r0[j] * x[j]
        out[p] = d0
        p += 1


@inner
def add_rows(shares, rows, first, end, n, out):
    """Add the rows first .. end - 1, each times its share, to out[:n]."""
    p = first
    while p + 3 < end:
        r0, r1, r2, r3 = rows[p], rows[p + 1], rows[p + 2], rows[p + 3]
        s0, s1, s2, s3 = shares[p], shares[p + 1], shares[p + 2], shares[p + 3]
        for j in range(n):
            out[j] += s0 * r0[j] + s1 * r1[j] + s2 * r2[j] + s3 * r3[j]
        p += 4
    while p < end:
        r0, s0 = rows[p], shares[p]
        for j in range(n):
            out[j] += s0 * r0[j]
        p += 1


@inner
def add_to_each(rows, count, shares, x, n):
    """Add x[:n], times its share, to each of rows[:count]; the rest of their last lines may become anything."""
    if n > SHORT:
        add_to_lines(rows, count, shares, x, padded(n))
        return
    p = 0
    while p + 3 < count:
        r0, r1, r2, r3 = rows[p], rows[p + 1], rows[p + 2], rows[p + 3]
        s0, s1, s2, s3 = shares[p], shares[p + 1], shares[p + 2], shares[p + 3]
        for j in range(n):
            value = x[j]
            r0[j] += s0 * value
            r1[j] += s1 * value
            r2[j] += s2 * value
            r3[j] += s3 * value
        p += 4
    while p < count:
        r0, s0 = rows[p], shares[p]
        for j in range(n):
            r0[j] += s0 * x[j]
        p += 1


@inner
def add_squares(shares, rows, count, n, weight, out):
    """Add the symmetric matrix weight * R' R of the rows R = rows[:count] to out[:n, :n]; `shares` is work space."""
    for i in range(n):
        for r in range(count):
            shares[r] = weight * rows[r][i]
        if n > SHORT:
            add_long(shares, rows, 0, count, 0, n, out[i])
        else:
            add_rows(shares, rows, 0, count, n, out[i])
