"""Queries of a robot, each with the default for a robot that lacks the ability.

Only this module asks whether a robot or a state has an ability. Each question takes microseconds; for use at every
tick, get a function once, as from :func:`integration` and :func:`joint_reader`.
"""

from __future__ import annotations

from collections.abc import Callable
from operator import add, attrgetter, sub
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.guard import Guard

from ..base.checks import Array
from . import abilities as able
from .abilities import Robot
from .frame import Frame
from .state import RobotState

#: Quantities of which a robot may have limits.
Quantity = Literal["position", "velocity", "acceleration", "torque"]
#: All optional abilities of robots and of states.
ABILITIES = (
    able.Neutral,
    able.Manifold,
    able.Homed,
    able.Floating,
    able.Named,
    able.WithFrames,
    able.WithAliases,
    able.Tipped,
    able.PositionLimited,
    able.VelocityLimited,
    able.AccelerationLimited,
    able.TorqueLimited,
    able.Inertial,
    able.MotionEquation,
    able.InverseDynamics,
    able.Manipulable,
    able.Drawn,
    able.SharedWorkspace,
)
STATE_ABILITIES = (able.WithJoints, able.Owned, able.Posed, able.Massive)


def abilities(robot: Robot) -> frozenset[type]:
    """The protocols of :mod:`tasks.robots.abilities` of which a robot has all attributes."""
    return frozenset(kind for kind in ABILITIES if able.has(robot, kind))


def state_abilities(state: RobotState) -> frozenset[type]:
    """The protocols of which a state has all attributes."""
    return frozenset(kind for kind in STATE_ABILITIES if able.has(state, kind))


# Configurations.


def neutral(robot: Robot) -> Array:
    """The configuration at which tasks are tried, shape (nq,)."""
    return np.asarray(robot.neutral) if able.has(robot, able.Neutral) else np.zeros(robot.nq)


def home(robot: Robot) -> Array:
    """A configuration to start from, shape (nq,)."""
    return np.asarray(robot.home) if able.has(robot, able.Homed) else neutral(robot)


def base(robot: Robot) -> int:
    """How many of the first velocities belong to a free base: 6, 3 in the plane, or 0."""
    return int(robot.base) if able.has(robot, able.Floating) else 0


def integration(robot: Robot) -> Callable[[Array, Array], Array]:
    """The function that gives the configuration, shape (nq,), after a step of the joints; for use at every tick.

    Raises
    ------
    InvalidInput
        If nq and nv differ, and the robot does not say how to integrate.
    """
    if able.has(robot, able.Manifold):
        return robot.integrate
    _check_flat(robot)
    return add


def integrate(robot: Robot, q: Array, step: Array) -> Array:
    """The configuration after a step of the joints, shape (nq,)."""
    return np.asarray(integration(robot)(q, step))


def subtraction(robot: Robot) -> Callable[[Array, Array], Array]:
    """The function that gives the step, shape (nv,), from one configuration to another; see `integration`."""
    if able.has(robot, able.Manifold):
        return robot.difference
    _check_flat(robot)
    return lambda start, end: sub(end, start)


def difference(robot: Robot, start: Array, end: Array) -> Array:
    """The step of the joints that leads from one configuration to another, shape (nv,)."""
    return np.asarray(subtraction(robot)(start, end))


def is_flat(robot: Robot) -> bool:
    """Whether the step from one configuration to another is the plain difference of their numbers."""
    return robot.nq == robot.nv and not able.has(robot, able.Manifold)


def _check_flat(robot: Robot) -> None:
    if robot.nq != robot.nv:
        raise InvalidInput(
            f"{robot!r} has {robot.nq} positions and {robot.nv} velocities: to say where a step leads it needs neutral,"
            " integrate(q, step) and difference(start, end)"
        )


def at_rest(robot: Robot) -> RobotState:
    """The state at which tasks are tried: neutral, and at rest."""
    return robot.at(neutral(robot), np.zeros(robot.nv))


def positioned(robot: Robot) -> NDArray[np.bool_]:
    """Which velocities have one position each, shape (nv,): not those of circles or of a free base."""
    if robot.nq == robot.nv or able.Manifold not in abilities(robot):
        return np.ones(robot.nv, dtype=np.bool_)
    here = at_rest(robot)
    there = robot.at(integrate(robot, here.q, np.full(robot.nv, 0.1)), here.v)
    return np.asarray(joint_positions(there) != joint_positions(here), dtype=np.bool_)


# Names.


def joint_names(robot: Robot) -> tuple[str, ...]:
    """One name per joint velocity."""
    return tuple(robot.joint_names) if able.has(robot, able.Named) else numbered(robot.nv)


def numbered(nv: int) -> tuple[str, ...]:
    """Default names of nv joints."""
    return tuple(f"joint {i}" for i in range(nv))


