r"""Away from singularities, with what freedom is left.

Where a task's Jacobian loses rank its measure of manipulability :math:`w = \sqrt{\det J J^T}` falls to
zero (section 2.2). A redundant arm can avoid it, because motions that the task does not see change w:
on a level below the task, the joints climb the gradient of w,

.. math::

    \text{velocity order:}\quad & \dot q = K \nabla w \\
    \text{acceleration order:}\quad & \ddot q = K^2 \nabla w - 2 K \dot q
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from hqp import InvalidInput
from hqp.checks import of_type

from ._checks import Array, positive, positive_scalar
from .part import Order, Part, Tick
from .robots.manipulability import manipulability
from .robots.robot import Robot
from .task import Task

#: Of the central differences [rad]: truncation and round-off are both about 1e-10 of w.
STEP = 1e-5


class ManipulabilityTask(Part):
    """Raise the manipulability of `task`, in every joint: it uses up all freedom left.

    Parameters
    ----------
    task : Task
        Whose Jacobian is to stay away from loss of rank; usually one of the levels above.
    gain : float
        K [1/s], against w in the unit of the task: [m^2] for the tip in the plane.
    weight : float or array, shape (nv,)
        Weight of the rows inside their level.
    name : str, optional

    Raises
    ------
    InvalidInput
        If `task` is no Task, or a gain or a weight is not positive or larger than 1e15.
    """

    plain: ClassVar[bool] = True
    rows = None

    def __init__(self, task: Task, *, gain: float, weight: float | Array = 1.0, name: str | None = None) -> None:
        if not isinstance(task, Task):
            raise InvalidInput(f"ManipulabilityTask takes a Task, not a {type(task).__name__}")
        self.task = task
        self.name = f"manipulability of {task.name}" if name is None else of_type(name, str, "name of a task")
        self.gain = positive_scalar(gain, f"{self.label()}: gain", unit="1/s")
        self.weight = positive(weight, f"{self.label()}: weight")

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.task.check(robot, order, dt)
        if robot.nq != robot.nv:
            raise InvalidInput(
                f"{self.label()}: takes a robot of as many joint positions as velocities, not {robot.nq} and {robot.nv}"
            )

    def gradient(self, robot: Robot, q: Array) -> Array:
        """How w changes with each joint [unit of w per rad], shape (nv,): central differences."""
        still = np.zeros(robot.nv)
        around = q + STEP * np.concatenate([np.eye(robot.nv), -np.eye(robot.nv)])
        J = np.array([self.task.jacobian(robot.at(near, still)) for near in around])
        if not np.isfinite(J).all():
            return np.full(robot.nv, np.nan)  # for the solver to report
        ahead, behind = manipulability(J).reshape(2, -1)
        return np.asarray((ahead - behind) / (2.0 * STEP))

    def write(self, tick: Tick, A: Array | None, lower: Array, upper: Array) -> None:
        climb = self.gradient(tick.robot, tick.state.q)
        if tick.order == "velocity":
            lower[:] = self.gain * climb
        else:
            lower[:] = self.gain**2 * climb - 2.0 * self.gain * tick.state.v
        upper[:] = lower

    def __repr__(self) -> str:
        return f"ManipulabilityTask({self.task!r}, gain={self.gain:.4g})"
