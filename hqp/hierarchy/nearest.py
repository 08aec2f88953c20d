r"""The last level in another norm: :math:`\min \|x - x_\text{ref}\|_M`, as rows.

With :math:`M = L L^T`, :math:`\|x - x_\text{ref}\|_M^2 = (x - x_\text{ref})^T M (x - x_\text{ref})` is
:math:`\|L^T x - L^T x_\text{ref}\|^2`: equality rows. Below a task :math:`J x = r` the answer is

.. math:: x = x_\text{ref} + M^{-1} J^T (J M^{-1} J^T)^{-1} (r - J x_\text{ref}),

the dynamically consistent one (Khatib 1987) where M is the mass matrix.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import finite_vector, real_array
from ..checks import of_type
from ..errors import InvalidInput
from .level import Level

#: How far M may be from symmetric, relative to its largest entry: round-off of its computation.
SYMMETRY = 1e-10


def nearest(x_ref: ArrayLike, M: ArrayLike, *, name: str = "nearest") -> Level:
    """The level ``min ||x - x_ref||_M``, which uses up the whole null space of the levels above: put it last.

    Parameters
    ----------
    x_ref : array, shape (n,)
    M : array, shape (n, n)
        Symmetric and positive definite, as a mass matrix.
    name : str

    Raises
    ------
    InvalidInput
        If M is not symmetric and positive definite, or x_ref does not fit it.

    Examples
    --------
    >>> from hqp import Hierarchy, Level, nearest, solve
    >>> total = Level.equality([[1.0, 1.0]], [3.0], name="sum")
    >>> last = nearest([0.0, 0.0], [[1.0, 0.0], [0.0, 2.0]])  # the second unknown costs twice as much
    >>> solve(Hierarchy([total, last])).x.round(6)
    array([2., 1.])
    """
    level = f"level {of_type(name, str, 'name of a level')!r}"
    metric = real_array(M, f"{level}: M")
    if metric.ndim != 2 or metric.shape[0] != metric.shape[1]:
        raise InvalidInput(f"{level}: M has shape {metric.shape}; it must be square")
    if not np.isfinite(metric).all():
        i, j = np.argwhere(~np.isfinite(metric))[0]
        raise InvalidInput(f"{level}: M[{i}, {j}] = {metric[i, j]} must be finite")
    reference = finite_vector(x_ref, len(metric), f"{level}: x_ref")
    skew = np.abs(metric - metric.T)
    if skew.max(initial=0.0) > SYMMETRY * np.abs(metric).max(initial=0.0):
        i, j = np.unravel_index(np.argmax(skew), skew.shape)
        raise InvalidInput(
            f"{level}: M[{i}, {j}] = {metric[i, j]}, but M[{j}, {i}] = {metric[j, i]}; M must be symmetric"
        )
    try:
        rows = np.linalg.cholesky((metric + metric.T) / 2).T
    except np.linalg.LinAlgError:
        least = np.linalg.eigvalsh(metric)[0]
        raise InvalidInput(f"{level}: M must be positive definite, and its smallest eigenvalue is {least:g}") from None
    return Level.equality(rows, rows @ reference, name=name)
