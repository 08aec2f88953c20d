r"""The joint motion that solves a task alone, tracked as a task in joint space.

The thesis's law, Eq. 4.8,

.. math:: \ddot\theta = J_1^\# h_1 + (I - J_1^\# J_1) J_2^\# h_2,

projects the motion :math:`J_2^\# h_2` that the second task would make on its own. It is the answer of
the hierarchy {J1 a = h1} > {a = J2# h2}, hence ``PositionTask(...) >> JointMotion(OrientationTask(...))``.
It has no algorithmic singularities, at the price of accuracy: the strict stack
``PositionTask(...) >> OrientationTask(...)`` meets the second task better wherever both can be met. Where the task
alone is singular, :math:`J_2^\#` is to be damped, :math:`J_2^T (J_2 J_2^T + \lambda^2 I)^{-1}`: then the joint motion
is at most :math:`\|h_2\| / 2 \lambda` (Chiaverini 1997: a task priority robust to singularities).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array, finite_scalar, numbers
from ..base.live import number, structure
from ..robots.robot import Robot, RobotState
from ..rows.part import Order, Part
from ..rows.task import Task

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class JointMotion(Part):
    """Track, joint by joint, the motion that solves `task` alone: rows ``x = J# h``.

    Parameters
    ----------
    task : Task
        Its J and h (Eq. 4.7, or the velocity law) give the motion of least norm that it asks for.
    damping : float
        The lambda of the pseudoinverse, in the unit of J; 0 for the exact one.

    Raises
    ------
    InvalidInput
        If `task` is no Task, or the damping is negative.

    Examples
    --------
    >>> from tasks import Controller, JointMotion, OrientationTask, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> stack = OrientationTask(0.0, gain=2.0) >> JointMotion(PositionTask([1.0, 0.2], gain=2.0))
    >>> Controller(arm, stack)(q).v.round(3)
    array([1.029, 0.478, 0.293])
    """

    task: Task = structure()
    plain = True
    rows = None

    def __init__(self, task: Task, *, damping: float = 0.0) -> None:
        if not isinstance(task, Task):
            raise InvalidInput(f"JointMotion takes a Task, not a {type(task).__name__}")
        self.task = task
        self.name = f"joint motion of {task.name}"
        self.weight = numbers(1.0, "weight")
        self.damping = damping

    @number
    def damping(self, value: float) -> float:
        """The lambda of the pseudoinverse, in the unit of J."""
        damping = finite_scalar(value, f"{self.full_name()}: damping")
        if damping < 0.0:
            raise InvalidInput(f"{self.full_name()}: damping = {damping} must not be negative")
        return damping

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.task.check(robot, order, dt)

    def decay_rate(self) -> float:
        """The decay rate of the task [1/s]."""
        return self.task.decay_rate()

    def error(self, state: RobotState, t: float) -> Array:
        """The error of the task itself, shape (rows of the task,)."""
        return self.task.error(state, t)

    def plan(self, site: Site) -> Plan:
        """The plan of the task, in rows of its own, and the joint motion of least norm that meets them."""
        from ..base.loops import Call
        from ..rows.plan import plan_of
        from ..rows.site import Site
        from .kernels.joint_motion import work_size, write_alone

        rows, n = self.task.size(site.shared.robot), site.shared.n
        own = Site(site.shared, np.zeros((rows, n)), *np.zeros((2, rows)))
        assert own.A is not None
        own.plain_error = site.plain_error
        damping, work = np.array([self.damping]), np.zeros(work_size(rows, n))
        call = Call(write_alone, rows, n, own.A, own.lower, damping, work, site.lower, site.upper)
        plan = plan_of(self.task, own)
        return replace(plan, calls=(*plan.calls, call), curvature=None)

    def __repr__(self) -> str:
        damping = f", damping={self.damping:g}" if self.damping else ""
        return f"JointMotion({self.task!r}{damping})"
