"""Task: position and orientation of a frame on one level."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.live import number
from ..base.rotations import transform
from ..robots.block import relative
from ..robots.robot import RobotState
from ..targets.trajectories import Trajectory, as_trajectory
from ..targets.turns import PoseSetpoint, RotationTrajectory, as_rotation
from .placement import Mask, PlacementTask, Reference, chosen

AXES = ("x", "y", "z", "rx", "ry", "rz")


def _parts(target: Any, what: str) -> tuple[Any, Any]:
    """Position and rotation of a target that has both: a transform, a PoseSetpoint, or a pair."""
    if isinstance(target, tuple) and len(target) == 2:
        return target
    if isinstance(target, PoseSetpoint):
        return target.position, target.rotation
    return transform(target, what)


class PoseTask(PlacementTask):
    """Bring a frame to a target pose: position and orientation on one level, weighed against each other.

    Where they conflict neither has priority; ``PositionTask(...) >> OrientationTask(...)`` gives it to the first.

    Parameters
    ----------
    position : array, shape (3,), or Trajectory; or, alone, a transform or a PoseSetpoint
        [m]. A transform is a matrix of shape (4, 4), or a ``pinocchio.SE3``.
    rotation : array, shape (3, 3), or RotationTrajectory, optional
        Its columns are the axes that the frame is to have; none beside a transform.
    frame : str, optional
        The name of a frame of the robot (default: its tip).
    relative_to : str, optional
        A frame of the robot in place of the world: all coordinates and motions are relative to it.
    mask : str or sequence of bool, optional
        The coordinates to be controlled, as in ``"x y rz"``.
    reference : {"local_world_aligned", "local", "world"}
        Pinocchio's names. Along the axes of the world, the linear rows those of the origin of the frame; along the axes
        of the frame; or the spatial velocity, its linear rows those of the point that is passing the world's origin.
    gain : float or array, shape (rows,)
        K [1/s]: the rate at which the error decays; of the rows in [m] before those in [rad].
    damping_ratio : float
        The zeta of acceleration order; 1 is critical damping.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level, against those of other tasks joined by ``+``.
    cap : float or array, shape (rows,), optional
        Length to which the error is cut off, in its unit; a far target is approached at K times that.
    deceleration : float, optional
        The deceleration with which it comes to rest at its target [m/s^2], [rad/s^2].
    name : str, optional
        Used in messages, tables and records (default: "pose").

    Examples
    --------
    >>> from math import pi
    >>> from tasks import PoseTask, from_rpy
    >>> PoseTask([0.4, 0.2, 0.5], from_rpy(pi, 0.0, 0.0), gain=2.0)
    PoseTask([0.4, 0.2, 0.5], rotation by [3.1416, 0.0, 0.0], reference='local_world_aligned', gain=2)
    """

    def __init__(
        self,
        position: ArrayLike | Trajectory | PoseSetpoint,
        rotation: ArrayLike | RotationTrajectory | None = None,
        *,
        frame: str | None = None,
        relative_to: str | None = None,
        mask: Mask | None = None,
        reference: Reference = "local_world_aligned",
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        self._call(name)
        if rotation is not None and isinstance(position, PoseSetpoint):
            raise InvalidInput(
                f"{self.full_name()}: a rotation is given beside a PoseSetpoint, which has one; give one"
            )
        where: Any = position
        how: Any = rotation
        if rotation is None:
            where, how = _parts(position, f"{self.full_name()}: target")
        super().__init__(
            mask=chosen(mask, AXES, self.full_name()),
            reference=reference,
            frame=frame,
            relative_to=relative_to,
            gain=gain,
            damping_ratio=damping_ratio,
            weight=weight,
            cap=cap,
            deceleration=deceleration,
            name=name,
        )
        self.position, self.rotation = where, how

    @number
    def position(self, value: ArrayLike | Trajectory) -> Trajectory:
        """The target position of its origin [m]."""
        return as_trajectory(value, 3, f"{self.full_name()}, position")

    @number
    def rotation(self, value: ArrayLike | RotationTrajectory) -> RotationTrajectory:
        """The target rotation of its axes."""
        return as_rotation(value, f"{self.full_name()}, rotation")

    @property
    def target(self) -> tuple[Trajectory, RotationTrajectory]:
        """The target pose; set by a pair, a transform or a PoseSetpoint."""
        return self.position, self.rotation

    @target.setter
    def target(self, value: Any) -> None:
        self.position, self.rotation = _parts(value, f"{self.full_name()}: target")

    @classmethod
    def hold(
        cls, state: RobotState, *, frame: str | None = None, relative_to: str | None = None, **options: Any
    ) -> PoseTask:
        """The task that keeps a frame where it is.

        ``PoseTask.hold(robot.at(q, v), frame="left_foot", gain=10.0)``

        Parameters
        ----------
        state : RobotState
            Where it is.
        frame, relative_to, **options
            Of the task.
        """
        here = state.frame(frame)
        if here.rotation.ndim == 1:
            raise InvalidInput(
                "PoseTask.hold: a planar arm has no pose in space; hold a PositionTask and an OrientationTask"
            )
        if relative_to is not None:
            here = relative(state.frame(relative_to), here, state.v)
        return cls(here.position, here.rotation, frame=frame, relative_to=relative_to, **options)

    def _shown(self) -> list[str]:
        mask = " ".join(AXES[i] for i in self.mask)
        targets = [repr(self.position), repr(self.rotation)]
        return [*targets, *super()._shown(), *([] if self.rows == 6 else [f"mask={mask!r}"])]
