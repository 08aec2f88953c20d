r"""Dense linear algebra of small matrices without allocation, for Jacobians of tasks and the mass matrix.

Matrices are flat arrays, by rows.

**Singular values** follow from one-sided Jacobi rotations (Hestenes 1958): pairs of rows are rotated until all rows are
orthogonal,

.. math:: U^T J = \Sigma V^T .

Squares appear only in the angles of the rotations, so that small singular values are accurate relative to the largest.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import inner

from ..rank import RANK_TOLERANCE

#: Rows are orthogonal if the cosine between them is at most the first; a row is round-off if its squared norm is at
#: most the second share of the largest.
RIGHT_ANGLE, ROUND_OFF = 2e-15, 1e-31
#: The most sweeps. Convergence is quadratic, after about 5; rows that are mere round-off may not converge.
SWEEPS = 30
#: A matrix whose largest entry is outside this range is scaled first: fourth powers could over- or underflow.
SMALL, LARGE = 1e-50, 1e50


@inner
def fill(array, count, value):
    """Set array[:count] to one value."""
    for t in range(count):
        array[t] = value


@inner
def largest(array, count):
    """The largest absolute value in array[:count]; NaN if one of them is not finite."""
    most = 0.0
    for t in range(count):
        size = abs(array[t])
        if not size < math.inf:
            return math.nan
        most = max(most, size)
    return most


@inner
def rotate(one, other, count, c, s):
    """Rotate two rows (count,) in place: to ``c * one + s * other`` and ``c * other - s * one``."""
    for t in range(count):
        first, second = one[t], other[t]
        one[t] = c * first + s * second
        other[t] = c * second - s * first


@inner
def decompose(J, m, n, ways, sizes):
    r"""Singular value decomposition :math:`J = \sum_k \sigma_k u_k v_k^T`, J of any shape; all NaN if J is not finite.

    Parameters
    ----------
    J : (m * n,)
        The matrix, by rows; on return row k is :math:`\sigma_k v_k^T`. If sigma_k is round-off, v_k has no meaning.
    ways : (m * m,)
        On return row k is :math:`u_k`; all m are orthonormal.
    sizes : (m,)
        On return the :math:`\sigma_k`, the largest first; if m > n, the last m - n are round-off or 0.
    """
    most = largest(J, m * n)
    if most != most:
        fill(J, m * n, math.nan)
        fill(ways, m * m, math.nan)
        fill(sizes, m, math.nan)
        return
    scale = 1.0 if SMALL < most < LARGE or most == 0.0 else most
    if scale != 1.0:
        for t in range(m * n):
            J[t] /= scale
    fill(ways, m * m, 0.0)
    for k in range(m):
        ways[k * m + k] = 1.0
    for _ in range(SWEEPS):
        if not sweep(J, m, n, ways):
            break
    for k in range(m):
        total, row = 0.0, J[k * n : (k + 1) * n]
        for t in range(n):
            total += row[t] * row[t]
        sizes[k] = scale * math.sqrt(total)
        if scale != 1.0:
            for t in range(n):
                row[t] *= scale


@inner
def sweep(J, m, n, ways):
    """Make every pair of rows of J orthogonal once, the longer one first; returns whether any was rotated.

    `ways` (m * m,) is rotated in the same way.
    """
    turned, most = False, 0.0
    for k in range(m):
        total, row = 0.0, J[k * n : (k + 1) * n]
        for t in range(n):
            total += row[t] * row[t]
        most = max(most, total)
    for p in range(m - 1):
        for q in range(p + 1, m):
            one, other = J[p * n : (p + 1) * n], J[q * n : (q + 1) * n]
            a = b = d = 0.0
            for t in range(n):
                a += one[t] * one[t]
                b += other[t] * other[t]
                d += one[t] * other[t]
            if b > a:  # exchange the rows, by a rotation of 90 degrees
                rotate(one, other, n, 0.0, 1.0)
                rotate(ways[p * m : (p + 1) * m], ways[q * m : (q + 1) * m], m, 0.0, 1.0)
                a, b, d = b, a, -d
                turned = True
            if abs(d) <= RIGHT_ANGLE * math.sqrt(a * b) or b <= ROUND_OFF * most:
                continue
            gap = a - b  # tan(2 theta) = 2 d / gap
            t = 2.0 * d / (gap + math.sqrt(gap * gap + 4.0 * d * d))
            c = 1.0 / math.sqrt(1.0 + t * t)
            rotate(one, other, n, c, c * t)
            rotate(ways[p * m : (p + 1) * m], ways[q * m : (q + 1) * m], m, c, c * t)
            turned = True
    return turned


@inner
def alone(J, m, n, h, damping, x, work):
    r"""Write the least-norm least-squares solution of :math:`J x = h`, damped or not, to x[:n].

    :math:`x = \sum_k v_k \, \sigma_k / (\sigma_k^2 + \lambda^2) \, u_k^T h`. With damping this is
    :math:`J^T (J J^T + \lambda^2 I)^{-1} h`; without, :math:`J^\# h`, where singular values up to the share
    :data:`RANK_TOLERANCE` of the largest are left out. NaN if J or h is not finite.

    Parameters
    ----------
    damping : float
        lambda, in the unit of J.
    work : (m * n + m * m + m,)
    """
    if m == 1:  # J# = J^T / ||J||^2
        square = damping * damping
        for t in range(n):
            square += J[t] * J[t]
        share = h[0] / square if square != 0.0 else 0.0
        for t in range(n):
            x[t] = J[t] * share
        return
    rows, ways, sizes = work[: m * n], work[m * n : m * (m + n)], work[m * (m + n) : m * (m + n + 1)]
    for t in range(m * n):
        rows[t] = J[t]
    decompose(rows, m, n, ways, sizes)
    bad = sizes[0] != sizes[0] or largest(h, m) != largest(h, m)
    fill(x, n, math.nan if bad else 0.0)
    for k in range(m):
        size = sizes[k]
        if bad or not size > (RANK_TOLERANCE * sizes[0] if damping == 0.0 else 0.0):
            break
        along, row = 0.0, rows[k * n : (k + 1) * n]
        for r in range(m):
            along += ways[k * m + r] * h[r]
        along /= size + damping * (damping / size)
        for t in range(n):
            x[t] += row[t] / size * along


@inner
def best_way(J, m, n, way, work):
    """Write the first left singular vector u_1 of J, along which J x can be largest; its largest entry is positive.

    Parameters
    ----------
    way : (m,)
        On return u_1.
    work : (m * n + m * m + m,)
    """
    rows, ways, sizes = work[: m * n], work[m * n : m * (m + n)], work[m * (m + n) : m * (m + n + 1)]
    for t in range(m * n):
        rows[t] = J[t]
    decompose(rows, m, n, ways, sizes)
    most = 0.0
    for r in range(m):
        if abs(ways[r]) > abs(most):
            most = ways[r]
    for r in range(m):
        way[r] = ways[r] if most > 0.0 else -ways[r]


@inner
def root(M, n, A):
    """Write the Cholesky factor A = L^T, M = L L^T, an upper triangle by rows; NaN if M is not positive definite.

    Only the upper triangle of M is read. Returns whether M is positive definite.
    """
    for i in range(n):
        own = A[i * n : (i + 1) * n]
        for j in range(i):
            own[j] = 0.0
        for j in range(i, n):
            own[j] = M[i * n + j]
        for k in range(i):
            above = A[k * n : (k + 1) * n]
            factor = above[i]
            for j in range(i, n):
                own[j] -= factor * above[j]
        if not 0.0 < own[i] < math.inf:
            fill(A, n * n, math.nan)
            return False
        scale = 1.0 / math.sqrt(own[i])
        for j in range(i, n):
            own[j] *= scale
    return True


@inner
def solve_upper(A, n, x):
    """Solve ``A x = b`` for an upper triangle A (n * n,); x is b on entry."""
    for i in range(n - 1, -1, -1):
        own, total = A[i * n : (i + 1) * n], x[i]
        for j in range(i + 1, n):
            total -= own[j] * x[j]
        x[i] = total / own[i]


@inner
def solve_lower(A, n, x):
    """Solve ``A^T x = b`` for an upper triangle A (n * n,); x is b on entry."""
    for i in range(n):
        own = A[i * n : (i + 1) * n]
        x[i] /= own[i]
        for j in range(i + 1, n):
            x[j] -= own[j] * x[i]


@inner
def times(A, m, n, x, out):
    """Write ``A x`` to out[:m], for A (m * n,)."""
    for r in range(m):
        total, row = 0.0, A[r * n : (r + 1) * n]
        for t in range(n):
            total += row[t] * x[t]
        out[r] = total
