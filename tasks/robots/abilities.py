"""Protocols of robots: what every robot has, and optional abilities, each a protocol of its own.

A robot has an ability if it has all attributes of the protocol: there is nothing to inherit from, and nothing to
register. :func:`tasks.robots.admission.as_robot` looks once at what each of them holds; :mod:`tasks.robots.robot` asks.
Only the attributes named here have a meaning, the one given here; a robot may have any others, such as a `model`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hqp.guard import Guard

from ..base.checks import Array
from ..base.protocols import has as has
from .frame import Frame
from .source import Source
from .state import RobotState

# What every robot has.


@runtime_checkable
class Sized(Protocol):
    """Has sizes: nq numbers of a configuration, and nv joint velocities."""

    @property
    def nq(self) -> int: ...
    @property
    def nv(self) -> int: ...


@runtime_checkable
class Robot(Sized, Protocol):
    """A robot: its sizes nq and nv, and its state at (q, v)."""

    def at(self, q: Array, v: Array) -> RobotState:
        """The state at joint positions q [rad], [m] and velocities v [rad/s], [m/s]."""
        ...


# Configurations.


@runtime_checkable
class Neutral(Protocol):
    """Has a configuration at which tasks are tried, shape (nq,); without it they are tried at zero."""

    @property
    def neutral(self) -> Array: ...


@runtime_checkable
class Manifold(Neutral, Protocol):
    """Its configurations lie on a manifold, where ``q + v dt`` means nothing: circles, quaternions, joints that wrap.

    Its states have `robot`, see :class:`Owned`, and, if nq and nv differ, `joints`, see :class:`WithJoints`.
    """

    def integrate(self, q: Array, step: Array, /) -> Array:
        """The configuration, shape (nq,), after a step of the joints, shape (nv,); a step of zero leads nowhere."""
        ...

    def difference(self, start: Array, end: Array, /) -> Array:
        """The step, shape (nv,), that leads from one configuration to another."""
        ...


@runtime_checkable
class Homed(Protocol):
    """Has a configuration to start from, shape (nq,); without it, that is the neutral one.

    Inverse kinematics starts there, and pairs of bodies that touch there are not watched for collision.
    """

    @property
    def home(self) -> Array: ...


@runtime_checkable
class Floating(Protocol):
    """Tells how many of the first velocities belong to a free base: 6, 3 in the plane, or 0.

    Postures and criteria ignore these velocities, and torques are refused if there are any. Without it: mounted.
    """

    @property
    def base(self) -> int: ...


# Names.


@runtime_checkable
class Named(Protocol):
    """Has a name and the unit of its position, "rad" or "m", for every joint velocity.

    Tasks and limits accept the names; messages and explanations use them. Without: "joint 0", ... in rad.
    """

    @property
    def joint_names(self) -> Sequence[str]: ...
    @property
    def joint_units(self) -> Sequence[str]: ...


@runtime_checkable
class WithFrames(Protocol):
    """Lists the names of its frames: an unknown name is refused with the nearest ones."""

    @property
    def frame_names(self) -> Sequence[str]: ...


@runtime_checkable
class WithAliases(WithFrames, Protocol):
    """Knows frames by more names than it lists."""

    def has_frame(self, name: str, /) -> bool:
        """Whether this names a frame."""
        ...


@runtime_checkable
class Tipped(Protocol):
    """Names its tip, the frame of tasks that name no frame; None if they must name one."""

    @property
    def tip(self) -> str | None: ...


# Limits of the robot, used by limits of a stack without numbers. Infinite for a joint without; None if all are without.


@runtime_checkable
class PositionLimited(Protocol):
    """Has lowest and highest joint positions [rad], [m], shape (2, nv)."""

    @property
    def position_limit(self) -> Array | None: ...


@runtime_checkable
class VelocityLimited(Protocol):
    """Has largest joint speeds [rad/s], [m/s], shape (nv,); 0 holds a joint."""

    @property
    def velocity_limit(self) -> Array | None: ...


@runtime_checkable
class AccelerationLimited(Protocol):
    """Has largest joint accelerations [rad/s^2], [m/s^2], shape (nv,)."""

    @property
    def acceleration_limit(self) -> Array | None: ...


@runtime_checkable
class TorqueLimited(Protocol):
    """Has largest joint torques [N m], forces [N], shape (nv,)."""

    @property
    def torque_limit(self) -> Array | None: ...


# Dynamics, tau = M(q) a + b(q, v), and quantities that records contain. All take leading axes: q of shape (..., nq).


@runtime_checkable
class Inertial(Protocol):
    """Knows its mass matrix: criteria of kinetic energy and of dynamic manipulability ask for it."""

    def mass_matrix(self, q: Array, /) -> Array:
        """M [kg m^2], shape (..., nv, nv)."""
        ...


@runtime_checkable
class MotionEquation(Inertial, Protocol):
    """Knows its equation of motion: limits and criteria of torque ask for it."""

    def bias(self, q: Array, v: Array, /) -> Array:
        """b [N m], shape (..., nv): Coriolis, centrifugal and gravity torques."""
        ...


@runtime_checkable
class Centroidal(Protocol):
    """Tells its momentum about its centre of mass."""

    def momentum(self, q: Array, v: Array, /) -> Array:
        """Linear [kg m/s], then angular [kg m^2/s], along the axes of the world, shape (6,)."""
        ...


@runtime_checkable
class InverseDynamics(Protocol):
    """Computes the torques for given accelerations: records have `tau`, and a controller can command torques."""

    def inverse_dynamics(self, q: Array, v: Array, a: Array, /) -> Array:
        """Joint torques [N m], shape (..., nv), for accelerations a [rad/s^2] (Eq. 4.1)."""
        ...


@runtime_checkable
class Manipulable(Protocol):
    """Tells how well its tip can be moved: records have `manipulability`."""

    def manipulability(self, q: Array, /) -> Array:
        """One number, shape (...), in a unit of the robot's own."""
        ...


