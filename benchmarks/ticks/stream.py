"""One motion, tick by tick, recorded once in closed loop, so that every library gets the same one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hqp.arrays import Array
from tasks import Controller
from tasks.robots.robot import integrate, joint_positions

from .scenes import COM, Scene
from .stack import declare

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot

#: Of a joint to its limit, for it to count as being there: of velocities [rad/s], and of positions [rad].
NEAR = 1e-9


@dataclass(frozen=True, eq=False)
class Stream:
    """What every library is given, tick by tick.

    Attributes
    ----------
    scene : Scene
    robot : PinocchioRobot
    q, v : array, shape (ticks, nq), (ticks, nv)
        Where the robot is.
    positions, rotations : dict of str to array, shape (ticks, 3), (ticks, 3, 3)
        The targets of each frame; the first has the one of the centre of mass too.
    saturated : float
        How many joints are at a limit at once, mean.
    """

    scene: Scene
    robot: PinocchioRobot
    q: Array
    v: Array
    positions: dict[str, Array]
    rotations: dict[str, Array]
    saturated: float

    @property
    def joints(self) -> int:
        """How many joints there are, a floating base not counted."""
        return self.robot.nv - self.robot.base

    @property
    def at_limit(self) -> str:
        """How many joints are at a limit, in words."""
        return f"{self.saturated:.1f} of {self.joints} joints"

    def __len__(self) -> int:
        return len(self.q)


def record(scene: Scene, ticks: int) -> Stream:
    """Run this library on the scene, and keep what it was given."""
    robot = scene.load()
    positions, rotations = targeted(scene, robot, ticks)
    stack, targets = declare(scene, robot)
    controller = Controller(robot, stack, dt=scene.dt, damping=None)
    q, v = np.zeros((ticks + 1, robot.nq)), np.zeros((ticks + 1, robot.nv))
    q[0] = robot.home
    for k in range(ticks):
        for moved, values in (targets.positions, positions), (targets.rotations, rotations):
            for name, target in moved.items():
                target.move(values[name][k])
        step = controller(q[k], v[k])
        assert step.v is not None
        v[k + 1] = step.v
        q[k + 1] = integrate(robot, q[k], scene.dt * step.v)
    return Stream(scene, robot, q[:-1], v[:-1], positions, rotations, _saturated(robot, q[1:], v[1:]))


def targeted(scene: Scene, robot: PinocchioRobot, ticks: int) -> tuple[dict[str, Array], dict[str, Array]]:
    """The positions and rotations of all targets, tick by tick."""
    state = robot.at(robot.home, np.zeros(robot.nv))
    starts = {name: (state.frame(name).position, state.frame(name).rotation) for name in scene.frames}
    if hasattr(state, "center_of_mass"):
        starts[COM] = state.center_of_mass.position, np.eye(3)
    positions, rotations = {}, {}
    for name, start in starts.items():
        places = [scene.motion(name).at(k * scene.dt, *start) for k in range(ticks)]
        positions[name], rotations[name] = (np.array(part) for part in zip(*places, strict=True))
    return positions, rotations


def _saturated(robot: PinocchioRobot, q: Array, v: Array) -> float:
    """How many joints are at a limit of position or velocity, mean of all ticks."""
    at_limit = np.zeros(v.shape, dtype=bool)
    if robot.velocity_limit is not None:
        at_limit |= np.abs(v) >= robot.velocity_limit - NEAR
    if robot.position_limit is not None:
        joints = np.array([joint_positions(robot.at(row, v[0])) for row in q])
        low, high = robot.position_limit
        at_limit |= (joints <= low + NEAR) | (joints >= high - NEAR)
    return float(at_limit.sum(axis=1).mean())
