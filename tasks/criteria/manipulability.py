r"""Secondary criteria: measures of manipulability, maximised in the null space of the tasks above.

Four measures of how well a task can be moved, which its Jacobian J (m rows) and the mass matrix M tell:

.. math::

    w &= \sqrt{\det J J^T} && \text{manipulability (Yoshikawa 1985a)} \\
    w_d &= \sqrt{\det J M^{-1} M^{-T} J^T} && \text{dynamic manipulability (Yoshikawa 1985b)} \\
    r &= (u^T (J J^T)^{-1} u)^{-1/2} && \text{velocity ratio in the direction u (Dubey and Luh 1987)} \\
    \sigma_m &= \min_{\lVert u \rVert = 1} r && \text{minor axis of the velocity ellipsoid (Dubey and Luh 1987)}

w is, up to a constant factor, the volume of the ellipsoid of task velocities that joint velocities of norm one give;
w_d that of task accelerations that torques of norm one give, from rest; r is the length of the ellipsoid of
velocities along u, the speed of the task per joint speed; :math:`\sigma_m`, the least singular value of J, is r in the
worst direction.
Where J loses rank w, w_d and :math:`\sigma_m` fall to zero, and r does unless u can still be moved.
A redundant arm can raise them, because motions in the null space of the task change them: each is a
:class:`~tasks.GradientTask`, to be put below the task.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.checks import Array, finite
from ..base.live import number, structure
from ..frames.frame_task import FrameTask
from ..robots.chain import chain_order
from ..robots.manipulability import manipulability, velocity_ellipse
from ..robots.robot import Robot, check_mass_matrix
from ..rows.part import Order
from ..rows.task import Task
from .dynamics import check_definite, check_fixed, root
from .gradient import GradientTask

if TYPE_CHECKING:
    from ..base.loops import Entry
    from ..rows.plan import Plan
    from ..rows.site import Site

#: Half axes [unit of J] below this count as this long: their inverse squares stay finite.
SHORTEST = 1e-150


class _MeasureOfTask(GradientTask):
    """Base of criteria that increase a measure of another task's Jacobian, in every joint but a floating base.

    Parameters
    ----------
    task : Task
        Usually one of the levels above.
    """

    task: Task = structure()
    measure: ClassVar[str]

    def __init__(self, task: Task, *, gain: float, weight: ArrayLike = 1.0, name: str | None = None) -> None:
        if not isinstance(task, Task):
            raise InvalidInput(f"{type(self).__name__} takes a Task, not a {type(task).__name__}")
        self.task = task
        super().__init__(gain=gain, weight=weight, name=f"{self.measure} of {task.name}" if name is None else name)

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.task.check(robot, order, dt)

    def value(self, robot: Robot, q: Array, t: float = 0.0) -> float:
        return float(self.values(robot, q[None], t)[0])

    def values(self, robot: Robot, q: Array, t: float = 0.0) -> Array:
        still = np.zeros(robot.nv)
        J = np.array([self.task.jacobian(robot.at(one, still)) for one in q])
        return self._of(J, robot, q, t) if np.isfinite(J).all() else np.full(len(q), np.nan)

    def plan(self, site: Site) -> Plan:
        """Loops where the gradient has a closed form; else Python, by differences."""
        told = self._frame(site)
        if told is None:
            return replace(self.python_plan(site), why=f"{self.full_name()}: its gradient is taken by differences")
        return self._loops(site, told)

    def _frame(self, site: Site) -> tuple[Entry, ...] | None:
        """The arguments of its loops on the frame of the task; None if the gradient has no closed form."""
        from ..rows.plan import overridden
        from .kernels.measures import work_size

        task, robot, n = self.task, site.shared.robot, site.shared.n
        if not isinstance(task, FrameTask) or overridden(type(task), task.says, "reading") is not None:
            return None
        reading, order = task.reading(), chain_order(robot, task.frame, task.relative_to)
        if reading is None or order is None:
            return None
        rows = len(reading.rows)
        work, slope = np.zeros(work_size(n, rows)), np.zeros(n)
        return n, task.block(site), reading.axes, reading.rows, rows, order, work, len(work), slope

    def _loops(self, site: Site, told: tuple[Entry, ...]) -> Plan:
        """The loops of this measure."""
        raise NotImplementedError

    def _of(self, J: Array, robot: Robot, q: Array, t: float) -> Array:
        """The measure of Jacobians, shape (k, m, nv), at these configurations, shape (k, nq)."""
        raise NotImplementedError

    def _shown(self) -> list[str]:
        return [repr(self.task)]


class ManipulabilityTask(_MeasureOfTask):
    """Raise the manipulability of `task`: keep its Jacobian away from loss of rank.

    Parameters
    ----------
    task : Task
        Usually one of the levels above.
    gain : float
        K [1/s], against w in the unit of J to the power of m: [m^2] for the tip in the plane.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level.
    name : str, optional
        Used in messages, tables and records.

    Raises
    ------
    InvalidInput
        If `task` is no Task, or a gain or a weight is not positive or larger than 1e15.

    Examples
    --------
    >>> from tasks import Controller, ManipulabilityTask, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> place = PositionTask([1.0, 0.2], gain=2.0)
    >>> Controller(arm, place >> ManipulabilityTask(place, gain=1.0))(q).v.round(3)
    array([ 0.523,  0.038, -0.25 ])
    """

    measure: ClassVar[str] = "manipulability"

    def _loops(self, site: Site, told: tuple[Entry, ...]) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.measures import write_manipulability

        return Plan((Call(write_manipulability, *self.law(site), *told),))

    def _of(self, J: Array, robot: Robot, q: Array, t: float) -> Array:
        return manipulability(J)


class MinorAxisTask(_MeasureOfTask):
    """Lengthen the minor axis of the velocity ellipsoid of `task`: raise its speed in the worst direction.

    ``reach >> MinorAxisTask(reach, gain=5.0)``; of manipulability, which is the product of all axes, the others have a
    share too.

    Parameters
    ----------
    task : Task
        Usually one of the levels above.
    gain : float
        K [1/s], against the axis in the unit of J: [m] for the tip in the plane.
    weight : float
        Weight of the row inside its level, against those of other tasks joined by ``+``.
    name : str, optional
        Used in messages, tables and records.

    Raises
    ------
    InvalidInput
        If `task` is no Task, or a gain or a weight is not positive or larger than 1e15.

    Examples
    --------
    >>> from tasks import Controller, MinorAxisTask, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> reach = PositionTask([1.0, 0.6], gain=2.0)
    >>> controller = Controller(arm, reach >> MinorAxisTask(reach, gain=5.0), dt=0.01)
    >>> controller([0.4, 0.6, 0.3]).solution.certify().ok
    True
    """

    measure: ClassVar[str] = "minor axis"

    def _loops(self, site: Site, told: tuple[Entry, ...]) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.measures import write_minor_axis

        return Plan((Call(write_minor_axis, *self.law(site), *told),))

    def _of(self, J: Array, robot: Robot, q: Array, t: float) -> Array:
        rows, joints = J.shape[-2:]
        return np.zeros(len(J)) if rows > joints else np.asarray(velocity_ellipse(J).half_axes[..., -1])


class DynamicManipulabilityTask(_MeasureOfTask):
    """Raise the dynamic manipulability of `task`: let small torques accelerate it in every direction.

    Parameters
    ----------
    task : Task
        Usually one of the levels above.
    gain : float
        K [1/s], against w_d in the unit of J M^-1 to the power of m: [1/kg^2 m^2] for the tip in the plane.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level.
    name : str, optional
        Used in messages, tables and records.

    Raises
    ------
    InvalidInput
        If `task` is no Task, a gain or a weight is not positive or larger than 1e15, or the robot has no
        ``mass_matrix(q)``, links without mass, or a floating base, which no torque moves.

    Examples
    --------
    >>> from tasks import Controller, DynamicManipulabilityTask, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5], masses=[1.0, 1.0, 1.0])
    >>> place = PositionTask([1.0, 0.2], gain=2.0)
    >>> Controller(arm, place >> DynamicManipulabilityTask(place, gain=1.0))([1.1, -1.3, -0.7]).v.round(3)
    array([ 1.258, -1.733,  1.886])
    """

    measure: ClassVar[str] = "dynamic manipulability"

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        super().check(robot, order, dt)
        check_mass_matrix(robot, self.full_name())
        check_fixed(robot, self.full_name())
        check_definite(robot, self.full_name())

    def _frame(self, site: Site) -> None:
        """None: the gradient also depends on the derivative of the mass matrix."""

    def _of(self, J: Array, robot: Robot, q: Array, t: float) -> Array:
        R = root(robot, q)  # M = R^T R
        if not np.isfinite(R).all():
            return np.full(len(J), np.nan)
        A = np.linalg.solve(R, np.linalg.solve(R.swapaxes(-1, -2), J.swapaxes(-1, -2)))  # M^-1 J^T
        return manipulability(A.swapaxes(-1, -2))


class VelocityRatioTask(_MeasureOfTask):
    """Raise the velocity ratio of `task` in one direction: turn the major axis of its velocity ellipsoid there.

    Parameters
    ----------
    task : Task
        Usually one of the levels above.
    direction : array, shape (rows of the task,), optional
        u, of any length but zero; by default that of the task's own desired velocity at each tick, and
        nothing is asked where that is zero.
    gain : float
        K [1/s], against r in the unit of J.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level.
    name : str, optional
        Used in messages, tables and records.

    Raises
    ------
    InvalidInput
        If `task` is no Task, the direction is zero, not finite or not of its rows, or a gain or a weight is not
        positive or larger than 1e15.

    Examples
    --------
    >>> from tasks import Controller, PlanarArm, PositionTask, VelocityRatioTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> place = PositionTask([1.0, 0.2], gain=2.0)
    >>> Controller(arm, place >> VelocityRatioTask(place, [1.0, 0.0], gain=1.0))(q).v.round(3)
    array([ 0.519,  0.049, -0.262])
    """

    measure: ClassVar[str] = "velocity ratio"

    def __init__(
        self,
        task: Task,
        direction: ArrayLike | None = None,
        *,
        gain: float,
        weight: ArrayLike = 1.0,
        name: str | None = None,
    ) -> None:
        super().__init__(task, gain=gain, weight=weight, name=name)
        self.direction = direction

    @number
    def direction(self, value: ArrayLike | None) -> Array | None:
        """u, shape (rows of the task,); None for the task's own desired velocity."""
        if value is None:
            return None
        u = finite(value, f"{self.full_name()}: direction")
        if not u.any():
            raise InvalidInput(f"{self.full_name()}: direction = {u.tolist()}; it must not be zero")
        return u

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        super().check(robot, order, dt)
        rows = self.task.size(robot)
        if self.direction is not None and self.direction.shape != (rows,):
            raise InvalidInput(
                f"{self.full_name()}: direction has shape {self.direction.shape}; it must be ({rows},),"
                f" one number a row of {self.task.full_name()}"
            )

    def _loops(self, site: Site, told: tuple[Entry, ...]) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.measures import write_velocity_ratio

        if self.direction is not None:
            return Plan((Call(write_velocity_ratio, *self.law(site), *told, self.direction, 0),))
        desired, task = np.zeros(6), self.task
        assert isinstance(task, FrameTask)  # as it has a reading

        def move(t: float) -> None:
            desired[:] = task.desired_velocity(t)

        return Plan((Call(write_velocity_ratio, *self.law(site), *told, desired, 1),), (move,))

    def _of(self, J: Array, robot: Robot, q: Array, t: float) -> Array:
        u = np.broadcast_to(self._direction(robot, q, t), J.shape[:-1])
        length = np.linalg.norm(u, axis=-1)
        ellipse = velocity_ellipse(J)
        along = np.einsum("kij,ki->kj", ellipse.directions, u) / np.maximum(ellipse.half_axes, SHORTEST)
        inverse = np.linalg.norm(along, axis=-1)
        return np.asarray(np.divide(length, inverse, out=np.zeros(len(J)), where=length > 0.0))

    def _direction(self, robot: Robot, q: Array, t: float) -> ArrayLike:
        """u, of any length, shape (m,), or where it is the task's own, which may turn with the robot, (k, m)."""
        if self.direction is not None:
            return self.direction
        still = np.zeros(robot.nv)
        desired = [np.asarray(self.task.rates(robot.at(one, still), t)[0]) for one in q]
        return np.array(desired).reshape(len(q), -1)

    def _shown(self) -> list[str]:
        return [*super()._shown(), *([] if self.direction is None else [str(self.direction.tolist())])]
