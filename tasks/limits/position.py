r"""Joint position limits.

A joint keeps its range only if it begins to brake in time. Both orders choose the velocity p at the end of the
tick; from there it can stop by :math:`p, p - s, p - 2 s, \dots, 0`, a tick each, with :math:`s = a_{max} dt`. The
largest p with which the tick and the stop take no more than the room in front of the joint is

.. math::

    p_{max}(D) &= \frac{D/dt + s\, m (m + 1)/2}{m + 1}, \qquad
        m = \Bigl\lfloor \tfrac12 \Bigl(\sqrt{1 + 8 D / (s\, dt)} - 1\Bigr) \Bigr\rfloor \\
    D &= q_{max} - q \quad \text{(velocity order)}, \qquad
        q_{max} - q - \tfrac12 v\, dt \quad \text{(acceleration order)}

where m is the number of whole steps s below p, and D the room less what is spent before p counts: at acceleration
order :math:`q^+ = q + (v + p) dt / 2`. The lower side is the mirror image. Whatever p is chosen, the next tick can
choose :math:`p - s`, or 0: the state stays viable, which is the idea of A. Del Prete, "Joint position and velocity
bounds in discrete-time acceleration/torque control of robot arms", IEEE Robotics and Automation Letters 3(1), 2018.
Here the stop takes whole ticks, so that it ends *on* the limit and without a reversal.

D < 0 means that the joint is, or will be, outside. Then :math:`p \le -r` drives it back,

.. math:: r = \min(\text{return speed},\ v_{max},\ p_{max}(-D),\ p_{max}(D') \text{ of the opposite side}),

to rest on the limit, and with :math:`p_{max}(-D)` braking in time for that: no harder than elsewhere. As
:math:`D + D' = q_{max} - q_{min} \ge 0`, at most one side is negative, and the two never exclude each other.

A step of inverse kinematics may go from one end of the range to the other: :math:`q_{min} - q \le dq \le q_{max} - q`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.checks import Array, numbers, position_range, positive_scalar
from ..base.live import number
from ..robots.robot import Quantity, Robot, integration, joint_names, joint_units, limit_of, positioned
from ..rows.part import Order
from .limit import JointLimit

if TYPE_CHECKING:
    from ..rows.site import Site

#: How fast a joint that is outside is driven back, unless told otherwise [rad/s].
RETURN_SPEED = 0.5


class JointPositionLimit(JointLimit):
    r"""Bounds on the joint positions [rad], [m]; a joint that is outside is driven back.

    Velocity order: :math:`-p_{max}(D_{lower}) \le x \le p_{max}(D_{upper})`. Acceleration order:
    :math:`(-p_{max}(D_{lower}) - v)/dt \le a \le (p_{max}(D_{upper}) - v)/dt`. See :mod:`tasks.limits.position`
    for :math:`p_{max}`, and :mod:`tasks.rows.envelope` for how the limits of one stack are made consistent.

    The braking a_max is that of the acceleration limits in the stack, else the robot's own. With neither,
    braking is unlimited at velocity order, and refused at acceleration order.

    Parameters
    ----------
    lower, upper : float or array, shape (nv,), optional
        Lowest and highest positions [rad], [m]; infinite where a joint turns freely. Both, or neither for the
        robot's own. Numbers count for all joints that have a position; arrays are infinite for a wheel without end, a
        ball and a base that moves freely. A joint whose ends are equal is held there.
    return_speed : float
        How fast, at most, the limit itself drives a joint back [rad/s].
    name : str, optional

    Raises
    ------
    InvalidInput
        If only one of the two is given, a lowest position is above the highest, or the return speed is not positive;
        and, with a robot, if a range is given to a joint without a position.

    Examples
    --------
    >>> from tasks import Controller, JointPositionLimit, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> stack = JointPositionLimit([-1.0, -1.32, -1.0], 1.2) >> PositionTask([1.0, 0.2], gain=2.0)
    >>> Controller(arm, stack, dt=0.01)(q).v.round(3)
    array([ 0.528,  0.028, -0.237])
    """

    quantity: ClassVar[Quantity] = "position"
    unit: ClassVar[str] = "rad"

    def __init__(
        self,
        lower: ArrayLike | None = None,
        upper: ArrayLike | None = None,
        *,
        return_speed: float = RETURN_SPEED,
        name: str | None = None,
    ) -> None:
        super().__init__(name)
        self.return_speed = return_speed
        self.lower, self.upper = lower, upper
        self._renew()

    @number
    def lower(self, value: ArrayLike | None) -> Array | None:
        """Lowest positions [rad], [m], shape () or (nv,); None for the robot's own."""
        return None if value is None else numbers(value, f"{self.full_name()}: lower")

    @number
    def upper(self, value: ArrayLike | None) -> Array | None:
        """Highest positions."""
        return None if value is None else numbers(value, f"{self.full_name()}: upper")

    @number
    def return_speed(self, value: float) -> float:
        """How fast, at most, the limit itself drives a joint back [rad/s]."""
        return positive_scalar(value, f"{self.full_name()}: return speed", unit="rad/s")

    def _renew(self) -> None:
        lower, upper = self.lower, self.upper
        if lower is not None and upper is not None:
            position_range((lower, upper), max(lower.size, upper.size), f"{self.full_name()}: range")
        elif lower is not None or upper is not None:
            missing = "upper" if upper is None else "lower"
            raise InvalidInput(
                f"{self.full_name()}: {missing} is missing; give both in rad, infinite where a side is free"
            )

    def range(self, robot: Robot) -> Array:
        """Lowest and highest position of each joint of this robot [rad], shape (2, nv).

        Raises
        ------
        InvalidInput
            If neither this limit nor the robot has a range, or there is not one a joint.
        """
        if self.lower is not None and self.upper is not None:
            own = self.lower, self.upper
        elif (kept := limit_of(robot, "position")) is not None:
            own = kept[0], kept[1]
        else:
            raise InvalidInput(
                f"{self.full_name()}: the robot has no position limit of its own;"
                f" give one in {self.unit}: {type(self).__name__}(-2.0, 2.0)"
            )
        what = f"{self.full_name()}: range"
        return position_range(own, robot.nv, what, positioned(robot), joint_units(robot), joint_names(robot))

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.range(robot)
        super().check(robot, order, dt)
        integration(robot)  # or there is no telling which position is whose

    def check_numbers(self, robot: Robot, order: Order, dt: float | None) -> None:
        """Nothing: what is wrong is refused by :meth:`claim`."""

    def ends(self, robot: Robot) -> Array:
        return self.range(robot)

    def claim(self, site: Site) -> None:
        values = self.ends(site.shared.robot)
        site.shared.envelope.claim(self.full_name(), "position", values, site, return_speed=self.return_speed)

    def __repr__(self) -> str:
        parts = [] if self.lower is None or self.upper is None else [str(self.lower.tolist()), str(self.upper.tolist())]
        if self.return_speed != RETURN_SPEED:
            parts.append(f"return_speed={self.return_speed:g}")
        return f"{type(self).__name__}({', '.join(parts)})"
