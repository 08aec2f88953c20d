r"""Secondary criterion: distance from the joint limits, optimised in the null space of the tasks above.

Liegeois (1977): the mean squared distance of the n joints that have a range from its middle, in halves of it,

.. math::

    H = \frac1n \sum_i \Bigl(\frac{q_i - m_i}{h_i}\Bigr)^2, \qquad
    m_i = \tfrac12 (\bar q_i + \underline q_i), \quad h_i = \tfrac12 (\bar q_i - \underline q_i), \qquad
    \frac{\partial H}{\partial q_i} = \frac{2}{n} \frac{q_i - m_i}{h_i^2},

is 0 in the middle and 1 where all joints stand at an end. It is not a limit: the task above may still move a joint
beyond its range, unless :class:`~tasks.JointLimits` stand on top.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from hqp import InvalidInput

from ..base.checks import Array
from ..robots.robot import Robot, check_positioned, joint_positions, limit_of
from ..rows.part import Order
from .gradient import GradientTask

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class JointCentringTask(GradientTask):
    """Bring joints towards the middle of their ranges; those without two finite ends, or held, are left alone.

    Parameters
    ----------
    gain : float
        K [1/s], against H, which has no unit: joint i alone nears its middle at the rate ``2 K / (n h_i^2)`` [1/s].
    weight : float or array, shape (rows,)
        Weight of the rows inside their level, one a joint with a range.
    name : str, optional
        Used in messages, tables and records.

    Raises
    ------
    InvalidInput
        If a gain or a weight is not positive or larger than 1e15, no joint of the robot has a range, or one that
        has is without a single position.

    Examples
    --------
    >>> from tasks import Controller, JointCentringTask, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5], position_limit=(-2.0, 2.0))
    >>> stack = PositionTask([1.0, 0.2], gain=2.0) >> JointCentringTask(gain=1.0)
    >>> Controller(arm, stack)([1.1, -1.3, -0.7]).v.round(3)
    array([ 0.519,  0.05 , -0.263])
    """

    descend: ClassVar[bool] = True
    reads_limits: ClassVar[bool] = True

    def variables(self, robot: Robot) -> NDArray[np.intp]:
        ranges = limit_of(robot, "position")
        if ranges is None:
            return np.zeros(0, dtype=np.intp)
        return np.flatnonzero(np.isfinite(ranges).all(axis=0) & (ranges[0] < ranges[1]))

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        own = self.variables(robot)
        if not len(own):
            raise InvalidInput(f"{self.full_name()}: takes a robot with position limits, and {robot!r} has none")
        check_positioned(robot, own, f"{self.full_name()}: joint")

    def value(self, robot: Robot, q: Array, t: float = 0.0) -> float:
        """H, between 0 and 1 inside the ranges."""
        low, high = self._ends(robot)
        here = joint_positions(robot.at(q, np.zeros(robot.nv)))[self.variables(robot)]
        return float(np.mean(((2.0 * here - high - low) / (high - low)) ** 2))

    def gradient(self, robot: Robot, q: Array, t: float = 0.0) -> Array:
        """dH/dq [1/rad, 1/m], shape (nv,), in closed form."""
        from hqp.kernels.compile import plain

        from .kernels.joints import centring

        own = self.variables(robot)
        positions, slope = joint_positions(robot.at(q, np.zeros(robot.nv))), np.zeros(robot.nv)
        loop = plain(centring)  # type: ignore[no-untyped-call]
        loop(len(own), own, own, positions, self._ends(robot).ravel(), slope)
        return slope

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.joints import write_centring

        shared, own = site.shared, self.variables(site.shared.robot)
        places, ends = shared.position_indices[own].astype(np.int64), self._ends(shared.robot)
        slope = np.zeros(shared.n)
        told = len(shared.positions), shared.positions, places, ends, slope
        return Plan((Call(write_centring, *self.law(site), *told),), linear=True)

    def _ends(self, robot: Robot) -> Array:
        """Lowest and highest position of each row, shape (2, rows)."""
        ranges = limit_of(robot, "position")
        assert ranges is not None  # checked
        return ranges[:, self.variables(robot)].copy()
