r"""Eigenvalues and eigenvectors of small symmetric matrices, by Jacobi's rotations.

Each rotation makes one entry beside the diagonal zero; a few rounds over all of them leave round-off. It is as exact
as can be for eigenvalues that are small beside others, and needs nothing but loops.
"""

from __future__ import annotations

import math

from .compile import inner

#: What is left of a diagonal entry has to be more than this share of it.
DEFINITE = 1e-13
#: Rounds after which it ends at the latest, and what counts as zero beside the diagonal, relative to the whole.
ROUNDS, ZERO = 30, 1e-15


@inner
def eigen(M, U, values, n):
    """The eigenvalues of M[:n, :n], which is overwritten, and as rows of U the eigenvectors, in no order."""
    whole = 0.0
    for i in range(n):
        row, own = U[i], M[i]
        for j in range(n):
            row[j] = 0.0
            whole += own[j] * own[j]
        row[i] = 1.0
    for _ in range(ROUNDS):
        beside = 0.0
        for i in range(n):
            own = M[i]
            for j in range(i):
                beside += own[j] * own[j]
        if beside <= ZERO * ZERO * whole:
            break
        for p in range(n - 1):
            for q in range(p + 1, n):
                if M[p][q] != 0.0:
                    rotate(M, U, p, q, n)
    for i in range(n):
        values[i] = M[i][i]


@inner
def rotate(M, U, p, q, n):
    """Make M[p, q] zero, by a rotation in the plane of both, and turn rows p and q of U with it."""
    one, other = M[p], M[q]
    theta = 0.5 * (other[q] - one[p]) / one[q]
    t = 1.0 / (abs(theta) + math.sqrt(theta * theta + 1.0))
    if theta < 0.0:
        t = -t
    c = 1.0 / math.sqrt(t * t + 1.0)
    s = t * c
    for j in range(n):
        a, b = one[j], other[j]
        one[j], other[j] = c * a - s * b, s * a + c * b
    for i in range(n):
        row = M[i]
        a, b = row[p], row[q]
        row[p], row[q] = c * a - s * b, s * a + c * b
    one[q] = other[p] = 0.0
    turned, beside = U[p], U[q]
    for j in range(n):
        a, b = turned[j], beside[j]
        turned[j], beside[j] = c * a - s * b, s * a + c * b


@inner
def cholesky(M, L, n):
    """The lower triangle L with L L' = M[:n, :n]; False where M is not clearly positive definite."""
    for i in range(n):
        row = L[i]
        for j in range(i + 1):
            other, total = L[j], M[i][j]
            for p in range(j):
                total -= row[p] * other[p]
            if j < i:
                row[j] = total / other[j]
            elif not total > DEFINITE * M[i][i]:
                return False
            else:
                row[i] = math.sqrt(total)
    return True


@inner
def smallest(M, L, n):
    r"""A bound from below for the eigenvalues of a positive definite matrix: one over the trace of its inverse."""
    if not cholesky(M, L, n):
        return 0.0
    total = 0.0
    for j in range(n):  # the columns of the inverse of L, each in the upper triangle of L
        for i in range(j, n):
            value = 1.0 if i == j else 0.0
            for p in range(j, i):
                value -= L[i][p] * (1.0 / L[j][j] if p == j else L[j][p])
            value /= L[i][i]
            if i > j:
                L[j][i] = value
            total += value * value
    return 1.0 / total if n > 0 else math.inf
