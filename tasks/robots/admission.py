"""Checks a user's own robot class once: every attribute with a meaning here must have the right type and size.

If such an attribute has another meaning in the user's class, such as a `home` that is a street, the error names it; the
user must rename it.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from numbers import Integral
from typing import Any, get_args
from weakref import WeakSet

import numpy as np

from hqp import InvalidInput
from hqp.checks import whole_number
from hqp.errors import brief

from ..base.checks import finite, numbers, position_range
from . import abilities as able
from .abilities import Robot
from .answers import (
    Quantity,
    abilities,
    at_rest,
    joint_names,
    joint_positions,
    limit_of,
    pose_reader,
    robot_of,
    state_abilities,
)
from .state import RobotState

#: The sizes of bases: mounted, planar, floating.
BASES = (0, 3, 6)
UNITS = ("rad", "m")
#: Robots that were checked.
_ADMITTED: WeakSet[Robot] = WeakSet()
#: Robots of which a state was checked.
_STATES_ADMITTED: WeakSet[Robot] = WeakSet()
#: Attributes that must come together: an ability with only some of them would be ignored silently.
TOGETHER: dict[type, tuple[tuple[str, ...], tuple[str, ...]]] = {
    able.Manifold: (("integrate", "difference"), ("neutral", "integrate", "difference")),
    able.Named: (("joint_names", "joint_units"), ("joint_names", "joint_units")),
}
#: The methods of each ability.
METHODS: dict[type, tuple[str, ...]] = {
    able.Manifold: ("integrate(q, step)", "difference(start, end)"),
    able.WithAliases: ("has_frame(name)",),
    able.InverseDynamics: ("inverse_dynamics(q, v, a)",),
    able.Manipulable: ("manipulability(q)",),
}


def as_robot(value: Robot) -> Robot:
    """`value`, which must have what every robot has, and valid attributes in each of its abilities.

    Raises
    ------
    InvalidInput
        If it has no nq, nv or at(q, v), a size is no positive integer, or an attribute of one of the protocols in
        :mod:`tasks.robots.abilities` holds something else; names the attribute, and what is allowed.
    """
    try:
        if value in _ADMITTED:
            return value
    except TypeError:  # its class is not hashable or takes no weak references
        pass
    for kind in able.Sized, Robot:
        if isinstance(value, type) or not able.has(value, kind):
            raise InvalidInput(f"robot = {brief(value)} is a {type(value).__name__}; a robot has nq, nv and at(q, v)")
        whole_number(value.nq, "nq of the robot", least=1)
        whole_number(value.nv, "nv of the robot", least=1)
    _check_method(value, "at(q, v)")
    own = abilities(value)
    _check_together(value, own)
    for ability, methods in METHODS.items():
        for method in methods if ability in own else ():
            _check_method(value, method)
    for ability, check in CHECKS.items():
        if ability in own:
            check(value)
    for quantity in get_args(Quantity):
        _check_limit(value, quantity)
    with suppress(TypeError):
        _ADMITTED.add(value)
    return value


def check_states(robot: Robot) -> None:
    """Refuse a robot whose states are no states, or have invalid attributes; checks its state at rest, once.

    Raises
    ------
    InvalidInput
    """
    with suppress(TypeError):  # as in `as_robot`
        if robot in _STATES_ADMITTED:
            return
    _look_at_states(robot)
    with suppress(TypeError):
        _STATES_ADMITTED.add(robot)


def _look_at_states(robot: Robot) -> None:
    state, what = at_rest(robot), "the state that at(q, v) of the robot gives"
    if not able.has(state, RobotState) or not callable(state.frame):
        raise InvalidInput(f"{what}, {brief(state)}, is a {type(state).__name__}; a state has q, v and frame(name)")
    own = state_abilities(state)
    _check_shape(state.q, (robot.nq,), f"q of {what}")
    _check_shape(state.v, (robot.nv,), f"v of {what}")
    if able.WithJoints in own:
        _check_shape(joint_positions(state), (robot.nv,), f"joints of {what}")
    pose = numbers(pose_reader(state)(state), f"pose of {what}")
    if pose.ndim != 1:
        raise InvalidInput(f"pose of {what} has shape {pose.shape}; it must be (k,)")
    owner = robot_of(state)
    if able.Owned in own and not (able.has(owner, Robot) and (owner.nq, owner.nv) == (robot.nq, robot.nv)):
        raise InvalidInput(f"robot of {what} = {brief(owner)}; it must be the robot whose state it is")
    if able.Manifold in abilities(robot):
        if able.Owned not in own:
            raise InvalidInput(f"{what} has no robot; where configurations lie on a manifold a state tells whose it is")
        if robot.nq != robot.nv and able.WithJoints not in own:
            raise InvalidInput(
                f"{what} has no joints; where nq = {robot.nq} and nv = {robot.nv} differ it tells the position of each"
                f" joint that has one, and 0 elsewhere, shape ({robot.nv},)"
            )


def _check_together(robot: Robot, own: frozenset[type]) -> None:
    held = {name for name in dir(robot) if any(name in names for _, names in TOGETHER.values())}
    held -= {name for name in held if getattr(robot, name) is None}  # None says that the robot does not have it
    for kind, (any_of, all_of) in TOGETHER.items():
        has, lacks = [name for name in any_of if name in held], [name for name in all_of if name not in held]
        if kind not in own and has:
            raise InvalidInput(
                f"the robot {brief(robot)} has {' and '.join(has)} but no {' and '.join(lacks)}; it must have"
                f" {', '.join(all_of)}, or none of them"
            )


def _check_method(robot: Robot, signature: str) -> None:
    name = signature.partition("(")[0]
    value = getattr(robot, name)
    if not callable(value):
        raise InvalidInput(f"{name} of the robot = {brief(value)} is a {type(value).__name__}; it must be {signature}")


def _check_shape(value: Any, shape: tuple[int, ...], what: str) -> None:
    given = numbers(value, what)
    if given.shape != shape:
        raise InvalidInput(f"{what} has shape {given.shape}; it must be {shape}")


def _check_configuration(name: str) -> Callable[[Any], None]:
    def check(robot: Any) -> None:
        what = f"{name} of the robot"
        _check_shape(finite(getattr(robot, name), what), (robot.nq,), f"{what}, a configuration,")

    return check


def _check_manifold(robot: Any) -> None:
    for what, method, arguments, size in (
        ("integrate(q, step)", robot.integrate, (robot.neutral, np.zeros(robot.nv)), robot.nq),
        ("difference(start, end)", robot.difference, (robot.neutral, robot.neutral), robot.nv),
    ):
        asked = f"{what} of the robot, asked where it is neutral,"
        try:
            given = method(*arguments)
        except Exception as error:
            raise InvalidInput(f"{asked} raised {type(error).__name__}: {error}") from error
        if not isinstance(given, np.ndarray) or given.shape != (size,):
            raise InvalidInput(f"{asked} gives {brief(given)}; it must be an array of shape ({size},)")


def _check_base(robot: Any) -> None:
    what = f"base of the robot = {brief(robot.base)}"
    rule = "must be 0, 3 or 6: how many velocities are those of a base that moves freely"
    if not isinstance(robot.base, Integral) or isinstance(robot.base, bool) or int(robot.base) not in BASES:
        raise InvalidInput(f"{what}; it {rule}")
    if robot.base > robot.nv:
        raise InvalidInput(f"{what}, and the robot has {robot.nv} velocities; it {rule}")


def _check_names(robot: Any) -> None:
    for what, allowed in ("joint_names", None), ("joint_units", UNITS):
        own = _words(getattr(robot, what), what)
        if len(own) != robot.nv:
            raise InvalidInput(f"{what} of the robot has {len(own)}; it must have {robot.nv}, one a velocity")
        wrong = [word for word in own if allowed is not None and word not in allowed]
        if wrong:
            raise InvalidInput(f"{what} of the robot has {wrong[0]!r}; it must be 'rad' or 'm'")
    names = list(robot.joint_names)
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise InvalidInput(f"joint_names of the robot has {twice[0]!r} twice; each joint needs a name of its own")


def _words(value: Any, what: str) -> list[str]:
    if isinstance(value, (list, tuple)) and all(isinstance(word, str) for word in value):
        return list(value)
    raise InvalidInput(f"{what} of the robot = {brief(value)} is a {type(value).__name__}; it must be a list of names")


def _check_frames(robot: Any) -> None:
    _words(robot.frame_names, "frame_names")


def _check_tip(robot: Any) -> None:
    if robot.tip is not None and not isinstance(robot.tip, str):
        raise InvalidInput(
            f"tip of the robot = {brief(robot.tip)} is a {type(robot.tip).__name__}; it must be the name of a frame, or"
            " None"
        )


def _check_limit(robot: Robot, quantity: Quantity) -> None:
    value = limit_of(robot, quantity)
    if value is None:
        return
    what = f"{quantity} limit of the robot"
    if quantity == "position":
        _check_shape(value, (2, robot.nv), f"{what}, lowest and highest,")
        position_range((value[0], value[1]), robot.nv, what, names=joint_names(robot))
        return
    _check_shape(value, (robot.nv,), f"{what}, one number a joint,")
    given = numbers(value, what)
    least_allowed = "be positive" if quantity == "acceleration" else "not be negative"
    wrong = ~(given > 0.0) if quantity == "acceleration" else ~(given >= 0.0)
    if wrong.any():
        joint = int(np.argmax(wrong))
        raise InvalidInput(f"{what}: that of {joint_names(robot)[joint]!r} = {given[joint]:g}; it must {least_allowed}")


#: The check of each ability, in this order.
CHECKS: dict[type, Callable[[Any], None]] = {
    able.Neutral: _check_configuration("neutral"),
    able.Manifold: _check_manifold,
    able.Homed: _check_configuration("home"),
    able.Floating: _check_base,
    able.Named: _check_names,
    able.WithFrames: _check_frames,
    able.Tipped: _check_tip,
}
