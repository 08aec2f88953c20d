"""Makes shapes of Coal, the library that computes distances: by name, as the hull of points, or as triangles."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.checks import Array, is_flat


def shape_of(name: str, *sizes: float) -> Any:
    """A sphere, capsule, cylinder, ellipsoid or box of Coal, by its own sizes [m]."""
    return getattr(coal, name)(*sizes)


#: The sizes of the simple shapes of Coal.
SIZES = {
    coal.Sphere: ("radius",),
    coal.Capsule: ("radius",),
    coal.Cylinder: ("radius", "halfLength"),
    coal.Cone: ("radius", "halfLength"),
    coal.Ellipsoid: ("radii",),
    coal.Box: ("halfSide",),
}


def check_sizes(shape: coal.CollisionGeometry, what: str) -> None:
    """Refuse a simple shape without volume, or with a size below zero, which Coal takes.

    Raises
    ------
    InvalidInput
    """
    for size in SIZES.get(type(shape), ()):
        own = np.ravel(getattr(shape, size))
        if not (np.isfinite(own).all() and own.min() > 0.0):
            kind = type(shape).__name__.lower()
            raise InvalidInput(f"{what} is a {kind} with {size} = {own.tolist()} m; its sizes must be positive")


def check_volume(points: Array, what: str) -> None:
    """Refuse points in a plane, whose hull has no volume.

    Raises
    ------
    InvalidInput
    """
    if is_flat(points):
        raise InvalidInput(f"{what} is a mesh without volume; it must not be flat")


def hull(points: Array, what: str) -> Any:
    """The convex hull of points, shape (k, 3) [m].

    Raises
    ------
    InvalidInput
        If they lie in a plane.
    """
    check_volume(points, what)
    vertices = coal.StdVec_Vec3s()
    for point in points:
        vertices.append(point)
    return coal.ConvexBase.convexHull(vertices, True, "Qt")


def triangles(points: ArrayLike, faces: ArrayLike) -> Any:
    """A mesh, not its hull: vertices, shape (k, 3) [m], and three vertex numbers per triangle, shape (m, 3)."""
    vertices, corners = np.array(points, dtype=np.float64), np.array(faces, dtype=np.int64)
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(corners), len(vertices))
    mesh.addVertices(vertices)
    mesh.addTriangles(corners)
    mesh.endModel()
    return mesh
