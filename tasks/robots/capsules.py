r"""Bodies of a robot as capsules: the smallest one about the shapes of each.

Every shape is the hull of balls: corners have radius 0, a sphere is one ball, a capsule two. A capsule with the axis
:math:`c + t u` and the radius :math:`\rho` holds the balls i, of radius :math:`r_i` at :math:`t_i` along the axis and
:math:`d_i` off it, where :math:`\rho \ge d_i + r_i` and, with :math:`s_i = \sqrt{(\rho - r_i)^2 - d_i^2}`, its segment
goes from :math:`\min_i (t_i + s_i)` to :math:`\max_i (t_i - s_i)`. Of all these the one of least volume is sought, by
the method of J. A. Nelder and R. Mead, "A simplex method for function minimization", The Computer Journal 7(4), 1965,
from each of the principal axes. The capsule found contains the shapes exactly; it is a local minimum of the volume.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from ..base.checks import Array
from ..base.rotations import perpendicular

#: Number of points on a circle, and from pole to pole, that approximate round shapes.
AROUND, ALONG = 64, 33


class Enclosing(NamedTuple):
    """A capsule in the coordinates of a joint: the ends of its segment, shape (3,) [m], and its radius [m]."""

    start: Array
    end: Array
    radius: float


def capsule_geometry(model: pin.Model, geometry: pin.GeometryModel, bodies: Iterable[str]) -> pin.GeometryModel:
    """The shapes of a robot, with one capsule per listed body instead of its own shapes.

    Two bodies are a pair if any shape of one and any shape of the other were a pair.
    """
    asked, own = set(bodies), pin.GeometryModel()
    number, capsule_of = dict[int, int](), dict[str, int]()
    for i, shape in enumerate(geometry.geometryObjects):
        body = str(model.frames[shape.parentFrame].name)
        if body not in asked:
            number[i] = own.addGeometryObject(pin.GeometryObject(shape))
            continue
        if body not in capsule_of:
            start, end, radius = enclosing_capsule(geometry, shape.parentFrame)
            capsule = coal.Capsule(radius, float(np.linalg.norm(end - start)))
            placement = pin.SE3(_along(end - start), 0.5 * (start + end))
            placed = pin.GeometryObject(body, shape.parentJoint, shape.parentFrame, placement, capsule)
            capsule_of[body] = own.addGeometryObject(placed)
        number[i] = capsule_of[body]
    pairs = {tuple(sorted((number[pair.first], number[pair.second]))) for pair in geometry.collisionPairs}
    for first, second in sorted(pairs):
        if first != second:
            own.addCollisionPair(pin.CollisionPair(first, second))
    return own


def enclosing_capsule(geometry: pin.GeometryModel, frame: int) -> Enclosing:
    """The smallest capsule about all shapes that a frame carries, in the coordinates of its joint.

    Raises
    ------
    InvalidInput
        If a shape is unbounded, such as a plane.
    """
    centres, radii = list[Array](), list[Array]()
    for shape in geometry.geometryObjects:
        if shape.parentFrame == frame:
            points, radius = _balls(shape.geometry, shape.name)
            placement = shape.placement
            centres.append(points @ np.array(placement.rotation).T + np.array(placement.translation))
            radii.append(radius)
    return smallest_capsule(np.concatenate(centres), np.concatenate(radii))


def smallest_capsule(centres: Array, radii: Array) -> Enclosing:
    """The smallest capsule about balls: centres of shape (k, 3), and radii, shape (k,) [m]."""
    from scipy.optimize import minimize

    middle = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    points = centres - middle
    size = float(np.max(np.linalg.norm(points, axis=1) + radii))
    points, scaled = points / size, radii / size
    axes = np.linalg.eigh(points.T @ points)[1].T

    def about(u: Array, x: Array) -> Enclosing:
        """The capsule with axis u turned by x[:2] and shifted by x[2:4], its radius x[4]^2 above the least."""
        first, second = perpendicular(u)
        axis = u + x[0] * first + x[1] * second
        axis /= np.linalg.norm(axis)
        centre = x[2] * first + x[3] * second
        along = (points - centre) @ axis
        off = np.linalg.norm(points - centre - along[:, None] * axis, axis=1)
        radius = float(np.max(off + scaled)) + x[4] ** 2
        reach = np.sqrt(np.maximum((radius - scaled) ** 2 - off**2, 0.0))
        low, high = float(np.min(along + reach)), float(np.max(along - reach))
        if low > high:  # one ball contains all
            low = high = 0.5 * (low + high)
        return Enclosing(centre + low * axis, centre + high * axis, radius)

    def volume(x: Array, u: Array) -> float:
        start, end, radius = about(u, x)
        return float(radius**2 * (np.linalg.norm(end - start) + 4.0 / 3.0 * radius))

    def descent(u: Array, x: Array, step: float, iterations: int) -> tuple[float, Array, Array]:
        options = {"initial_simplex": np.vstack([x, x + step * np.eye(5)]), "maxiter": iterations}
        found = minimize(volume, x, (u,), "Nelder-Mead", options={**options, "xatol": 1e-4, "fatol": 1e-7})
        return float(found.fun), u, found.x

    _, u, x = min((descent(u, np.zeros(5), 0.2, 120) for u in axes), key=lambda found: found[0])
    _, u, x = descent(u, x, 0.05, 300)  # restart, as a simplex may collapse; the best point is kept
    start, end, radius = about(u, x)
    return Enclosing(middle + size * start, middle + size * end, size * radius)


def _balls(shape: coal.CollisionGeometry, name: str) -> tuple[Array, Array]:
    """Balls whose hull holds a shape: their centres, shape (k, 3), and radii [m]."""
    radius = 0.0
    if isinstance(shape, coal.Sphere):
        points, radius = np.zeros((1, 3)), float(shape.radius)
    elif isinstance(shape, coal.Capsule):
        points, radius = np.outer([-shape.halfLength, shape.halfLength], [0.0, 0.0, 1.0]), float(shape.radius)
    elif isinstance(shape, coal.Box):
        points = _corners() * np.array(shape.halfSide)
    elif isinstance(shape, coal.Cylinder):
        ends = [[0.0, 0.0, -shape.halfLength], [0.0, 0.0, shape.halfLength]]
        points = np.concatenate([_circle() * shape.radius + end for end in ends])
    elif isinstance(shape, coal.Cone):
        base = _circle() * shape.radius - [0.0, 0.0, shape.halfLength]
        points = np.vstack([base, [0.0, 0.0, shape.halfLength]])
    elif isinstance(shape, coal.Ellipsoid):
        points = _sphere() * np.array(shape.radii)
    elif isinstance(shape, coal.ConvexBase):
        points = np.array(shape.points(), dtype=np.float64).reshape(-1, 3)
    else:
        raise InvalidInput(f"shape {name!r} is a {type(shape).__name__}; no capsule holds it")
    return points, np.full(len(points), radius + float(shape.getSweptSphereRadius()))


@cache
def _corners() -> Array:
    return np.stack(np.meshgrid(*([-1.0, 1.0],) * 3), axis=-1).reshape(-1, 3)


@cache
def _circle() -> Array:
    """The corners of a polygon about the unit circle."""
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    return np.asarray(np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1) / np.cos(np.pi / AROUND))


@cache
def _sphere() -> Array:
    """Points whose hull holds the unit sphere.

    Every direction is within some angle of a point; the points are scaled by the inverse of its cosine.
    """
    height, angle = np.meshgrid(np.linspace(0.0, np.pi, ALONG), 2.0 * np.pi * np.arange(AROUND) / AROUND)
    points = np.stack([np.sin(height) * np.cos(angle), np.sin(height) * np.sin(angle), np.cos(height)], axis=-1)
    away = np.hypot(0.5 * np.pi / (ALONG - 1), np.pi / AROUND)
    return np.asarray(points.reshape(-1, 3) / np.cos(away))


def _along(direction: Array) -> Array:
    """A rotation whose third axis has the given direction, or z for a zero vector."""
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        return np.eye(3)
    axis = direction / length
    return np.stack([*perpendicular(axis), axis], axis=1)
