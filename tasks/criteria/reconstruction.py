r"""Task reconstruction: a task is slowed down where its manipulability is small; an alternative to damping.

After Kim, Marani, Chung and Yuh, Task reconstruction method for real-time singularity avoidance for robotic
manipulators (Advanced Robotics, 2006), with a share of its own. Let
:math:`x_a = J_a^\# h_a` be the motion of the task above, if there is one, :math:`\hat J = J (I - J_a^\# J_a)`, and
:math:`w = \sqrt{\det \hat J \hat J^T}` the manipulability that is left for this task, with the gradient
:math:`g = \nabla w` in the joints. The exact motion changes it by

.. math:: \dot w = g^T (x_a + \hat J^\# r), \qquad r = h - J x_a.

Where :math:`w < w_0` the task is changed along the one direction of its space in which w changes,
:math:`n = \hat J^{\# T} g`, and in no other:

.. math::

    h' = h - \bigl(1 - (w / w_0)^2\bigr) \dot w \, n / \|n\|^2, \qquad \text{so that} \quad
    \dot w' = (w / w_0)^2 \, \dot w.

Close to a singularity :math:`\dot w` is of the order of 1 / w, since the exact motion is. So :math:`\dot w'` and the
motion that makes it are of the order of w: w decays like an exponential, and the singularity is never reached. On the
way out the same holds, and the task is as slow.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label

from ..base.checks import Array, positive_scalar
from ..base.live import number, structure
from ..base.rank import RANK_TOLERANCE
from ..robots.manipulability import manipulability
from ..robots.robot import Robot, RobotState, integrate
from ..rows.part import Order, Part, Tick
from ..rows.task import Task
from .gradient import STEP

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class Reconstructed(Part):
    """`task`, slowed along the direction that changes its manipulability, where that is below a threshold.

    ``position >> Reconstructed(orientation, 0.1, above=position)``; at velocity order, and in inverse kinematics.

    Parameters
    ----------
    task : Task
    threshold : float
        :math:`w_0`, in the unit of w: that of the rows to the power of their number.
    above : Task, optional
        The one task above it, whose motion and whose null space the measure allows for.

    Raises
    ------
    InvalidInput
        If `task` or `above` is no Task, the threshold is not positive, or the order is not velocity.

    Notes
    -----
    The effect on w of limits above it, and of levels below, is not taken into account. The gradient is taken by
    central differences, two states of the robot a joint. A run should not start at a
    singularity, where it finds no direction out.

    Examples
    --------
    >>> from tasks import Controller, OrientationTask, PlanarArm, PositionTask, Reconstructed
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> place = PositionTask([1.0, 0.2], gain=2.0)
    >>> Controller(arm, Reconstructed(place, 0.1) >> OrientationTask(0.0, gain=2.0))(q).v.round(3)
    array([ 1.162, -1.502,  1.607])
    """

    task: Task = structure()
    above: Task | None = structure()

    def __init__(self, task: Task, threshold: float, *, above: Task | None = None) -> None:
        for what, value in ("task", task), ("above", above):
            if not (isinstance(value, Task) or (value is None and what == "above")):
                raise InvalidInput(f"Reconstructed: {what} must be a Task, not a {type(value).__name__}")
        self.task, self.above = task, above
        self.name, self.rows = task.name, task.rows
        self.threshold = threshold

    @number
    def threshold(self, value: float) -> float:
        """w_0, in the unit of w."""
        return positive_scalar(value, f"{self.full_name()}: threshold")

    @property
    def weight(self) -> Array:
        """The weight of the task."""
        return self.task.weight

    @weight.setter
    def weight(self, value: ArrayLike) -> None:
        self.task.weight = value

    def size(self, robot: Robot) -> int:
        return self.task.size(robot)

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return self.task.labels(robot, order)

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if order == "acceleration":
            raise InvalidInput(f"{self.full_name()}: takes order = 'velocity', not {order!r}")
        for task in (self.task, self.above) if self.above is not None else (self.task,):
            task.check(robot, order, dt)

    def error(self, state: RobotState, t: float) -> Array:
        """The error of the task, shape (rows,)."""
        return self.task.error(state, t)

    def measure(self, robot: Robot, q: Array) -> float:
        """w: the manipulability that the task above leaves to this one."""
        state = robot.at(q, np.zeros(robot.nv))
        return float(manipulability(self._left(self.task.jacobian(state), state)))

    def gradient(self, robot: Robot, q: Array) -> Array:
        """dw/dq [unit of w per rad], shape (nv,), by central differences."""
        steps = STEP * np.eye(robot.nv)
        ahead, behind = ([self.measure(robot, integrate(robot, q, sign * s)) for s in steps] for sign in (1.0, -1.0))
        return np.asarray(np.subtract(ahead, behind) / (2.0 * STEP))

    def plan(self, site: Site) -> Plan:
        """The plans of both tasks; then Python slows the rows of this one."""
        from ..base.loops import run_all
        from ..rows.plan import Plan, plan_of
        from ..rows.site import Site

        plans, above = [plan_of(self.task, site)], None
        if self.above is not None:
            rows = self.above.size(site.shared.robot)
            above = Site(site.shared, np.zeros((rows, site.shared.n)), *np.zeros((2, rows)))
            plans.append(plan_of(self.above, above))

        def write(tick: Tick) -> None:
            for plan in plans:
                if plan.python is not None:
                    plan.python(tick)
                run_all(plan.calls)
            self._slow(tick, site, above)

        moves = tuple(move for plan in plans for move in plan.moves)
        why = "the gradient of its measure is taken from other states"
        return Plan(moves=moves, python=write, why=why, curvature=plans[0].curvature)

    def _slow(self, tick: Tick, site: Site, above: Site | None) -> None:
        """Write h' in the place of h."""
        J, h = site.A, site.lower.copy()
        assert J is not None  # the rows are never plain
        if not (np.isfinite(J).all() and np.isfinite(h).all()):
            return  # for the solver to report
        moved, left = np.zeros(len(tick.state.v)), J
        if above is not None:
            assert above.A is not None
            moved, left = _inverse(above.A) @ above.lower, J - J @ _inverse(above.A) @ above.A
        share = float(manipulability(left)) / self.threshold
        if share >= 1.0:
            return
        slope, inverse = self.gradient(tick.robot, tick.state.q), _inverse(left)
        n = inverse.T @ slope
        rate, square = float(slope @ (moved + inverse @ (h - J @ moved))), float(n @ n)
        if square > 0.0:
            site.lower[:] = site.upper[:] = h - (1.0 - share * share) * rate / square * n

    def _left(self, J: Array, state: RobotState) -> Array:
        """J in the null space of the task above."""
        if self.above is None:
            return J
        J_above = np.asarray(self.above.jacobian(state))
        return np.asarray(J - J @ _inverse(J_above) @ J_above)

    def __repr__(self) -> str:
        above = "" if self.above is None else f", above={self.above!r}"
        return f"Reconstructed({self.task!r}, {self.threshold:g}{above})"


def _inverse(J: Array) -> Array:
    return np.asarray(np.linalg.pinv(J, rcond=RANK_TOLERANCE))
