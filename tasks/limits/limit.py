"""The base class of joint limits: bounds on every component of x."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type

from ..base.checks import Array, limits, numbers, per_row
from ..base.live import number
from ..robots.robot import Quantity, Robot, joint_names, joint_units, limit_of
from ..rows.part import PER, Order, Part

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class JointLimit(Part):
    """Base of the joint limits: one row a joint, without a matrix.

    The limits of one stack are made consistent, see :mod:`tasks.rows.envelope`, and one loop writes all of them.

    Attributes
    ----------
    quantity : str
        What is limited: "position", "velocity" or "acceleration".
    unit : str
        The unit of the quantity.
    """

    is_limit: ClassVar[bool] = True
    limited: ClassVar[Literal["motion", "torque"] | None] = "motion"
    plain = True
    quantity: ClassVar[Quantity]
    unit: ClassVar[str]
    rows = None

    def __init__(self, name: str | None) -> None:
        self.name = self.quantity if name is None else of_type(name, str, f"name of a {type(self).__name__}")
        self.weight = numbers(1.0, "weight")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        part = f"{self.name} limit" if self.name == self.quantity else self.name
        joints = zip(joint_names(robot), joint_units(robot), strict=True)
        return [Label(part, joint, unit + PER[order]) for joint, unit in joints]

    def ends(self, robot: Robot) -> Array:
        """Lowest and highest value of the quantity in every joint, shape (2, nv)."""
        raise NotImplementedError

    def claim(self, site: Site) -> None:
        site.shared.envelope.claim(self.full_name(), self.quantity, self.ends(site.shared.robot), site)

    def plan(self, site: Site) -> Plan:
        """An empty plan: the loop of all joint limits writes its rows."""
        from ..rows.plan import Plan

        return Plan()

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if type(self).write is not Part.write:
            raise InvalidInput(
                f"{self.full_name()}: one loop writes all joint limits, and never calls write(); define ends(robot)"
            )
        if dt is None and order not in (self.quantity, "displacement"):
            raise InvalidInput(f"{self.full_name()}: at {order} order it needs the tick; give the controller dt in s")


class SymmetricLimit(JointLimit):
    """Base of the limits that are one number a joint, the same in both directions.

    Parameters
    ----------
    limit : float or array, shape (nv,), optional
        Positive, in an array infinite for a joint without limit; None for the robot's own. A velocity of 0 holds the
        joint.
    name : str, optional

    Raises
    ------
    InvalidInput
        If a limit is not positive, or larger than 1e15.
    """

    zero_holds: ClassVar[bool] = False

    def __init__(self, limit: ArrayLike | None = None, *, name: str | None = None) -> None:
        super().__init__(name)
        self.limit = limit

    @number
    def limit(self, value: ArrayLike | None) -> Array | None:
        """The largest value in each joint, shape () or (nv,), in the unit of the class; None for the robot's own."""
        if value is None:
            return None
        return limits(value, f"{self.full_name()}: limit", unit=self.unit, zero_holds=self.zero_holds)

    def ends(self, robot: Robot) -> Array:
        largest = self.largest(robot)
        return np.array([-largest, largest])

    def largest(self, robot: Robot) -> Array:
        """The limit of each joint of this robot, shape (nv,), in the unit of the class.

        Raises
        ------
        InvalidInput
            If neither this limit nor the robot has a number, or there is not one a joint.
        """
        return largest(self, self.limit, robot, self.quantity, self.unit)

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.largest(robot)
        super().check(robot, order, dt)

    def check_numbers(self, robot: Robot, order: Order, dt: float | None) -> None:
        """Nothing: what is wrong is refused by :meth:`claim`."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({'' if self.limit is None else self.limit.tolist()})"


def largest(part: Part, given: Array | None, robot: Robot, quantity: Quantity, unit: str) -> Array:
    """The limit of each joint, shape (nv,): the given one, or the robot's own of this quantity.

    Raises
    ------
    InvalidInput
        If there is neither, or not one number a joint.
    """
    limit = given if given is not None else limit_of(robot, quantity)
    if limit is None:
        raise InvalidInput(
            f"{part.full_name()}: the robot has no {quantity} limit of its own;"
            f" give one in {unit}: {type(part).__name__}(3.0)"
        )
    return per_row(np.asarray(limit), robot.nv, f"{part.full_name()}: limit", "joint")
