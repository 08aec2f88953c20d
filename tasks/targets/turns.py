"""Rotation trajectories: desired orientations in time, with angular velocity and acceleration."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import real_number

from ..base.checks import Array, fill, finite, numbers, positive_scalar
from ..base.live import structure
from ..base.rotations import about, exp, is_transform, log, matrix_of, rotation_matrix, transform
from .timing import Timing, as_timing, quintic
from .trajectories import Fixed, Setpoint, Spread, Target, Trajectory, alike, as_trajectory, three_of


@runtime_checkable
class RotationTrajectory(Protocol):
    """A rotation in time: ``trajectory(t)`` gives R (3, 3), and omega [rad/s] and its rate [rad/s^2], each (3,).

    Both in the axes of the world, as R is.
    """

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]: ...


class FixedRotation(Target):
    """A constant rotation.

    Parameters
    ----------
    R : array, shape (3, 3)

    Examples
    --------
    >>> from tasks import FixedRotation, from_rpy
    >>> FixedRotation(from_rpy(0.0, 0.0, 0.5))
    rotation by [0.0, 0.0, 0.5]
    """

    R: Array = structure()

    def __init__(self, R: ArrayLike) -> None:
        self.R = rotation_matrix(R, "rotation")
        self._sample = (self.R, np.zeros(3), np.zeros(3))

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        return self._sample

    def __repr__(self) -> str:
        return f"rotation by {log(self.R).round(4).tolist()}"


class RotationSetpoint(Target):
    """A desired rotation set by the caller: ``setpoint.move(R)`` before a tick.

    Parameters
    ----------
    R : array, shape (3, 3)
        Where it begins.

    Examples
    --------
    >>> from tasks import OrientationTask, RotationSetpoint, from_rpy
    >>> hand = RotationSetpoint(from_rpy(0.0, 0.0, 0.0))
    >>> task = OrientationTask(hand, gain=5.0)
    >>> hand.move(from_rpy(0.0, 0.0, 0.5))  # before a tick
    """

    def __init__(self, R: ArrayLike) -> None:
        self._R = np.array(rotation_matrix(R, "setpoint"))
        self._omega, self._alpha = np.zeros((2, 3))
        self._turns = False

    def move(self, R: ArrayLike, omega: ArrayLike | None = None, alpha: ArrayLike | None = None) -> None:
        """Set the rotation and, if known, its angular velocity [rad/s] and acceleration [rad/s^2] (default: 0).

        Raises
        ------
        InvalidInput
            If R is no rotation, to 1e-6; or omega or alpha is not three numbers, or alpha comes without omega.
        """
        turns = omega is not None
        if not turns and alpha is not None:
            raise InvalidInput("setpoint: alpha is given without omega; give both")
        where = rotation_matrix(R, "setpoint")
        if not turns and not self._turns:
            self._R[:] = where
            return
        rate = 0.0 if omega is None else alike(omega, self._omega, "setpoint: omega")
        change = 0.0 if alpha is None else alike(alpha, self._alpha, "setpoint: alpha")
        self._R[:], self._omega[:], self._alpha[:], self._turns = where, rate, change, turns

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        return self._R, self._omega, self._alpha

    def __repr__(self) -> str:
        return f"RotationSetpoint by {log(self._R).round(4).tolist()}"


class PoseSetpoint(Target):
    """A desired pose set by the caller: ``setpoint.move(T)`` before a tick, and ``PoseTask(setpoint, gain=5.0)``.

    Parameters
    ----------
    T : array, shape (4, 4), or pinocchio.SE3
        Where it begins.

    Attributes
    ----------
    position : Setpoint
    rotation : RotationSetpoint

    Raises
    ------
    InvalidInput
        If it is no transform.

    Examples
    --------
    >>> import numpy as np
    >>> from tasks import PoseSetpoint, PoseTask
    >>> hand = PoseSetpoint(np.eye(4))
    >>> task = PoseTask(hand, gain=5.0)
    >>> hand.position(0.0)[0]
    array([0., 0., 0.])
    """

    position: Setpoint = structure()
    rotation: RotationSetpoint = structure()

    def __init__(self, T: Any) -> None:
        p, R = transform(T, "setpoint")
        self.position, self.rotation = Setpoint(p), RotationSetpoint(R)

    def move(self, T: Any, velocity: ArrayLike | None = None) -> None:
        """Set the pose and, if known, its velocity: linear [m/s] before angular [rad/s], in world axes.

        Raises
        ------
        InvalidInput
            If T is no transform, or the velocity not six numbers. The setpoint then stays where it was.
        """
        p, R = transform(T, "setpoint")
        twist = None if velocity is None else alike(velocity, np.zeros(6), "setpoint: velocity")
        self.position.move(p, None if twist is None else twist[:3])
        self.rotation.move(R, None if twist is None else twist[3:])

    def __repr__(self) -> str:
        return f"PoseSetpoint({self.position!r}, {self.rotation!r})"


class WatchedRotation:
    """A user's rotation in time: where it gives no rotation there is NaN, which makes the tick INVALID.

    Parameters
    ----------
    target : RotationTrajectory
    what : str
        Whose target it is, for messages.
    """

    def __init__(self, target: RotationTrajectory, what: str) -> None:
        self.target, self._what = target, what

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        R, omega, alpha = three_of(self.target(t), self._what, t)
        turning = np.zeros((2, 3))
        for out, rate in zip(turning, (omega, alpha), strict=True):
            fill(out, rate, f"{self._what}: a rate of target({t})")
        try:
            return rotation_matrix(R, "target"), turning[0], turning[1]
        except InvalidInput:
            return np.full((3, 3), np.nan), turning[0], turning[1]

    def __repr__(self) -> str:
        return repr(self.target)


class AboutZ:
    """A rotation about z by an angle as a function of time: the only rotation of a planar arm.

    Parameters
    ----------
    angle : Trajectory
        Of one number [rad], which may go on beyond a full turn.
    """

    def __init__(self, angle: Trajectory) -> None:
        self.angle = angle

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        angle, rate, change = (float(part[0]) for part in self.angle(t))
        return about(2, angle), np.array([0.0, 0.0, rate]), np.array([0.0, 0.0, change])

    def __repr__(self) -> str:
        return repr(self.angle)


class Turn(Target):
    """The shortest rotation from one orientation to another, about a fixed axis, by a timing law.

    Parameters
    ----------
    start, end : array, shape (3, 3)
    duration : float
        [s]; before it begins, and after, the rotation stands still.
    law : callable
        One of ``cubic``, ``quintic``, ``harmonic``, ``cycloid``.

    Examples
    --------
    >>> from tasks import Turn, from_rpy
    >>> turn = Turn(from_rpy(0.0, 0.0, 0.0), from_rpy(0.0, 0.0, 1.0), duration=2.0)
    >>> R, omega, _ = turn(1.0)
    >>> omega
    array([0.    , 0.    , 0.9375])
    """

    start: Array = structure()
    end: Array = structure()
    duration: float = structure()
    law: Timing = structure()

    def __init__(self, start: ArrayLike, end: ArrayLike, duration: float, law: Timing = quintic) -> None:
        self.start, self.end = rotation_matrix(start, "start"), rotation_matrix(end, "end")
        self.duration, self.law = positive_scalar(duration, "duration", unit="s"), as_timing(law, "law")
        self._vector = log(self.end @ self.start.T)

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        if type(t) is not float:
            t = real_number(t, "t")
        s, ds, dds = self.law(t / self.duration)
        rate, change = ds / self.duration, dds / self.duration**2
        return exp(s * self._vector) @ self.start, rate * self._vector, change * self._vector

    def __repr__(self) -> str:
        return f"Turn of {np.linalg.norm(self._vector):.4g} rad in {self.duration:g} s"


def position_of(target: Any, what: str) -> Any:
    """The position of a transform or a PoseSetpoint; any other target unchanged."""
    if isinstance(target, PoseSetpoint):
        return target.position
    return transform(target, f"{what}: target")[0] if is_transform(target) else target


def as_rotation(target: ArrayLike | RotationTrajectory | Trajectory, what: str) -> RotationTrajectory:
    """`target` as a rotation in time: a matrix stands still, one angle turns about z, functions of time move.

    Of a transform, or a PoseSetpoint, it is the rotation.

    Raises
    ------
    InvalidInput
        If it is neither, or (at t = 0) gives no rotation.
    """
    if isinstance(target, AboutZ):
        return target
    if isinstance(target, PoseSetpoint):
        return target.rotation
    if is_transform(target):
        return FixedRotation(transform(target, f"{what}: target")[1])
    if hasattr(target, "as_matrix"):
        return FixedRotation(rotation_matrix(matrix_of(target), f"{what}: target"))
    if not callable(target):
        array = finite(target, f"{what}: target")
        if array.size == 1:
            return AboutZ(Fixed(array))
        if array.ndim != 2:
            raise InvalidInput(f"{what}: target has shape {array.shape}; it must be (3, 3), or (1,), an angle about z")
        return FixedRotation(rotation_matrix(array, f"{what}: target"))
    try:
        sample = [numbers(part, f"{what}: target(0.0)") for part in target(0.0)]
    except InvalidInput:
        raise
    except Exception as error:
        raise InvalidInput(f"{what}: target(0.0) raised {type(error).__name__}: {error}") from error
    shapes = [part.shape for part in sample]
    if shapes == [(1,)] * 3:
        return AboutZ(as_trajectory(target, 1, what))
    if shapes != [(3, 3), (3,), (3,)]:
        raise InvalidInput(
            f"{what}: target(0.0) gives shapes {shapes}; it must give rotation, angular velocity and acceleration,"
            " (3, 3), (3,), (3,), or an angle and its derivatives, each (1,)"
        )
    rotation_matrix(sample[0], f"{what}: target(0.0)")
    return target if isinstance(target, KNOWN) else WatchedRotation(target, what)


#: Classes that always give valid rotations.
KNOWN = (FixedRotation, RotationSetpoint, Turn, WatchedRotation)


def stands_still(target: object) -> bool:
    """Whether a target is constant: numbers, not a function of time."""
    return constant(target) is not None


def constant(target: object) -> tuple[object, ...] | None:
    """The form of a constant target, the same for all that differ by their numbers alone; None of what may move."""
    if isinstance(target, Fixed):
        return type(target), len(target.target)
    if isinstance(target, FixedRotation):
        return (type(target),)
    if isinstance(target, Spread):
        inner = constant(target.trajectory)
        return None if inner is None else (Spread, target.columns.start, target.columns.stop, *inner)
    if isinstance(target, AboutZ):
        inner = constant(target.angle)
        return None if inner is None else (AboutZ, *inner)
    return None
