"""Convex solids that stand in the world: boxes, and polyhedra as the hulls of their corners."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import of_type

from ..base.checks import Array, finite, is_flat, positive
from ..base.live import Live, number, structure
from ..base.rotations import transform

#: At the origin, along the axes of the world.
ORIGIN = np.eye(4)


class Solid(Live):
    """Base of the solids; see :class:`tasks.CollisionLimit`.

    Parameters
    ----------
    at : array, shape (4, 4) or (3,), or pinocchio.SE3
        Where it is in the world; a point [m] leaves its axes along those of the world.
    name : str
        For labels.
    """

    name: str = structure()

    def __init__(self, at: Any, name: str) -> None:
        self.name, self.at = of_type(name, str, f"name of a {type(self).__name__}"), at

    @number
    def at(self, value: Any) -> Array:
        """Where it is in the world, shape (4, 4); set it to move it from one tick to the next."""
        what, place = f"{self.full_name()}: at", np.eye(4)
        if isinstance(value, np.ndarray | list | tuple) and (point := finite(value, what)).shape == (3,):
            place[:3, 3] = point
        else:
            place[:3, 3], place[:3, :3] = transform(value, what)
        return place

    def numbers(self) -> tuple[Any, ...]:
        """The arrays that define it."""
        raise NotImplementedError

    def shape(self) -> Any:
        """Its shape in Coal."""
        raise NotImplementedError


class Box(Solid):
    """A box.

    Parameters
    ----------
    size : array, shape (3,)
        Its edges along its own axes [m].
    at : array, shape (4, 4) or (3,), or pinocchio.SE3
        Where its centre is in the world, and how it stands; a point [m] leaves its axes along those of the world.
    name : str

    Raises
    ------
    InvalidInput
        If an edge is not positive, or `at` is no transform.

    Examples
    --------
    >>> from tasks import Box
    >>> Box([0.6, 1.2, 0.04], [0.5, 0.0, 0.2], name="table")
    Box([0.6, 1.2, 0.04])
    """

    def __init__(self, size: ArrayLike, at: Any = ORIGIN, *, name: str = "box") -> None:
        super().__init__(at, name)
        self.size = size

    @number
    def size(self, value: ArrayLike) -> Array:
        """Its edges [m], shape (3,)."""
        size = positive(value, f"{self.full_name()}: size", unit="m")
        if size.shape != (3,):
            raise InvalidInput(f"{self.full_name()}: size has shape {size.shape}; it must be (3,)")
        return size

    def numbers(self) -> tuple[Any, ...]:
        return self.size, self.at

    def shape(self) -> Any:
        from ..robots.convexity import shape_of

        return shape_of("Box", *self.size.tolist())

    def __repr__(self) -> str:
        return f"Box({self.size.tolist()})"


class Polyhedron(Solid):
    """The convex hull of points, such as the corners of a polyhedron or the vertices of a mesh.

    Parameters
    ----------
    points : array, shape (k, 3)
        At least four, not in a plane [m].
    at : array, shape (4, 4) or (3,), or pinocchio.SE3
        Where its own coordinates are in the world; a point [m] leaves its axes along those of the world.
    name : str

    Raises
    ------
    InvalidInput
        If the points lie in a plane or are not finite, or `at` is no transform.

    Examples
    --------
    >>> from tasks import Polyhedron
    >>> Polyhedron([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], name="corner")
    Polyhedron(4 points)
    """

    def __init__(self, points: ArrayLike, at: Any = ORIGIN, *, name: str = "polyhedron") -> None:
        super().__init__(at, name)
        self.points = points

    @number
    def points(self, value: ArrayLike) -> Array:
        """The points whose hull it is [m], shape (k, 3)."""
        points = finite(value, f"{self.full_name()}: points")
        if points.ndim != 2 or points.shape[1] != 3:
            raise InvalidInput(f"{self.full_name()}: points has shape {points.shape}; it must be (k, 3)")
        if is_flat(points):
            raise InvalidInput(f"{self.full_name()}: points lie in a plane; they must enclose a volume")
        return points

    def numbers(self) -> tuple[Any, ...]:
        return self.points, self.at

    def shape(self) -> Any:
        from ..robots.convexity import hull

        return hull(self.points, f"{self.full_name()}: points")

    def __repr__(self) -> str:
        return f"Polyhedron({len(self.points)} points)"
