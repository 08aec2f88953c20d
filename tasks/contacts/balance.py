r"""Balance: a task for the capture point, and a limit that keeps it in the support polygon.

A robot whose centre of mass c is h above its contacts falls as an inverted pendulum, at the rate
:math:`\omega = \sqrt{g / h}`. It comes to rest without a step if its *capture point*

.. math:: \xi = c + \dot c / \omega

is in the support polygon, the hull of its contact points seen from above: the contact forces can then hold it there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type

from ..base.checks import Array, not_negative, numbers, positive_scalar, scalar
from ..base.live import number, structure
from ..robots.robot import Robot, at_rest, center_of_mass
from ..rows.expansion import Companions, Setting
from ..rows.part import PER, Order, Part
from ..targets.trajectories import Trajectory, as_trajectory
from .contact import Contact

if TYPE_CHECKING:
    from ..base.loops import Table
    from ..rows.plan import Plan
    from ..rows.site import Site, Workspace

#: The gravity for which capture points are computed [m/s^2], and how far that of a model may be off: files round it.
DOWN, AROUND = (0.0, 0.0, -9.81), 0.05


class _Balance(Part):
    """Base class of rows that depend on the contacts which carry the robot."""

    task: Part = structure()
    contacts: tuple[Contact, ...] = structure()

    def __init__(self, task: Part, contacts: tuple[Contact, ...]) -> None:
        self.task, self.contacts, self.name = task, contacts, task.name

    @property
    def weight(self) -> Array:
        """The weight of the task."""
        return self.task.weight

    @weight.setter
    def weight(self, value: ArrayLike) -> None:
        self.task.weight = value

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if center_of_mass(at_rest(robot)) is None:
            raise InvalidInput(f"{self.task.full_name()}: {robot!r} does not tell its centre of mass")
        model = getattr(robot, "model", None)
        if model is not None and not np.allclose(model.gravity.linear, DOWN, rtol=0.0, atol=AROUND):
            raise InvalidInput(
                f"{self.task.full_name()}: gravity in the model of {robot!r} is {model.gravity.linear.tolist()} m/s^2;"
                f" a capture point needs that of the earth, {DOWN} or nearly so"
            )

    @property
    def points(self) -> int:
        """The largest number of contact points."""
        return sum(len(contact.shape.points) for contact in self.contacts)

    def support(self, shared: Workspace) -> tuple[int, Table]:
        """The contacts as arguments of a loop: their number, and for each one its slot, frame, axes and points."""
        from ..base.loops import Table

        told: list[Any] = []
        for contact in self.contacts:
            slot, points = contact.slot(shared), contact.touching(shared)
            told += [slot.numbers, shared.blocks.frame(contact.frame), slot.axes, points, len(points)]
        return len(self.contacts), Table(*told)

    def __repr__(self) -> str:
        return repr(self.task)


def standing(part: Part, setting: Setting) -> tuple[Contact, ...]:
    """The contacts of a stack.

    Raises
    ------
    InvalidInput
        If the stack has no contact.
    """
    contacts = tuple(other for other in setting.parts if isinstance(other, Contact))
    if not contacts:
        raise InvalidInput(f"{part.full_name()}: there is no contact in the stack that the robot could stand on")
    return contacts


class CapturePointTask(Part):
    r"""Bring the capture point to a target: :math:`\dot\xi = \dot\xi^d + K (\xi^d - \xi)`.

    At acceleration order the rows are :math:`J_c a = \omega (\dot\xi^d + K e - \dot c) - \dot J_c v`, at velocity order
    :math:`J_c v = \omega (\xi^d - c)`.

    Parameters
    ----------
    target : array, shape (2,), or Trajectory
        x and y in the world [m].
    gain : float
        K [1/s].
    weight : float or array, shape (rows,)
        Weight of the rows inside their level.
    name : str, optional
        Used in messages, tables and records.

    Raises
    ------
    InvalidInput
        If the target does not have two numbers; with a stack, if the stack has no contact.

    Examples
    --------
    >>> from tasks import CapturePointTask
    >>> CapturePointTask([0.0, 0.1], gain=3.0)
    CapturePointTask([0.0, 0.1], gain=3)
    """

    def __init__(
        self, target: ArrayLike | Trajectory, *, gain: float, weight: ArrayLike = 1.0, name: str = "capture point"
    ) -> None:
        self.name = of_type(name, str, "name of a CapturePointTask")
        self.target, self.gain, self.weight = target, gain, weight

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """x and y in the world [m]."""
        return as_trajectory(value, 2, self.full_name())

    @number
    def gain(self, value: float) -> float:
        """K [1/s]."""
        return positive_scalar(value, f"{self.full_name()}: gain", unit="1/s")

    def companions(self, setting: Setting) -> Companions:
        return Companions((CaptureRows(self, standing(self, setting)),))

    def __repr__(self) -> str:
        return f"CapturePointTask({self.target!r}, gain={self.gain:g})"


class CaptureRows(_Balance):
    """The rows of a capture point task."""

    task: CapturePointTask

    def __init__(self, task: CapturePointTask, contacts: tuple[Contact, ...]) -> None:
        super().__init__(task, contacts)
        self.rows = 2

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return [Label(self.name, axis, "m" + PER[order]) for axis in "xy"]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.kernels.law import ORDERS
        from ..rows.plan import Plan
        from .kernels.balance import write_capture_point

        shared, target = site.shared, np.zeros((3, 2))
        moves = site.keep_up(self.task, "target", *target)
        count, support = self.support(shared)
        assert site.A is not None
        told = ORDERS.index(shared.order), shared.n, site.center_of_mass(), count, support
        call = Call(write_capture_point, *told, site.A, site.lower, site.upper, target, np.array([self.task.gain]))
        return Plan((call,), moves)


class SupportLimit(Part):
    r"""Keep the capture point inside the support polygon, whatever lower levels ask of the centre of mass.

    Every edge of the support polygon, with outward normal n and distance d from the origin, gives one row
    :math:`n^T \dot\xi \le K (d - n^T \xi)`. As long as the height of the centre of mass changes slowly, contact forces
    that satisfy these rows exist for every capture point inside. Contacts that are being released do not count, nor do
    contacts on surfaces steeper than 60 degrees, such as walls.

    Parameters
    ----------
    margin : float
        Distance to keep from the edges [m]; at most 0.4 of the smallest width of the polygon is used.
    gain : float
        K [1/s]: how fast the capture point may approach an edge.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level.
    name : str, optional
        Used in messages, tables and records.

    Raises
    ------
    InvalidInput
        If a number is out of range; with a stack, if it has no contact; with a controller, if the gain exceeds 1/dt.

    Examples
    --------
    >>> from tasks import CenterOfMassTask, SupportLimit
    >>> SupportLimit(margin=0.01) >> CenterOfMassTask([0.3, 0.0], mask="xy", gain=4.0)
    SupportLimit(0.01, gain=10) >> CenterOfMassTask([0.3, 0.0], gain=4, name='center of mass')
    """

    is_limit: ClassVar[bool] = True

    def __init__(
        self, margin: float = 0.01, *, gain: float = 10.0, weight: ArrayLike = 1.0, name: str = "support polygon"
    ) -> None:
        self.name = of_type(name, str, "name of a SupportLimit")
        self.margin, self.gain, self.weight = margin, gain, numbers(weight, "weight")

    @number
    def margin(self, value: float) -> float:
        """Distance to keep from the edges of the polygon [m]."""
        return scalar(not_negative(value, f"{self.full_name()}: margin", unit="m"), "margin")

    @number
    def gain(self, value: float) -> float:
        """K [1/s]."""
        return positive_scalar(value, f"{self.full_name()}: gain", unit="1/s")

    def companions(self, setting: Setting) -> Companions:
        return Companions((SupportRows(self, standing(self, setting)),))

    def __repr__(self) -> str:
        return f"SupportLimit({self.margin:g}, gain={self.gain:g})"


class SupportRows(_Balance):
    """One row per edge, for the largest possible number of edges; rows without an edge have no bounds."""

    is_limit: ClassVar[bool] = True
    task: SupportLimit

    def __init__(self, task: SupportLimit, contacts: tuple[Contact, ...]) -> None:
        super().__init__(task, contacts)
        self.rows = max(self.points, 4)

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return [Label(self.name, f"edge {i}", "m" + PER[order], place="polygon") for i in range(self.size(robot))]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        super().check(robot, order, dt)
        if dt is not None and self.task.gain * dt > 1.0 + 1e-9:
            raise InvalidInput(
                f"{self.task.full_name()}: gain = {self.task.gain:g} 1/s passes the bound within a tick of {dt:g} s; it"
                f" must be at most {1.0 / dt:g}"
            )

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.kernels.law import ORDERS
        from ..rows.plan import Plan
        from .kernels.balance import write_support

        shared, points = site.shared, self.points
        count, support = self.support(shared)
        told = ORDERS.index(shared.order), shared.n, site.center_of_mass(), count, support
        assert site.A is not None
        rows = site.A, site.lower, site.upper, np.array([self.task.margin, self.task.gain]), site.rows
        return Plan((Call(write_support, *told, *rows, points, np.zeros(8 * points + 16)),))
