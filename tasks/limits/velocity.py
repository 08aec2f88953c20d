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

    Examples
    --------
    >>> from tasks import Controller, JointVelocityLimit, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> stack = JointVelocityLimit([0.1, 1.0, 1.0]) >> PositionTask([1.0, 0.2], gain=2.0)
    >>> Controller(arm, stack, dt=0.01)(q).v.round(3)
    array([ 0.1  ,  0.807, -0.997])
    """

    quantity: ClassVar[Quantity] = "velocity"
    zero_holds: ClassVar[bool] = True
    unit: ClassVar[str] = "rad/s"
