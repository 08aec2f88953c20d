"""The shape of a contact: its points, and the motions of the frame that they constrain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput

from ..base.checks import Array, finite, positive, positive_scalar
from ..base.telling import tell

#: Points count as collinear, or as one point, up to this share of their extent.
FLAT = 1e-6
#: Points count as in one plane up to this share of their extent.
UNEVEN = 0.01
#: Cosine beyond which an axis of the frame counts as parallel to the normal.
STEEP = 0.7


@dataclass(frozen=True, eq=False)
class Shape:
    """Points of a contact in the coordinates of its frame.

    Attributes
    ----------
    points : array, shape (k, 3)
        [m].
    centre : array, shape (3,)
        Centre of the points; the contact constrains its motion and the rotation of the frame.
    along : array, shape (3,)
        Direction in the frame that defines t1; 0 if t1 is taken from the axes of the world.
    turning : array of int
        The axes t1, t2, n of the surface about which the frame cannot turn.
    """

    points: Array
    centre: Array
    along: Array
    turning: NDArray[np.int64]

    @property
    def motions(self) -> int:
        """How many motions of the frame it constrains: 3 at a point, 5 along a line, 6 on a plane."""
        return 3 + len(self.turning)


def shape_of(
    points: ArrayLike | None, plane: ArrayLike | None, line: float | None, centre: ArrayLike, what: str
) -> Shape:
    """The shape of points, of a rectangle in the x-y plane of the frame, of a line along its x axis, or of one point.

    Raises
    ------
    InvalidInput
        If several of them are given, or there is no point.
    """
    given = [name for name, value in (("points", points), ("plane", plane), ("line", line)) if value is not None]
    if len(given) > 1:
        raise InvalidInput(f"{what}: {' and '.join(given)} are given; it takes one of points, plane and line")
    middle = finite(centre, f"{what}: centre")
    if middle.shape != (3,):
        raise InvalidInput(f"{what}: centre has shape {middle.shape}; it must be (3,)")
    if plane is not None:
        lengths = positive(plane, f"{what}: plane", unit="m")
        if lengths.shape != (2,):
            raise InvalidInput(f"{what}: plane has shape {lengths.shape}; it must be (2,), its lengths along x and y")
        x, y = 0.5 * lengths
        return _shape(middle + np.array([[x, y, 0.0], [x, -y, 0.0], [-x, y, 0.0], [-x, -y, 0.0]]))
    if line is not None:
        half = 0.5 * positive_scalar(line, f"{what}: line", unit="m")
        return _shape(middle + np.array([[half, 0.0, 0.0], [-half, 0.0, 0.0]]))
    if points is None:
        return _shape(middle[None])
    own = finite(points, f"{what}: points")
    if own.ndim != 2 or own.shape[1] != 3 or not len(own):
        raise InvalidInput(f"{what}: points have shape {own.shape}; they must be (k, 3), one or more of them, in m")
    shape = _shape(own + middle)
    off = _unevenness(shape)
    if off > UNEVEN * np.ptp(own, axis=0).max():
        tell(
            f"{what}: its points are up to {1e3 * off:.3g} mm off one plane; each has a friction cone about the one"
            " normal, as on a step. Is a coordinate wrong?"
        )
    return shape


def _unevenness(shape: Shape) -> float:
    """How far points are from the plane that fits them best, at most [m]."""
    out = shape.points - shape.centre
    normal = np.linalg.svd(out, full_matrices=True)[2][2]
    return float(np.abs(out @ normal).max())


def _shape(points: Array) -> Shape:
    centre = points.mean(axis=0)
    _, sizes, ways = np.linalg.svd(points - centre, full_matrices=True)
    sizes = np.append(sizes, np.zeros(3))[:3]
    rank = int((sizes > FLAT * max(sizes[0], FLAT)).sum())
    if rank == 0:
        return Shape(points, centre, np.zeros(3), np.zeros(0, dtype=np.int64))
    if rank == 1:  # a line can turn about itself
        return Shape(points, centre, ways[0], np.array([1, 2]))
    return Shape(points, centre, np.eye(3)[0 if abs(ways[2, 0]) < STEEP else 1], np.arange(3))
