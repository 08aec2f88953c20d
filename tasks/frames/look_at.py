r"""Task: an axis of a frame points at a point, for a camera that follows it or a hand that faces its grasp.

With the point c at the distance :math:`\rho` in the direction :math:`d = (c - p) / \rho`, which turns as the frame
moves, the axis turns against it by

.. math:: \omega - d \times \dot d = \omega + d \times u / \rho, \qquad u = \dot p - \dot c,

whose derivative is :math:`\dot\omega + d \times \dot u / \rho + 2 (d \cdot u) (d \times u) / \rho^2`. The rest is
:mod:`tasks.frames.axis`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ..targets.trajectories import Trajectory
from .axis import PointingTask

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class LookAtTask(PointingTask):
    """Point an axis of a frame at a point: two rows, and the third rotation stays free.

    Parameters
    ----------
    point : array, shape (3,), or Trajectory
        c [m], in the world or in `relative_to`.
    axis : array, shape (3,)
        In the frame; by default its z axis.
    frame : str, optional
        The name of a frame of the robot (default: its tip).
    relative_to : str, optional
        A frame of the robot in place of the world: all coordinates and motions are relative to it.
    gain : float or array, shape (2,)
        K [1/s]: the rate at which the error decays.
    damping_ratio : float
        The zeta of acceleration order; 1 is critical damping.
    weight : float or array, shape (2,)
        Weight of the rows inside their level, against those of other tasks joined by ``+``.
    cap : float or array, shape (rows,), optional
        Length to which the error is cut off, in its unit; a far target is approached at K times that.
    deceleration : float, optional
        The deceleration with which it comes to rest at its target [m/s^2], [rad/s^2].
    name : str, optional
        Used in messages, tables and records (default: "lookat").

    Raises
    ------
    InvalidInput
        If the axis has no direction.

    Examples
    --------
    >>> from tasks import Controller, LookAtTask, load_robot
    >>> panda = load_robot("panda", lock=["panda_finger_joint1"])
    >>> look = LookAtTask([1.0, 0.5, 0.2], gain=2.0)  # with the hand's z axis
    >>> Controller(panda, look)(panda.home).solution.levels[0].rank
    2
    """

    def __init__(
        self,
        point: ArrayLike | Trajectory,
        *,
        axis: ArrayLike = (0.0, 0.0, 1.0),
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
        self.target, self.axis = point, axis
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

    @property
    def point(self) -> Trajectory:
        """The point to look at: the target by its other name."""
        return self.target

    @point.setter
    def point(self, value: ArrayLike | Trajectory) -> None:
        self.target = value

    def plan(self, site: Site) -> Plan:
        """One loop; the point is written every tick where it moves."""
        from .kernels.directions import write_sight

        return self._pointing(site, write_sight, at_point=True)