def joint_units(robot: Robot) -> tuple[str, ...]:
    """Unit of each joint position."""
    return tuple(robot.joint_units) if able.has(robot, able.Named) else ("rad",) * robot.nv


def frame_names(robot: Robot) -> tuple[str, ...]:
    """The names of frames that the robot lists; none where it lists none."""
    return tuple(robot.frame_names) if able.has(robot, able.WithFrames) else ()


def has_frame(robot: Robot, name: str) -> bool:
    """Whether this names a frame, as far as the robot tells."""
    if able.has(robot, able.WithAliases):
        return bool(robot.has_frame(name))
    names = frame_names(robot)
    return name in names or not names


def tells_tip(robot: Robot) -> bool:
    """Whether the robot says which frame its tip is, if any."""
    return able.has(robot, able.Tipped)


def tip(robot: Robot) -> str | None:
    """The frame used by tasks that name no frame, if the robot has one."""
    return robot.tip if able.has(robot, able.Tipped) else None


# Limits and dynamics.


def limit_of(robot: Robot, quantity: Quantity) -> Array | None:
    """The robot's own limit, shape (2, nv) of positions, else (nv,); None if it has none."""
    own = None
    if quantity == "position":
        own = robot.position_limit if able.has(robot, able.PositionLimited) else None
    elif quantity == "velocity":
        own = robot.velocity_limit if able.has(robot, able.VelocityLimited) else None
    elif quantity == "acceleration":
        own = robot.acceleration_limit if able.has(robot, able.AccelerationLimited) else None
    elif able.has(robot, able.TorqueLimited):
        own = robot.torque_limit
    return None if own is None else np.asarray(own)


def limits_reader(robot: Robot) -> Callable[[], tuple[ArrayLike | None, ...]]:
    """The function that reads all limits of a robot, in the form in which it gives them."""
    kinds = {
        "position_limit": able.PositionLimited,
        "velocity_limit": able.VelocityLimited,
        "acceleration_limit": able.AccelerationLimited,
        "torque_limit": able.TorqueLimited,
    }
    readers = [attrgetter(name) for name, kind in kinds.items() if able.has(robot, kind)]
    return lambda: tuple(read(robot) for read in readers)


def mass_matrix(robot: Robot) -> Callable[[Array], Array] | None:
    """M of q, or None if the robot does not know it."""
    return robot.mass_matrix if able.has(robot, able.Inertial) else None


def bias(robot: Robot) -> Callable[[Array, Array], Array] | None:
    """b of q and v, or None if the robot does not know its equation of motion."""
    return robot.bias if able.has(robot, able.MotionEquation) else None


def inverse_dynamics(robot: Robot) -> Callable[[Array, Array, Array], Array] | None:
    """Joint torques of q, v and a, or None if the robot does not know them."""
    return robot.inverse_dynamics if able.has(robot, able.InverseDynamics) else None


def manipulability(robot: Robot) -> Callable[[Array], Array] | None:
    """How well the tip can be moved at q, or None if the robot does not tell it."""
    return robot.manipulability if able.has(robot, able.Manipulable) else None


def points(robot: Robot) -> Callable[[Array], Array] | None:
    """Base, joints and tip at q, or None if the robot does not tell them."""
    return robot.points if able.has(robot, able.Drawn) else None


def workspace(robot: Robot) -> able.SharedWorkspace | None:
    """The robot as one whose states share a workspace; None if each has its own."""
    if able.has(robot, able.SharedWorkspace) and isinstance(robot.guard, Guard):
        return robot
    return None


# States.


def joint_positions(state: RobotState) -> Array:
    """The position of each joint that has one, 0 elsewhere, shape (nv,)."""
    return np.asarray(state.joints) if able.has(state, able.WithJoints) else state.q


def joint_reader(example: RobotState) -> Callable[[RobotState], Array]:
    """The function that gives the joint positions of states like this one; for use at every tick."""
    return attrgetter("joints" if able.has(example, able.WithJoints) else "q")


def robot_of(state: RobotState) -> Robot | None:
    """The robot that a state belongs to; None if the state does not name it."""
    return state.robot if able.has(state, able.Owned) else None


def towards(state: RobotState, q: Array) -> Array:
    """The step of the joints that leads from here to a configuration, shape (nv,)."""
    robot = robot_of(state)
    return q - state.q if robot is None else difference(robot, state.q, q)


def pose_reader(example: RobotState) -> Callable[[RobotState], Array]:
    """The function that gives the poses of states like this one for records; empty if there are none."""
    return attrgetter("pose") if able.has(example, able.Posed) else lambda state: np.zeros(0)


def center_of_mass(state: RobotState) -> Frame | None:
    """The centre of mass, or None if the state does not tell it."""
    return state.center_of_mass if able.has(state, able.Massive) else None
