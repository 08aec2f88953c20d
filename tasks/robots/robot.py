"""What tasks and controllers ask of a robot. Any object that answers is a robot."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hqp import InvalidInput
from hqp.checks import whole_number
from hqp.errors import brief

from .._checks import Array, nearest
from .frame import Frame


class RobotState(Protocol):
    """One robot at one instant: everything that tasks of the same tick share, computed once.

    Attributes
    ----------
    q : array, shape (nq,)
        Configuration: joint positions [rad, m], and whatever else the robot needs to say where it is.
    v : array, shape (nv,)
        Joint velocities [rad/s, m/s].

    Notes
    -----
    A state may have more: ``robot``, whose state it is; ``joints``, shape (nv,), where nq and nv differ: the positions
    of the joints that have one, 0 elsewhere; ``pose``, an array of any length, which a record of the motion tells; and
    ``center_of_mass``, a :class:`~tasks.robots.frame.Frame` along the axes of the world.
    """

    @property
    def q(self) -> Array: ...
    @property
    def v(self) -> Array: ...

    def frame(self, name: str | None = None) -> Frame:
        """The frame of that name, by default the tip of the robot."""
        ...


class Robot(Protocol):
    """A robot: sizes, its own limits if it has any, and its state at (q, v).

    Attributes
    ----------
    nq, nv : int
        Numbers of a configuration, and of joint velocities.
    position_limit : array, shape (2, nv), or None
        Lowest and highest joint positions [rad], [m]; infinite where a joint turns freely.
    velocity_limit : array, shape (nv,), or None
        Largest joint speed [rad/s], [m/s].
    acceleration_limit : array, shape (nv,), or None
        Largest joint acceleration [rad/s^2], [m/s^2].

    Notes
    -----
    A robot may have more. Where a configuration is more than a number a joint, so that ``q + v dt`` means nothing:

    ``neutral``
        A configuration, shape (nq,), to try tasks at; zero where there is none.
    ``integrate(q, dq)``
        The configuration after a step dq, shape (nv,); the sum where there is none.
    ``difference(a, b)``
        The step, shape (nv,), that leads from a to b; what the two differ by where there is none.

    Names for messages and tasks: ``joint_names`` and ``joint_units``, one a velocity, ``frame_names``, and
    ``has_frame(name)`` where there are more names than these. And what a record of its motion tells, with leading axes:

    ``inverse_dynamics(q, v, a)``
        Joint torques [N m], shape (..., nv), which accelerations a [rad/s^2] take (Eq. 4.1). A controller of order
        "torque" commands them.
    ``manipulability(q)``
        How well the tip can be moved, shape (...), in a unit of the robot's own.

    And what limits on torques need, ``tau = M(q) a + b(q, v)``:

    ``mass_matrix(q)``
        M [kg m^2], shape (..., nv, nv).
    ``bias(q, v)``
        b [N m], shape (..., nv): Coriolis, centrifugal and gravity torques.
    ``torque_limit``
        Largest joint torques [N m], shape (nv,), infinite where a joint has none; or None.
    """

    @property
    def nq(self) -> int: ...
    @property
    def nv(self) -> int: ...
    @property
    def position_limit(self) -> Array | None: ...
    @property
    def velocity_limit(self) -> Array | None: ...
    @property
    def acceleration_limit(self) -> Array | None: ...

    def at(self, q: Array, v: Array) -> RobotState:
        """The state at joint positions q [rad] and velocities v [rad/s]."""
        ...


def on_pinocchio(robot: Robot) -> bool:
    """Whether this is a robot of Pinocchio, and not one of somebody's own that happens to have a model."""
    module = sys.modules.get("tasks.robots.pinocchio")  # there is none without it
    return module is not None and isinstance(robot, module.PinocchioRobot)


def neutral(robot: Robot) -> Array:
    """A configuration to try tasks at, shape (nq,)."""
    return np.asarray(getattr(robot, "neutral", np.zeros(robot.nq)))


def integrate(robot: Robot, q: Array, step: Array) -> Array:
    """The configuration after a step of the joints, shape (nq,)."""
    own = getattr(robot, "integrate", None)
    return q + step if own is None else np.asarray(own(q, step))


def difference(robot: Robot, start: Array, end: Array) -> Array:
    """The step of the joints that leads from one configuration to another, shape (nv,)."""
    own = getattr(robot, "difference", None)
    return end - start if own is None else np.asarray(own(start, end))


