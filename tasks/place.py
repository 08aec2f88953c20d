r"""A frame brought to a place: the law of position, orientation and pose.

In the axes of the world, with the frame at p, R and its target at :math:`p^d, R^d`,

.. math:: e = (p^d - p, \; \log(R^d R^T)), \qquad J = (J_p, \; J_\omega),

of which a task has the first half, the second half or both. The rotation vector :math:`\log(R^d R^T)` is the shortest
way to turn there, and :math:`\omega = K e` goes along it: the error decays at the rate K, and J loses no rank on the
way, not even at half a turn. In the axes of the frame itself, which turn with it, both halves are multiplied by
:math:`R^T`: a task with all its coordinates asks for the same motion in any axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import one_of
from hqp.errors import brief

from ._checks import Array
from .frame_task import FrameTask
from .motion.trajectories import Trajectory
from .motion.turns import AboutZ, RotationTrajectory
from .part import Order
from .robots.frame import Frame
from .robots.robot import Robot, RobotState
from .rotations import cross, log

#: Along which axes a task is written down.
Reference = Literal["world", "local", "local_world_aligned"]
#: Some of the coordinates: their names, ``"xz"``, or a truth for each.
Mask = str | Sequence[bool]
#: What does not move: no place, no velocity, no acceleration.
STILL = (np.zeros(3), np.zeros(3), np.zeros(3))


class PlaceTask(FrameTask):
    """Base of the tasks that bring a frame to a place.

    Parameters
    ----------
    position : Trajectory or None
        Where its origin is to be [m]; None if that is free.
    rotation : RotationTrajectory or None
        How its axes are to stand; None if they are free.
    mask : tuple of int
        The coordinates to be controlled, of those the task has.
    reference : {"world", "local", "local_world_aligned"}
        The axes of the world (or of `relative_to`), or those of the frame itself, which turn with it.
        "local_world_aligned" is Pinocchio's name for the former; see :class:`tasks.PoseTask` for the difference.
    frame, relative_to, gain, damping_ratio, weight, name
        See :class:`~tasks.frame_task.FrameTask`.
    """

    rows: int

    def __init__(
        self,
        position: Trajectory | None,
        rotation: RotationTrajectory | None,
        *,
        mask: tuple[int, ...],
        reference: Reference,
        frame: str | None,
        relative_to: str | None,
        gain: ArrayLike,
        damping_ratio: float,
        weight: ArrayLike,
        name: str | None,
    ) -> None:
        self._call(name)
        self.reference: Reference = as_reference(reference, self.label())
        self.position, self.rotation, self.mask = position, rotation, mask
        self.rows = len(mask)
        first, last = mask[0], mask[-1]
        self._rows = slice(first, last + 1) if self.rows == last - first + 1 else list(mask)
        super().__init__(frame, relative_to, gain=gain, damping_ratio=damping_ratio, weight=weight, name=name)

    def error(self, state: RobotState, t: float) -> Array:
        frame, away, turn = self.seen(state), STILL[0], STILL[0]
        if self.position is not None:
            away = self.position(t)[0] - frame.position
        if self.rotation is not None:
            turn = _turn(self.rotation, frame.rotation, t)
        return self._along(frame, away, turn)

    def jacobian(self, state: RobotState) -> Array:
        frame = self.seen(state)
        return self._along(frame, frame.linear, frame.angular)

    def drift(self, state: RobotState) -> Array:
        frame, v = self.seen(state), state.v
        drift = self._along(frame, frame.linear_drift, frame.angular_drift)
        return drift + self._turning(frame, v, frame.linear @ v, frame.angular @ v)

    def rates(self, state: RobotState, t: float) -> tuple[Array, Array]:
        frame, v = self.seen(state), state.v
        (_, p1, p2), (_, r1, r2) = (STILL if goal is None else goal(t) for goal in (self.position, self.rotation))
        linear, angular = frame.linear @ v, frame.angular @ v
        # The axes turn with the frame, not with the target; and what stands still in the frame is R^T log(R^d R^T).
        turning = self._turning(frame, v, linear, angular)
        return self._along(frame, p1, r1), self._along(frame, p2, r2 + cross(r1, angular)) + turning

    def _along(self, frame: Frame, linear: Array, angular: Array) -> Array:
        """Vectors in the axes of the world, or the columns of matrices, as the rows of this task."""
        if self.reference == "local":
            linear, angular = frame.rotation.T @ linear, frame.rotation.T @ angular
        elif self._spatial:
            linear = linear + cross(frame.position, angular)
        return self._own(linear, angular)

    def _turning(self, frame: Frame, v: Array, linear: Array, angular: Array) -> Array | float:
        """How the rows of vectors that stand still in the world change, as their axes or their origin move."""
        if self.reference == "local":
            turned = frame.rotation.T
            omega = turned @ (frame.angular @ v)
            return self._own(np.cross(turned @ linear, omega), np.cross(turned @ angular, omega))
        if self._spatial:
            return self._own(np.cross(frame.linear @ v, angular), STILL[0])
        return 0.0

    @property
    def _spatial(self) -> bool:
        """Whether the linear rows are those of the point that is passing the origin of the world."""
        return self.reference == "world" and self.position is not None and self.rotation is not None

    def _own(self, linear: Array, angular: Array) -> Array:
        """The coordinates of this task."""
        if self.rotation is None:
            return linear[self._rows]
        if self.position is None:
            return angular[self._rows]
        return np.concatenate([linear, angular])[self._rows]

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        names = [(axis, "m") for axis in "xyz"] if self.position is not None else []
        if self.rotation is not None:
            names += [(f"r{axis}" if names else axis, "rad") for axis in "xyz"]
        return [names[i] for i in self.mask]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.check_frames(robot)
        if self.seen(self.at_rest(robot)).rotation.ndim == 1:
            self._check_planar()
        super().check(robot, order, dt)

    def _check_planar(self) -> None:
        """Refuse what a planar arm has not."""
        if self.reference == "local":
            raise InvalidInput(f"{self.label()}: a planar arm knows the axes of the world only")
        if self.position is not None and 2 in self.mask:
            raise InvalidInput(f"{self.label()}: a planar arm has no z; give x and y")
        if self.rotation is not None and not isinstance(self.rotation, AboutZ):
            raise InvalidInput(f"{self.label()}: a planar arm turns about z only; give one angle [rad]")

    def _shown(self) -> list[str]:
        return [*super()._shown(), *([] if self.reference == "world" else [f"reference={self.reference!r}"])]


def _turn(target: RotationTrajectory, R: Array, t: float) -> Array:
    """The rotation vector from R to the target, shape (3,)."""
    if R.ndim == 1 and isinstance(target, AboutZ):
        return np.array([0.0, 0.0, float(target.angle(t)[0][0] - R[0])])
    return log(target(t)[0] @ R.T)


def as_reference(value: str, what: str) -> Reference:
    """`value`, which must name some axes."""
    found: Reference = one_of(value, get_args(Reference), f"{what}: reference")  # type: ignore[assignment]
    return found


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
    try:
        truths = list(mask)
    except TypeError:
        truths = [mask]  # type: ignore[list-item]
    if len(truths) != len(names) or not all(isinstance(t, bool | np.bool_) for t in truths) or not any(truths):
        raise InvalidInput(
            f"{what}: mask = {brief(truths)}; it must say True or False of {', '.join(names)}, and True once"
        )
    return tuple(int(i) for i in np.flatnonzero(truths))
