"""Convex shapes of Coal, which tells distances between them: by name, and the hull of points."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np

from hqp import InvalidInput

from ..base.checks import Array

#: Points whose least extent is this share of their largest have no volume.
FLAT = 1e-9


def shape_of(name: str, *sizes: float) -> Any:
    """A sphere, capsule, cylinder, ellipsoid or box of Coal, by its own sizes [m]."""
    return getattr(coal, name)(*sizes)


def check_volume(points: Array, what: str) -> None:
    """Refuse points in a plane, which have no hull.

    Raises
    ------
    InvalidInput
    """
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False) if len(points) > 3 else np.zeros(1)
    if not spread.min() > FLAT * spread.max():
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
