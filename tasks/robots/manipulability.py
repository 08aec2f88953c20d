r"""Manipulability measures of a Jacobian, from its singular values.

With the singular values :math:`\sigma_1 \ge \dots \ge \sigma_m` of J, m rows and n columns:

.. math::

    w = \sqrt{\det J J^T} = \sigma_1 \cdots \sigma_m, \qquad
    \text{degree of manipulability} = \operatorname{rank} J, \qquad
    \text{degree of redundancy} = n - \operatorname{rank} J

(Yoshikawa's measure; Eq. 3.7 and 3.8). For the tip of two links :math:`w = l_1 l_2 |\sin q_2|` (Eq. 2.2).
All functions take leading axes: the Jacobians of a whole record, shape (..., m, n).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.checks import positive_number

from ..base.checks import Array, finite
from ..base.rank import RANK_TOLERANCE


@dataclass(frozen=True, eq=False)
class VelocityEllipse:
    """The velocity ellipsoid: the task velocities that joint velocities of norm one give.

    Attributes
    ----------
    half_axes : array, shape (..., m)
        Their lengths, the longest first, in the unit of J; 0 across a direction that cannot be moved.
    directions : array, shape (..., m, m)
        Orthonormal columns, that of the longest first.
    """

    half_axes: Array
    directions: Array


@dataclass(frozen=True, eq=False)
class Degrees:
    """The degrees of manipulability and of redundancy of a task.

    Attributes
    ----------
    manipulability : array of int
        Directions of the task that can be moved: rank J (Eq. 3.7).
    redundancy : array of int
        Degrees of freedom left for other tasks: n - rank J (Eq. 3.8).
    """

    manipulability: NDArray[np.int64]
    redundancy: NDArray[np.int64]


def manipulability(J: ArrayLike) -> Array:
    """Yoshikawa's measure ``sqrt(det(J J^T))``, shape (...), in the unit of J to the power of m.

    It is 0 if J has more rows than columns: some direction cannot be moved.

    Parameters
    ----------
    J : array, shape (..., m, n)
        Jacobian of the task.

    Raises
    ------
    InvalidInput
        If J is not finite or has fewer than two axes.

    Examples
    --------
    >>> from tasks import manipulability
    >>> float(manipulability([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]))
    2.0
    """
    J = _jacobians(J)
    if J.shape[-2] > J.shape[-1]:
        return np.zeros(J.shape[:-2])
    return np.asarray(np.prod(np.linalg.svd(J, compute_uv=False), axis=-1))


def velocity_ellipse(J: ArrayLike) -> VelocityEllipse:
    """The image of the joint velocities of norm one (section 1.3.5).

    Parameters
    ----------
    J : array, shape (..., m, n)
        Jacobian of the task.

    Raises
    ------
    InvalidInput
        If J is not finite or has fewer than two axes.

    Examples
    --------
    >>> from tasks import velocity_ellipse
    >>> velocity_ellipse([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]).half_axes
    array([2., 1.])
    """
    J = _jacobians(J)
    directions, values, _ = np.linalg.svd(J)
    half_axes = np.zeros(J.shape[:-1])
    half_axes[..., : values.shape[-1]] = values
    return VelocityEllipse(half_axes, directions)


def task_degrees(J: ArrayLike, tolerance: float = RANK_TOLERANCE) -> Degrees:
    """Degrees of manipulability and of redundancy, arrays of shape (...), of a task with Jacobian J.

    Parameters
    ----------
    J : array, shape (..., m, n)
    tolerance : float
        Singular values up to this share of the largest count as zero; between 0 and 1.

    Raises
    ------
    InvalidInput
        If J is not finite or has fewer than two axes, or the tolerance is out of range.

    Examples
    --------
    >>> from tasks import task_degrees
    >>> degrees = task_degrees([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    >>> int(degrees.manipulability), int(degrees.redundancy)
    (1, 2)
    """
    J = _jacobians(J)
    share = positive_number(tolerance, "tolerance", below=1.0)
    values = np.linalg.svd(J, compute_uv=False)
    rank = np.asarray(np.sum(values > share * values[..., :1], axis=-1))
    return Degrees(rank, J.shape[-1] - rank)


def _jacobians(J: ArrayLike) -> Array:
    given = finite(J, "J")
    if given.ndim < 2:
        raise InvalidInput(f"J has shape {given.shape}; it must be (..., rows of the task, joints)")
    return given
