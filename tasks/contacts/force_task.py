"""Tasks of contact forces: smallest forces, a given sum, or a centre of pressure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type

from ..base.checks import Array, positive
from ..base.live import number, structure
from ..robots.robot import Robot
from ..rows.expansion import Companions, Setting
from ..rows.part import Order, Part
from ..targets.trajectories import Trajectory, as_trajectory
from .contact import Contact
from .forces import OfForces
from .model import AXES

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class ForceTask(Part):
    """Bring the forces of contacts to zero, or their sum at one contact to a target.

    ``ForceTask(weight=1e-2)`` on the last level distributes the forces over all points by least squares.
    ``ForceTask([20.0], contact=hand)`` presses with 20 N.

    Parameters
    ----------
    target : array, shape (1,) or (3,), or Trajectory, optional
        The sum of the forces on the robot at one contact [N]: along its normal, or along t1, t2 and the normal
        (default: every single force is brought to zero).
    contact : Contact, optional
        Default: all contacts of the stack; required with a target.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level; [1/N] if the other rows there have no unit.
    name : str

    Raises
    ------
    InvalidInput
        If a target is given without a contact; with a stack, if the contact is not in it, or has no forces.

    Examples
    --------
    >>> from tasks import Contact, ForceTask
    >>> foot = Contact("left_ankle_roll_link", plane=(0.2, 0.1), friction=0.6, name="left foot")
    >>> ForceTask(weight=1e-2)  # of all contacts, towards zero
    ForceTask(weight=0.01)
    >>> ForceTask([0.0, 0.0, 200.0], contact=foot)  # [N]
    ForceTask([0.0, 0.0, 200.0], contact=Contact('left_ankle_roll_link', friction=0.6, name='left foot'), weight=1.0)
    """

    contact: Contact | None = structure()

    def __init__(
        self,
        target: ArrayLike | Trajectory | None = None,
        *,
        contact: Contact | None = None,
        weight: ArrayLike = 1.0,
        name: str = "force",
    ) -> None:
        self.name = of_type(name, str, "name of a ForceTask")
        self.contact = None if contact is None else of_type(contact, Contact, f"{self.full_name()}: contact")
        if target is not None and contact is None:
            raise InvalidInput(f"{self.full_name()}: a target is for the forces of one contact; give contact=...")
        self.weight, self.target = weight, target

    @number
    def target(self, value: ArrayLike | Trajectory | None) -> Trajectory | None:
        """The sum of the forces [N], or None."""
        if value is None:
            return None
        trajectory = as_trajectory(value, None, self.full_name())
        if len(trajectory(0.0)[0]) not in (1, 3):
            raise InvalidInput(f"{self.full_name()}: target must have shape (1,), along the normal, or (3,) [N]")
        return trajectory

    def companions(self, setting: Setting) -> Companions:
        contacts = contacts_of(self, setting, self.contact)
        if self.target is not None:
            return Companions((ForceSum(self, contacts[0]),))
        return Companions(tuple(LeastForces(self, contact) for contact in contacts))

    def __repr__(self) -> str:
        parts = [] if self.target is None else [repr(self.target)]
        parts += [] if self.contact is None else [f"contact={self.contact!r}"]
        return f"ForceTask({', '.join([*parts, f'weight={self.weight.tolist()}'])})"


def contacts_of(part: Part, setting: Setting, contact: Contact | None = None) -> tuple[Contact, ...]:
    """The contacts of a stack whose forces are unknowns; if `contact` is given, only that one.

    Raises
    ------
    InvalidInput
        If the order or the stack has no contact forces, or `contact` is not in the stack.
    """
    own = tuple(other for other in setting.parts if isinstance(other, Contact))
    if setting.order != "acceleration" or not setting.has_dynamics:
        raise InvalidInput(
            f"{part.full_name()}: contacts have forces at torque and at acceleration order,"
            " with Dynamics() in the stack"
        )
    if contact is not None and not any(other is contact for other in own):
        raise InvalidInput(f"{part.full_name()}: {contact!r} is not in the stack")
    if not own:
        raise InvalidInput(f"{part.full_name()}: there is no contact in the stack")
    return own if contact is None else (contact,)


class _ForceRows(OfForces):
    """Base class of the rows of a force task at one contact."""

    task: Part = structure()

    def __init__(self, task: Part, contact: Contact) -> None:
        self.task, self.contact, self.name = task, contact, f"{contact.name}: {task.name}"

    @property
    def weight(self) -> Array:
        """The weight of the task."""
        return self.task.weight

    @weight.setter
    def weight(self, value: ArrayLike) -> None:
        self.task.weight = value

    def __repr__(self) -> str:
        return f"{self.task!r} of {self.contact!r}"


class LeastForces(_ForceRows):
    """Bring every force of a contact to zero."""

    plain = True

    def __init__(self, task: Part, contact: Contact) -> None:
        super().__init__(task, contact)
        self.rows = contact.unknowns

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        block = self.contact.block()
        return [Label(self.name, name, unit) for name, unit in zip(block.names, block.units, strict=True)]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.forces import write_least_forces

        return Plan((Call(write_least_forces, site.rows, site.lower, site.upper),))


class ForceSum(_ForceRows):
    """Bring the sum of the forces of a contact to a target."""

    task: ForceTask

    def __init__(self, task: ForceTask, contact: Contact) -> None:
        super().__init__(task, contact)
        assert task.target is not None
        self.rows = len(task.target(0.0)[0])

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return [Label(self.name, axis, "N") for axis in AXES[-self.size(robot) :]]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.forces import write_force_sum

        contact, rows = self.contact, site.rows
        assert site.A is not None
        assert self.task.target is not None
        site.A[:] = 0.0
        points = 1 if contact.wrench else len(contact.shape.points)
        first = site.shared.unknowns.of(contact).start
        for i in range(points):
            site.A[:, first + 3 * i : first + 3 * i + 3] = np.eye(3)[-rows:]
        target = np.zeros((3, rows))
        moves = site.keep_up(self.task, "target", *target)
        slot = contact.slot(site.shared)
        return Plan((Call(write_force_sum, slot.numbers, rows, target, site.lower, site.upper),), moves)


class CenterOfPressureTask(Part):
    r"""Bring the centre of pressure of a contact to a point: :math:`\sum_i f_{n,i} (p_i - p^d) = 0`.

    Parameters
    ----------
    target : array, shape (2,), or Trajectory
        Coordinates x and y in the frame of the contact [m]; its z axis must be along the normal.
    contact : Contact
    weight : float or array, shape (2,)
        Weight of the rows, which are in [N m], inside their level.
    name : str

    Raises
    ------
    InvalidInput
        If the target does not have two numbers; with a stack, if the contact is not in it, or has no forces.

    Examples
    --------
    >>> from tasks import CenterOfPressureTask, Contact
    >>> foot = Contact("left_ankle_roll_link", plane=(0.2, 0.1), friction=0.6, name="left foot")
    >>> CenterOfPressureTask([0.02, 0.0], foot)
    CenterOfPressureTask([0.02, 0.0], Contact('left_ankle_roll_link', friction=0.6, name='left foot'))
    """

    contact: Contact = structure()

    def __init__(
        self, target: ArrayLike | Trajectory, contact: Contact, *, weight: ArrayLike = 1.0, name: str = "pressure"
    ) -> None:
        self.name = of_type(name, str, "name of a CenterOfPressureTask")
        self.contact = of_type(contact, Contact, f"{self.full_name()}: contact")
        self.weight, self.target = weight, target

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """Coordinates x and y in the frame of the contact [m]."""
        return as_trajectory(value, 2, self.full_name())

    @number
    def weight(self, value: ArrayLike) -> Array:
        """Weight of the rows inside their level, shape () or (2,)."""
        return positive(value, f"{self.full_name()}: weight")

    def companions(self, setting: Setting) -> Companions:
        contacts_of(self, setting, self.contact)
        return Companions((PressureRows(self, self.contact),))

    def __repr__(self) -> str:
        return f"CenterOfPressureTask({self.target!r}, {self.contact!r})"


class PressureRows(_ForceRows):
    """Moments of the normal forces about the target."""

    task: CenterOfPressureTask

    def __init__(self, task: CenterOfPressureTask, contact: Contact) -> None:
        super().__init__(task, contact)
        self.rows = 2

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return [Label(self.name, axis, "N m") for axis in ("x", "y")]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.forces import write_pressure

        contact, unknowns, shape = self.contact, site.shared.unknowns, self.contact.shape
        assert site.A is not None
        site.A[:] = 0.0
        points = shape.centre[None] if contact.wrench else contact.touching(site.shared)
        target = np.zeros((3, 2))
        moves = site.keep_up(self.task, "target", *target)
        told = contact.wrench, len(points), points, target, unknowns.n, unknowns.of(contact).start
        return Plan((Call(write_pressure, *told, site.A, site.lower, site.upper),), moves)
