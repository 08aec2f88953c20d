"""All joint limits as one level of plain bounds: one row a joint, where single limits have a row each.

Both are equivalent, because the limits never exclude each other (:mod:`tasks.rows.envelope`); one row a joint is
faster to solve.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from hqp import InvalidInput, Label, Side
from hqp.checks import of_type

from ..base.checks import numbers
from ..base.live import structure
from ..robots.robot import Robot, joint_names, joint_units, limit_of
from ..rows.part import PER, Order, Part
from ..rows.plan import check_numbers
from .acceleration import JointAccelerationLimit
from .limit import JointLimit
from .position import JointPositionLimit
from .velocity import JointVelocityLimit

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site

#: Of a bound, against the limit that it may be.
SAME = 1e-9


class JointLimits(Part):
    """All joint limits that the robot has, on one level: position, velocity and, where it names one, acceleration.

    ``JointLimits() >> task`` is the level that most stacks begin with.

    Parameters
    ----------
    *limits : JointPositionLimit, JointVelocityLimit, JointAccelerationLimit
        At most one of each (default: one of each that the robot has).
    name : str

    Raises
    ------
    InvalidInput
        If something else is given, or two of a kind; and, with a robot, if nothing is limited.

    Examples
    --------
    >>> from tasks import Controller, JointLimits, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5], position_limit=(-2.0, 2.0), velocity_limit=0.3)
    >>> Controller(arm, JointLimits() >> PositionTask([1.0, 0.2], gain=2.0), dt=0.01)([1.1, -1.3, -0.7]).v.round(3)
    array([ 0.3  ,  0.275, -0.3  ])
    """

    is_limit: ClassVar[bool] = True
    limited: ClassVar[Literal["motion", "torque"] | None] = "motion"
    plain = True
    rows = None
    limits: tuple[JointLimit, ...] = structure()

    def __init__(self, *limits: JointLimit, name: str = "joint limits") -> None:
        self.name = of_type(name, str, "name of the JointLimits")
        self.weight = numbers(1.0, "weight")
        self.limits = tuple(of_type(limit, JointLimit, "a part of JointLimits") for limit in limits)
        self._each = (JointPositionLimit(), JointVelocityLimit(), JointAccelerationLimit())
        kinds = [limit.quantity for limit in self.limits]
        if len(set(kinds)) != len(kinds):
            raise InvalidInput(f"JointLimits{self.limits}: there are two of a kind; one of each is taken")

    def of(self, robot: Robot) -> tuple[JointLimit, ...]:
        """The limits that apply to this robot."""
        if self.limits:
            return self.limits
        own = tuple(part for part in self._each if limit_of(robot, part.quantity) is not None)
        if not own:
            raise InvalidInput(
                f"{self.full_name()}: the robot has no limits of its own; give them:"
                " JointLimits(JointVelocityLimit(3.0))"
            )
        return own

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        for limit in self.of(robot):
            limit.check(robot, order, dt)

    def check_numbers(self, robot: Robot, order: Order, dt: float | None) -> None:
        for limit in self.of(robot):
            check_numbers(limit, robot, order, dt)

    def claim(self, site: Site) -> None:
        for limit in self.of(site.shared.robot):
            limit.claim(site)

    def plan(self, site: Site) -> Plan:
        """An empty plan: the loop of all joint limits writes its rows."""
        from ..rows.plan import Plan

        return Plan()

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        limits = self.of(robot)
        own = next((limit for limit in limits if limit.quantity == order), None)
        others = [
            limit.quantity
            for limit in limits
            if limit is not own and (order != "displacement" or limit.quantity == "position")
        ]
        rest = f"{' or '.join(others)} limit" if others else "limit"
        constant = np.full(robot.nv, inf) if own is None else own.ends(robot)[1]
        return [
            Label(self.name, joint, unit + PER[order], Which(largest, f"{order} limit", rest))
            for joint, unit, largest in zip(joint_names(robot), joint_units(robot), constant.tolist(), strict=True)
        ]

    def __repr__(self) -> str:
        return f"JointLimits({', '.join(map(repr, self.limits))})"


@dataclass(frozen=True)
class Which:
    """Which limit a bound on x is: the constant one on x itself, or one of those that change from tick to tick.

    Attributes
    ----------
    constant : float
        The constant limit, infinite where there is none.
    name, rest : str
    """

    constant: float
    name: str
    rest: str

    def __call__(self, side: Side, bound: float) -> str:
        return self.name if abs(abs(bound) - self.constant) <= SAME * self.constant < inf else self.rest
