"""A default stack for any robot model; `hqp live` starts with it.

Arm: limits, position of the tip, orientation of the tip, posture. Robot on feet: limits, fixed feet, centre of mass,
hands, posture. Feet and hands are found among the ends of the joint chains: feet are the lowest ends at home of a robot
with a floating base; hands are other ends with enough joints.
"""

from __future__ import annotations

from functools import reduce
from operator import add
from typing import TYPE_CHECKING

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from ..control.controller import Controller
from ..frames.center_of_mass import CenterOfMassTask
from ..frames.orientation import OrientationTask
from ..frames.pose import PoseTask
from ..frames.position import PositionTask
from ..joints.posture import PostureTask
from ..limits.joint_limits import JointLimits
from ..robots.robot import RobotState
from ..rows.part import Part, Stack

if TYPE_CHECKING:
    from ..robots.pinocchio import PinocchioRobot

#: Gains [1/s]: of the feet, of targets that are dragged, of the posture.
HOLD, REACH, REST = 10.0, 3.0, 1.0
#: Acceleration limit of joints that have none [rad/s^2], [m/s^2].
BRAKES = 15.0
#: How far above the lowest end a foot may be, relative to the height of the robot; and the fewest joints of a hand.
LOW, JOINTS = 0.15, 4
#: Rows of a foot whose pose is held; with fewer joints, its position is held.
WHOLE = 6


def ready_controller(robot: PinocchioRobot, dt: float) -> Controller[Array, None, None]:
    """A controller with the default stack, at velocity order.

    A robot without acceleration limits is given `BRAKES` for its joints: without such limits, a strict stack with
    a target out of reach makes a stretched arm jump from one speed limit to the other.

    Raises
    ------
    InvalidInput
        As :func:`ready_stack`; also if dt is not positive.
    """
    if robot.acceleration_limit is None:
        brakes = np.full(robot.nv, BRAKES)
        brakes[: robot.base] = np.inf
        robot.acceleration_limit = brakes
    return Controller(robot, ready_stack(robot), dt=dt)


def ready_stack(robot: PinocchioRobot) -> Stack:
    """The default stack of a robot, as the module describes it.

    Raises
    ------
    InvalidInput
        If the robot has no chain of joints with an end that a task can move.
    """
    state = robot.at(robot.home, np.zeros(robot.nv))
    feet, hands = limbs(robot)
    if not feet and not hands:
        raise InvalidInput(f"{robot!r} has no chain of joints with an end to be moved; give live() a controller")
    levels: list[list[Part]] = [[JointLimits()]]
    if feet:
        levels.append([_foot(robot, state, name) for name in feet])
        mass = state.center_of_mass.position
        levels.append([CenterOfMassTask(mass[:2] if hands else mass, mask="xy" if hands else None, gain=REACH)])
        if not hands:
            levels.append([OrientationTask(np.eye(3), frame=_trunk(robot), gain=REACH, name="trunk")])
    frames = [(name, state.frame(name)) for name in hands]
    single = len(hands) == 1
    levels.append(
        [
            PositionTask(f.position, frame=n, gain=REACH, name="position" if single else _called(n, "hand"))
            for n, f in frames
        ]
    )
    if not feet:
        levels.append(
            [
                OrientationTask(
                    f.rotation, frame=n, gain=REACH, name="orientation" if single else f"{_called(n, 'hand')} turn"
                )
                for n, f in frames
            ]
        )
    levels.append([PostureTask(robot.home, gain=REST)])
    return Stack(*(reduce(add, level[1:], level[0]) for level in levels if level))


def limbs(robot: PinocchioRobot) -> tuple[list[str], list[str]]:
    """The frames of the feet, and of the hands, as the module describes them; of a robot with a tip, only the tip."""
    if not robot.base and robot.tip is not None:
        return [], [robot.tip]
    ends = _ends(robot)
    state = robot.at(robot.home, np.zeros(robot.nv))
    lengths = {joint: _length(robot, joint) for joint in ends}
    heights = {joint: float(state.frame(_frame(robot, joint)).position[2]) for joint in ends}
    feet: list[int] = []
    if robot.base == 6 and ends:
        low, high = min(heights.values()), max([*heights.values(), float(robot.home[2])])
        feet = [j for j in ends if heights[j] <= low + LOW * (high - low) and lengths[j] >= 3]
    hands = [joint for joint in ends if joint not in feet and lengths[joint] >= JOINTS]
    if not feet and not hands and ends:
        hands = [max(ends, key=lambda joint: lengths[joint])]
    return [_frame(robot, joint) for joint in feet], [_frame(robot, joint) for joint in hands]


def _ends(robot: PinocchioRobot) -> list[int]:
    """Joints that carry no other joint; several on the same joint, as fingers on a hand, are replaced by that joint."""
    model = robot.model
    parents = [int(parent) for parent in model.parents]
    ends = [joint for joint in range(1, model.njoints) if joint not in parents[1:]]
    first = 2 if robot.base else 1
    grouped: list[int] = []
    for joint in ends:
        together = [other for other in ends if parents[other] == parents[joint]]
        own = parents[joint] if len(together) > 1 and parents[joint] >= first else joint
        if own not in grouped:
            grouped.append(own)
    return grouped


def _length(robot: PinocchioRobot, joint: int) -> int:
    """The number of joints from the last one that carries several others, such as a waist, to this one."""
    parents = [int(parent) for parent in robot.model.parents]
    count, first = 1, 2 if robot.base else 1
    while (joint := parents[joint]) >= first and parents.count(joint) == 1:
        count += 1
    return count


def _frame(robot: PinocchioRobot, joint: int) -> str:
    """The link that a joint carries."""
    import pinocchio as pin

    for frame in robot.model.frames:
        if frame.parentJoint == joint and frame.type == pin.FrameType.BODY and robot.has_frame(frame.name):
            return str(frame.name)
    return f"joint:{robot.model.names[joint]}"


def _foot(robot: PinocchioRobot, state: RobotState, name: str) -> Part:
    here = state.frame(name)
    joint = robot.model.frames[robot.frame_index(name)].parentJoint
    if len(robot.model.supports[joint]) - 2 >= WHOLE:
        return PoseTask(here.position, here.rotation, frame=name, gain=HOLD, name=_called(name, "foot"))
    return PositionTask(here.position, frame=name, gain=HOLD, name=_called(name, "foot"))


def _trunk(robot: PinocchioRobot) -> str:
    return _frame(robot, 1)


def _called(link: str, limb: str) -> str:
    """The name of a limb: ``"left foot"`` if the name of its link tells the side, else the name of the link."""
    words = link.lower().split("_")
    sides = [side for side in ("left", "right") if side in words or side[0] in words]
    return f"{sides[0]} {limb}" if len(sides) == 1 else link
