r"""A task as an inequality, at any level: keep its value above, below or within bounds.

The law of a task, :math:`J x = h`, brings its error to zero at the rate K. To keep :math:`e \le e_{max}` the same law
is asked of :math:`e - e_{max}`, and only where it would grow: as h has K e in it (K^2 e at acceleration order),

.. math:: h - K e_{max} \le J x \le h - K e_{min}:

far from its bound the quantity moves freely, near it ever slower towards it, and from beyond it comes back at the rate
K. At velocity order it never passes a bound that stands still (a control barrier function; with a tick dt as long as
:math:`K dt \le 1`) if it is linear in the joints. Any other bends within a tick, and while it moves along its bound
passes it by so much, in the order of :math:`\lVert x \rVert^2 dt / K`.

*In time.* Where a stack limits the accelerations of the joints, they cannot stop at once. K is then at most the rate at
which all joints together can be slowed from full speed (:mod:`tasks.rows.envelope`): slowed in proportion they go on
along their way, and the speed of the bounded quantity falls at least as fast as its distance. Room for the curvature of
that way, :math:`\tfrac12 \dot J v / K^2`, is left beside the bound. At acceleration order the velocity at the end of
the tick, and the place where it is reached, obey the law of velocity order.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput, Label

from ..base.checks import Array, numbers, per_row
from ..base.live import number, structure
from ..base.telling import tell
from ..robots.robot import Robot, RobotState
from ..targets.turns import stands_still
from .part import Part
from .plan import Plan, plan_of
from .site import Site
from .task import Task
from .tick import Order, Tick


class Inequality(Part):
    """Base of AtLeast, AtMost and Within: a task whose value stays from target + `below` to target + `above`."""

    task: Task = structure()
    is_limit: ClassVar[bool] = True
    says: ClassVar[tuple[str, ...]] = ("write",)

    def __init__(self, task: Task, below: ArrayLike, above: ArrayLike) -> None:
        if not isinstance(task, Task):
            raise InvalidInput(f"{type(self).__name__} takes a Task, not a {type(task).__name__}")
        self.task, self.name, self.rows, self.plain = task, task.name, task.rows, task.plain
        self.below, self.above = below, above
        self._renew()

    @number
    def below(self, value: ArrayLike) -> Array:
        """How far below its target the value may be, as a number that is not positive, shape () or (rows,)."""
        return numbers(value, f"{self.full_name()}: below")

    @number
    def above(self, value: ArrayLike) -> Array:
        """How far above its target the value may be, shape () or (rows,)."""
        return numbers(value, f"{self.full_name()}: above")

    @property
    def weight(self) -> Array:
        """That of the task."""
        return self.task.weight

    @weight.setter
    def weight(self, value: ArrayLike) -> None:
        self.task.weight = value

    def _renew(self) -> None:
        shapes = {side.shape for side in (self.below, self.above)} - {()}
        if len(shapes) > 1 or any(len(shape) > 1 for shape in shapes):
            raise InvalidInput(
                f"{self.full_name()}: below has shape {self.below.shape}, above {self.above.shape}; each must be one"
                " number, or one a row"
            )
        if not (self.below <= self.above).all():
            raise InvalidInput(f"{self.full_name()}: below = {self.below!r} must not exceed above = {self.above!r}")

    def size(self, robot: Robot) -> int:
        return self.task.size(robot)

    def decay_rate(self) -> float:
        """That of the task."""
        return self.task.decay_rate()

    def variables(self, robot: Robot) -> NDArray[np.intp]:
        return self.task.variables(robot)

    def reach(self, robot: Robot) -> NDArray[np.bool_] | None:
        return self.task.reach(robot)

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return self.task.labels(robot, order)

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.task.check(robot, order, dt if order == "acceleration" else None)
        self.check_numbers(robot, order, dt)

    def check_numbers(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.task.check_numbers(robot, order, dt if order == "acceleration" else None)
        for word in "cap", "deceleration":
            if getattr(self.task, word) is not None:
                raise InvalidInput(
                    f"{self.full_name()}: {word} of its task must be None: far from its bound an inequality moves"
                    " freely; lower the gain, or take FrameVelocityLimit"
                )
        rows = self.size(robot)
        for what, value in ("below", self.below), ("above", self.above):
            if value.ndim:
                per_row(value, rows, f"{self.full_name()}: {what}")
        fastest = float(self.task.gain.max())
        if dt is not None and order == "velocity" and fastest * dt > 1.0 + 1e-9:
            raise InvalidInput(
                f"{self.full_name()}: gain = {fastest:g} 1/s passes the bound within a tick of {dt:g} s;"
                f" it must be at most {1.0 / dt:g}"
            )

    def check_beside(self, tick: Tick) -> None:
        assert tick.envelope is not None
        rate = tick.envelope.braking_rate()
        if self.plain or not rate < np.inf:
            return
        if tick.envelope.brakes_blindly:
            tell(
                f"{self.full_name()}: the joints brake by an acceleration limit, and no velocity limit says for how"
                " long; it may be passed; add JointVelocityLimit(2.0), in rad/s, to the stack"
            )
        if self._moves():
            units = {unit for _, unit in self.task.row_names(tick.robot)}
            unit = units.pop() if len(units) == 1 else "unit"
            tell(
                f"{self.full_name()}: its bound moves, and the joints take up to {1.0 / rate:.3g} s to stop: where it"
                f" comes nearer by 1 {unit}/s more than it told, it may be passed by up to {0.5 / rate:.3g} {unit}"
            )

    def _moves(self) -> bool:
        """Whether the bound may change with time: anything but constant numbers."""
        targets = [getattr(self.task, name, None) for name in ("target", "position", "rotation")]
        return any(target is not None and not stands_still(target) for target in targets)

    def error(self, state: RobotState, t: float) -> Array:
        """By how much the value is beyond its bounds, signed towards them, shape (rows,)."""
        e = self.task.error(state, t)
        return np.maximum(e + self.below, 0.0) + np.minimum(e + self.above, 0.0)

    def plan(self, site: Site) -> Plan:
        """The law of the task, of its error between both bounds."""
        return plan_of(self.task, site.within(self))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.task!r})"


class AtLeast(Inequality):
    """Keep what a task measures at its target or above, row by row.

    ``AtLeast(PositionTask([0.4], frame="panda_link4", mask="z", gain=5.0))``: the elbow at 0.4 m or higher.

    Parameters
    ----------
    task : Task
        Its target is the bound, its gain the rate at which the bound is neared.

    Raises
    ------
    InvalidInput
        If it is no task; and, with a controller of velocity order, if its gain is more than 1/dt.

    Examples
    --------
    >>> from tasks import AtLeast, Controller, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> Controller(arm, AtLeast(PositionTask([0.5], mask="y", gain=5.0)), dt=0.01)(q).v.round(3)
    array([1.562, 1.217, 0.472])
    """

    def __init__(self, task: Task) -> None:
        super().__init__(task, 0.0, np.inf)


class AtMost(Inequality):
    """Keep what a task measures at its target or below, row by row; see :class:`AtLeast`.

    Parameters
    ----------
    task : Task
        Its target is the bound, its gain the rate at which the bound is neared.

    Examples
    --------
    >>> from tasks import AtMost, Controller, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> Controller(arm, AtMost(PositionTask([0.5], mask="x", gain=5.0)), dt=0.01)(q).v.round(3)
    array([-0.302, -3.267, -2.606])
    """

    def __init__(self, task: Task) -> None:
        super().__init__(task, -np.inf, 0.0)


class Within(Inequality):
    """Keep what a task measures within a tolerance of its target, row by row.

    Parameters
    ----------
    task : Task
    tolerance : float or array, shape (rows,)
        How far above the target, and below it, in the unit of the task; not negative.
    below : float or array, shape (rows,), optional
        How far below it, where that differs.

    Raises
    ------
    InvalidInput
        If a tolerance is negative or not a number; see also :class:`AtLeast`.

    Examples
    --------
    >>> from tasks import Controller, OrientationTask, PlanarArm, PositionTask, Within
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> reach = Within(OrientationTask(-0.8, gain=5.0), 0.05) >> PositionTask([1.0, 0.2], gain=2.0)
    >>> Controller(arm, reach, dt=0.01)(q).v.round(3)
    array([ 0.543, -0.008, -0.194])
    """

    def __init__(self, task: Task, tolerance: ArrayLike, *, below: ArrayLike | None = None) -> None:
        what = f"Within {getattr(task, 'name', '')!r}: tolerance"
        above = numbers(tolerance, what)
        under = above if below is None else numbers(below, f"{what} below")
        for side, value in ("", above), (" below", under):
            if not (value >= 0.0).all():
                raise InvalidInput(f"{what}{side} = {value.tolist()} must not be negative")
        super().__init__(task, -under, above)

    def __repr__(self) -> str:
        return f"Within({self.task!r}, {self.above.tolist()})"
