r"""Singular values of the rows of one level in the null space of the levels above, from their triangle T.

Damping rules need the smallest, :math:`1 / \|T^{-1}\|_2`. It is at least :math:`1 / \|T^{-1}\|_F`: far from
singularities this bound is enough.
"""

from __future__ import annotations

import math

from .compile import inner

#: Relative round-off of the bound, with a margin.
MARGIN = 1e-9
#: The squaring of a matrix of trace 1 ends when the sum of its squared entries is within this of 1: all eigenvalues but
#: one are then near zero. And the most squarings: eigenvalues that are not separated by then are equal.
ALONE, SQUARINGS = 1e-8, 50


@inner
def volume(ids, rank, L, c):
    """The product of the singular values of `rank` independent rows: the determinant of their triangle.

    The triangle is ``L[ids[r]][c + q]``.
    """
    total = 1.0
    for r in range(rank):
        total *= L[ids[r]][c + r]
    return total


@inner
def share_of_smallest(ids, rank, L, c, H, R, threshold):
    """The smallest singular value of `rank` independent rows over the threshold, at most 1.

    The triangle is ``L[ids[r]][c + q]``; H and R are work space.
    """
    if invert(ids, rank, L, c, H) * threshold * threshold < 1.0 - MARGIN:
        return 1.0
    return min(1.0 / (math.sqrt(largest(rank, H, R)) * threshold), 1.0)


@inner
def invert(ids, rank, L, c, H):
    """Write the inverse of the triangle ``L[ids[r]][c + q]``, column j to H[j]; returns its squared Frobenius norm."""
    total = 0.0
    for j in range(rank):
        column = H[j]
        for r in range(rank):
            row = L[ids[r]]
            value = 1.0 if r == j else 0.0
            for q in range(j, r):
                value -= row[c + q] * column[q]
            column[r] = value / row[c + r] if r >= j else 0.0
            total += column[r] * column[r]
    return total


@inner
def largest(rank, H, R):
    r"""The largest eigenvalue of :math:`G^T G`, with column j of G in H[j], by repeated squaring of the matrix.

    The Rayleigh quotient of the vector found is returned. Its error is the square of that of the vector, and zero if
    the largest eigenvalues are equal.
    """
    trace = 0.0
    for i in range(rank):
        for j in range(i + 1):
            one, other, total = H[i], H[j], 0.0
            for r in range(rank):
                total += one[r] * other[r]
            H[i][rank + j] = R[i][j] = R[j][i] = total
        trace += R[i][i]
    for _ in range(SQUARINGS):
        scale, total = 1.0 / trace, 0.0
        for i in range(rank):
            for j in range(rank):
                R[i][j] *= scale
                total += R[i][j] * R[i][j]
        if total > 1.0 - ALONE:
            break
        trace = square(rank, R)
    best = 0
    for i in range(rank):
        best = i if R[i][i] > R[best][best] else best
    v, along, size = R[best], 0.0, 0.0
    for i in range(rank):
        size += v[i] * v[i]
        along += H[i][rank + i] * v[i] * v[i]
        for j in range(i):
            along += 2.0 * H[i][rank + j] * v[i] * v[j]
    return along / size


@inner
def square(rank, R):
    """Replace the symmetric matrix R[:rank, :rank] by its square, using the rows below it; returns the trace."""
    trace = 0.0
    for i in range(rank):
        mine, out = R[i], R[rank + i]
        for j in range(i + 1):
            other, total = R[j], 0.0
            for q in range(rank):
                total += mine[q] * other[q]
            out[j] = total
        trace += out[i]
    for i in range(rank):
        for j in range(i + 1):
            R[i][j] = R[j][i] = R[rank + i][j]
    return trace
