r"""Secondary criteria: the least motion that the levels above permit, by joint or by kinetic energy.

Whitney (1969) takes, of the motions that meet a task :math:`J x = h`, the one that is least in a norm of weights W,

.. math:: \min_x \lVert x \rVert_W^2 = x^T W x \quad\Rightarrow\quad x = W^{-1} J^T (J W^{-1} J^T)^{-1} h,

and with the mass matrix, :math:`W = M(q)`, the one of least kinetic energy :math:`\tfrac12 \dot q^T M \dot q`. With
:math:`W = L L^T` it is the last level :math:`L^T x = 0`, as in :func:`hqp.nearest`.

At acceleration order that would not change speeds in the null space: joints once set in motion would never
stop. There the rows are :math:`L^T (\ddot q + K \dot q) = 0`, which brake it at the rate K.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type

from ..base.checks import Array, positive, positive_scalar
from ..base.live import number
from ..robots.robot import Robot, check_mass_matrix, joint_names
from ..rows.part import Order, Part, Tick
from .dynamics import check_definite, root

if TYPE_CHECKING:
    from ..base.loops import Entry
    from ..rows.plan import Plan
    from ..rows.site import Site


class _LeastMotion(Part):
    """Rows ``L^T x = -L^T K v``, K at acceleration order only."""

    rows = None
    default: ClassVar[str]

    def __init__(self, gain: float | None, name: str | None) -> None:
        self.name = self.default if name is None else of_type(name, str, "name of a task")
        self.gain = gain

    @number
    def gain(self, value: float | None) -> float | None:
        """K [1/s], the rate at which motion in the null space is braked; None at velocity order."""
        return None if value is None else positive_scalar(value, f"{self.full_name()}: gain", unit="1/s")

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if order == "acceleration" and self.gain is None:
            raise InvalidInput(
                f"{self.full_name()}: gain = None; at acceleration order it must be the rate [1/s] at which motion is"
                " braked that nothing above asks for"
            )

    def decay_rate(self) -> float:
        """K / 2: its law slows a speed at the rate K."""
        return 0.5 * (self.gain or 0.0)

    def _wanted(self, tick: Tick) -> Array:
        """The x that would be best, shape (nv,)."""
        if tick.order != "acceleration" or self.gain is None:
            return np.zeros(tick.robot.nv)
        return -self.gain * tick.state.v

    def _law(self, site: Site) -> tuple[Entry, ...]:
        """The first arguments of its loops; see :mod:`tasks.criteria.kernels.joints`."""
        shared = site.shared
        brakes = shared.order == "acceleration" and self.gain is not None
        braking = np.array([self.gain if brakes else 0.0], dtype=np.float64)
        return shared.n, braking, shared.v, site.lower, site.upper

    def _options(self) -> list[str]:
        """The gain in the repr."""
        return [] if self.gain is None else [f"gain={self.gain:.4g}"]


class MinimumMotionTask(_LeastMotion):
    """Move each joint as little as possible: least ``sum weight_i^2 x_i^2``. Leaves no null space below.

    For least motion around a posture, use ``PostureTask(posture, gain=K, weight=...)``.

    Parameters
    ----------
    weight : float or array, shape (nv,)
        The cost of moving each joint, [s/rad] or [s/m] if the sum is to have no unit: the square root of W.
    gain : float, optional
        K [1/s], needed at acceleration order.
    name : str, optional

    Raises
    ------
    InvalidInput
        If a weight or the gain is not positive or larger than 1e15, or there is no gain at acceleration order.

    Examples
    --------
    >>> from tasks import Controller, MinimumMotionTask, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> stack = PositionTask([1.0, 0.2], gain=2.0) >> MinimumMotionTask([3.0, 1.0, 1.0])
    >>> Controller(arm, stack)(q).v.round(3)
    array([ 0.356,  0.442, -0.736])
    """

    plain = True
    default = "minimum motion"

    def __init__(self, weight: ArrayLike = 1.0, *, gain: float | None = None, name: str | None = None) -> None:
        super().__init__(gain, name)
        self.weight = weight

    @number
    def weight(self, value: ArrayLike) -> Array:
        """The cost of moving each joint, shape () or (nv,)."""
        return positive(value, f"{self.full_name()}: weight")

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.joints import write_least_motion

        return Plan((Call(write_least_motion, *self._law(site)),), linear=True)

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        lower[:] = upper[:] = self._wanted(tick)  # the rows of A are those of the identity from the start

    def __repr__(self) -> str:
        return f"MinimumMotionTask({', '.join([str(self.weight.tolist()), *self._options()])})"


class KineticEnergyTask(_LeastMotion):
    """Move with as little kinetic energy as possible: rows ``L^T x``, M = L L^T. Leaves no null space below.

    Parameters
    ----------
    weight : float
        Of the rows inside their level; they are in [J^(1/2)].
    gain : float, optional
        K [1/s], needed at acceleration order.
    name : str, optional

    Raises
    ------
    InvalidInput
        If the weight or the gain is not positive or larger than 1e15, there is no gain at acceleration order, or the
        robot has no ``mass_matrix(q)`` or one that is not positive definite.

    Examples
    --------
    >>> from tasks import Controller, KineticEnergyTask, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5], masses=[1.0, 1.0, 1.0])
    >>> stack = PositionTask([1.0, 0.2], gain=2.0) >> KineticEnergyTask()
    >>> Controller(arm, stack)([1.1, -1.3, -0.7]).v.round(3)
    array([ 0.45 ,  0.215, -0.463])
    """

    default = "kinetic energy"

    def __init__(self, *, weight: float = 1.0, gain: float | None = None, name: str | None = None) -> None:
        super().__init__(gain, name)
        self.weight = weight

    @number
    def weight(self, value: float) -> Array:
        """Weight of all rows inside their level."""
        return np.asarray(positive_scalar(value, f"{self.full_name()}: weight"))

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.joints import write_kinetic_energy

        assert site.A is not None  # its rows are not plain
        return Plan((Call(write_kinetic_energy, *self._law(site), site.shared.blocks.mass_matrix(), site.A),))

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        super().check(robot, order, dt)
        check_mass_matrix(robot, self.full_name())
        check_definite(robot, self.full_name())

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return [Label(self.name, name) for name in joint_names(robot)]

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        assert A is not None  # its rows are not plain
        A[:] = root(tick.robot, tick.state.q)
        lower[:] = upper[:] = A @ self._wanted(tick)

    def __repr__(self) -> str:
        return f"KineticEnergyTask({', '.join(self._options())})"
