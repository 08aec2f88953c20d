"""Joint velocity limits."""

from __future__ import annotations

from typing import ClassVar

from ..robots.robot import Quantity
from .limit import SymmetricLimit


class JointVelocityLimit(SymmetricLimit):
    r"""Bounds on the joint speeds [rad/s], [m/s].

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
