"""How fast the joints may change their speed."""

from __future__ import annotations

from typing import ClassVar

from .._checks import Array
from ..part import Tick
from ..robots.robot import Quantity
from .limit import SymmetricLimit


class JointAccelerationLimit(SymmetricLimit):
    r"""No joint accelerates faster than its limit [rad/s^2].

    Acceleration order: :math:`-a_{max} \le a \le a_{max}`. Velocity order:
    :math:`v - a_{max} dt \le x \le v + a_{max} dt`, where v is the velocity of the tick before.

    Parameters
    ----------
    limit : float or array, shape (nv,), optional
        [rad/s^2]; None for the robot's own.
    name : str, optional
    """

    quantity: ClassVar[Quantity] = "acceleration"
    unit: ClassVar[str] = "rad/s^2"

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        limit = self.largest(tick.robot)
        if tick.order == "acceleration":
            lower[:], upper[:] = -limit, limit
        else:
            assert tick.dt is not None  # checked before the first tick
            lower[:] = tick.state.v - limit * tick.dt
            upper[:] = tick.state.v + limit * tick.dt
