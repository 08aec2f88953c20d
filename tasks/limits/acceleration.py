"""Joint acceleration limits."""

from __future__ import annotations

from typing import ClassVar

from ..robots.robot import Quantity
from .limit import SymmetricLimit


class JointAccelerationLimit(SymmetricLimit):
    r"""Bounds on the joint accelerations [rad/s^2], [m/s^2].

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
