"""Row spaces and null spaces, with a rank decision that does not depend on the scale of the rows."""

from __future__ import annotations

import numpy as np

from ..arrays import Array


def split(rows: Array, norms: Array, tolerance: float) -> tuple[Array, Array]:
    """Orthonormal bases of the row space and of the null space of `rows`.

    Parameters
    ----------
    rows : array, shape (m, n)
        Usually ``A Z``: rows already projected onto the null space of higher levels.
    norms : array, shape (m,)
        Norms of the *original* rows of A. The rank decision is relative to these, not to ``A Z`` itself: otherwise the
        round-off of a dependent row (1e-16) would count as a direction.
    tolerance : float
        Singular values of the rows divided by `norms`, up to this one, count as zero.

    Returns
    -------
    row_space : array, shape (n, r)
    null_space : array, shape (n, n - r)
    """
    kept = norms > 0
    range_, null, _ = row_space(rows[kept] / norms[kept, None], tolerance)
    return range_, null


def row_space(units: Array, tolerance: float) -> tuple[Array, Array, float]:
    """:func:`split` for rows divided by their norms; also returns the smallest singular value kept (1 if none).

    Parameters
    ----------
    units : array, shape (m, n)
        Rows divided by their norms.
    tolerance : float
        Singular values up to this one count as zero.
    """
    n = units.shape[1]
    if not n or not len(units):
        return np.zeros((n, 0)), np.eye(n), 1.0
    _, singular, vt = np.linalg.svd(units)
    rank = int(np.count_nonzero(singular > tolerance))
    return vt[:rank].T, vt[rank:].T, float(singular[rank - 1]) if rank else 1.0
