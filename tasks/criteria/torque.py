r"""Secondary criterion: the least joint torque that the levels above permit, at acceleration order.

Hollerbach and Suh (1987) minimise the torques of the same instant in the null space of a task,

.. math::

    \tau = M(q)\,\ddot q + b(q, v), \qquad
    \min_{\ddot q} \sum_i \Bigl(\frac{\tau_i - m_i}{h_i}\Bigr)^2,

with the bias b (Coriolis, centripetal, gravity) and, where the actuators have a range, its middle m and half h. As
a level these are rows :math:`M \ddot q = m - b` of weights 1/h. Below a task :math:`J \ddot q = h_1` the answer is

.. math:: \ddot q = \ddot q_0 + W J^T (J W J^T)^{-1} (h_1 - J \ddot q_0), \qquad
    \ddot q_0 = M^{-1} (m - b), \quad W = (M D^2 M)^{-1}, \quad D = \operatorname{diag}(1/h).

The best torque at every instant is not the best for the motion: torques are saved by letting joints swing, and their
speed in the null space later needs centripetal torques that grow with its square. On long motions joint speeds build
up, and torques *rise* far above those of least accelerations, which is what Hollerbach and Suh
found. The remedy is a share of least motion on the same level (a balance as of Ma 1996), with a velocity term:

.. math:: \lVert M \ddot q + b \rVert^2 + \lambda^2 \lVert \ddot q + K v \rVert^2,

``MinimumTorqueTask() + MinimumMotionTask(weight, gain=K)``, its weight lambda [kg m^2] of the size of M. See
``examples/09_torque_minimisation.py``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type
from hqp.errors import brief

from ..base.checks import Array, finite, pair, per_row, positive
from ..base.live import number
from ..robots.robot import Robot, check_dynamics, joint_names, joint_units
from ..rows.part import Order, Part, Tick
from .dynamics import check_fixed

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class MinimumTorqueTask(Part):
    """Minimise the joint torques, or their distance to the middle of their range; leaves no null space to levels below.

    Alone it is unstable on long motions: join it to a :class:`~tasks.MinimumMotionTask` by ``+``.

    Parameters
    ----------
    torque_range : pair of float or array, shape (nv,), optional
        Lowest and highest joint torques [N m], or forces [N]: the torques are brought to its middle, each weighed by
        the inverse of half its range (default: to zero, with equal weights).
    weight : float or array, shape (nv,)
        Weight of the rows inside their level, besides.
    name : str, optional

    Raises
    ------
    InvalidInput
        If a weight is not positive or larger than 1e15, the range is no pair of finite numbers, the lowest
        below the highest, the order is not acceleration, or the robot has no ``mass_matrix(q)`` or
        ``bias(q, v)``, or a floating base.

    Examples
    --------
    >>> from tasks import Controller, MinimumTorqueTask, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5], masses=[1.0, 1.0, 1.0])
    >>> stack = PositionTask([1.0, 0.2], gain=5.0) >> MinimumTorqueTask()
    >>> Controller(arm, stack, order="torque", dt=0.01)([1.1, -1.3, -0.7], [0.0, 0.0, 0.0]).tau.round(3)
    array([8.776, 2.336, 0.292])
    """

    rows = None

    def __init__(
        self,
        *,
        torque_range: tuple[ArrayLike, ArrayLike] | None = None,
        weight: ArrayLike = 1.0,
        name: str | None = None,
    ) -> None:
        self.name = "minimum torque" if name is None else of_type(name, str, "name of a task")
        self.weight = weight
        self.torque_range = torque_range
        self._renew()

    @number
    def weight(self, value: ArrayLike) -> Array:
        """Weight of the rows inside their level, shape () or (nv,), besides the inverse of half the range."""
        return positive(value, f"{self.full_name()}: weight")

    @number
    def torque_range(self, value: tuple[ArrayLike, ArrayLike] | None) -> tuple[Array, Array] | None:
        """Lowest and highest joint torques [N m], forces [N], or None."""
        if value is None:
            return None
        what = f"{self.full_name()}: torque range"
        low, high = (finite(end, what) for end in pair(value, what, "lowest and highest [N m]"))
        return low, high

    def _renew(self) -> None:
        self._middle, self._half = np.zeros(()), np.ones(())
        if self.torque_range is None:
            return
        what, (low, high) = f"{self.full_name()}: torque range", self.torque_range
        shapes = {array.shape for array in (low, high, self.weight)} - {()}
        if len(shapes) > 1:
            raise InvalidInput(f"{what} and weight have shapes {', '.join(map(str, sorted(shapes)))}; they must agree")
        if not np.all(low < high):
            raise InvalidInput(f"{what} from {low.tolist()} to {high.tolist()}; the lowest must be below the highest")
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)

    def weights(self, robot: Robot) -> Array:
        return per_row(self.weight / self._half, robot.nv, f"{self.full_name()}: weight", "joint")

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if order != "acceleration":
            raise InvalidInput(
                f"{self.full_name()}: order = {order!r}; torques belong to accelerations: 'acceleration'"
            )
        check_dynamics(robot, self.full_name())
        check_fixed(robot, self.full_name())
        per_row(self._middle, robot.nv, f"{self.full_name()}: torque range", "joint")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        rows = zip(joint_names(robot), joint_units(robot), strict=True)
        return [Label(self.name, name, "N" if unit == "m" else "N m") for name, unit in rows]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.joints import write_minimum_torque

        assert site.A is not None  # its rows are not plain
        n, blocks = site.shared.n, site.shared.blocks
        middle = np.ascontiguousarray(np.broadcast_to(self._middle, n))
        law = n, np.zeros(1), site.shared.v, site.lower, site.upper
        return Plan((Call(write_minimum_torque, *law, blocks.mass_matrix(), site.A, blocks.bias(), middle),))

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        assert A is not None  # its rows are not plain
        robot, state = tick.robot, tick.state
        A[:] = robot.mass_matrix(state.q)  # type: ignore[attr-defined]
        lower[:] = self._middle - robot.bias(state.q, state.v)  # type: ignore[attr-defined]
        upper[:] = lower

    def __repr__(self) -> str:
        ends = None if self.torque_range is None else tuple(end.tolist() for end in self.torque_range)
        shown = "" if ends is None else f"torque_range={brief(ends)}"
        return f"MinimumTorqueTask({shown})"
