"""Task: a linear relation between joint positions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.checks import of_type

from ..base.checks import Array, finite_scalar
from ..base.live import number
from ..robots.robot import Robot, RobotState, check_positioned, joint_index, joint_names, joint_positions, joint_units
from ..rows.alone import robot_of
from ..rows.loop_task import LoopTask
from ..rows.part import Order
from ..rows.task import TargetTask
from ..targets.trajectories import Trajectory

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site

#: The unit of a sum over revolute and prismatic joints.
MIXED = "(rad, m)"


class Factors(Mapping[str | int, float]):
    """Joint -> factor, read-only."""

    def __init__(self, factors: Mapping[str | int, float]) -> None:
        self._of = dict(factors)

    def __getitem__(self, joint: str | int) -> float:
        return self._of[joint]

    def __iter__(self) -> Iterator[str | int]:
        return iter(self._of)

    def __len__(self) -> int:
        return len(self._of)

    def __repr__(self) -> str:
        return repr(self._of)


class JointCouplingTask(LoopTask, TargetTask):
    """Keep a sum of joint positions, each with its factor, at a value.

    ``JointCouplingTask({"left": 1, "right": -1}, gain=5.0)`` makes two joints move by equal angles.

    Parameters
    ----------
    factors : dict of name or number to float
        Joint -> factor; not all zero.
    target : float or Trajectory
        The desired ``sum(factor * position)``: in rad if all of these joints are revolute, in m if all are
        prismatic; of both kinds, in the unit that the factors give it.
    gain : float
        K [1/s]: the rate at which the error decays.
    damping_ratio : float
        The zeta of acceleration order; 1 is critical damping.
    weight : float
        Weight of the rows inside their level, against those of other tasks joined by ``+``.
    cap : float or array, shape (rows,), optional
        Length to which the error is cut off, in its unit; a far target is approached at K times that.
    deceleration : float, optional
        The deceleration with which it comes to rest at its target [m/s^2], [rad/s^2].
    name : str, optional
        Used in messages, tables and records (default: "jointcoupling").

    Raises
    ------
    InvalidInput
        If a factor is not finite, or all are zero; and, with a robot, if it has no such joint.

    Examples
    --------
    >>> from tasks import Controller, JointCouplingTask, PlanarArm
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> Controller(arm, JointCouplingTask({0: 1.0, 1: 1.0}, 0.0, gain=2.0))(q).v.round(3)
    array([0.2, 0.2, 0. ])
    """

    rows = 1

    def __init__(
        self,
        factors: Mapping[str | int, float],
        target: ArrayLike | Trajectory = 0.0,
        *,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.factors = factors
        super().__init__(
            target, gain=gain, damping_ratio=damping_ratio, weight=weight, cap=cap, deceleration=deceleration, name=name
        )

    @number
    def factors(self, value: Mapping[str | int, float]) -> Factors:
        """Joint -> factor; other factors of the same joints may be set, among them 0."""
        given = of_type(value, Mapping, f"{self.full_name()}: factors")
        factors = Factors(
            {joint: finite_scalar(f, f"{self.full_name()}: factor of {joint!r}") for joint, f in given.items()}
        )
        if not any(factors.values()):
            raise InvalidInput(f"{self.full_name()}: factors = {factors}; one must not be zero")
        before = vars(self).get("factors", factors)
        if factors.keys() != before.keys():
            raise InvalidInput(
                f"{self.full_name()}: factors = {factors}; its joints are part of its structure, and stay"
                f" {', '.join(map(repr, before))}; {self._instead}"
            )
        return factors

    def measure(self, state: RobotState) -> Array:
        return self._row(robot_of(state))[None] @ joint_positions(state)

    def reach(self, robot: Robot) -> NDArray[np.bool_]:
        own = [joint_index(joint_names(robot), joint, "joint") for joint in self.factors]
        return np.isin(np.arange(robot.nv), own)[None]

    def plan(self, site: Site) -> Plan:
        """One loop; the target is written every tick where it moves."""
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels import joints as loops

        shared, target = site.shared, np.zeros((3, 1))
        moves = site.keep_up(self, "target", *target)
        row, q = self._row(shared.robot), shared.positions
        call = Call(loops.write_coupling, site.law(self), q, len(q), target, row, shared.position_indices)
        return Plan((call,), moves, linear=True)

    def _row(self, robot: Robot) -> Array:
        """The factor of every joint of a robot, shape (nv,)."""
        names, row = joint_names(robot), np.zeros(robot.nv)
        for joint, factor in self.factors.items():
            row[joint_index(names, joint, f"{self.full_name()}: joint")] += factor
        return row

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        super().check(robot, order, dt)
        if not self._row(robot).any():
            raise InvalidInput(f"{self.full_name()}: factors = {self.factors} cancel each other; name each joint once")
        check_positioned(robot, np.flatnonzero(self._row(robot)), f"{self.full_name()}: joint")

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        units = joint_units(robot)
        own = {units[i] for i in np.flatnonzero(self._row(robot))}
        return [("sum", own.pop() if len(own) == 1 else MIXED)]

    def _shown(self) -> list[str]:
        return [repr(self.factors), *super()._shown()]
