"""Checks of names, joints and abilities against a robot; errors list the nearest names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from hqp import InvalidInput
from hqp.arrays import real_array
from hqp.checks import whole_number

from ..base.checks import Array, suggestion
from .abilities import Robot
from .answers import base, bias, frame_names, has_frame, joint_names, limit_of, mass_matrix, neutral, positioned


def joint_index(names: Sequence[str], joint: str | int, what: str) -> int:
    """The index of a joint among the joint velocities, from its name or number.

    Raises
    ------
    InvalidInput
        If there is no such joint; the message lists the nearest names.
    """
    if isinstance(joint, str):
        if joint not in names:
            raise InvalidInput(f"{what} {joint!r} is no joint of the robot{suggestion(joint, names)}")
        return list(names).index(joint)
    index = whole_number(joint, what)
    if index >= len(names):
        raise InvalidInput(f"{what} = {index}; the robot has the joints 0 .. {len(names) - 1}")
    return index


def check_positioned(robot: Robot, columns: Iterable[int], what: str) -> None:
    """Refuse joints that do not have exactly one position.

    Raises
    ------
    InvalidInput
        The message names the first such joint.
    """
    single = positioned(robot)
    for column in columns:
        if not single[column]:
            raise InvalidInput(
                f"{what} {joint_names(robot)[column]!r} has no single position; it turns without end, or is a"
                " part of a ball or of a floating or planar base"
            )


def check_frame(robot: Robot, name: str, what: str) -> None:
    """Refuse a name that is not one of the robot's frames, if the robot lists them.

    Raises
    ------
    InvalidInput
        The message lists the nearest names.
    """
    if not has_frame(robot, name):
        raise InvalidInput(f"{what} {name!r} is no frame of {robot!r}{suggestion(str(name), frame_names(robot))}")


def check_fixed_base(robot: Robot, what: str) -> None:
    """Refuse a floating base: joint torques alone do not determine how it accelerates.

    Raises
    ------
    InvalidInput
    """
    if free := base(robot):
        kind = "planar" if free == 3 else "floating"
        raise InvalidInput(f"{what}: {robot!r} has a {kind} base, which no joint torque drives; it must be fixed")


def check_motors(robot: Robot, what: str) -> None:
    """Refuse joints without a motor besides the base, where nothing limits torques: they would be driven.

    Raises
    ------
    InvalidInput
    """
    limits, first = limit_of(robot, "torque"), base(robot)
    if limits is None:
        return
    names = [name for name, limit in zip(joint_names(robot)[first:], limits[first:], strict=True) if limit == 0.0]
    if names:
        raise InvalidInput(
            f"{what}: no motor drives {', '.join(names)} of {robot!r}, as their torque limit of 0 says; add"
            " JointTorqueLimit() to the stack, best to its first level"
        )


def check_mass_matrix(robot: Robot, what: str) -> None:
    """Refuse a robot that does not tell its mass matrix, of shape (nv, nv) for one configuration.

    Raises
    ------
    InvalidInput
    """
    method = mass_matrix(robot)
    given = None if method is None else method(neutral(robot))
    _check_method(robot, what, "mass_matrix(q)", given, (robot.nv, robot.nv))


def check_dynamics(robot: Robot, what: str) -> None:
    """Refuse a robot that does not tell its mass matrix and its bias, of shape (nv,) for one configuration.

    Raises
    ------
    InvalidInput
    """
    check_mass_matrix(robot, what)
    method = bias(robot)
    given = None if method is None else method(neutral(robot), np.zeros(robot.nv))
    _check_method(robot, what, "bias(q, v)", given, (robot.nv,))


def _check_method(robot: Robot, what: str, method: str, given: Array | None, shape: tuple[int, ...]) -> None:
    if given is None:
        name = method.partition("(")[0]
        raise InvalidInput(f"{what}: takes a robot that has {name}, and {robot!r} has no {method}")
    found = real_array(given, f"{what}: {method} of {robot!r}").shape
    if found != shape:
        raise InvalidInput(f"{what}: {method} of {robot!r} gives shape {found}; it must be {shape}")


def check_joints(robot: Robot, q: Array, v: Array) -> None:
    """Refuse joint positions q and velocities v of another length than the robot's.

    Raises
    ------
    InvalidInput
    """
    if q.shape == (robot.nq,) and v.shape == (robot.nv,):
        return
    for what, value, size in ("q", q, robot.nq), ("v", v, robot.nv):
        if value.shape != (size,):
            raise InvalidInput(f"{what} has shape {value.shape}; the robot takes ({size},), one number a joint")
