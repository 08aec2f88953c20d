"""A scene as a stack of this library, its targets set tick by tick."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from hqp import DampingRule
from tasks import (
    CenterOfMassTask,
    Damped,
    JointLimits,
    OrientationTask,
    Part,
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


def declare(
    scene: Scene, robot: PinocchioRobot, damping: Mapping[str, DampingRule | float] = MappingProxyType({})
) -> tuple[Stack, Targets]:
    """The stack of a scene, its levels damped by the rule for what their first goal asks, and what sets its targets."""
    targets = Targets(scene, robot)
    levels: list[Part | Stack] = [JointLimits()]
    for level in scene.levels:
        parts = [_task(goal, scene, robot, targets) for goal in level]
        tasks = sum(parts[1:], start=parts[0])
        rule = damping.get(level[0].what)
        levels.append(tasks if rule is None else Damped(tasks, rule))
    return Stack(*levels), targets


def _task(goal: Goal, scene: Scene, robot: PinocchioRobot, targets: Targets) -> Task:
    frame, gain, positions, rotations = goal.frame, scene.gain, targets.positions, targets.rotations
    if goal.what == "posture":
        return PostureTask(robot.home, gain=scene.posture_step / scene.dt)
    if goal.what == "com":
        return CenterOfMassTask(positions[COM], mask="xy", gain=gain)
    if goal.what == "pose":
        return PoseTask(positions[frame], rotations[frame], frame=frame, gain=gain)
    if goal.what == "position":
        return PositionTask(positions[frame], frame=frame, mask=goal.mask, gain=gain)
    return OrientationTask(rotations[frame], frame=frame, gain=gain)
