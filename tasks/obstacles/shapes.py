r"""Shapes of obstacles: spheres and capsules.

Every shape is a core, the convex hull of a few points, and a radius about it: a sphere has one point, a capsule two.
The distance of two shapes is that of their cores less both radii. In the plane z = 0 a sphere is a circle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.checks import Array, finite, not_negative, positive_scalar, scalar
from ..base.live import Live, number
from ..targets.trajectories import Fixed, Trajectory, as_trajectory


class Obstacle(Live):
    """Base of obstacles: a shape in the world, fixed or moving.

    A class of your own defines `core`, and `velocity` and `acceleration` if it moves; it is evaluated at every tick,
    unless `moves` is False.

    Attributes
    ----------
    radius : float
        About the core [m].
    """

    @number
    def radius(self, value: float) -> float:
        """About the core [m]; not negative."""
        return scalar(not_negative(value, f"{self.full_name()}: radius", unit="m"), f"{self.full_name()}: radius")

    @property
    def moves(self) -> bool:
        """Whether it may be somewhere else at another time."""
        return False

    @property
    def is_flat(self) -> bool:
        """Whether it was placed by two numbers, in the plane z = 0."""
        return False

    def core(self, t: float) -> Array:
        """The points whose convex hull is the core at time t [s], shape (1 or 2, 3) [m]."""
        raise NotImplementedError

    def velocity(self, t: float) -> Array:
        """The velocity of the shape, which does not turn, shape (3,) [m/s]."""
        return np.zeros(3)

    def acceleration(self, t: float) -> Array:
        """The acceleration of the shape, shape (3,) [m/s^2]."""
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

    Examples
    --------
    >>> from tasks import Line, Sphere
    >>> Sphere([0.6, 0.3], 0.1)
    Sphere([0.6, 0.3], 0.1)
    >>> Sphere(Line([0.6, 0.3], [0.6, 0.8], duration=2.0), 0.1)  # it moves
    Sphere(Line([0.6, 0.3], [0.6, 0.8], 2), 0.1)
    """

    def __init__(self, centre: ArrayLike | Trajectory, radius: float) -> None:
        self.radius, self.centre = radius, centre

    @number
    def radius(self, value: float) -> float:
        """[m]."""
        return positive_scalar(value, f"{self.full_name()}: radius", unit="m")

    @number
    def centre(self, value: ArrayLike | Trajectory) -> Trajectory:
        """Where it is [m]."""
        what = f"{self.full_name()}: centre"
        trajectory = as_trajectory(value if callable(value) else _point(value, what, flat=True), None, what)
        _point(trajectory(0.0)[0], what, flat=True)
        return trajectory

    @property
    def moves(self) -> bool:
        return not isinstance(self.centre, Fixed)

    @property
    def is_flat(self) -> bool:
        return len(self.centre(0.0)[0]) == 2

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

    Examples
    --------
    >>> from tasks import Capsule
    >>> Capsule([0.5, 0.0, 0.0], [0.5, 0.0, 1.0], 0.05)  # an upright pole
    Capsule([0.5, 0.0, 0.0], [0.5, 0.0, 1.0], 0.05)
    """

    def __init__(self, start: ArrayLike, end: ArrayLike, radius: float) -> None:
        self.radius, self.start, self.end = radius, start, end

    @number
    def radius(self, value: float) -> float:
        """[m]."""
        return positive_scalar(value, f"{self.full_name()}: radius", unit="m")

    @number
    def start(self, value: ArrayLike) -> Array:
        """Where the segment begins [m], shape (3,)."""
        return _point(value, f"{self.full_name()}: start")

    @number
    def end(self, value: ArrayLike) -> Array:
        """Where it ends [m], shape (3,)."""
        point = _point(value, f"{self.full_name()}: end")
        self._ends_flat = np.shape(value) == (2,)
        return point

    @property
    def is_flat(self) -> bool:
        return self._ends_flat

    def core(self, t: float) -> Array:
        return np.array([self.start, self.end])

    def __repr__(self) -> str:
        return f"Capsule({self.start.tolist()}, {self.end.tolist()}, {self.radius:g})"


def _point(value: ArrayLike, what: str, *, flat: bool = False) -> Array:
    point = finite(value, what)
    if point.shape not in {(2,), (3,)}:
        raise InvalidInput(f"{what} has shape {point.shape}; it must be (3,), or (2,) in the plane")
    return point if flat else _spatial(point)


def _spatial(point: Array) -> Array:
    """With z = 0 where the point is one of the plane."""
    return np.append(point, 0.0) if len(point) == 2 else np.asarray(point)
