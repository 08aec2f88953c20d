"""How fast the joints may turn."""

from __future__ import annotations

from typing import ClassVar

from .._checks import Array
from ..part import Tick
from ..robots.robot import Quantity
from .limit import SymmetricLimit


class JointVelocityLimit(SymmetricLimit):
    r"""No joint turns faster than its limit [rad/s].

    Velocity order: :math:`-v_{max} \le x \le v_{max}`. Acceleration order:
    :math:`(-v_{max} - v)/dt \le a \le (v_{max} - v)/dt`, so that the *next* velocity ``v + a dt``
    keeps the limit.

    Parameters
    ----------
    limit : float or array, shape (nv,), optional
        [rad/s], [m/s]; None for the robot's own. 0 holds a joint.
    name : str, optional
    """

    quantity: ClassVar[Quantity] = "velocity"
    zero_holds: ClassVar[bool] = True
    unit: ClassVar[str] = "rad/s"

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        limit = self.largest(tick.robot)
        if tick.order == "velocity":
            lower[:], upper[:] = -limit, limit
        else:
            assert tick.dt is not None  # checked before the first tick
            lower[:] = (-limit - tick.state.v) / tick.dt
            upper[:] = (limit - tick.state.v) / tick.dt
