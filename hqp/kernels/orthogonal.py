r"""Orthonormalisation of the rows of a level, and its least squares in the null space of the levels above.

The rows V[0:c] are orthonormal and span the rows of the levels above. A row a of the next level is split into
:math:`a = L V + R`: coefficients along V, and a remainder. Pivoted Gram-Schmidt turns the remainders into new rows of
V, the longest first, until only dependent rows are left, whose remainder is a small share of their length. Then

.. math:: A_k x = L_k y, \qquad x = x_0 + V^T y

with L lower triangular in its pivot rows. Projecting again where cancellation ate the first decimal keeps V
orthonormal to round-off ("twice is enough": Giraud, Langou, Rozloznik 2005).
"""

from __future__ import annotations

import math

from . import layout
from .compile import inner, integer
from .lines import multiply_lines, product, scale_line, subtract_lines, take_out

#: A remainder below this share of the length of its row is projected again.
CANCELLED = 0.1
#: A remainder below this share of the length of its row is round-off and set to 0, as a large slack would magnify it. A
#: longer one takes part in the least squares of its level, even if it is too short for a direction of its own.
NONE = 1e-14

padded = inner(layout.padded)


@inner
def only_entry(row, f):
    """The place of the only entry of row[:f] that is not 0, as in a plain bound; -1 if there are more, or none."""
    place = integer(-1)
    for t in range(f):
        if row[t] != 0.0:
            if place >= 0:
                return integer(-1)
            place = integer(t)
    return place


@inner
def project(row, f, V, first, c, coefficients):
    """Subtract from row[:f] its part along V[first:c]; its coefficients are *added* to `coefficients`, shape (c,)."""
    q, only = first, only_entry(row, f)
    size = row[only] if only >= 0 else 0.0
    while q + 3 < c:  # four rows at a time: one pass over `row` serves them all
        v0, v1, v2, v3 = V[q], V[q + 1], V[q + 2], V[q + 3]
        d0 = d1 = d2 = d3 = 0.0
        if only >= 0:  # one product is all of the sum: half the work
            d0, d1, d2, d3 = size * v0[only], size * v1[only], size * v2[only], size * v3[only]
        else:
            for t in range(f):
                d0 += row[t] * v0[t]
                d1 += row[t] * v1[t]
                d2 += row[t] * v2[t]
                d3 += row[t] * v3[t]
        for t in range(f):
            row[t] -= d0 * v0[t] + d1 * v1[t] + d2 * v2[t] + d3 * v3[t]
        coefficients[q] += d0
        coefficients[q + 1] += d1
        coefficients[q + 2] += d2
        coefficients[q + 3] += d3
        q += 4
    while q < c:
        v0 = V[q]
        d0 = 0.0
        if only >= 0:
            d0 = size * v0[only]
        else:
            for t in range(f):
                d0 += row[t] * v0[t]
        for t in range(f):
            row[t] -= d0 * v0[t]
        coefficients[q] += d0
        q += 1


@inner
def split(row, wide, V, first, c, coefficients):
    """Write the coefficients of row[:wide] along V[first:c], and subtract from it its part along these."""
    only = only_entry(row, wide)
    if only >= 0:  # one product is all of the sum
        size = row[only]
        for q in range(first, c):
            coefficients[q] = size * V[q][only]
    else:
        multiply_lines(V, first, c, row, wide, coefficients)
    subtract_lines(V, first, c, coefficients, wide, row)


@inner
def length(row, f):
    """Euclidean norm of row[:f]."""
    return math.sqrt(product(row, row, f))


@inner
def factor(ids, count, slots, sizes, R, norm, V, L, c, f, tau):
    """Pivoted Gram-Schmidt of the rows of one level, on top of V[:c].

    Parameters
    ----------
    ids : int (count,)
        Row numbers; reordered, the pivots first.
    slots, sizes : work (count,)
        Where in R each row stands, and its length there.
    R : (count, f)
        On entry the rows themselves; overwritten.
    norm : (m,)
        Lengths of the rows, by row number: the scale of the rank decision.
    V : (n, n)
        Rows c, c + 1, ... are written.
    L : (m, n)
        Coefficients along V, by row number; columns 0 .. c + rank - 1 are written.

    Returns
    -------
    rank : int
    """
    separate(ids, count, slots, sizes, R, norm, V, L, 0, c, f, tau)
    return pivots(ids, count, slots, sizes, R, norm, V, L, c, f, tau)


@inner
def separate(ids, count, slots, sizes, R, norm, V, L, first, c, f, tau):
    """Split the rows R: coefficients along V[first:c] to L, remainders to R, their lengths to `sizes`.

    Arguments as of :func:`factor`.
    """
    for r in range(count):
        slots[r] = r
        row, coefficients = R[r], L[ids[r]]
        if c > first:
            split(row, f, V, first, c, coefficients)
        sizes[r] = length(row, f)
        if not sizes[r] > min(NONE, tau) * norm[ids[r]]:
            sizes[r] = 0.0
            for t in range(f):
                row[t] = 0.0