@runtime_checkable
class Drawn(Protocol):
    """Can be drawn as one line from joint to joint."""

    def points(self, q: Array, /) -> Array:
        """Base, joints and tip [m], shape (k, 2) or (k, 3)."""
        ...


# Controllers.


@runtime_checkable
class SharedWorkspace(Protocol):
    """Its states share one workspace, and its configurations are checked before use.

    A controller never raises for a configuration: it calls `on_manifold`, then `state`. If `guard` is not an
    :class:`hqp.guard.Guard`, the three attributes have another meaning, and the robot does not have this ability.

    Attributes
    ----------
    guard : hqp.guard.Guard
        Held in every tick: all controllers of the robot share it.
    """

    @property
    def guard(self) -> Guard: ...

    def on_manifold(self, q: Array, /) -> tuple[Array, str | None]:
        """q without round-off, and an error message or None."""
        ...

    def state(self, q: Array, v: Array, /) -> RobotState:
        """The same state as `at`, for a q that has been checked."""
        ...


# States.


@runtime_checkable
class WithJoints(Protocol):
    """A state that tells the position of each joint that has one, 0 elsewhere, shape (nv,); without, it is q."""

    @property
    def joints(self) -> Array: ...


@runtime_checkable
class Owned(Protocol):
    """A state that names its robot: postures and couplings then know the names of the joints, and the manifold."""

    @property
    def robot(self) -> Robot: ...


@runtime_checkable
class Posed(Protocol):
    """A state with an array of any length, such as where the tip is, which a record of the motion keeps."""

    @property
    def pose(self) -> Array: ...


@runtime_checkable
class Massive(Protocol):
    """A state that tells the centre of mass, as a frame along the axes of the world."""

    @property
    def center_of_mass(self) -> Frame: ...


@runtime_checkable
class Sourced(Protocol):
    """Has its frames written by loops, and one number of q for the position of a joint that has one."""

    def frame_source(self, q: Array, v: Array) -> Source:
        """Where the numbers of its frames come from; q and v hold the state of the tick."""
        ...

    def position_indices(self, columns: NDArray[np.intp]) -> NDArray[np.int64]:
        """The index in q of the position of each of these velocities, shape (k,); -1 if it has none of its own."""
        ...

    def circles(self, columns: NDArray[np.intp]) -> NDArray[np.int64]:
        """The index in q of the cosine of each angle, its sine is the next number; -1 if it is not on a circle."""
        ...
