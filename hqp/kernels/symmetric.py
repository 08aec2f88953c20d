r"""Eigenvalues and eigenvectors of small symmetric matrices.

Eigenvalues by Householder reflections to a tridiagonal matrix, then implicit QL steps with Wilkinson's shift (Golub and
Van Loan, *Matrix Computations*, 8.3), as loops over rows. Each rotation has to wait for the one before it, and half of
that would be for a root. So a step finds the squares of its sines and cosines without any (Reinsch, 1971), from squares
of what is beside the diagonal, and takes their roots, which the eigenvectors need, beside that.
"""

from __future__ import annotations

import math

from .compile import inner, integer, precise
from .orthogonal import padded
from .single_lines import clear_line
from .sums import SHORT, add_rows, multiply_long
from .transforms import reflect, rotate, subtract_both

#: An off-diagonal entry counts as zero below this share of its two diagonal neighbours; and the most QL steps for each
#: eigenvalue.
ZERO, MOST = 1e-16, 60
#: A matrix with less in it is zero; and where the largest entry is 1, the square of one beside the diagonal that is
#: less, before its inverse is too large for a number.
TINY = 1e-290
#: A cosine is zero where its square is less than the inverse of this.
MUCH = 1e280
#: Share of the largest entry of a matrix that is round-off of its own computation, such as a product of three.
NOISE = 1e-15


@inner
def eigen(M, U, values, n, noise):
    """Write the eigenvalues of M[:n, :n] to `values`, in no order, and the eigenvectors to the rows of U.

    M is overwritten. `noise` is the share of the largest entry up to which others count as zero: 0 where eigenvalues
    far below it matter, as of a graded matrix; with :data:`NOISE` a matrix of low rank takes half of the time. The rows
    of M and U, and `values`, have room for padded(n) numbers.
    """
    tridiagonal(M, values, n)
    gather_beside(M, n)
    accumulate(M, U, n)
    diagonalise(M[0], U, values, n, padded(n), noise)


@inner
def largest(M, values, n):
    r"""The largest eigenvalue of M[:n, :n], which is overwritten and has no negative ones; 0 if n is 0.

    Of more than a few by Laguerre's method on the characteristic polynomial p of the tridiagonal matrix: from above all
    roots it converges monotonically to the largest, cubically. With the pivots
    :math:`q_i = (t - a_i) - b_i^2 / q_{i-1}`, whose product is p, :math:`p' / p = \sum q_i' / q_i`, and
    :math:`(p' / p)' = \sum (q_i' / q_i)'`.
    """
    if n == 0:
        return 0.0
    tridiagonal(M, values, n)
    gather_beside(M, n)
    beside, t = M[0], 0.0
    if n <= SHORT:
        diagonalise(beside, M, values, n, 0, NOISE)
        for i in range(n):
            t = max(t, values[i])
        return t
    for i in range(n):  # Gershgorin's circles
        after = abs(beside[i + 1]) if i + 1 < n else 0.0
        t = max(t, values[i] + (abs(beside[i]) if i > 0 else 0.0) + after)
    for _ in range(MOST if t > 0.0 else 0):
        once, twice, pivot, slope, bend = 0.0, 0.0, 1.0, 0.0, 0.0
        for i in range(n):
            part = beside[i] * beside[i] / pivot if i > 0 else 0.0
            rate = slope / pivot
            curve = bend / pivot - 2.0 * rate * rate
            pivot = t - values[i] - part
            slope, bend = 1.0 + part * rate, part * curve
            if not pivot > 0.0:
                return t  # as near as round-off tells
            change = slope / pivot
            once += change
            twice += bend / pivot - change * change
        # roots further off: p' / p = 1 / (t - root) + (n - 1) equal others
        spread = (n - 1) * max(-n * twice - once * once, 0.0)
        less = n / (once + math.sqrt(spread))
        if not less > ZERO * t:
            return t
        t -= less
    return t


@inner
def gather_beside(M, n):
    """Write the entries beside the diagonal of :func:`tridiagonal` to M[0]: entry i is that of (i - 1, i)."""
    beside = M[0]
    for i in range(1, n):
        beside[i] = M[i - 1][i]


@inner
def diagonalise(beside, U, values, n, columns, noise):
    """QL steps on a tridiagonal matrix, `values` and `beside`; they rotate the first columns of U along.

    Meanwhile the matrix is scaled to entries of up to 1, and beside the diagonal are squares with the signs of entries.
    """
    size = 0.0
    for i in range(1, n):
        size = max(size, abs(values[i]) + abs(beside[i]))
    size = max(size, abs(values[0])) if n > 0 else 0.0
    if not size > TINY:
        return
    over, least = 1.0 / size, max(noise * noise, TINY)
    for i in range(n):
        values[i] *= over
    for i in range(1, n):
        beside[i] = math.copysign((over * beside[i]) * (over * beside[i]), beside[i])
    end, tries = n - 1, integer(0)
    while end > 0 and tries < MOST * n:
        begin = end
        while begin > 0 and counts(beside[begin], values[begin], values[begin - 1], least):
            begin -= 1
        if begin == end:
            end -= 1
            continue
        tries += 1
        if end == begin + 1:
            pair(beside, U, values, begin, columns)
            end = begin
        else:
            step(beside, U, values, begin, end, columns)
    for i in range(n):
        values[i] *= size


@inner
def counts(square, one, other, noise):
    """Whether an off-diagonal entry, of which this is the square, is more than round-off; so is the square `noise`."""
    if not abs(square) > noise:
        return False
    least = ZERO * (abs(one) + abs(other))
    return abs(square) > least * least


