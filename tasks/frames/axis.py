r"""Task: the direction of one axis of a frame; the rotation about that axis stays free.

With the axis a and the wanted direction d, unit vectors in the world, the shortest turn from a to d is
:math:`\vartheta` about :math:`a \times d`. It has no component along a: two rows, U, perpendicular to the axis in the
frame describe it completely,

.. math:: e = U R^T \vartheta \frac{a \times d}{\lVert a \times d \rVert}, \qquad J = U R^T J_\omega.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.checks import Array, finite
from ..base.live import number
from ..base.rotations import perpendicular
from ..robots.robot import Robot
from ..rows.loop_task import LoopTask
from ..targets.trajectories import Trajectory, as_trajectory
from .frame_task import FrameTask, Reading

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class PointingTask(FrameTask, LoopTask):
    """Base of the tasks that point an axis of a frame somewhere: two rows, and the third rotation stays free."""

    rows = 2
    spatial: ClassVar[bool] = True

    @number
    def axis(self, value: ArrayLike) -> Array:
        """The axis, in the frame: normalised; any length but 0 may be given."""
        return unit(finite(value, f"{self.full_name()}: axis"), f"{self.full_name()}: axis")

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """The direction or the point to point at: three coordinates, or a trajectory of them."""
        return as_trajectory(value, 3, self.full_name())

    @property
    def _across(self) -> Array:
        """The rows U."""
        return perpendicular(self.axis)

    def _pointing(self, site: Site, kernel: Any, *, at_point: bool) -> Plan:
        """One loop for the rows, from the axis and its target, and one for their curvature."""
        from ..base.loops import Call
        from ..rows.curvature import curvature_call
        from ..rows.plan import Plan
        from .kernels import curvature as kernels
        from .kernels.directions import work_size

        target, axis, law = np.zeros((3, 3)), np.vstack([self.axis, self._across]), site.law(self)
        moves = site.keep_up(self, "target", *target)
        call = Call(kernel, law, self.block(site), target, axis, np.zeros(work_size(site.shared.n)))
        curvature = curvature_call(
            site,
            kernels.direction_curvature,
            self.motion_curvature(site),
            kernels.WORK_SIZE,
            law,
            target,
            axis,
            at_point,
        )
        return Plan((call,), moves, curvature=curvature)

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        return [("across 1", "rad"), ("across 2", "rad")]

    def _shown(self) -> list[str]:
        return [repr(self.target), f"axis={self.axis.tolist()}", *super()._shown()]


class AxisTask(PointingTask):
    """Point an axis of a frame in a direction: two rows, and the third rotation stays free.

    Parameters
    ----------
    direction : array, shape (3,), or Trajectory
        d, in the world or in `relative_to`, of any length but 0.
    axis : array, shape (3,)
        a, in the frame; by default its z axis.
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
        Used in messages, tables and records (default: "axis").

    Raises
    ------
    InvalidInput
        If a direction is zero or not finite.

    Examples
    --------
    >>> from tasks import AxisTask, Controller, load_robot
    >>> panda = load_robot("panda", lock=["panda_finger_joint1"])
    >>> down = AxisTask([0.0, 0.0, -1.0], axis=[0.0, 0.0, 1.0], gain=2.0)  # the hand's z axis
    >>> Controller(panda, down)(panda.home).solution.levels[0].rank
    2
    """

    def __init__(
        self,
        direction: ArrayLike | Trajectory,
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
        self.target, self.axis = direction, axis
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
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """The direction d, of any length but 0, or a trajectory of it."""
        trajectory = as_trajectory(value, 3, self.full_name())
        unit(trajectory(0.0)[0], f"{self.full_name()}: direction")
        return trajectory

    @property
    def direction(self) -> Trajectory:
        """The target by its other name: the direction d."""
        return self.target

    @direction.setter
    def direction(self, value: ArrayLike | Trajectory) -> None:
        self.target = value

    def plan(self, site: Site) -> Plan:
        """One loop; the direction is written every tick where it moves."""
        from .kernels.directions import write_axis

        return self._pointing(site, write_axis, at_point=False)

    def reading(self) -> Reading:
        from .kernels.placement import LOCAL

        return Reading(LOCAL, np.hstack([np.zeros((2, 3)), self._across]))

    def desired_velocity(self, t: float) -> Array:
        d, velocity, _ = self.target(t)
        return np.concatenate([np.zeros(3), np.cross(d, velocity) / (d @ d)])


def unit(vector: Array, what: str) -> Array:
    """`vector`, made of length one.

    Raises
    ------
    InvalidInput
        If it is not three numbers, or has no direction.
    """
    if vector.shape != (3,):
        raise InvalidInput(f"{what} has shape {vector.shape}; it must be (3,)")
    norm = float(np.linalg.norm(vector))
    if not 0.0 < norm < np.inf:
        raise InvalidInput(f"{what} = {vector.tolist()} has no direction; its length must be positive")
    return vector / norm
