"""The targets of a stack as draggable gizmos: a point, a rotation or both, and the tasks that follow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..base.checks import Array
from ..base.rotations import log, perpendicular
from ..frames.axis import AxisTask
from ..frames.center_of_mass import CenterOfMassTask
from ..frames.frame_task import FrameTask
from ..frames.look_at import LookAtTask
from ..frames.placement import PlacementTask
from ..frames.position import PositionTask
from ..robots.robot import RobotState
from ..rows.inequality import Inequality
from ..rows.part import Part
from ..targets.trajectories import Setpoint
from ..targets.turns import AboutZ, RotationSetpoint, stands_still


@dataclass(eq=False)
class Target:
    """A draggable target: one point, one rotation, or both of one frame.

    Attributes
    ----------
    name : str
    relative_to : str or None
        The frame in whose coordinates the target is; None for the world.
    point : PlacementTask, LookAtTask or None
        The task that follows its position.
    turn : PlacementTask, AxisTask or None
        The task that follows its rotation.
    p : array, shape (3,)
        Its position [m]; coordinates that no task controls are those of the frame at the start.
    R : array, shape (3, 3)
        Its orientation.
    """

    name: str
    relative_to: str | None
    point: PlacementTask | LookAtTask | None
    turn: PlacementTask | AxisTask | None
    p: Array
    R: Array

    @property
    def free(self) -> tuple[bool, bool, bool]:
        """Whether dragging the target along x, y, z has an effect."""
        if isinstance(self.point, PlacementTask):
            return 0 in self.point.mask, 1 in self.point.mask, 2 in self.point.mask
        return (True, True, True)

    @property
    def draggable(self) -> bool:
        """Whether it can be dragged: it is constant or a setpoint, not a function of time."""
        goals = [] if self.point is None else [_goal(self.point)]
        if self.turn is not None:
            goals.append(self.turn.target if isinstance(self.turn, AxisTask) else self.turn.rotation)
        return all(stands_still(goal) or isinstance(goal, Setpoint | RotationSetpoint) for goal in goals)

    def move(self, p: Array | None = None, R: Array | None = None) -> None:
        """Move the target to p, R; the tasks follow from the next tick on.

        Raises
        ------
        InvalidInput
            If a task refuses it; then the target stays where it was.
        """
        if p is not None and self.point is not None:
            before = self.p
            self.p = np.where(self.free, p, before)
            try:
                _set_point(self.point, self.p)
            except Exception:
                self.p = before
                raise
        if R is not None and self.turn is not None:
            self.R = np.asarray(_set_turn(self.turn, R))

    def follow(self, t: float) -> None:
        """Update p and R from the targets of the tasks at time t [s], which another program may have moved."""
        if isinstance(self.point, PlacementTask):
            self.p = np.where(self.free, self.point.position(t)[0], self.p)
        elif self.point is not None:
            self.p = np.asarray(self.point.target(t)[0])
        if isinstance(self.turn, PlacementTask):
            self.R = np.asarray(self.turn.rotation(t)[0])
        elif self.turn is not None:
            self.R = _pointing(np.asarray(self.turn.target(t)[0]))


def targets_of(parts: Iterable[Part], state: RobotState) -> list[Target]:
    """The targets of all tasks of frames; position and rotation of the same frame become one target.

    `state` is that of the robot at the start, for coordinates that no task controls.
    """
    found: list[Target] = []
    for part in parts:
        task = part.task if isinstance(part, Inequality) else part
        if isinstance(task, PlacementTask):
            _add_placement(found, task, state)
        elif isinstance(task, LookAtTask):
            here = task.seen(state)
            found.append(Target(task.name, task.relative_to, task, None, np.array(here.position), np.eye(3)))
        elif isinstance(task, AxisTask):
            here = task.seen(state)
            found.append(Target(task.name, task.relative_to, None, task, np.array(here.position), np.eye(3)))
    for target in found:
        target.follow(0.0)
    return found


def _add_placement(found: list[Target], task: PlacementTask, state: RobotState) -> None:
    point = task if task.position is not None else None
    turn = task if task.rotation is not None else None
    for target in found:  # the other half of the same frame
        own = target.point or target.turn
        if isinstance(own, PlacementTask) and _frames(own) == _frames(task):
            if point is not None and turn is None and target.point is None:
                target.point, target.name = point, f"{target.name} + {task.name}"
                return
            if turn is not None and point is None and target.turn is None:
                target.turn, target.name = turn, f"{target.name} + {task.name}"
                return
    here = task.seen(state)
    R = np.array(here.rotation) if here.rotation.ndim == 2 else np.eye(3)
    found.append(Target(task.name, task.relative_to, point, turn, np.array(here.position), R))


def _frames(task: FrameTask) -> tuple[bool, str | None, str | None]:
    return isinstance(task, CenterOfMassTask), task.frame, task.relative_to


def _goal(task: PlacementTask | LookAtTask) -> object:
    return task.target if isinstance(task, LookAtTask) else task.position


def _set_point(task: PlacementTask | LookAtTask, p: Array) -> None:
    goal = _goal(task)
    if isinstance(task, PositionTask) and len(task.target(0.0)[0]) != 3:
        goal, p = task.target, p[list(task.mask)]
    if isinstance(goal, Setpoint):
        goal.move(p)
    elif isinstance(task, PlacementTask):
        task.position = p
    else:
        task.target = p


def _set_turn(task: PlacementTask | AxisTask, R: Array) -> Array:
    """Set the rotation, or the axis, that a task follows; returns the rotation of its target then."""
    if isinstance(task, AxisTask):
        if isinstance(task.target, Setpoint):
            task.target.move(R[:, 2])
        else:
            task.target = R[:, 2]
        return R
    goal = task.rotation
    if isinstance(goal, RotationSetpoint):
        goal.move(R)
    elif isinstance(goal, AboutZ):  # the angle is unwrapped: the nearest of all that give this rotation
        turned = float(log(R @ np.asarray(goal(0.0)[0]).T)[2])
        angle = np.asarray(goal.angle(0.0)[0]) + turned
        if isinstance(goal.angle, Setpoint):
            goal.angle.move(angle)
        else:
            task.rotation = angle
    else:
        task.rotation = R
    return np.asarray(task.rotation(0.0)[0])


def _pointing(direction: Array) -> Array:
    """A rotation matrix whose z axis points along `direction`."""
    axis = direction / np.linalg.norm(direction)
    return np.column_stack([*perpendicular(axis), axis])
