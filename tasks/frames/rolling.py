"""Tasks: wheels that roll on a plane without slip, in all directions or in one."""

from __future__ import annotations

from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.checks import Array, finite, finite_scalar, positive_scalar
from ..base.live import number
from ..base.rotations import perpendicular
from ..robots.robot import Robot, base
from ..rows.expansion import Companions, Setting
from ..rows.loop_task import LoopTask
from .axis import unit
from .frame_task import FrameTask

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class WheelTask(FrameTask, LoopTask):
    """Base of the wheels on a plane.

    Parameters
    ----------
    radius : float
        [m].
    frame : str, optional
        The hub, which turns with the wheel.
    relative_to : str, optional
        The floor, where it is no part of the world.
    normal : array, shape (3,)
        Of the plane, towards the wheel.
    floor : float
        How far the plane is from the origin, along the normal [m].
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
        Used in messages, tables and records (default: from the name of the class).
    """

    spatial = True

    def __init__(
        self,
        radius: float,
        *,
        frame: str | None = None,
        relative_to: str | None = None,
        normal: ArrayLike = (0.0, 0.0, 1.0),
        floor: float = 0.0,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.radius, self.normal, self.floor = radius, normal, floor
        super().__init__(
            frame,
            relative_to,
            gain=gain,
            damping_ratio=damping_ratio,
            weight=weight,
            cap=cap,
            deceleration=deceleration,
            name=name,
        )

    @number
    def radius(self, value: float) -> float:
        """Of the wheel [m]."""
        return positive_scalar(value, f"{self.full_name()}: radius", unit="m")

    @number
    def normal(self, value: ArrayLike) -> Array:
        """Of the plane: normalised; any length but 0 may be given."""
        return unit(finite(value, f"{self.full_name()}: normal"), f"{self.full_name()}: normal")

    @number
    def floor(self, value: float) -> float:
        """How far the plane is from the origin, along the normal [m]."""
        return finite_scalar(value, f"{self.full_name()}: floor")

    def _wheel(self) -> Array:
        """The arguments of its loop; see :mod:`tasks.frames.kernels.rolling`."""
        from .kernels import rolling as loops

        wheel = np.zeros(loops.WHEEL_SIZE)
        wheel[loops.NORMAL : loops.NORMAL + 3] = self.normal
        wheel[loops.FIRST : loops.FIRST + 6] = perpendicular(self.normal).ravel()
        wheel[loops.RADIUS], wheel[loops.FLOOR] = self.radius, self.floor
        return wheel

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.rolling import write_rolling

        told = site.law(self), self.block(site), self._wheel(), site.rows - 1, site.shared.work
        return Plan((Call(write_rolling, *told),))

    def companions(self, setting: Setting) -> Companions:
        if setting.order == "acceleration" and setting.has_dynamics and base(setting.robot):
            raise InvalidInput(
                f"{self.full_name()}: a wheel on the ground is driven by forces, which are no unknowns of it; beside"
                f" Dynamics() it is a Contact({self.frame!r}, radius={self.radius:g}, friction=0.6)"
            )
        return super().companions(setting)

    def check_frames(self, robot: Robot) -> bool:
        if self.at_rest(robot).frame(self.frame).rotation.ndim == 1:
            raise InvalidInput(f"{self.full_name()}: {robot!r} moves in the plane; wheels take robots in space")
        return super().check_frames(robot)

    def _shown(self) -> list[str]:
        return [f"{self.radius:g}", *super()._shown()]


class RollingTask(WheelTask):
    """Let a wheel, or a ball, roll on a plane without slip, at the height of its radius.

    The point of contact has no velocity along the plane: two rows for the slip, and one for the height, which the law
    brings to the radius. The wheel stands upright, or is a ball: the point of contact is straight below the hub.
    ``RollingTask(0.1, frame="left_wheel", gain=10.0)``, for each wheel of a robot with a floating or planar
    base, lets its base move as the wheels do.

    Parameters
    ----------
    radius : float
        [m].
    frame : str, optional
        The hub, which turns with the wheel.
    relative_to : str, optional
        The floor, where it is no part of the world.
    normal : array, shape (3,)
        Of the plane, towards the wheel.
    floor : float
        How far the plane is from the origin, along the normal [m].
    gain : float or array, shape (rows,)
        K [1/s]: the rate at which the error of the height decays and, at acceleration order, the slip.
    damping_ratio : float
        The zeta of acceleration order; 1 is critical damping.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level, against those of other tasks joined by ``+``.
    cap : float or array, shape (rows,), optional
        Length to which the error is cut off, in its unit; a far target is approached at K times that.
    deceleration : float, optional
        The deceleration with which it comes to rest at its target [m/s^2], [rad/s^2].
    name : str, optional
        Used in messages, tables and records (default: from the name of the class).

    Raises
    ------
    InvalidInput
        If the radius is not positive, or the normal has no direction; with a robot, if it moves in the plane.

    Examples
    --------
    >>> from tasks import RollingTask, load_robot
    >>> panda = load_robot("panda", lock=["panda_finger_joint1"])
    >>> task = RollingTask(0.1, frame="panda_hand", gain=2.0)  # as if the hand were a wheel
    >>> height = panda.at(panda.home).frame("panda_hand").position[2]
    >>> bool(abs(task.error(panda.at(panda.home), 0.0)[-1] - (0.1 - height)) < 1e-12)
    True
    """

    rows = 3

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        return [("slip 1", "m"), ("slip 2", "m"), ("height", "m")]


class OmniwheelTask(WheelTask):
    """Let a wheel with rollers on its rim roll on a plane: it slips freely where its rollers roll, and only there.

    One row for the slip and one for the height. Rollers of an omniwheel turn about the direction in which the wheel
    drives, and let it go aside; those of a mecanum wheel stand at 45 degrees to it, ``rollers=np.pi / 4`` or
    ``-np.pi / 4``.

    Parameters
    ----------
    radius : float
        [m].
    axle : array, shape (3,)
        The axis of the wheel, in the frame of the hub; by default its y axis.
    rollers : float
        From the direction in which the wheel drives, axle x normal, to the axes of its rollers, about the normal [rad].
    frame : str, optional
        The hub, which turns with the wheel.
    relative_to : str, optional
        The floor, where it is no part of the world.
    normal : array, shape (3,)
        Of the plane, towards the wheel.
    floor : float
        How far the plane is from the origin, along the normal [m].
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
        Used in messages, tables and records (default: from the name of the class).

    Raises
    ------
    InvalidInput
        If the radius is not positive, or a vector has no direction; with a robot, if it moves in the plane. Where the
        axle is upright the tick is INVALID.

    Examples
    --------
    >>> from tasks import OmniwheelTask, load_robot
    >>> panda = load_robot("panda", lock=["panda_finger_joint1"])
    >>> task = OmniwheelTask(0.1, axle=[1.0, 0.0, 0.0], frame="panda_hand", gain=2.0)  # as if the hand were a wheel
    >>> height = panda.at(panda.home).frame("panda_hand").position[2]
    >>> bool(abs(task.error(panda.at(panda.home), 0.0)[-1] - (0.1 - height)) < 1e-12)
    True
    """

    rows = 2

    def __init__(
        self,
        radius: float,
        *,
        axle: ArrayLike = (0.0, 1.0, 0.0),
        rollers: float = 0.0,
        frame: str | None = None,
        relative_to: str | None = None,
        normal: ArrayLike = (0.0, 0.0, 1.0),
        floor: float = 0.0,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.axle, self.rollers = axle, rollers
        super().__init__(
            radius,
            frame=frame,
            relative_to=relative_to,
            normal=normal,
            floor=floor,
            gain=gain,
            damping_ratio=damping_ratio,
            weight=weight,
            cap=cap,
            deceleration=deceleration,
            name=name,
        )

    @number
    def axle(self, value: ArrayLike) -> Array:
        """The axis of the wheel in the frame of the hub: normalised; any length but 0 may be given."""
        return unit(finite(value, f"{self.full_name()}: axle"), f"{self.full_name()}: axle")

    @number
    def rollers(self, value: float) -> float:
        """From the direction in which the wheel drives to the axes of its rollers [rad]."""
        return finite_scalar(value, f"{self.full_name()}: rollers")

    def _wheel(self) -> Array:
        from .kernels import rolling as loops

        wheel = super()._wheel()
        wheel[loops.AXLE : loops.AXLE + 3], wheel[loops.TURNS] = self.axle, 1.0
        wheel[loops.COSINE], wheel[loops.SINE] = cos(self.rollers), sin(self.rollers)
        return wheel

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        return [("slip", "m"), ("height", "m")]
