"""Cartesian limits of a frame: its speed, a half-space, a box."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput, Label
from hqp.checks import of_type

from ..base.checks import Array, numbers, per_row, positive
from ..base.live import number, structure
from ..robots.robot import Robot
from ..rows.inequality import Inequality
from ..rows.part import PER, Order, Part
from ..targets.trajectories import Trajectory
from .placement import Mask, Reference
from .plane import PlaneTask
from .pose import PoseTask
from .position import PositionTask

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site

#: The shapes of a corner of a box.
OF_A_CORNER = "(3,), or (2,) for a planar arm"


class FrameVelocityLimit(Part):
    """Bounds on the velocity of a frame, coordinate by coordinate.

    At acceleration order the velocity at the end of the tick is limited, so that the controller needs its dt.

    Parameters
    ----------
    limit : float or array, one number a coordinate of the mask
        Positive [m/s], [rad/s].
    frame : str, optional
        The name of a frame of the robot (default: its tip).
    relative_to : str, optional
        A frame of the robot in place of the world.
    mask : str or sequence of bool
        Of x, y, z, rx, ry, rz; by default the three of translation.
    reference : {"local_world_aligned", "local", "world"}
        Of which velocity: along the axes of the world, at the origin of the frame; along the axes of the frame; or the
        spatial one, of the point that is passing the world's origin.
    name : str, optional

    Raises
    ------
    InvalidInput
        If a limit is not positive, or there is not one a coordinate.

    Examples
    --------
    >>> from tasks import Controller, FrameVelocityLimit, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> stack = FrameVelocityLimit(0.1, mask="xy") >> PositionTask([1.0, 0.2], gain=2.0)
    >>> Controller(arm, stack, dt=0.01)(q).v.round(3)
    array([ 0.16 , -0.035, -0.115])
    """

    is_limit: ClassVar[bool] = True
    rows: int = structure()
    pose_task: PoseTask = structure()

    def __init__(
        self,
        limit: ArrayLike,
        *,
        frame: str | None = None,
        relative_to: str | None = None,
        mask: Mask = "xyz",
        reference: Reference = "local_world_aligned",
        name: str = "speed",
    ) -> None:
        self.pose_task = PoseTask(
            np.zeros(3),
            np.eye(3),
            frame=frame,
            relative_to=relative_to,
            mask=mask,
            reference=reference,
            gain=1.0,
            name=name,
        )
        self.name, self.rows, self.weight = name, self.pose_task.rows, numbers(1.0, "weight")
        self.limit = limit

    @number
    def limit(self, value: ArrayLike) -> Array:
        """The largest speed of each coordinate [m/s], [rad/s], shape (rows,)."""
        what = f"{self.full_name()}: limit"
        return per_row(positive(value, what), self.rows, what, "coordinate")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return [Label(f"{self.name} limit", row, unit + PER[order]) for row, unit in self.pose_task.row_names(robot)]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if self.pose_task.check_frames(robot):
            if not set(self.pose_task.mask) <= {0, 1, 5}:
                raise InvalidInput(f"{self.full_name()}: a planar arm has x, y and rz only; give it a mask of these")
            if self.pose_task.reference == "local":
                raise InvalidInput(f"{self.full_name()}: a planar arm knows the axes of the world only")
        if order == "acceleration" and dt is None:
            raise InvalidInput(
                f"{self.full_name()}: at acceleration order it needs the tick; give the controller dt in s"
            )

    def reach(self, robot: Robot) -> NDArray[np.bool_] | None:
        return self.pose_task.reach(robot)

    def plan(self, site: Site) -> Plan:
        """One loop; a step of inverse kinematics has no speed."""
        from ..base.loops import Call
        from ..rows.plan import Plan, free
        from .kernels import speed as loops

        if site.shared.order == "displacement":
            return free(site)
        assert site.A is not None
        call = Call(
            loops.write_speed_limit,
            site.law(self.pose_task),
            self.pose_task.block(site),
            site.shared.work,
            self.pose_task.axes,
            np.array(self.pose_task.mask, dtype=np.int64),
            self.limit,
        )
        return Plan((call,))

    def __repr__(self) -> str:
        return f"FrameVelocityLimit({self.limit.tolist()})"


class BoxLimit(Inequality):
    """Keep the origin of a frame inside a box.

    Parameters
    ----------
    lower, upper : array, shape (3,)
        Its corners [m], along the axes of the world or of `relative_to`; infinite where a side is open.
    frame : str, optional
        The name of a frame of the robot (default: its tip).
    relative_to : str, optional
        A frame of the robot in place of the world: all coordinates and motions are relative to it.
    gain : float
        The rate [1/s] at which a side is neared.
    name : str, optional

    Raises
    ------
    InvalidInput
        If a corner is not three numbers, or `lower` not below `upper`.

    Examples
    --------
    >>> from tasks import BoxLimit, Controller, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> stack = BoxLimit([0.0, 0.0], [0.9, 1.0], gain=5.0) >> PositionTask([1.2, 0.2], gain=2.0)
    >>> Controller(arm, stack, dt=0.01)(q).v.round(3)
    array([ 1.269, -0.636, -0.979])
    """

    def __init__(
        self,
        lower: ArrayLike,
        upper: ArrayLike,
        *,
        frame: str | None = None,
        relative_to: str | None = None,
        gain: ArrayLike,
        name: str = "box",
    ) -> None:
        name = of_type(name, str, "name of a BoxLimit")
        low, high = numbers(lower, f"box {name!r}: lower"), numbers(upper, f"box {name!r}: upper")
        if low.shape not in {(2,), (3,)}:
            raise InvalidInput(f"box {name!r}: lower has shape {low.shape}; it must be {OF_A_CORNER}")
        task = PositionTask(np.zeros(len(low)), frame=frame, relative_to=relative_to, gain=gain, name=name)
        super().__init__(task, low, high)

    @property
    def lower(self) -> Array:
        """Its lowest corner [m], shape (3,), or (2,) of a planar arm."""
        return self.below

    @lower.setter
    def lower(self, value: ArrayLike) -> None:
        self.below = value

    @property
    def upper(self) -> Array:
        """Its highest corner."""
        return self.above

    @upper.setter
    def upper(self, value: ArrayLike) -> None:
        self.above = value

    def _renew(self) -> None:
        low, high, what = self.below, self.above, f"box {self.name!r}"
        for name, corner in ("lower", low), ("upper", high):
            if corner.shape != (self.task.rows,):
                raise InvalidInput(f"{what}: {name} has shape {corner.shape}; it must be {OF_A_CORNER}")
        if not (low < high).all():
            raise InvalidInput(f"{what}: lower = {low.tolist()} must be below upper = {high.tolist()}")
        super()._renew()

    def __repr__(self) -> str:
        return f"BoxLimit({self.below.tolist()}, {self.above.tolist()})"


class PlaneLimit(Inequality):
    """Keep the origin of a frame in front of a plane.

    Parameters
    ----------
    normal : array, shape (3,)
        It points to where the frame may be.
    distance : float
        From the origin of the world, or of `relative_to`, along the normal [m].
    frame : str, optional
        The name of a frame of the robot (default: its tip).
    relative_to : str, optional
        A frame of the robot in place of the world: all coordinates and motions are relative to it.
    gain : float
        The rate [1/s] at which the plane is neared.
    name : str, optional

    Examples
    --------
    >>> from tasks import Controller, PlanarArm, PlaneLimit, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> stack = PlaneLimit([0.0, 1.0, 0.0], 0.2, gain=5.0) >> PositionTask([1.0, 0.0], gain=2.0)
    >>> Controller(arm, stack, dt=0.01)(q).v.round(3)
    array([ 1.253,  0.069, -0.373])
    """

    task: PlaneTask = structure()

    def __init__(
        self,
        normal: ArrayLike,
        distance: float,
        *,
        frame: str | None = None,
        relative_to: str | None = None,
        gain: ArrayLike,
        name: str = "plane",
    ) -> None:
        super().__init__(
            PlaneTask(normal, distance, frame=frame, relative_to=relative_to, gain=gain, name=name), 0.0, np.inf
        )

    @property
    def normal(self) -> Array:
        """The unit normal of the plane, shape (3,)."""
        return self.task.normal

    @normal.setter
    def normal(self, value: ArrayLike) -> None:
        self.task.normal = value

    @property
    def distance(self) -> Trajectory:
        """From the origin along the normal [m]."""
        return self.task.target

    @distance.setter
    def distance(self, value: ArrayLike | Trajectory) -> None:
        self.task.target = value
