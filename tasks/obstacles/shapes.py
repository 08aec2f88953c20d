r"""Shapes of obstacles, and where two of them are nearest.

Every shape is a core, the convex hull of a few points, and a radius about it: a sphere has one point, a capsule two.
The distance of two shapes is that of their cores less both radii. In the plane z = 0 a sphere is a circle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from .._checks import Array, finite, positive_scalar
from ..motion.trajectories import Fixed, Trajectory, as_trajectory

#: Cores nearer than this have no direction that leads from one to the other [m].
TOUCHING = 1e-12


class Obstacle:
    """A shape in the world.

    Attributes
    ----------
    radius : float
        About the core [m].
    """

    radius: float

    @property
    def moves(self) -> bool:
        """Whether it may be somewhere else at another time."""
        return False

    def core(self, t: float) -> Array:
        """The points whose convex hull is the core at time t [s], shape (1 or 2, 3) [m]."""
        raise NotImplementedError

    def velocity(self, t: float) -> Array:
        """Of the whole shape, which does not turn, shape (3,) [m/s]."""
        return np.zeros(3)

    def acceleration(self, t: float) -> Array:
        """The same, shape (3,) [m/s^2]."""
        return np.zeros(3)


class Sphere(Obstacle):
    """A sphere; for a planar arm a circle.

    Parameters
    ----------
    centre : array, shape (3,) or (2,), or Trajectory
        Where it is [m]; a trajectory brings its velocity.
    radius : float
        [m].

    Raises
    ------
    InvalidInput
        If the centre is not two or three finite numbers, or the radius not positive.
    """

    def __init__(self, centre: ArrayLike | Trajectory, radius: float) -> None:
        self.radius = positive_scalar(radius, "Sphere: radius", unit="m")
        given = centre if callable(centre) else _point(centre, "Sphere: centre", flat=True)
        self.centre = as_trajectory(given, None, "Sphere: centre")
        _point(self.centre(0.0)[0], "Sphere: centre", flat=True)

    @property
    def moves(self) -> bool:
        return not isinstance(self.centre, Fixed)

    def core(self, t: float) -> Array:
        return _spatial(self.centre(t)[0])[None]

    def velocity(self, t: float) -> Array:
        return _spatial(self.centre(t)[1])

    def acceleration(self, t: float) -> Array:
        return _spatial(self.centre(t)[2])

    def __repr__(self) -> str:
        return f"Sphere({self.centre!r}, {self.radius:g})"


class Capsule(Obstacle):
    """All points within a radius of a segment, such as a pole or a rail.

    Parameters
    ----------
    start, end : array, shape (3,) or (2,)
        Of the segment [m].
    radius : float
        [m].

    Raises
    ------
    InvalidInput
        If an end is not two or three finite numbers, or the radius not positive.
    """

    def __init__(self, start: ArrayLike, end: ArrayLike, radius: float) -> None:
        self.radius = positive_scalar(radius, "Capsule: radius", unit="m")
        self._ends = np.array([_point(start, "Capsule: start"), _point(end, "Capsule: end")])

    def core(self, t: float) -> Array:
        return self._ends

    def __repr__(self) -> str:
        return f"Capsule({self._ends[0].tolist()}, {self._ends[1].tolist()}, {self.radius:g})"


def nearest_points(first: Array, second: Array) -> tuple[Array, Array]:
    """Where two cores of one or two points each are nearest, a point of each, shapes (3,).

    A point of the first segment that is nearest to the second is at an end, or both are inside their segments;
    C. Ericson, Real-Time Collision Detection (2005), 5.1.9, minimises the same square in s and t.
    """
    a, c = first[0], second[0]
    u, w, gap = first[-1] - a, second[-1] - c, a - c
    uu, uw, ww, ug, wg = u @ u, u @ w, w @ w, u @ gap, w @ gap
    across = uu * ww - uw * uw
    # Parallel segments are nearest along a whole piece: begin in the middle of the first.
    s = float(np.clip((uw * wg - ug * ww) / across, 0.0, 1.0)) if across > 1e-12 * uu * ww else 0.5
    t = float(np.clip((uw * s + wg) / ww, 0.0, 1.0)) if ww > 0.0 else 0.0
    s = float(np.clip((uw * t - ug) / uu, 0.0, 1.0)) if uu > 0.0 else 0.0
    return a + s * u, c + t * w


def _point(value: ArrayLike, what: str, *, flat: bool = False) -> Array:
    point = finite(value, what)
    if point.shape not in {(2,), (3,)}:
        raise InvalidInput(f"{what} has shape {point.shape}; it must be (3,), or (2,) in the plane")
    return point if flat else _spatial(point)


def _spatial(point: Array) -> Array:
    """With z = 0 where the point is one of the plane."""
    return np.append(point, 0.0) if len(point) == 2 else np.asarray(point)
