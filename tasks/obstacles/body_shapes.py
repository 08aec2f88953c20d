"""Pairs of convex shapes on the joints of a robot, and their distances by Coal."""

from __future__ import annotations

from bisect import insort
from collections.abc import Iterable
from typing import Any

import numpy as np

from hqp import InvalidInput
from hqp.errors import brief

from ..base.checks import Array, suggestion
from ..robots.frame import WORLD
from ..robots.robot import RobotState, on_pinocchio


class Shapes:
    """The shapes of one robot, and which pairs of them are watched.

    Parameters
    ----------
    robot : PinocchioRobot
    geometry : pinocchio.GeometryModel
        The shapes; its pairs are replaced.
    pairs : iterable of (int, int)
        Which of them are watched.

    Attributes
    ----------
    geometry : pinocchio.GeometryModel
    pairs : list of (str, str)
        The frames of the bodies of each pair.
    """

    def __init__(self, robot: Any, geometry: Any, pairs: Iterable[tuple[int, int]]) -> None:
        import pinocchio as pin

        from ..robots.geometry import cold_request, witnesses

        self._robot, self._pin, self._witnesses, self._request = robot, pin, witnesses, cold_request()
        self.geometry = pin.GeometryModel(geometry)
        self.geometry.removeAllCollisionPairs()
        for i, j in pairs:
            self.geometry.addCollisionPair(pin.CollisionPair(i, j))
        shapes = self.geometry.geometryObjects
        for shape in shapes:
            shape.geometry.computeLocalAABB()
        self._centres = [np.array(shape.geometry.aabb_center) for shape in shapes]
        self._radii = np.array([shape.geometry.aabb_radius for shape in shapes])
        for k in np.flatnonzero(np.isinf(self._radii)):  # a half space; Coal puts its centre at infinity
            self._centres[k][:] = 0.0
        self._watch()

    def _watch(self) -> None:
        """Note the pairs as they are now."""
        pairs = list(self.geometry.collisionPairs)
        bodies = bodies_of(self._robot, self.geometry)
        self._data = self._pin.GeometryData(self.geometry)
        for k in range(len(pairs)):  # Pinocchio's own begin where the last call ended, and the witnesses go by it
            self._data.distanceRequests[k] = self._request
        self.pairs = [(bodies[pair.first], bodies[pair.second]) for pair in pairs]
        self._sides = np.array([(pair.first, pair.second) for pair in pairs], dtype=np.intp).reshape(-1, 2).T

    def leave_out(self, margin: float) -> None:
        """Remove the pairs with a distance of at most `margin` [m] at the robot's home."""
        home = self.distances(self._robot.at(self._robot.home))
        for k in np.flatnonzero(home <= margin)[::-1]:
            self.geometry.removeCollisionPair(self.geometry.collisionPairs[int(k)])
        self._watch()

    def __len__(self) -> int:
        return len(self.geometry.collisionPairs)

    def names(self) -> list[str]:
        """One name per pair: ``"panda_hand - panda_link0"``; fixed objects by the name of their shape."""
        shapes, bodies = self.geometry.geometryObjects, bodies_of(self._robot, self.geometry)
        titles = [shape.name if body == WORLD else body for shape, body in zip(shapes, bodies, strict=True)]
        return [f"{titles[pair.first]} - {titles[pair.second]}" for pair in self.geometry.collisionPairs]

    def distances(self, state: RobotState) -> Array:
        """The distances of all pairs [m]; negative where two shapes overlap."""
        self._place(state)
        self._pin.computeDistances(self.geometry, self._data)
        return np.array([result.min_distance for result in self._data.distanceResults])

    def closest(self, state: RobotState, count: int) -> list[int]:
        """The `count` nearest pairs.

        Bounding balls give a lower bound on each distance; pairs whose bound is too large are not measured.
        """
        self._place(state)
        centres = np.array([place.act(ball) for place, ball in zip(self._data.oMg, self._centres, strict=True)])
        first, second = self._sides
        least = np.linalg.norm(centres[first] - centres[second], axis=1) - self._radii[first] - self._radii[second]
        found: list[tuple[float, int]] = []
        for k in np.argsort(least, kind="stable").tolist():
            if len(found) == count and least[k] > found[-1][0]:
                break
            insort(found, (float(self._pin.computeDistance(self.geometry, self._data, k).min_distance), k))
            del found[count:]
        return [k for _, k in found]

    def contact(self, k: int, out: Array) -> None:
        """Write distance, normal and both witnesses of pair k, as last measured, into `out`."""
        out[0], out[4:7], out[7:], out[1:4] = self._witnesses(self._data.distanceResults[k])

    def _place(self, state: RobotState) -> None:
        """Move the shapes with the joints; computes the joint Jacobians of the state, which include joint poses."""
        data = state.ready()  # type: ignore[attr-defined]
        self._pin.updateGeometryPlacements(self._robot.model, data, self.geometry, self._data)


def shapes_of(robot: Any, what: str) -> Any:
    """The collision shapes of a robot.

    Raises
    ------
    InvalidInput
        If it is not a robot with shapes.
    """
    if not on_pinocchio(robot):
        raise InvalidInput(f"{what}: {brief(robot)} has no shapes; it needs a robot of load_robot")
    geometry = robot.geometry()
    if not len(geometry.geometryObjects):
        raise InvalidInput(f"{what}: {robot!r} has no collision shapes; give it some by robot.with_geometry")
    return geometry


def bodies_of(robot: Any, geometry: Any) -> list[str]:
    """The frame that carries each shape."""
    from ..robots import geometry as of_robots

    return of_robots.bodies_of(robot.model, geometry)


def known(names: Iterable[str], bodies: Iterable[str], what: str) -> None:
    """Refuse a name that is not a body with a shape.

    Raises
    ------
    InvalidInput
        The message lists the nearest names.
    """
    bodies = dict.fromkeys(bodies)
    for name in names:
        if name not in bodies:
            raise InvalidInput(f"{what}: {name!r} is no body with a shape{suggestion(str(name), bodies)}")
