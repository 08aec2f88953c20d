r"""Rotations in space: matrices R whose columns are the axes of a frame, and rotation vectors."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.errors import brief

from .checks import Array, finite, finite_scalar

#: Largest error of R^T R against the identity that is accepted, and that is left uncorrected.
ORTHONORMAL, EXACT = 1e-6, 1e-15
#: Below this angle [rad] a series is more accurate than the quotient.
SMALL = 1e-4
EYE = np.eye(3)


def rotation_matrix(value: ArrayLike, what: str) -> Array:
    """`value`, a matrix or an object with ``as_matrix()``, as a rotation matrix, orthonormal to round-off.

    Raises
    ------
    InvalidInput
        If it is not a finite 3 x 3 matrix, its columns are not orthonormal to 1e-6, or it is a reflection.
    """
    if hasattr(value, "as_matrix"):
        value = value.as_matrix()
    R = value if type(value) is np.ndarray and value.dtype == np.float64 else finite(value, what)
    if R.shape != (3, 3):
        raise InvalidInput(f"{what} has shape {R.shape}; a rotation is a matrix of shape (3, 3)")
    (a, b, c), (d, e, f), (g, h, i) = R.tolist()  # scalar code: for nine numbers numpy's calls cost more
    error = max(
        abs(a * a + d * d + g * g - 1.0),
        abs(b * b + e * e + h * h - 1.0),
        abs(c * c + f * f + i * i - 1.0),
        abs(a * b + d * e + g * h),
        abs(a * c + d * f + g * i),
        abs(b * c + e * f + h * i),
    )
    if not error <= ORTHONORMAL:
        finite(R, what)
        raise InvalidInput(f"{what} is no rotation: R^T R differs from the identity by {error:.3g}")
    if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0.0:
        raise InvalidInput(f"{what} is a reflection, not a rotation: its determinant is -1")
    nearest = np.array(R)
    if error > EXACT:  # Newton's method for the polar factor, the nearest rotation, squares the error
        for _ in range(2):
            nearest -= 0.5 * (nearest @ (nearest.T @ nearest - EYE))
    nearest.flags.writeable = False
    return nearest


def exp(vector: ArrayLike) -> Array:
    """The rotation about the direction of `vector` by its length [rad] (Rodrigues), shape (3, 3)."""
    x, y, z = np.asarray(vector, dtype=np.float64)
    angle = math.sqrt(x * x + y * y + z * z)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < SMALL:
        a, b = 1.0 - angle * angle / 6.0, 0.5 - angle * angle / 24.0
    else:
        a, b = math.sin(angle) / angle, 2.0 * (math.sin(0.5 * angle) / angle) ** 2
    return np.asarray(np.eye(3) + a * K + b * (K @ K))


def log(R: Array) -> Array:
    """The rotation vector of R [rad], shape (3,), of length 0 .. pi: ``exp(log(R)) = R``."""
    out = [0.0, 0.0, 0.0]
    _rotation_vector()(R.ravel().tolist(), out, 0)
    return np.array(out)


@cache
def _rotation_vector() -> Callable[[list[float], list[float], int], None]:
    """The formula of the loops as plain Python: for nine numbers a call of compiled code costs more."""
    from hqp.kernels.compile import plain

    from .kernels.rotation import rotation_vector

    found: Callable[[list[float], list[float], int], None] = plain(rotation_vector)  # type: ignore[no-untyped-call]
    return found


def about(axis: int, angle: float) -> Array:
    """The rotation by `angle` [rad] about axis 0, 1 or 2 (x, y or z), shape (3, 3)."""
    cosine, sine = math.cos(angle), math.sin(angle)
    R = np.eye(3)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    R[first, first] = R[second, second] = cosine
    R[first, second], R[second, first] = -sine, sine
    return R


def from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """The rotation about the axes of the world by roll (x), then pitch (y), then yaw (z) [rad]: URDF's ``rpy``.

    Parameters
    ----------
    roll, pitch, yaw : float
        Angles [rad].

    Returns
    -------
    array, shape (3, 3)

    Raises
    ------
    InvalidInput
        If an angle is not a finite number.

    Examples
    --------
    >>> from math import pi
    >>> from tasks import from_rpy
    >>> (from_rpy(0.0, 0.0, pi / 2) @ [1.0, 0.0, 0.0]).round(6)
    array([0., 1., 0.])
    """
    roll, pitch, yaw = finite_scalar(roll, "roll"), finite_scalar(pitch, "pitch"), finite_scalar(yaw, "yaw")
    return np.asarray(about(2, yaw) @ about(1, pitch) @ about(0, roll))


def from_xyzw(quaternion: ArrayLike) -> Array:
    """The rotation of a unit quaternion (x, y, z, w), its scalar part last, as in ROS and Pinocchio, shape (3, 3).

    MuJoCo and Eigen's constructor use the order (w, x, y, z): reorder it first.

    Parameters
    ----------
    quaternion : array, shape (4,)
        x, y, z, w.

    Raises
    ------
    InvalidInput
        If it does not have four finite numbers with norm 1, to 1e-6.

    Examples
    --------
    >>> from tasks import from_xyzw
    >>> from_xyzw([0.0, 0.0, 1.0, 0.0]) @ [1.0, 0.0, 0.0]
    array([-1.,  0.,  0.])
    """
    q = finite(quaternion, "quaternion (x, y, z, w)")
    if q.shape != (4,):
        raise InvalidInput(f"quaternion (x, y, z, w) has shape {q.shape}; it must be (4,)")
    norm = float(np.linalg.norm(q))
    if not abs(norm - 1.0) <= ORTHONORMAL:
        raise InvalidInput(f"quaternion (x, y, z, w) = {q.tolist()} has norm {norm:g}; it must be 1")
    return from_quaternion(*q.tolist())


@runtime_checkable
class RigidTransform(Protocol):
    """An object with a translation and a rotation, such as a pinocchio.SE3."""

    @property
    def translation(self) -> ArrayLike: ...
    @property
    def rotation(self) -> ArrayLike: ...


def is_transform(value: Any) -> bool:
    """Whether a value is meant as a transform, not as a point or a rotation."""
    value = matrix_of(value)
    if isinstance(value, np.ndarray):
        return bool(value.shape == (4, 4))
    if isinstance(value, list | tuple):
        return len(value) == 4 and all(isinstance(row, list | tuple | np.ndarray) and len(row) == 4 for row in value)
    return isinstance(value, RigidTransform)


def matrix_of(value: Any) -> Any:
    """The result of ``value.as_matrix()``, or the value itself if it has no such method.

    Raises
    ------
    InvalidInput
        If `as_matrix()` raises, as when `value` is a class.
    """
    if not hasattr(value, "as_matrix"):
        return value
    try:
        return value.as_matrix()
    except Exception as error:
        raise InvalidInput(f"as_matrix() of {brief(value)} raised {type(error).__name__}: {error}") from error


def transform(value: Any, what: str) -> tuple[Array, Array]:
    """Position [m] and rotation matrix of a transform: 4 x 4 matrix, SE3 of Pinocchio, or object with `as_matrix()`.

    Raises
    ------
    InvalidInput
        If it is none of these, its last row is not 0 0 0 1, or its rotation part is not a rotation.
    """
    value = matrix_of(value)
    if not isinstance(value, np.ndarray) and isinstance(value, RigidTransform):  # the second question is a long one
        position, rotation = finite(value.translation, f"{what}, translation"), value.rotation
    else:
        T = finite(value, what)
        if T.shape != (4, 4):
            raise InvalidInput(
                f"{what} has shape {T.shape}; a transform is a matrix of shape (4, 4), or a pinocchio.SE3"
            )
        if not (T[3] == [0.0, 0.0, 0.0, 1.0]).all():
            raise InvalidInput(f"{what} has the last row {T[3].tolist()}; that of a transform is 0 0 0 1")
        position, rotation = T[:3, 3], T[:3, :3]
    if np.shape(position) != (3,):
        raise InvalidInput(f"{what}, translation has shape {np.shape(position)}; it must be (3,)")
    return np.array(position), rotation_matrix(rotation, f"{what}, rotation")


def from_quaternion(x: float, y: float, z: float, w: float) -> Array:
    """The rotation of a quaternion of any length but 0, its scalar part w last.

    Raises
    ------
    InvalidInput
        If a number is not finite, or all are 0.
    """
    q = finite([x, y, z, w], "quaternion (x, y, z, w)")
    norm = float(np.linalg.norm(q))
    if norm == 0.0:
        raise InvalidInput("quaternion (x, y, z, w) is zero; it must have a direction")
    x, y, z, w = (q / norm).tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def perpendicular(axis: Array) -> Array:
    """Two unit vectors that form a right-handed frame with the unit vector `axis`: the rows, shape (2, 3)."""
    first = np.zeros(3)
    first[np.argmin(np.abs(axis))] = 1.0
    first -= axis * (axis @ first)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(axis, first)])