@inner
def bring_forward(U, values, n, sign):
    """Swap the eigenvectors whose eigenvalues have this sign to the first rows of U; returns how many there are."""
    count = integer(0)
    for p in range(n):
        if sign * values[p] > 0.0:
            if p > count:
                one, other = U[count], U[p]
                values[count], values[p] = values[p], values[count]
                for j in range(n):
                    one[j], other[j] = other[j], one[j]
            count += 1
    return count


@inner
def add_spectrum(U, values, n, count, scale, shares, out):
    """Add scale * sum of values[p] u_p u_p', over the first `count` rows u of U, to out[:n, :n]; `shares` is work."""
    for i in range(n):
        for p in range(count):
            shares[p] = scale * values[p] * U[p][i]
        add_rows(shares, U, 0, count, n, out[i])


@inner
def tridiagonal(M, values, n):
    """Reflect M to a tridiagonal matrix: its diagonal to `values`, and beside it, entry (i - 1, i) in M.

    Row i of M, up to its diagonal, is then the reflection :math:`I - s u u^T` of the first i directions: u, then s.
    """
    for i in range(n - 1, 0, -1):
        row, head, total = M[i], M[i][i - 1], 0.0
        for j in range(i - 1):
            total += row[j] * row[j]
        values[i], row[i], M[i - 1][i] = row[i], 0.0, head
        if total == 0.0:
            continue
        size = math.sqrt(total + head * head)
        if head > 0.0:
            size = -size
        first = head - size
        scale, along = 2.0 / (total + first * first), 0.0
        row[i - 1], row[i] = first, scale
        # M - u p' - p u', with p = M u * scale - (u' M u) scale^2 / 2 u, in `values`.
        if i > SHORT:
            multiply_long(M, i, row, i, values)
        else:
            for r in range(i):
                own, value = M[r], 0.0
                for j in range(i):
                    value += own[j] * row[j]
                values[r] = value
        for r in range(i):
            values[r] *= scale
            along += values[r] * row[r]
        along *= 0.5 * scale
        for r in range(i):
            values[r] -= along * row[r]
        if i > SHORT:
            subtract_both(M, i, row, values, padded(i))
        else:
            for r in range(i):
                own, one, other = M[r], row[r], values[r]
                for j in range(i):
                    own[j] -= one * values[j] + other * row[j]
        M[i - 1][i] = size
    if n > 0:
        values[0] = M[0][0]


@inner
def accumulate(M, U, n):
    """Write the product of the reflections in the rows of M, see :func:`tridiagonal`, to U. Row 0 of M is left."""
    wide = padded(n)
    for i in range(n):
        own, u, scale = U[i], M[i], M[i][i] if i > 0 else 0.0
        clear_line(own, wide)
        own[i] = 1.0
        if scale == 0.0:
            continue
        if i >= SHORT:
            for j in range(i, padded(i)):
                u[j] = 0.0
            reflect(U, i, u, scale, padded(i))
            continue
        for r in range(i):
            row, along = U[r], 0.0
            for j in range(i):
                along += row[j] * u[j]
            along *= scale
            for j in range(i):
                row[j] -= along * u[j]


@inner
def pair(beside, U, values, i, n):
    """Make the block of rows i and i + 1 diagonal by one rotation, which also turns these rows of U."""
    square, half = abs(beside[i + 1]), 0.5 * (values[i + 1] - values[i])
    root = math.sqrt(half * half + square)
    far = half + (root if half >= 0.0 else -root)
    over = 1.0 / (far * far + square)
    values[i] -= square / far
    values[i + 1] += square / far
    sine = math.copysign(square * over, beside[i + 1] if half >= 0.0 else -beside[i + 1])
    beside[i + 1] = 0.0
    rotate(U[i], U[i + 1], sine, far * far * over, n)


@precise
def step(beside, U, values, begin, end, n):
    r"""One implicit QL step on the block begin .. end: diagonal `values`, squares `beside` it; rotates U with it.

    With the pivot :math:`\pi` of a rotation, p is its square, g is it times the cosine of the rotation before, and
    `sign` its sign, which is that of its own cosine. Sums and products are kept in their order: each rotation waits for
    one quotient of the one before, not for two.
    """
    half, square = 0.5 * (values[begin + 1] - values[begin]), abs(beside[begin + 1])
    root = math.sqrt(half * half + square)  # hypot takes three times as long
    shift = values[begin] + (half - math.copysign(root, half))  # round-off in it makes no eigenvalue less accurate
    g = values[end] - shift
    sign, last, p, c, sine = math.copysign(1.0, g), 1.0, g * g, 1.0, 0.0
    for i in range(end - 1, begin - 1, -1):
        entry, diagonal = beside[i + 1], values[i]
        square = abs(entry)
        total = p + square
        if i + 1 < end:
            beside[i + 2] = math.copysign(sine * total, beside[i + 2])
        before, old, over, much = c, g, 1.0 / total, p * (diagonal - shift) - square * g
        c, sine, g = p * over, square * over, much * over
        values[i + 1] = old + (diagonal - g)
        rotate(U[i], U[i + 1], math.copysign(sine, entry), math.copysign(c, sign), n)
        if total < MUCH * p:
            p = g * (much / p)
            last, sign = sign, sign * math.copysign(1.0, g)
        else:  # the limit as the cosine goes to zero
            p = before * square
            last, sign = sign, -last
    values[begin] = g + shift
    beside[begin + 1] = math.copysign(sine * p, sign * beside[begin + 1])