@inner
def pivots(ids, count, slots, sizes, R, norm, V, L, c, f, tau):
    """Turn the remainders R into rows of V, the longest first, until only dependent ones are left; returns the rank.

    Arguments as of :func:`factor`, after :func:`separate`; f may be :func:`padded`, V has as many
    rows as there are variables.
    """
    rank = integer(0)
    renewed = -1  # the row that was just projected again
    while rank < count and c + rank < min(len(V), f):
        best, most = -1, 0.0
        for r in range(rank, count):
            if sizes[r] > most and sizes[r] > tau * norm[ids[r]]:
                best, most = r, sizes[r]
        if best < 0:
            break
        i, slot = ids[best], slots[best]
        row, coefficients = R[slot], L[i]
        if most < CANCELLED * norm[i] and renewed != slot:
            project(row, f, V, 0, c + rank, coefficients)
            sizes[best] = length(row, f)
            renewed = slot
            continue
        renewed = -1
        ids[best], slots[best], sizes[best] = ids[rank], slots[rank], sizes[rank]
        ids[rank], slots[rank], sizes[rank] = i, slot, most
        direction = V[c + rank]
        scale_line(row, 1.0 / most, f, direction)
        coefficients[c + rank] = most
        take_out(R, slots, rank + 1, count, direction, f, L, ids, c + rank, sizes)
        rank += 1
    return rank


@inner
def reflect(vector, column, j, head, scale, rank, count):
    """``vector -= scale * u (u . vector)``, where u is `head` at j and column[rank:count], and 0 elsewhere."""
    mine, other = vector[rank:count], column[rank:count]
    along = scale * (vector[j] * head + product(mine, other, count - rank))
    vector[j] -= along * head
    for r in range(count - rank):
        mine[r] -= along * other[r]


@inner
def triangle(ids, count, rank, L, c, rhs, diagonal, H):
    """Reflect the trapezoid of :func:`level_least_squares` to a lower triangle, and `rhs` with it.

    Row j of the triangle is ``H[0][j] .. H[j - 1][j], diagonal[c + j]``; H also keeps the reflections.
    """
    for j in range(rank):
        column = H[j]
        for r in range(j):  # above the diagonal of the trapezoid
            column[r] = 0.0
        for r in range(j, count):
            column[r] = L[ids[r]][c + j]
    # From the last column to the first: so the triangle in the first `rank` rows costs next to nothing.
    for j in range(rank - 1, -1, -1):
        column = H[j]
        below, total = column[rank:count], column[j] * column[j]
        for r in range(count - rank):
            total += below[r] * below[r]
        size = math.sqrt(total)
        if column[j] > 0.0:
            size = -size
        head = column[j] - size  # u = (head, dependent rows): I - 2 u u^T / ||u||^2 turns the column into size * e_j
        scale = -1.0 / (size * head)  # 2 / ||u||^2
        for i in range(j):
            reflect(H[i], column, j, head, scale, rank, count)
        reflect(rhs, column, j, head, scale, rank, count)
        column[j] = head
        diagonal[c + j] = size


@inner
def level_least_squares(ids, count, rank, L, c, rhs, y, slack, H):
    r"""Minimise ``||L_k y - rhs||`` over y[c : c + rank].

    `L_k` are the rows `ids` of L in the columns c .. c + rank - 1, a trapezoid: lower triangular in its first `rank`
    rows. Without dependent rows it is solved by substitution, and the slack is *exactly* 0. Otherwise Householder
    reflections Q make it a triangle, and the slack is :math:`w = -Q (0, \text{tail})`, which is orthogonal to the
    columns of `L_k` however large it is.

    Parameters
    ----------
    rhs : (count,)
        In the order of ids; overwritten.
    slack : (m,)
        By row number; ``L_k y - rhs``.
    H : work (n, most rows of a level)
    """
    if count == rank:
        for r in range(rank):
            row = L[ids[r]]
            total = rhs[r]
            for q in range(r):
                total -= row[c + q] * y[c + q]
            y[c + r] = total / row[c + r]
            slack[ids[r]] = 0.0
        return
    triangle(ids, count, rank, L, c, rhs, y, H)
    for j in range(rank):  # lower triangular again
        total = rhs[j]
        for q in range(j):
            total -= H[q][j] * y[c + q]
        y[c + j] = total / y[c + j]
        rhs[j] = 0.0
    for j in range(rank):
        column = H[j]
        head = column[j]
        below, square = column[rank:count], head * head
        for r in range(count - rank):
            square += below[r] * below[r]
        reflect(rhs, column, j, head, 2.0 / square, rank, count)
    for r in range(count):
        slack[ids[r]] = -rhs[r]
