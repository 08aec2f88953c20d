r"""Eigenvalues, Cholesky factor, and a bound of the smallest eigenvalue, of small symmetric matrices.

Eigenvalues by Householder reflections to a tridiagonal matrix, then implicit QR steps with Wilkinson's shift (Golub and
Van Loan, *Matrix Computations*, 8.3), as loops over rows.
"""

from __future__ import annotations

import math

from .compile import inner, integer

#: A matrix is positive definite if each squared pivot of its Cholesky factor is more than this share of its diagonal.
DEFINITE = 1e-13
#: An off-diagonal entry counts as zero below this share of its two diagonal neighbours; and the most QR steps for each
#: eigenvalue.
ZERO, MOST = 1e-16, 60


@inner
def eigen(M, U, values, n):
    """Write the eigenvalues of M[:n, :n] to `values`, in no order, and the eigenvectors to the rows of U.

    M is overwritten.
    """
    for i in range(n):
        row = U[i]
        for j in range(n):
            row[j] = 0.0
        row[i] = 1.0
    tridiagonal(M, U, values, n)
    for i in range(n):
        values[i] = M[i][i]
    end = n - 1
    tries = integer(0)
    while end > 0 and tries < MOST * n:
        begin = end
        while begin > 0 and abs(M[0][begin]) > ZERO * (abs(values[begin]) + abs(values[begin - 1])):
            begin -= 1
        if begin == end:
            end -= 1
            continue
        tries += 1
        step(M[0], U, values, begin, end, n)


@inner
def tridiagonal(M, U, work, n):
    """Reflect M to a tridiagonal matrix, and the rows of U with it; M[0][i] is then its entry (i - 1, i)."""
    for k in range(n - 2):
        row = M[k]
        total = 0.0
        for j in range(k + 2, n):
            total += row[j] * row[j]
        if total == 0.0:
            continue
        head = row[k + 1]
        size = math.sqrt(total + head * head)
        if head > 0.0:
            size = -size
        first = head - size
        total += first * first
        row[k + 1] = first  # u is row[k + 1 :], and the reflection I - 2 u u' / |u|^2
        scale, along = 2.0 / total, 0.0
        reflect_rows(U, row, work, k + 1, n, scale)
        # M - u p' - p u', with p = M u * scale - (u' M u) scale^2 / 2 u, in `work`.
        for i in range(k + 1, n):
            own, value = M[i], 0.0
            for j in range(k + 1, n):
                value += own[j] * row[j]
            work[i] = value * scale
            along += work[i] * row[i]
        along *= 0.5 * scale
        for i in range(k + 1, n):
            work[i] -= along * row[i]
        for i in range(k + 1, n):
            own, one, other = M[i], row[i], work[i]
            for j in range(k + 1, n):
                own[j] -= one * work[j] + other * row[j]
        row[k + 1] = size
    for i in range(n - 1, 0, -1):
        M[0][i] = M[i - 1][i]


@inner
def reflect_rows(U, u, work, first, n, scale):
    """Apply the reflection ``I - scale u u'`` to the rows first .. n - 1 of U; `work` (n,) is overwritten."""
    for j in range(n):
        work[j] = 0.0
    for i in range(first, n):
        row, part = U[i], u[i]
        for j in range(n):
            work[j] += part * row[j]
    for i in range(first, n):
        row, part = U[i], scale * u[i]
        for j in range(n):
            row[j] -= part * work[j]


@inner
def step(beside, U, values, begin, end, n):
    """One implicit QR step on the block begin .. end: diagonal `values`, off-diagonal `beside`; rotates U with it."""
    half, square = 0.5 * (values[begin + 1] - values[begin]), beside[begin + 1] ** 2
    root = math.sqrt(half * half + square)  # hypot takes three times as long, and no entry is near 1e150
    shift = values[begin] - (square / (half + (root if half >= 0.0 else -root)) if root > 0.0 else 0.0)
    g, s, c, p = values[end] - shift, 1.0, 1.0, 0.0
    for i in range(end - 1, begin - 1, -1):
        f, b = s * beside[i + 1], c * beside[i + 1]
        size = math.sqrt(f * f + g * g)
        if i + 2 <= end:
            beside[i + 2] = size
        if size == 0.0:
            values[i + 1] -= p
            return
        s, c = f / size, g / size
        g = values[i + 1] - p
        size = (values[i] - g) * s + 2.0 * c * b
        p = s * size
        values[i + 1] = g + p
        g = c * size - b
        one, other = U[i], U[i + 1]
        for j in range(n):
            a, d = one[j], other[j]
            other[j], one[j] = s * a + c * d, c * a - s * d
    values[begin] -= p
    beside[begin + 1] = g


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
def smallest(M, L, n):
    r"""A lower bound of the eigenvalues of M[:n, :n]; 0 if it is not positive definite, infinite if n is 0.

    With the mean m and the deviation s of the eigenvalues of the inverse, :math:`1 / (m + s \sqrt{n - 1})` (Wolkowicz
    and Styan, 1980): the smallest one if there are two, if all are equal, or as one of them goes to zero. Both come
    from traces, so that no axes matter. L is overwritten.
    """
    if n == 0:
        return math.inf
    if not cholesky(M, L, n):
        return 0.0
    for j in range(n):  # column j of the inverse of L, kept in row j of the upper triangle of L
        column = L[j]
        for i in range(j + 1, n):
            row, value = L[i], -L[i][j] / column[j]
            for p in range(j + 1, i):
                value -= row[p] * column[p]
            column[i] = value / row[i]
    trace, squares = 0.0, 0.0
    for i in range(n):
        for j in range(i + 1):  # the inverse of M
            value = 0.0
            for p in range(i, n):
                value += (L[i][p] if p > i else 1.0 / L[i][i]) * (L[j][p] if p > j else 1.0 / L[j][j])
            if i == j:
                trace += value
                squares += value * value
            else:
                squares += 2.0 * value * value
    mean = trace / n
    return 1.0 / (mean + math.sqrt(max(squares / n - mean * mean, 0.0) * (n - 1)))