def joint_positions(state: RobotState) -> Array:
    """The position of each joint that has one, 0 elsewhere, shape (nv,)."""
    return np.asarray(getattr(state, "joints", state.q))


def positioned(robot: Robot) -> NDArray[np.bool_]:
    """Which velocities are those of a joint with one position: no wheel on a circle, no floating base, shape (nv,)."""
    if robot.nq == robot.nv or not hasattr(robot, "integrate"):
        return np.ones(robot.nv, dtype=np.bool_)
    rest, start = np.zeros(robot.nv), neutral(robot)
    there = robot.at(integrate(robot, start, np.full(robot.nv, 0.1)), rest)
    return np.asarray(joint_positions(there) != joint_positions(robot.at(start, rest)), dtype=np.bool_)


def joint_names(robot: Robot) -> tuple[str, ...]:
    """One name a joint velocity."""
    own = getattr(robot, "joint_names", None)
    return tuple(f"joint {i}" for i in range(robot.nv)) if own is None else tuple(own)


def joint_units(robot: Robot) -> tuple[str, ...]:
    """Unit of each joint position."""
    own = getattr(robot, "joint_units", None)
    return ("rad",) * robot.nv if own is None else tuple(own)


def towards(state: RobotState, q: Array) -> Array:
    """The step of the joints that leads from here to a configuration, shape (nv,)."""
    robot = getattr(state, "robot", None)
    return q - state.q if robot is None else difference(robot, state.q, q)


def joint_index(names: Sequence[str], joint: str | int, what: str) -> int:
    """Which joint velocity of a robot with these joints a joint is, by name or by number.

    Raises
    ------
    InvalidInput
        If there is no such joint; tells the nearest names.
    """
    if isinstance(joint, str):
        if joint not in names:
            raise InvalidInput(f"{what} {joint!r} is no joint of the robot{nearest(joint, names)}")
        return list(names).index(joint)
    index = whole_number(joint, what)
    if index >= len(names):
        raise InvalidInput(f"{what} = {index}; the robot has the joints 0 .. {len(names) - 1}")
    return index


def check_positioned(robot: Robot, columns: Iterable[int], what: str) -> None:
    """Refuse joints without one position each.

    Raises
    ------
    InvalidInput
        Names the first.
    """
    single = positioned(robot)
    for column in columns:
        if not single[column]:
            raise InvalidInput(
                f"{what} {joint_names(robot)[column]!r} has no single position; it turns without end, or is a"
                " part of a ball or of a floating or planar base"
            )


def check_frame(robot: Robot, name: str, what: str) -> None:
    """Refuse a name that is no frame's, where the robot tells those of its frames.

    Raises
    ------
    InvalidInput
        Tells the nearest names.
    """
    names = getattr(robot, "frame_names", ())
    has = getattr(robot, "has_frame", names.__contains__)
    if names and not has(name):
        raise InvalidInput(f"{what} {name!r} is no frame of {robot!r}{nearest(str(name), names)}")


def check_fixed_base(robot: Robot, what: str) -> None:
    """Refuse a floating base: the torques of the joints alone do not say how it accelerates.

    Raises
    ------
    InvalidInput
    """
    base = getattr(robot, "base", 0)
    if base:
        kind = "planar" if base == 3 else "floating"
        raise InvalidInput(f"{what}: {robot!r} has a {kind} base, which no joint torque drives; it must be fixed")


def as_robot(value: Robot) -> Robot:
    """`value`, which must have what every robot has.

    Raises
    ------
    InvalidInput
        If it has no nq, nv or at(q, v), or a size is no positive integer.
    """
    if not all(hasattr(value, name) for name in ("nq", "nv", "at")):
        raise InvalidInput(f"robot = {brief(value)} is a {type(value).__name__}; a robot has nq, nv and at(q, v)")
    for size in "nq", "nv":
        whole_number(getattr(value, size), f"{size} of the robot", least=1)
    return value


def check_joints(robot: Robot, q: Array, v: Array) -> None:
    """Refuse joint positions q and velocities v of another length than the robot's.

    Raises
    ------
    InvalidInput
    """
    for what, value, size in ("q", q, robot.nq), ("v", v, robot.nv):
        if value.shape != (size,):
            raise InvalidInput(f"{what} has shape {value.shape}; the robot takes ({size},), one number a joint")
