"""Limit: the bodies of a robot keep a distance from convex solids in the world; see :mod:`.shapes_limit`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from hqp import InvalidInput
from hqp.checks import listed, of_type
from hqp.errors import brief

from ..base.live import structure
from ..robots.robot import Robot
from .body_shapes import Shapes, bodies_of, known, shapes_of
from .shapes_limit import ShapesLimit
from .solids import Solid


class CollisionLimit(ShapesLimit):
    """Keep the shapes of a robot at a distance from solids: boxes, and convex polyhedra and meshes.

    ``CollisionLimit([Box([0.8, 1.2, 0.05], at=table)], margin=0.02, gain=10.0)``; the shapes of the robot are those of
    its file, or of ``robot.with_geometry(...)``. Bodies fixed in the world are ignored. Spheres
    and capsules that move are for :class:`DistanceLimit`, whose margin is proved within the tick.

    Parameters
    ----------
    obstacles : sequence of Box and Polyhedron
        Those of an MJCF scene are found by :func:`scene_solids`.
    bodies : names, optional
        Frames of the bodies that are kept away (default: all that move).
    margin : float
        The least distance [m]; not negative.
    gain : float
        K [1/s]: the rate at which the margin is neared; at most 1/dt.
    rows : int
        Number of rows, one for each of the nearest pairs.
    name : str

    Raises
    ------
    InvalidInput
        If there is no obstacle, one is not a solid, the margin is negative, the gain is not positive or exceeds 1/dt,
        the robot has no shapes, or a name is not a moving body with a shape.

    Examples
    --------
    >>> from tasks import Box, CollisionLimit, Controller, JointLimits, PositionTask, load_robot
    >>> panda = load_robot("panda", lock=["panda_finger_joint1"])
    >>> stack = JointLimits() >> CollisionLimit([Box([0.4, 0.4, 0.1])], margin=0.02, gain=5.0)
    >>> Controller(panda, stack >> PositionTask([0.3, 0.0, 0.2], gain=2.0), dt=0.01)(panda.home).solution.certify().ok
    True
    """

    obstacles: tuple[Solid, ...] = structure()
    bodies: tuple[str, ...] | None = structure()

    def __init__(
        self,
        obstacles: Sequence[Solid],
        *,
        bodies: Iterable[str] | None = None,
        margin: float,
        gain: float,
        rows: int = 8,
        name: str = "collision",
    ) -> None:
        self.name = of_type(name, str, "name of a CollisionLimit")
        self.obstacles = tuple(listed(obstacles, f"{self.full_name()}: obstacles", "Box and Polyhedron"))
        wrong = [value for value in self.obstacles if not isinstance(value, Solid)]
        if wrong or not self.obstacles:
            got = brief(wrong[0]) if wrong else "none"
            raise InvalidInput(f"{self.full_name()}: got {got}; it takes at least one Box or Polyhedron in a list")
        self.bodies = None
        if bodies is not None:
            names = listed(bodies, f"{self.full_name()}: bodies", "names")
            self.bodies = tuple(of_type(body, str, f"{self.full_name()}: body") for body in names)
        super().__init__(margin=margin, gain=gain, rows=rows, name=name)

    def numbers(self) -> tuple[Any, ...]:
        return tuple(value for solid in self.obstacles for value in solid.numbers())

    def found(self, robot: Robot) -> Shapes:
        import pinocchio as pin

        geometry = pin.GeometryModel(shapes_of(robot, self.full_name()))
        bodies = bodies_of(robot, geometry)
        moving = [k for k, shape in enumerate(geometry.geometryObjects) if shape.parentJoint > 0]
        if self.bodies is not None:
            known(self.bodies, [bodies[k] for k in moving], self.full_name())
            moving = [k for k in moving if bodies[k] in self.bodies]
        if not moving:
            raise InvalidInput(f"{self.full_name()}: no body of {robot!r} that moves has a shape")
        first = geometry.ngeoms
        for k, solid in enumerate(self.obstacles):
            name = f"{solid.name} {k + 1}" if len(self.obstacles) > 1 else solid.name
            geometry.addGeometryObject(pin.GeometryObject(name, 0, 0, pin.SE3(np.array(solid.at)), solid.shape()))
        return Shapes(robot, geometry, [(i, first + k) for i in moving for k in range(len(self.obstacles))])
