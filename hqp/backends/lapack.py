"""Row spaces and least squares by direct calls of LAPACK: for small matrices numpy's wrappers take most of the time."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgels, dgesdd

from ..arrays import Array


def row_space(units: Array, tolerance: float) -> tuple[Array, Array]:
    """Orthonormal bases, (n, r) and (n, n - r), of the row space and the null space of rows in units of their norms.

    Singular values up to the tolerance count as zero, see :func:`hqp.certificate.split`.
    """
    n = units.shape[1]
    if not units.size:
        return np.zeros((n, 0)), np.eye(n)
    _, singular, vt, failed = dgesdd(units)
    if failed:
        raise np.linalg.LinAlgError("no singular value decomposition")
    rank = np.count_nonzero(singular > tolerance)
    return vt[:rank].T, vt[rank:].T


def least_squares(A: Array, b: Array) -> Array:
    """The x with ``||A x - b||`` smallest, where A has full column rank."""
    if not A.size:
        return np.zeros(A.shape[1])
    _, x, failed = dgels(A, b)
    if failed:
        raise np.linalg.LinAlgError("no least squares: the matrix has not full rank")
    solution: Array = x[: A.shape[1]]
    return solution
