r"""What tasks of a frame share: which frame, seen by whom, along which axes.

In the axes of the world, with the frame at p, R and its target at :math:`p^d, R^d`,

.. math:: e = \begin{bmatrix} p^d - p \\ \log(R^d R^T) \end{bmatrix}, \qquad J = \begin{bmatrix} J_p \\ J_\omega \end{bmatrix},

of which a task has the upper half, the lower half or both. The rotation vector :math:`\log(R^d R^T)` is the shortest way
to turn there, and :math:`\omega = K e` goes along it: the error decays at the rate K, and J loses no rank on the way, not
even at half a turn. In the axes of the frame itself, which turn with it, both halves are multiplied by :math:`R^T`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import of_type

from ._checks import Array
from .motion.trajectories import Trajectory
from .motion.turns import AboutZ, RotationTrajectory
from .robots.frame import Frame, relative
from .robots.robot import Robot, RobotState, nearest, neutral
from .rotations import cross, log
from .task import Task

#: Along which axes a task is written down.
Reference = Literal["world", "local", "local_world_aligned"]
#: Some of the coordinates: their names, ``"xz"``, or a truth for each.
Mask = str | Sequence[bool]
#: What does not move: no place, no velocity, no acceleration.
STILL = (np.zeros(3), np.zeros(3), np.zeros(3))


class FrameTask(Task):
    """Base of the tasks that bring a frame to a place.

    Parameters
    ----------
    position : Trajectory or None
        Where its origin is to be [m]; None if that is free.
    rotation : RotationTrajectory or None
        How its axes are to stand; None if they are free.
    frame : str, optional
        The name of a frame of the robot (default: its tip).
    relative_to : str, optional
        A frame of the robot that stands for the world: all coordinates are its own, all motions relative to it.
    mask : tuple of int
        The coordinates to be controlled, of those the task has.
    reference : {"world", "local", "local_world_aligned"}
        The axes of the world (or of `relative_to`), or those of the frame itself, which turn with it.
        "local_world_aligned" is Pinocchio's name for the former; see :class:`tasks.PoseTask` for the difference.
    gain, damping_ratio, weight, name
        See :class:`tasks.Task`.
    """

    rows: int

    def __init__(
        self,
        position: Trajectory | None,
        rotation: RotationTrajectory | None,
        *,
        frame: str | None,
        relative_to: str | None,
        mask: tuple[int, ...],
        reference: Reference,
        gain: ArrayLike,
        damping_ratio: float,
        weight: ArrayLike,
        name: str | None,
    ) -> None:
        self._call(name)
        self.frame = None if frame is None else of_type(frame, str, f"{self.label()}: frame")
        self.relative_to = None if relative_to is None else of_type(relative_to, str, f"{self.label()}: relative_to")
        if reference not in get_args(Reference):
            allowed = ", ".join(map(repr, get_args(Reference)))
            raise InvalidInput(f"{self.label()}: reference = {reference!r}; it must be one of {allowed}")
        self.reference: Reference = reference
        self.position, self.rotation, self.mask = position, rotation, mask
        self.rows = len(mask)
        first, last = mask[0], mask[-1]
        self._rows = slice(first, last + 1) if self.rows == last - first + 1 else list(mask)
        super().__init__(gain=gain, damping_ratio=damping_ratio, weight=weight, name=name)

    def seen(self, state: RobotState) -> Frame:
        """The frame, in the coordinates of the world or of `relative_to`."""
        frame = state.frame(self.frame)
        return frame if self.relative_to is None else relative(state.frame(self.relative_to), frame, state.v)

    def error(self, state: RobotState, t: float) -> Array:
        frame = self.seen(state)
        away = None if self.position is None else self.position(t)[0] - frame.position
        turn = None if self.rotation is None else _turn(self.rotation, frame.rotation, t)
        return self._along(frame, away, turn)

    def jacobian(self, state: RobotState) -> Array:
        frame = self.seen(state)
        return self._along(frame, frame.linear, frame.angular)

    def drift(self, state: RobotState) -> Array:
        frame, v = self.seen(state), state.v
        drift = self._along(frame, frame.linear_drift, frame.angular_drift)
        return drift + self._turning(frame, v, frame.linear @ v, frame.angular @ v)

    def rates(self, state: RobotState, t: float) -> tuple[Array, Array]:
        linear, angular = (STILL if target is None else target(t) for target in (self.position, self.rotation))
        frame = self.seen(state)
        velocity = self._along(frame, linear[1], angular[1])
        return velocity, self._along(frame, linear[2], angular[2]) + self._turning(frame, state.v, linear[1], angular[1])

    def _along(self, frame: Frame, linear: Array | None, angular: Array | None) -> Array:
        """Vectors in the axes of the world, or the columns of two matrices, as the rows of this task."""
        if self.reference == "local":
            turned = frame.rotation.T
            linear = None if self.position is None else turned @ linear
            angular = None if self.rotation is None else turned @ angular
        elif self.reference == "world" and self.position is not None and self.rotation is not None:
            linear = linear + cross(frame.position, angular)
        parts = [part for part, own in ((linear, self.position), (angular, self.rotation)) if own is not None]
        return np.asarray((parts[0] if len(parts) == 1 else np.concatenate(parts))[self._rows])

    def _turning(self, frame: Frame, v: Array, linear: Array, angular: Array) -> Array | float:
        """How the rows of constant vectors change, because their axes or their origin move."""
        if self.reference == "local":
            turned = frame.rotation.T
            omega = turned @ (frame.angular @ v)
            parts = [
                np.cross(turned @ vector, omega)
                for vector, own in ((linear, self.position), (angular, self.rotation))
                if own is not None
            ]
        elif self.reference == "world" and self.position is not None and self.rotation is not None:
            parts = [np.cross(frame.linear @ v, angular), np.zeros(3)]
        else:
            return 0.0
        return np.asarray(np.concatenate(parts)[self._rows])

    def check(self, robot: Robot, order: str, dt: float | None) -> None:
        names = getattr(robot, "frame_names", ())
        for what, name in ("frame", self.frame), ("relative_to", self.relative_to):
            if name is not None and names and name not in names:
                raise InvalidInput(f"{self.label()}: {what} {name!r} is no frame of {robot!r}{nearest(name, names)}")
        if self.frame is None and getattr(robot, "tip", "") is None:
            raise InvalidInput(f"{self.label()}: {robot!r} has no tip; give the task a frame, or the robot a tip")
        frame = robot.at(neutral(robot), np.zeros(robot.nv)).frame(self.frame)
        if frame.rotation.ndim == 1:  # a planar arm
            if self.reference == "local" or self.relative_to is not None:
                raise InvalidInput(f"{self.label()}: a planar arm knows the axes of the world only")
            if self.position is not None and 2 in self.mask:
                raise InvalidInput(f"{self.label()}: a planar arm has no z; give x and y")
            if self.rotation is not None and not isinstance(self.rotation, AboutZ):
                raise InvalidInput(f"{self.label()}: a planar arm turns about z only; give one angle [rad]")
        super().check(robot, order, dt)

    def _shown(self) -> list[str]:
        parts = []
        options = {"frame": (self.frame, None), "relative_to": (self.relative_to, None)}
        parts += [f"{key}={value!r}" for key, (value, default) in options.items() if value != default]
        return parts if self.reference == "world" else [*parts, f"reference={self.reference!r}"]


def _turn(target: RotationTrajectory, R: Array, t: float) -> Array:
    """The rotation vector from R to the target, shape (3,)."""
    if R.ndim == 1 and isinstance(target, AboutZ):
        return np.array([0.0, 0.0, float(target.angle(t)[0][0] - R[0])])
    return log(target(t)[0] @ R.T)


def chosen(mask: Mask | None, names: Sequence[str], what: str) -> tuple[int, ...]:
    """Which coordinates a mask chooses, in order; all, if there is none.

    Raises
    ------
    InvalidInput
        If a name is unknown or comes twice, there is not one truth a coordinate, or none is chosen.
    """
    if mask is None:
        return tuple(range(len(names)))
    if isinstance(mask, str):
        words = mask.split() if " " in mask or mask in names else list(mask)
        unknown = [word for word in words if word not in names]
        if unknown or len(set(words)) != len(words) or not words:
            raise InvalidInput(f"{what}: mask = {mask!r}; it must name some of {', '.join(names)}, each once")
        return tuple(sorted(map(list(names).index, words)))
    truths = list(mask)
    if len(truths) != len(names) or not all(isinstance(t, bool | np.bool_) for t in truths) or not any(truths):
        raise InvalidInput(f"{what}: mask = {truths}; it must say True or False of {', '.join(names)}, and True once")
    return tuple(int(i) for i in np.flatnonzero(truths))
