"""Singular values of the rows of one level in what the levels above leave, from their trapezoid."""

from __future__ import annotations

import math

from .compile import inner

#: Columns count as orthogonal up to this share of their lengths; and the most rounds that are spent on it.
ORTHOGONAL, ROUNDS = 1e-15, 30
#: Round-off of a bound, with a margin.
MARGIN = 1e-9


@inner
def volume(ids, rank, L, c):
    """The product of the singular values of as many rows as directions: the determinant of a triangle."""
    total = 1.0
    for r in range(rank):
        total *= L[ids[r]][c + r]
    return total


@inner
def clearly_above(ids, rank, L, c, H, threshold):
    r"""Whether a lower bound of the smallest singular value of as many rows as directions is above the threshold.

    It is :math:`1 / \|T^{-1}\|_F`, T the triangle, and far from singularities spares all that :func:`smallest` does.
    """
    total = 0.0
    for j in range(rank):
        column = H[j]
        for r in range(j, rank):
            row = L[ids[r]]
            value = 1.0 if r == j else 0.0
            for q in range(j, r):
                value -= row[c + q] * column[q]
            column[r] = value / row[c + r]
            total += column[r] * column[r]
    return total * threshold * threshold < 1.0 - MARGIN


@inner
def smallest(ids, count, rank, L, c, H):
    """The smallest singular value of the rows `ids` of L in the columns c .. c + rank.

    Rotations make the columns orthogonal, pair by pair (one-sided Jacobi, Hestenes 1958); their lengths are the values
    then, each to as many digits as the rows give.
    """
    for j in range(rank):
        column = H[j]
        for r in range(count):
            column[r] = L[ids[r]][c + j] if j <= r else 0.0
    for _ in range(ROUNDS):
        turned = False
        for p in range(rank):
            for q in range(p + 1, rank):
                a, b = H[p], H[q]
                aa = bb = ab = 0.0
                for r in range(count):
                    aa += a[r] * a[r]
                    bb += b[r] * b[r]
                    ab += a[r] * b[r]
                if abs(ab) <= ORTHOGONAL * math.sqrt(aa * bb):
                    continue
                turned = True
                zeta = (bb - aa) / (2.0 * ab)
                tangent = 1.0 / (abs(zeta) + math.sqrt(1.0 + zeta * zeta))
                if zeta < 0.0:
                    tangent = -tangent
                cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
                sine = cosine * tangent
                for r in range(count):
                    one = a[r]
                    a[r] = cosine * one - sine * b[r]
                    b[r] = sine * one + cosine * b[r]
        if not turned:
            break
    least = math.inf
    for j in range(rank):
        column, total = H[j], 0.0
        for r in range(count):
            total += column[r] * column[r]
        least = min(least, math.sqrt(total))
    return least
