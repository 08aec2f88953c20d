"""All limits of the joints as one level of plain bounds: one row a joint, where each limit alone has rows of its own.

Both say the same, as the limits never exclude each other (:mod:`tasks.limits.envelope`), but one row a joint is what a
solver likes best.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from hqp import InvalidInput, Label, Side
from hqp.checks import of_type

from .._checks import Array, numbers
from ..part import PER, Order, Part, Tick
from ..robots.robot import Robot, joint_names, joint_units, limit_of
from .acceleration import JointAccelerationLimit
from .limit import JointLimit
from .position import JointPositionLimit
from .velocity import JointVelocityLimit

#: Of a bound, against the limit that it may be.
SAME = 1e-9
KINDS = (JointPositionLimit, JointVelocityLimit, JointAccelerationLimit)


class JointLimits(Part):
    """Every limit that the robot has: position, velocity and, where it names one, acceleration.

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
    """

    is_limit: ClassVar[bool] = True
    plain = True
    rows = None

    def __init__(self, *limits: JointLimit, name: str = "joint limits") -> None:
        self.name = of_type(name, str, "name of the JointLimits")
        self.weight = numbers(1.0, "weight")
        self.limits = tuple(of_type(limit, JointLimit, "a part of JointLimits") for limit in limits)
        self._each = tuple(kind() for kind in KINDS)
        kinds = [type(limit) for limit in self.limits]
        if len(set(kinds)) != len(kinds):
            raise InvalidInput(f"JointLimits{self.limits}: there are two of a kind; one of each is taken")

    def of(self, robot: Robot) -> tuple[JointLimit, ...]:
        """The limits that count on this robot."""
        if self.limits:
            return self.limits
        own = tuple(part for part in self._each if limit_of(robot, part.quantity) is not None)
        if not own:
            raise InvalidInput(
                f"{self.label()}: the robot has no limits of its own; give them: JointLimits(JointVelocityLimit(3.0))"
            )
        return own

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        for limit in self.of(robot):
            limit.check(robot, order, dt)

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        """Nothing: its limits are written by themselves, and merged."""

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        largest: dict[str, Array] = {
            limit.quantity: limit.largest(robot)
            for limit in self.of(robot)
            if isinstance(limit, (JointVelocityLimit, JointAccelerationLimit))
        }
        others = [limit.quantity for limit in self.of(robot) if limit.quantity != order]
        rest = f"{' or '.join(others)} limit" if others else "limit"
        same = largest.get(order, np.full(robot.nv, np.inf))
        return [
            Label(self.name, joint, unit + PER[order], Which(float(own), f"{order} limit", rest))
            for joint, unit, own in zip(joint_names(robot), joint_units(robot), same, strict=True)
        ]

    def __repr__(self) -> str:
        return f"JointLimits({', '.join(map(repr, self.limits))})"


@dataclass(frozen=True)
class Which:
    """Which limit a bound on x is: the constant one on x itself, or one of those that change from tick to tick."""

    constant: float
    name: str
    rest: str

    def __call__(self, side: Side, bound: float) -> str:
        return self.name if abs(abs(bound) - self.constant) <= SAME * self.constant < np.inf else self.rest
