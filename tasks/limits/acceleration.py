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

    Examples
    --------
    >>> from tasks import Controller, JointAccelerationLimit, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> stack = JointAccelerationLimit(10.0) >> PositionTask([1.0, 0.2], gain=2.0)
    >>> Controller(arm, stack, dt=0.01)(q).v.round(3)
    array([0.1, 0.1, 0.1])
    """

    quantity: ClassVar[Quantity] = "acceleration"
    unit: ClassVar[str] = "rad/s^2"
