"""Row spaces and null spaces with a rank decision that does not depend on the scale of the rows."""

from __future__ import annotations

import numpy as np

from .arrays import Array


def split(rows: Array, norms: Array, tolerance: float) -> tuple[Array, Array]:
    """Orthonormal bases of the row space of `rows` and of its null space.

    Parameters
    ----------
    rows : array, shape (m, n)
        Usually ``A Z``: rows already projected onto the null space of higher levels.
    norms : array, shape (m,)
        Norms of the *original* rows of A. Cutting relative to these, not to ``A Z`` itself, is
        what keeps the round-off of a fully dependent row (1e-16) from being taken for a direction.
    tolerance
        Singular values of the rows divided by `norms` up to this one count as zero.

    Returns
    -------
    row_space : array, shape (n, r)
    null_space : array, shape (n, n - r)
    """
    n = rows.shape[1]
    kept = norms > 0
    if not n or not kept.any():
        return np.zeros((n, 0)), np.eye(n)
    _, singular, vt = np.linalg.svd(rows[kept] / norms[kept, None])
    rank = int(np.count_nonzero(singular > tolerance))
    return vt[:rank].T, vt[rank:].T
