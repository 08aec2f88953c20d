"""What tasks and controllers ask of a robot. Any object that answers is a robot."""

from __future__ import annotations

from reprlib import repr as brief
from typing import Protocol

from hqp import InvalidInput
from hqp.checks import whole_number

from .._checks import Array


class RobotState(Protocol):
    """One robot at one instant: everything that tasks of the same tick share, computed once.

    Attributes
    ----------
    q : array, shape (nq,)
        Joint positions [rad].
    v : array, shape (nv,)
        Joint velocities [rad/s].
    pose : array
        What the tip is doing, in the coordinates of the robot: (x [m], y [m], phi [rad]) if planar.
    jacobian : array, shape (len(pose), nv)
        Rows of ``d pose / dt = J v``.
    twist : array, shape (len(pose),)
        ``J v``.
    drift : array, shape (len(pose),)
        ``Jdot v``, the acceleration of the tip while the joints do not accelerate (Eq. 4.4).
    """

    @property
    def q(self) -> Array: ...
    @property
    def v(self) -> Array: ...
    @property
    def pose(self) -> Array: ...
    @property
    def jacobian(self) -> Array: ...
    @property
    def twist(self) -> Array: ...
    @property
    def drift(self) -> Array: ...


class Robot(Protocol):
    """A robot: sizes, its own limits if it has any, and its state at (q, v).

    Attributes
    ----------
    nq, nv : int
        Number of joint positions and of joint velocities.
    position_limit : array, shape (2, nv), or None
        Lowest and highest joint positions [rad]; infinite where a joint turns freely.
    velocity_limit : array, shape (nv,), or None
        Largest joint speed [rad/s].
    acceleration_limit : array, shape (nv,), or None
        Largest joint acceleration [rad/s^2].

    Notes
    -----
    A robot may have more, which a record of its motion then tells. All take leading axes:

    ``inverse_dynamics(q, v, a)``
        Joint torques [N m], shape (..., nv), which accelerations a [rad/s^2] take (Eq. 4.1).
    ``manipulability(q)``
        How well the tip can be moved, shape (...), in a unit of the robot's own.
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
