"""The base class of tasks measured by compiled loops, with ``error`` and ``jacobian`` as views for Python."""

from __future__ import annotations

from hqp import InvalidInput

from ..base.checks import Array
from ..robots.robot import Robot, RobotState
from .alone import measured_alone
from .plan import overridden
from .task import Task
from .tick import Order


class LoopTask(Task):
    """Base of the tasks with a :meth:`~tasks.rows.part.Part.plan` of their own, of which these methods are views."""

    def error(self, state: RobotState, t: float) -> Array:
        return measured_alone(self, state, t).error

    def jacobian(self, state: RobotState, t: float = 0.0) -> Array:
        """Derivative of the actual value by the joint motion at time t [s], shape (rows, nv)."""
        return measured_alone(self, state, t).jacobian

    def drift(self, state: RobotState, t: float = 0.0) -> Array:
        """``Jdot v``, for a target that stands still where it is at time t [s], shape (rows,)."""
        return measured_alone(self, state, t, drifts=True).drift

    def rates(self, state: RobotState, t: float) -> tuple[Array, Array]:
        found = measured_alone(self, state, t, drifts=True)
        return found.rate, found.change

    def _try(self, robot: Robot, order: Order) -> None:
        unheard = overridden(type(self), ("feedforward", "measure"))
        if unheard is not None:
            raise InvalidInput(
                f"{self.full_name()}: {unheard}, which nothing asks for here; write error(state, t) or rates(state, t)"
            )
        super()._try(robot, order)
