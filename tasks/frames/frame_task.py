"""The base class of tasks of a frame, in the world or relative to another frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.checks import of_type

from ..base.checks import Array
from ..base.live import structure
from ..robots.block import relative
from ..robots.chain import APART, chain_order
from ..robots.frame import Frame
from ..robots.robot import Robot, RobotState, check_frame, tells_tip, tip
from ..rows.part import Order
from ..rows.task import Task

if TYPE_CHECKING:
    from ..base.loops import Table
    from ..rows.site import Site


class Reading(NamedTuple):
    """The linear map from the twist of a frame to the rows of a task.

    Attributes
    ----------
    axes : int
        The axes of the velocity: WORLD, LOCAL or SPATIAL of :mod:`tasks.frames.kernels.placement`.
    rows : array, shape (rows, 6)
        The coefficients of each row for the linear and angular velocity along these axes.
    """

    axes: int
    rows: Array


class FrameTask(Task):
    """Base of the tasks of one frame; make a PoseTask, a PositionTask or an OrientationTask, or a subclass of your own.

    Parameters
    ----------
    frame : str, optional
        The name of a frame of the robot (default: its tip).
    relative_to : str, optional
        A frame of the robot in place of the world: all coordinates and motions are relative to it.
    gain : float or array, shape (rows,)
        K [1/s]: the rate at which the error decays.
    damping_ratio : float
        The zeta of acceleration order; 1 is critical damping.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level, against those of other tasks joined by ``+``.
    cap : float or array, shape (rows,), optional
        Length to which the error is cut off, in its unit; a far target is approached at K times that.
    deceleration : float, optional
        The deceleration with which it comes to rest at its target [m/s^2], [rad/s^2].
    name : str, optional
        Used in messages, tables and records (default: the name of the class).

    Attributes
    ----------
    spatial : bool
        Whether it needs rotations out of the plane, which no planar arm has.
    """

    frame: str | None = structure()
    relative_to: str | None = structure()
    spatial: ClassVar[bool] = False
    says: ClassVar[tuple[str, ...]] = (*Task.says, "seen")

    def __new__(cls, *args: Any, **options: Any) -> Self:
        if cls is FrameTask:
            raise InvalidInput(
                "FrameTask is the base of the tasks of a frame; use PoseTask(position, rotation, frame=..., gain=...),"
                " PositionTask(position, ...) or OrientationTask(rotation, ...), the latter two on levels of their own"
                " where one goes before the other"
            )
        return super().__new__(cls)

    def __init__(
        self,
        frame: str | None,
        relative_to: str | None,
        *,
        gain: ArrayLike,
        damping_ratio: float,
        weight: ArrayLike,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None,
    ) -> None:
        self._call(name)
        self.frame = None if frame is None else of_type(frame, str, f"{self.full_name()}: frame")
        self.relative_to = (
            None if relative_to is None else of_type(relative_to, str, f"{self.full_name()}: relative_to")
        )
        super().__init__(
            gain=gain, damping_ratio=damping_ratio, weight=weight, cap=cap, deceleration=deceleration, name=name
        )

    def seen(self, state: RobotState) -> Frame:
        """The frame, in the coordinates of the world or of `relative_to`."""
        frame = self._itself(state)
        return frame if self.relative_to is None else relative(state.frame(self.relative_to), frame, state.v)

    def _itself(self, state: RobotState) -> Frame:
        return state.frame(self.frame)

    def block(self, site: Site) -> Array:
        """The block of the frame, for loops; see :mod:`tasks.robots.kernels.block`."""
        return site.frame(self.frame, self.relative_to)

    def reach(self, robot: Robot) -> NDArray[np.bool_] | None:
        """The joints between the world and the frames."""
        frames = [self.frame] if self.relative_to is None else [self.frame, self.relative_to]
        chains = [chain_order(robot, frame) for frame in frames]
        if any(chain is None for chain in chains):
            return None
        return np.tile(np.any([np.asarray(chain) != APART for chain in chains], axis=0), (self.size(robot), 1))

    def motion_curvature(self, site: Site) -> Table | None:
        """The curvature of the frame's motion, see :mod:`tasks.rows.curvature`; None where it is not known."""
        from ..rows.curvature import frame_curvature

        return frame_curvature(site.shared, self.frame, self.relative_to)

    def reading(self) -> Reading | None:
        """The linear map from the motion of the frame to its rows; None if it is not constant."""
        return None

    def desired_velocity(self, t: float) -> Array:
        """The velocity of the target, linear and angular, along the axes of the world, shape (6,)."""
        raise NotImplementedError(f"{type(self).__name__} must define desired_velocity(t), as it has a reading()")

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if self.check_frames(robot):
            self.check_planar()
        super().check(robot, order, dt)

    def check_planar(self) -> None:
        """Refuse coordinates that a planar arm does not have."""

    def check_frames(self, robot: Robot) -> bool:
        """Refuse a frame that the robot does not have; True if it is a frame of a planar arm."""
        self.check_names(robot)
        if self.frame is None and tells_tip(robot) and tip(robot) is None:
            raise InvalidInput(f"{self.full_name()}: {robot!r} has no tip; give the task a frame, or the robot a tip")
        planar = self.at_rest(robot).frame(self.frame).rotation.ndim == 1
        if planar:
            if self.spatial:
                raise InvalidInput(f"{self.full_name()}: a planar arm turns about z only; give it an OrientationTask")
            if self.relative_to is not None:
                raise InvalidInput(f"{self.full_name()}: a planar arm knows the axes of the world only")
        return planar

    def check_names(self, robot: Robot) -> None:
        """Refuse names of frames that the robot does not have; the message suggests the nearest."""
        for what, name in ("frame", self.frame), ("relative_to", self.relative_to):
            if name is not None:
                check_frame(robot, name, f"{self.full_name()}: {what}")
        own = tip(robot) if self.frame is None else self.frame
        if self.relative_to is not None and self.relative_to == own:
            raise InvalidInput(f"{self.full_name()}: relative_to = {own!r} is the frame itself; name another one")

    def _shown(self) -> list[str]:
        options = {"frame": self.frame, "relative_to": self.relative_to}
        return [f"{key}={value!r}" for key, value in options.items() if value is not None]
