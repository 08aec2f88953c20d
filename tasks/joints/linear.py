r"""Task: linear relations between joint positions, :math:`A (q \ominus q_0) = b`."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.checks import Array, finite
from ..base.live import number
from ..robots.robot import Robot, joint_names, joint_units, neutral
from ..rows.loop_task import LoopTask
from ..rows.part import Order
from ..rows.site import Workspace
from ..rows.task import TargetTask
from ..targets.trajectories import Trajectory, as_trajectory
from .coupling import MIXED
from .posture import check_configuration, joint_kinds

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class LinearHolonomicTask(LoopTask, TargetTask):
    r"""Bring :math:`A (q \ominus q_0)` to b: each row is a weighted sum of joint displacements from q0.

    ``LinearHolonomicTask(np.eye(nv)[[0, 3]], [0.1, -0.2], q0, gain=5.0)`` moves two joints by 0.1 and -0.2 from where
    they are at q0. :class:`JointCouplingTask` is one such row, its joints by name and its q0 zero.

    Parameters
    ----------
    A : array, shape (rows, nv)
        Zero for joints that have no single position, such as those of a floating base.
    b : float, array, shape (rows,), or Trajectory
        In the unit that A gives it (default: 0).
    q0 : array, shape (nq,), optional
        Default: the neutral configuration. The displacement of a joint on a circle is the shorter one.
    gain : float or array, shape (rows,)
        K [1/s]: the rate at which the error decays.
    damping_ratio : float
        The zeta of acceleration order; 1 is critical damping.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level, against those of other tasks joined by ``+``.
    cap : float or array, shape (rows,), optional
        Length to which the error is cut off, in its unit; a far target is approached at K times that.
    deceleration : float, optional
        The deceleration with which it comes to rest at its target [m/s^2], [rad/s^2].
    name : str, optional
        Used in messages, tables and records (default: from the name of the class).

    Raises
    ------
    InvalidInput
        If A is no matrix of finite numbers, or a row of it is zero; with a robot, if A, b or q0 does not fit it, or A
        counts a joint without a single position.

    Examples
    --------
    >>> from tasks import LinearHolonomicTask, PlanarArm
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> task = LinearHolonomicTask([[1.0, 1.0, 0.0]], 0.5, q0=[0.1, 0.2, 0.0], gain=2.0)
    >>> task.error(arm.at([0.3, 0.2, 0.9]), 0.0).round(9).tolist()
    [0.3]
    """

    reads_limits: ClassVar[bool] = True  # the neutral configuration lies within the ranges

    def __init__(
        self,
        A: ArrayLike,
        b: ArrayLike | Trajectory = 0.0,
        q0: ArrayLike | None = None,
        *,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.A = A
        self.rows, self.q0 = len(self.A), q0
        if not callable(b):
            wanted = finite(b, f"{self.full_name()}: b")
            b = wanted if wanted.ndim else np.full(self.rows, wanted)
        super().__init__(
            b, gain=gain, damping_ratio=damping_ratio, weight=weight, cap=cap, deceleration=deceleration, name=name
        )

    @number
    def A(self, value: ArrayLike) -> Array:
        """The factor of every joint in every row, shape (rows, nv)."""
        matrix = finite(value, f"{self.full_name()}: A")
        if matrix.ndim != 2 or not matrix.size:
            raise InvalidInput(f"{self.full_name()}: A has shape {matrix.shape}; it must be (rows, nv)")
        if not matrix.any(axis=1).all():
            raise InvalidInput(
                f"{self.full_name()}: A[{int(np.argmin(matrix.any(axis=1)))}] is zero; it asks for nothing"
            )
        before = vars(self).get("A", matrix)
        if matrix.shape != before.shape:
            raise InvalidInput(
                f"{self.full_name()}: A has shape {matrix.shape}; its rows are part of its structure, and stay"
                f" {before.shape}; {self._instead}"
            )
        return matrix

    @number
    def q0(self, value: ArrayLike | None) -> Array | None:
        """The configuration from which displacements are measured, shape (nq,); None for the neutral one."""
        return None if value is None else finite(value, f"{self.full_name()}: q0")

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """b, shape (rows,), or a trajectory of it."""
        return as_trajectory(value, self.rows, self.full_name())

    @property
    def b(self) -> Trajectory:
        """The target by its other name."""
        return self.target

    @b.setter
    def b(self, value: ArrayLike | Trajectory) -> None:
        self.target = value

    def plan(self, site: Site) -> Plan:
        """One loop; the rows are there from the start."""
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels import joints as loops

        shared, target = site.shared, np.zeros((3, site.rows))
        moves = site.keep_up(self, "target", *target)
        assert site.A is not None
        site.A[:] = self.A
        start, q = self._start(shared.robot), shared.positions
        told = site.law(self), q, len(q), np.zeros(shared.n), target, start, joint_kinds(shared, np.arange(shared.n))
        return Plan((Call(loops.write_linear, *told),), moves, linear=True)

    def _start(self, robot: Robot) -> Array:
        return neutral(robot) if self.q0 is None else self.q0

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        from .kernels import joints as loops

        if self.A.shape[1] != robot.nv:
            raise InvalidInput(
                f"{self.full_name()}: A has shape {self.A.shape}; it must be (rows, {robot.nv}) on {robot!r}"
            )
        if self._start(robot).shape != (robot.nq,):
            raise InvalidInput(f"{self.full_name()}: q0 has shape {self._start(robot).shape}; it must be ({robot.nq},)")
        check_configuration(robot, self._start(robot), f"{self.full_name()}: q0")
        own = np.flatnonzero(self.A.any(axis=0))
        kinds = joint_kinds(Workspace(robot, order, dt), own)[loops.KIND]
        if (kinds == loops.MANIFOLD).any():
            joint = joint_names(robot)[own[int(np.argmax(kinds == loops.MANIFOLD))]]
            raise InvalidInput(
                f"{self.full_name()}: A counts joint {joint!r}, which has no single position; it must be 0"
            )
        super().check(robot, order, dt)

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        units = joint_units(robot)
        own = [{units[i] for i in np.flatnonzero(row)} for row in self.A]
        return [(f"row {i}", unit.pop() if len(unit) == 1 else MIXED) for i, unit in enumerate(own)]

    def _shown(self) -> list[str]:
        return [str(self.A.tolist()), *super()._shown()]
