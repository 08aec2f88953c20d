"""Convex shapes of Coal, which tells distances between them: by name, and the hull of points."""

from __future__ import annotations

from typing import Any

import coal

from hqp import InvalidInput

from ..base.checks import Array, is_flat


def shape_of(name: str, *sizes: float) -> Any:
    """A sphere, capsule, cylinder, ellipsoid or box of Coal, by its own sizes [m]."""
    return getattr(coal, name)(*sizes)


def check_volume(points: Array, what: str) -> None:
    """Refuse points in a plane, which have no hull.

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
