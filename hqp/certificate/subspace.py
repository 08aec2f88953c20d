"""Row spaces and null spaces, with a rank decision that does not depend on the scale of the rows."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, length

#: Unit rows are clearly independent if all singular values, or pivots, are above this.
CLEAR = 1e-6
#: A pivot below this multiple of the rank tolerance is clearly round-off.
FAR_BELOW = 1e-2
#: Up to so many unknowns numpy's singular value decomposition is as fast, so that scipy need not be imported.
FEW = 8
#: The most refinements of multipliers, each of which gains a factor ``CLEAR^2 / eps``, four digits, or more; and the
#: relative residual at which they end.
REFINEMENTS, SETTLED = 3, 1e-14


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


class RowSpace:
    """The span of rows, extended block by block.

    A new block is projected onto the orthogonal complement of the span, and a QR decomposition with column pivoting of
    the result gives the new directions. The rank follows from the pivots if these are clear. Otherwise, or with few
    unknowns, it follows from the singular values of all rows so far, as in :func:`row_space`.

    Parameters
    ----------
    n : int
        Number of unknowns.
    tolerance : float
        Singular values up to this one count as zero.

    Attributes
    ----------
    rows : array, shape (m, n)
        The rows added so far, divided by their norms.
    basis : array, shape (n, r)
        An orthonormal basis of the span.
    """

    def __init__(self, n: int, tolerance: float) -> None:
        self._tolerance = tolerance
        self.rows, self.basis = np.zeros((0, n)), np.zeros((n, 0))
        self._gram = np.zeros((0, 0))
        self._factor: Array | None = self._gram

    def grow(self, units: Array) -> None:
        """Add a block of rows, shape (k, n), divided by their norms."""
        if not len(units):
            return
        self.rows = np.concatenate([self.rows, units])
        few = units.shape[1] <= FEW
        if few or not (self._extend(units) and self._factorise(units)):
            self.basis, _, _ = row_space(self.rows, self._tolerance)
            self._gram, self._factor = np.zeros((0, 0)), None
            if not few:
                self._factorise(self.rows)

    def project(self, vectors: Array) -> Array:
        """Project vectors, shape (n,) or (k, n), onto the orthogonal complement of the span."""
        return vectors - (vectors @ self.basis) @ self.basis.T

    def smallest(self) -> float:
        """The smallest singular value of the rows above the tolerance; 1 if there is none."""
        return row_space(self.rows, self._tolerance)[2]

    def combine(self, vector: Array) -> Array:
        r"""The least-norm :math:`\lambda`, shape (m,), that minimises ``||rows^T lambda - vector||``.

        With the coordinates :math:`C` of the rows in the basis, it is :math:`C (C^T C)^{-1}` times the coordinates of
        the vector; with iterative refinement, because :math:`C^T C` squares the condition number.
        """
        if not self.basis.size:
            return np.zeros(len(self.rows))
        if self._factor is None:
            return np.asarray(np.linalg.lstsq(self.rows.T, vector, rcond=self._tolerance)[0], dtype=np.float64)
        from scipy.linalg.lapack import dpotrs

        wanted = left = vector @ self.basis
        found = np.zeros(len(self.rows))
        for _ in range(REFINEMENTS):
            found += self.rows @ (self.basis @ dpotrs(self._factor, left)[0])
            left = wanted - (found @ self.rows) @ self.basis
            if length(left) <= SETTLED * length(wanted):
                break
        return found

    def _extend(self, units: Array) -> bool:
        """Add the new directions of a block to the basis; False if its pivots leave the rank in doubt."""
        from scipy.linalg.lapack import dgeqp3, dorgqr

        n, known = self.basis.shape
        if known == n:
            return True
        factors, _, scalars, _, _ = dgeqp3(self.project(units).T)
        pivots = np.abs(factors.diagonal())
        rank = int(np.count_nonzero(pivots > CLEAR))
        if rank < len(pivots) and pivots[rank] > FAR_BELOW * self._tolerance:
            return False
        if rank:
            directions, _, _ = dorgqr(factors[:, :rank], scalars[:rank])
            directions -= self.basis @ (self.basis.T @ directions)  # again: short rows have lost digits
            self.basis = np.concatenate([self.basis, directions], axis=1)
        return True

    def _factorise(self, units: Array) -> bool:
        """Add a block to C^T C, and compute its Cholesky factor; False if a singular value of C may be near zero."""
        from scipy.linalg.lapack import dpocon, dpotrf

        known, rank = len(self._gram), self.basis.shape[1]
        more = units @ self.basis
        gram = more.T @ more
        gram[:known, :known] += self._gram  # earlier rows have no part in new directions
        factor, failed = dpotrf(gram)
        size = float(np.abs(gram).sum(axis=0).max(initial=0.0))
        independent = not rank or (not failed and dpocon(factor, size)[0] * size > CLEAR * CLEAR)
        self._gram, self._factor = gram, factor if independent else None
        return independent
