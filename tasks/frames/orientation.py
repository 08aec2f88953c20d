"""Task: the orientation of a frame."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.live import number
from ..targets.trajectories import Trajectory
from ..targets.turns import AboutZ, RotationTrajectory, as_rotation
from .placement import Mask, PlacementTask, Reference, chosen
from .position import AXES


class OrientationTask(PlacementTask):
    """Turn a frame to a rotation, the shortest way; or by one angle about z: the second task of the thesis, Eq. 4.3.

    The angle of a planar arm is the plain sum of its joint angles, unwrapped: a target 2 pi away is a full turn away.

    Parameters
    ----------
    target : array, shape (3, 3), or RotationTrajectory; or float, or Trajectory of one number
        The rotation, its columns the axes that the frame is to have; or the angle about z [rad], counter-clockwise,
        which leaves the other axes free.
    frame : str, optional
        The name of a frame of the robot (default: its tip).
    relative_to : str, optional
        A frame of the robot in place of the world: all coordinates and motions are relative to it.
    reference : {"world", "local", "local_world_aligned"}
        The axes of the rows: of the world (or of `relative_to`), or of the frame itself, which turn with it.
        "local_world_aligned" is Pinocchio's name for the former.
    mask : str or sequence of bool, optional
        The axes about which to turn, as in ``"xy"``; see :class:`tasks.AxisTask` for a tool that may spin.
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
        Used in messages, tables and records (default: "orientation").

    Raises
    ------
    InvalidInput
        If the target is no rotation, or a mask stands beside one angle; and, with a robot, if it has no such frame.

    Examples
    --------
    >>> from tasks import Controller, OrientationTask, PlanarArm
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> Controller(arm, OrientationTask(0.0, gain=2.0))(q).v.round(3)
    array([0.6, 0.6, 0.6])
    """

    def __init__(
        self,
        target: ArrayLike | RotationTrajectory | Trajectory,
        *,
        frame: str | None = None,
        relative_to: str | None = None,
        mask: Mask | None = None,
        reference: Reference = "world",
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self._about_z = isinstance(as_rotation(target, self.full_name()), AboutZ)
        if self._about_z and mask is not None:
            raise InvalidInput(f"{self.full_name()}: one angle turns about z; a mask needs a rotation of shape (3, 3)")
        super().__init__(
            mask=(2,) if self._about_z else chosen(mask, AXES, self.full_name()),
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
        self.target = target

    @number
    def target(self, value: ArrayLike | RotationTrajectory | Trajectory) -> RotationTrajectory | Trajectory:
        """The rotation, or the angle about z [rad], that the frame is to have; of the kind that it began with."""
        rotation = as_rotation(value, self.full_name())
        angle = isinstance(rotation, AboutZ)
        if angle != self._about_z:
            kinds = ("a rotation of shape (3, 3)", "one angle about z")
            raise InvalidInput(
                f"{self.full_name()}: target is {kinds[angle]}; it must be {kinds[not angle]}, as it was made with one"
            )
        return rotation.angle if isinstance(rotation, AboutZ) else rotation

    @property
    def rotation(self) -> RotationTrajectory:
        """The target as a function of time that gives rotations."""
        target: Any = self.target
        return AboutZ(target) if self._about_z else target

    @rotation.setter
    def rotation(self, value: ArrayLike | RotationTrajectory | Trajectory) -> None:
        self.target = value

    def _shown(self) -> list[str]:
        mask = "".join(AXES[i] for i in self.mask)
        shown = isinstance(self.rotation, AboutZ) or mask == "xyz"
        return [repr(self.target), *super()._shown(), *([] if shown else [f"mask={mask!r}"])]
