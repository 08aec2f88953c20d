r"""The base class of criteria that follow a gradient: a scalar function of q, in the null space of the tasks above.

Liegeois (1977) puts the gradient of a scalar H(q) into the null space of a task. As a level below the task that is

.. math::

    \text{velocity order:}\quad & \dot q = \pm K \nabla H \\
    \text{acceleration order:}\quad & \ddot q = \pm K^2 \nabla H - 2 K \dot q,

plus where H is to rise. Below a task with :math:`N = I - J^\# J` the joints move by
:math:`\pm K N \nabla H`, along which :math:`\dot H = \pm K \lVert N \nabla H \rVert^2`: H can only improve, and comes
to rest where the gradient lies in the row space of J.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp.checks import of_type

from ..base.checks import Array, fill, positive, positive_scalar
from ..base.live import number
from ..robots.robot import Robot, base, integration
from ..rows.part import Part, Tick

if TYPE_CHECKING:
    from ..base.loops import Entry
    from ..rows.plan import Plan
    from ..rows.site import Site

#: Of the central differences [rad, m]: truncation and round-off are both about 1e-10 of H.
STEP = 1e-5


class GradientTask(Part):
    """Ascend a scalar function of the configuration, in every joint but a floating base; leaves no null space below.

    A criterion of your own needs `value`, and may give its `gradient`:

    >>> class Stretched(GradientTask):
    ...     def value(self, robot, q, t=0.0):
    ...         return float(robot.at(q, np.zeros(robot.nv)).frame().position @ [1.0, 0.0])
    >>> Stretched(gain=2.0)
    Stretched(gain=2)

    Parameters
    ----------
    gain : float
        K [1/s], against H in its own unit.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level.
    name : str, optional
        Default: the name of the class.

    Raises
    ------
    InvalidInput
        If a gain or a weight is not positive or larger than 1e15.
    """

    plain = True
    says: ClassVar[tuple[str, ...]] = ("value", "values", "gradient", "variables", "write")
    #: Whether the value is a cost, which falls.
    descend: ClassVar[bool] = False
    rows = None

    def __init__(self, *, gain: float, weight: ArrayLike = 1.0, name: str | None = None) -> None:
        default = type(self).__name__.removesuffix("Task").lower()
        self.name = default if name is None else of_type(name, str, "name of a task")
        self.gain, self.weight = gain, weight

    @number
    def gain(self, value: float) -> float:
        """K [1/s]."""
        return positive_scalar(value, f"{self.full_name()}: gain", unit="1/s")

    def decay_rate(self) -> float:
        """K: its law slows a speed at the rate 2 K."""
        return float(self.gain)

    @number
    def weight(self, value: ArrayLike) -> Array:
        """Weight of the rows inside their level, shape () or (rows,)."""
        return positive(value, f"{self.full_name()}: weight")

    def size(self, robot: Robot) -> int:
        return len(self.variables(robot))

    def variables(self, robot: Robot) -> NDArray[np.intp]:
        return np.arange(base(robot), robot.nv)

    def value(self, robot: Robot, q: Array, t: float = 0.0) -> float:
        """H at the configuration q and time t [s]; NaN if it is not finite, for the solver to report."""
        raise NotImplementedError(f"{type(self).__name__} must define value(robot, q, t)")

    def values(self, robot: Robot, q: Array, t: float = 0.0) -> Array:
        """H at several configurations, shape (k, nq): one by one, unless a criterion has a faster way."""
        return np.array([self.value(robot, one, t) for one in q])

    def gradient(self, robot: Robot, q: Array, t: float = 0.0) -> Array:
        """dH/dq [unit of H per rad, or per m], shape (nv,); 0 where there is no row.

        By central differences along ``robot.integrate``.
        """
        own = self.variables(robot)
        steps = STEP * np.eye(robot.nv)[own]
        integrate = integration(robot)
        around = np.array([integrate(q, step) for step in (*steps, *-steps)])
        ahead, behind = np.reshape(self.values(robot, around, t), (2, -1))
        slope = np.zeros(robot.nv)
        slope[own] = (ahead - behind) / (2.0 * STEP)
        return slope

    def python_plan(self, site: Site) -> Plan:
        """Its gradient by the methods above; the law is that of all gradients."""
        if type(self).write is not Part.write:
            return super().python_plan(site)
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.joints import write_gradient

        slope, what = np.zeros(site.shared.n), f"{self.full_name()}: gradient"

        def measure(tick: Tick) -> None:
            fill(slope, self.gradient(tick.robot, tick.state.q, tick.t), what)

        call = Call(write_gradient, *self.law(site), slope)
        return Plan((call,), python=measure, why=f"{type(self).__name__} is measured in Python")

    def law(self, site: Site) -> tuple[Entry, ...]:
        """The first arguments of every loop of a gradient; see :mod:`tasks.criteria.kernels.joints`."""
        from ..rows.kernels.law import ORDERS

        own, shared = self.variables(site.shared.robot), site.shared
        numbers = np.array([self.gain, -1.0 if self.descend else 1.0])
        order = ORDERS.index(shared.order)
        return len(own), own.astype(np.int64), numbers, shared.n, shared.v, order, site.lower, site.upper

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join([*self._shown(), f'gain={self.gain:.4g}'])})"

    def _shown(self) -> list[str]:
        """The arguments in the repr before the gain."""
        return []
