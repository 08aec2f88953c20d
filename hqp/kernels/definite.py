"""Triangular factors of small symmetric matrices that are positive definite, and bounds of their eigenvalues."""

from __future__ import annotations

import math

from .compile import inner
from .layout import PAD
from .lines import scale_behind
from .orthogonal import padded
from .single_lines import copy_line, eliminate
from .sums import add_long

#: A matrix is positive definite if each squared pivot of its Cholesky factor is more than this share of its diagonal.
DEFINITE = 1e-13


@inner
def cholesky(M, L, n):
    """Write the Cholesky factor L, L L' = M[:n, :n]; False if M is not clearly positive definite."""
    for i in range(n):
        row, own = L[i], M[i]
        for j in range(i + 1):
            other, total = L[j], own[j]
            for p in range(j):
                total -= row[p] * other[p]
            if j < i:
                row[j] = total / other[j]
            elif not total > DEFINITE * own[i]:
                return False
            else:
                row[i] = math.sqrt(total)
    return True


@inner
def factor_by_lines(M, R, n, shares):
    """:func:`upper_factor` of long rows: each takes those before it at once."""
    for j in range(n):
        row, own = R[j], M[j]
        for c in range(n):
            row[c] = own[c]
        for p in range(j):
            shares[p] = -R[p][j]
        add_long(shares, R, 0, j, j, n, row)
        if not row[j] > DEFINITE * own[j]:
            return False
        scale_behind(row, 1.0 / math.sqrt(row[j]), j, padded(n), row)
    return True


@inner
def upper_factor(M, R, n, shares):
    """Write the upper triangular R, R' R = M[:n, :n]; False if M is not clearly positive definite.

    Of M the upper triangle is read. `shares` is work space.
    """
    if n > PAD:
        return factor_by_lines(M, R, n, shares)
    for j in range(n):
        copy_line(M[j], PAD, R[j])
    for j in range(n):  # rows behind wait for a quotient, and for no root
        row, pivot = R[j], R[j][j]
        if not pivot > DEFINITE * M[j][j]:
            return False
        eliminate(R, j, n, 1.0 / pivot)
        scale_behind(row, 1.0 / math.sqrt(pivot), j, PAD, row)
    return True


@inner
def turn(R, b, n):
    """Replace b[:n] by the solution x of R' x = b, for an upper triangular R."""
    for p in range(n):
        own, value = R[p], b[p]
        if value != 0.0:
            b[p] = value = value / own[p]
            for q in range(p + 1, n):
                b[q] -= value * own[q]


@inner
def turn_back(R, b, n):
    """Replace b[:n] by the solution x of R x = b, for an upper triangular R."""
    for p in range(n - 1, -1, -1):
        own, value = R[p], b[p]
        for q in range(p + 1, n):
            value -= own[q] * b[q]
        b[p] = value / own[p]


@inner
def smallest(M, R, inverse, shares, n):
    r"""A lower bound of the eigenvalues of M[:n, :n]; 0 if it is not positive definite, infinite if n is 0.

    With the mean m and the deviation s of the eigenvalues of the inverse, :math:`1 / (m + s \sqrt{n - 1})` (Wolkowicz
    and Styan, 1980): the smallest one if there are two, if all are equal, or as one of them goes to zero. Both come
    from traces, so that no axes matter: of :math:`R^{-T} R^{-1}`, which has the same eigenvalues. The other arrays are
    work space.
    """
    if n == 0:
        return math.inf
    if not upper_factor(M, R, n, shares):
        return 0.0
    trace, squares = 0.0, 0.0
    for i in range(n):
        row, over = inverse[i], 1.0 / R[i][i]
        for c in range(i):
            value = 0.0
            for p in range(c, i):
                value -= R[p][i] * inverse[p][c]
            row[c] = value * over
        row[i] = over
        for r in range(i + 1):
            other, value = inverse[r], 0.0
            for p in range(r + 1):
                value += row[p] * other[p]
            squares += value * value if r == i else 2.0 * value * value
            trace += value if r == i else 0.0
    mean = trace / n
    return 1.0 / (mean + math.sqrt(max(squares / n - mean * mean, 0.0) * (n - 1)))
