"""A scene as a stack of this library, its targets set tick by tick."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tasks import (
    CenterOfMassTask,
    JointLimits,
    OrientationTask,
    PoseTask,
    PositionTask,
    PostureTask,
    RotationSetpoint,
    Setpoint,
    Stack,
    Task,
)

from .scenes import COM, Goal, Scene

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot


class Targets:
    """The targets of one stack, which somebody sets, as an operator does: what they will be next is not known.

    Attributes
    ----------
    positions : dict of str to Setpoint
        Of each frame, and of the centre of mass, where it has a task.
    rotations : dict of str to RotationSetpoint
        Of each frame; of a planar arm a Setpoint, of the angle.
    """

    def __init__(self, scene: Scene, robot: PinocchioRobot) -> None:
        state = robot.at(robot.home, np.zeros(robot.nv))
        self.positions = {name: Setpoint(state.frame(name).position) for name in scene.frames}
        turns = {name: state.frame(name).rotation for name in scene.frames}
        self.rotations = {name: Setpoint(R) if R.ndim == 1 else RotationSetpoint(R) for name, R in turns.items()}
        if any(goal.what == "com" for goal in scene.goals):
            self.positions[COM] = Setpoint(state.center_of_mass.position)


def declare(scene: Scene, robot: PinocchioRobot) -> tuple[Stack, Targets]:
    """The stack of a scene, and what sets its targets."""
    targets = Targets(scene, robot)
    levels = [JointLimits()]
    for level in scene.levels:
        parts = [_task(goal, scene.gain, robot, targets.positions, targets.rotations) for goal in level]
        levels.append(sum(parts[1:], start=parts[0]))
    return Stack(*levels), targets


def _task(
    goal: Goal,
    gain: float,
    robot: PinocchioRobot,
    positions: Mapping[str, Setpoint],
    rotations: Mapping[str, RotationSetpoint | Setpoint],
) -> Task:
    frame = goal.frame
    if goal.what == "posture":
        return PostureTask(robot.home, gain=gain)
    if goal.what == "com":
        return CenterOfMassTask(positions[COM], mask="xy", gain=gain)
    if goal.what == "pose":
        return PoseTask(positions[frame], rotations[frame], frame=frame, gain=gain)
    if goal.what == "position":
        return PositionTask(positions[frame], frame=frame, mask=goal.mask, gain=gain)
    return OrientationTask(rotations[frame], frame=frame, gain=gain)
