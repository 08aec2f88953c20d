"""Task: the position of the centre of mass."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.checks import Array
from ..robots.frame import Frame
from ..robots.robot import Robot, RobotState, center_of_mass
from ..targets.trajectories import Trajectory
from .placement import Mask
from .position import PositionTask

if TYPE_CHECKING:
    from ..base.loops import Table
    from ..rows.site import Site


class CenterOfMassTask(PositionTask):
    """Bring the centre of mass to a point, such as one above the feet with the mask ``"xy"``.

    It is that of all links that joints move, without bodies fixed to the world.

    Parameters
    ----------
    target : array, shape (3,), or of one number a coordinate of the mask, or Trajectory
        [m].
    relative_to : str, optional
        A frame of the robot, such as a foot, in place of the world.
    mask : str or sequence of bool, optional
        The coordinates to be controlled.
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
        Used in messages, tables and records (default: "center of mass").

    Examples
    --------
    >>> from tasks import CenterOfMassTask, Controller, load_robot
    >>> panda = load_robot("panda", lock=["panda_finger_joint1"])
    >>> lean = CenterOfMassTask([0.1, 0.0], mask="xy", gain=2.0)
    >>> Controller(panda, lean)(panda.home).v.shape
    (7,)
    """

    def __init__(
        self,
        target: ArrayLike | Trajectory,
        *,
        relative_to: str | None = None,
        mask: Mask | None = None,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        super().__init__(
            target,
            relative_to=relative_to,
            mask=mask,
            gain=gain,
            damping_ratio=damping_ratio,
            weight=weight,
            cap=cap,
            deceleration=deceleration,
            name="center of mass" if name is None else name,
        )

    def _itself(self, state: RobotState) -> Frame:
        point = center_of_mass(state)
        assert point is not None  # checked
        return point

    def block(self, site: Site) -> Array:
        return site.center_of_mass(self.relative_to)

    def reach(self, robot: Robot) -> None:
        """Every joint may carry a mass."""

    def motion_curvature(self, site: Site) -> Table | None:
        from ..rows.curvature import center_of_mass_curvature

        return center_of_mass_curvature(site.shared, self.relative_to)

    def reading(self) -> None:
        """No joint carries the centre of mass as it carries a frame."""

    def check_frames(self, robot: Robot) -> bool:
        state = self.at_rest(robot)
        point = center_of_mass(state)
        if point is None:
            raise InvalidInput(f"{self.full_name()}: {robot!r} does not tell its centre of mass")
        if not np.isfinite(point.position).all():
            raise InvalidInput(f"{self.full_name()}: nothing that {robot!r} moves has a mass; it has no centre")
        self.check_names(robot)
        return point.rotation.ndim == 1
