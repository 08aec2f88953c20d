"""Task: the signed distance of a frame from a plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import Array, finite
from ..base.live import number
from ..robots.robot import Robot
from ..rows.loop_task import LoopTask
from ..targets.trajectories import Trajectory, as_trajectory
from .axis import unit
from .frame_task import FrameTask

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class PlaneTask(FrameTask, LoopTask):
    """Bring the origin of a frame to a distance from a plane: one row, n . p.

    ``AtLeast(PlaneTask([0, 0, 1], 0.02, gain=5.0))`` keeps the tip 2 cm above the floor.

    Parameters
    ----------
    normal : array, shape (3,)
        n, in the world or in `relative_to`, of any length but 0: it points to where distances are positive.
    distance : float or Trajectory
        From the plane through the origin with this normal [m].
    frame : str, optional
        The name of a frame of the robot (default: its tip).
    relative_to : str, optional
        A frame of the robot in place of the world: all coordinates and motions are relative to it.
    gain : float
        K [1/s]: the rate at which the error decays.
    damping_ratio : float
        The zeta of acceleration order; 1 is critical damping.
    weight : float
        Weight of the rows inside their level, against those of other tasks joined by ``+``.
    cap : float or array, shape (rows,), optional
        Length to which the error is cut off, in its unit; a far target is approached at K times that.
    deceleration : float, optional
        The deceleration with which it comes to rest at its target [m/s^2], [rad/s^2].
    name : str, optional
        Used in messages, tables and records (default: "plane").

    Raises
    ------
    InvalidInput
        If the normal has no direction, or the distance is not finite.

    Examples
    --------
    >>> from tasks import Controller, PlanarArm, PlaneTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> Controller(arm, PlaneTask([0.0, 1.0, 0.0], 0.3, gain=2.0))(q).v.round(3)
    array([0.396, 0.308, 0.12 ])
    """

    rows = 1

    def __init__(
        self,
        normal: ArrayLike,
        distance: ArrayLike | Trajectory,
        *,
        frame: str | None = None,
        relative_to: str | None = None,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.normal, self.target = normal, distance
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
    def normal(self, value: ArrayLike) -> Array:
        """n: normalised; any length but 0 may be given."""
        return unit(finite(value, f"{self.full_name()}: normal"), f"{self.full_name()}: normal")

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """The distance from the plane [m], or a trajectory of it."""
        return as_trajectory(value, 1, self.full_name())

    @property
    def distance(self) -> Trajectory:
        """The target by its other name: the distance from the plane [m]."""
        return self.target

    @distance.setter
    def distance(self, value: ArrayLike | Trajectory) -> None:
        self.target = value

    def feedforward(self, t: float) -> tuple[Array, Array]:
        _, velocity, acceleration = self.target(t)
        return velocity, acceleration

    def plan(self, site: Site) -> Plan:
        """One loop; the distance is written every tick where it moves."""
        from ..base.loops import Call
        from ..rows.curvature import curvature_call
        from ..rows.plan import Plan
        from .kernels import curvature as kernels
        from .kernels.directions import write_plane

        target = np.zeros((3, 1))
        moves = site.keep_up(self, "target", *target)
        call = Call(write_plane, site.law(self), self.block(site), target, self.normal)
        curvature = curvature_call(
            site, kernels.plane_curvature, self.motion_curvature(site), kernels.WORK_SIZE, self.normal
        )
        return Plan((call,), moves, curvature=curvature)

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        return [("distance", "m")]

    def _shown(self) -> list[str]:
        return [str(self.normal.tolist()), repr(self.target), *super()._shown()]
