"""Task: a posture, desired positions of all joints or of some."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from numbers import Integral
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.checks import listed
from hqp.errors import brief

from ..base.checks import Array
from ..base.live import number, structure
from ..robots.robot import (
    Robot,
    base,
    check_positioned,
    joint_index,
    joint_names,
    joint_units,
    on_pinocchio,
    towards,
)
from ..rows.loop_task import LoopTask
from ..rows.part import Order, Tick
from ..rows.task import TargetTask, Task
from ..targets.trajectories import Trajectory, as_trajectory
from ..targets.turns import stands_still

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Move, Site, Workspace


class PostureTask(LoopTask, TargetTask):
    """Bring joints to given positions (r2 = theta, Eq. 3.18): J = I, so all of them together leave no null space below.

    Parameters
    ----------
    target : array, shape (nq,), or Trajectory; or (number of joints,), where joints are named
        A configuration, or the positions of the named joints: [rad], [m]. A trajectory of configurations needs nq = nv.
        A floating base is left alone.
    joints : names or numbers, optional
        The joints to be brought there (default: all). Each must have one position.
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
        Used in messages, tables and records (default: "posture").

    Raises
    ------
    InvalidInput
        If the target fits neither the joints nor, with a robot, its configurations, or there is no such joint; or a
        circle or quaternion in it has not norm 1.

    Examples
    --------
    >>> from tasks import Controller, PlanarArm, PostureTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> Controller(arm, PostureTask([0.0, 0.0, 0.0], gain=2.0))(q).v.round(3)
    array([-2.2,  2.6,  1.4])
    """

    plain = True
    joints: tuple[str | int, ...] | None = structure()

    def __init__(
        self,
        target: ArrayLike | Trajectory,
        *,
        joints: Iterable[str | int] | None = None,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.joints = named_joints(joints, f"{self.full_name()}: joints")
        if self.joints is not None:
            self.rows = len(self.joints)
        self.target = target
        Task.__init__(
            self, gain=gain, damping_ratio=damping_ratio, weight=weight, cap=cap, deceleration=deceleration, name=name
        )

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """A configuration, or the positions of the named joints [rad], [m]; or a trajectory."""
        trajectory = as_trajectory(value, None, self.full_name())
        size = len(trajectory(0.0)[0])
        if self.joints is not None and size < len(self.joints):
            raise InvalidInput(
                f"{self.full_name()}: target has shape ({size},); it must be ({len(self.joints)},), one number a joint,"
                " or a configuration of the robot"
            )
        return trajectory

    def size(self, robot: Robot) -> int:
        return len(self.variables(robot))

    def variables(self, robot: Robot) -> NDArray[np.intp]:
        return columns(self.joints, joint_names(robot), base(robot))

    def plan(self, site: Site) -> Plan:
        """One loop; Python measures the error of joints whose configurations cannot be subtracted."""
        from ..base.loops import Call
        from ..rows.plan import Plan
        from ..rows.site import kept_up
        from .kernels import joints as loops

        shared, own = site.shared, self.variables(site.shared.robot)
        if site.A is not None:
            site.A[:] = np.eye(shared.n)[own]
        target, steps = np.zeros((3, len(self.target(0.0)[0]))), np.zeros(site.rows)
        joints = self._joints(shared, own)

        def put() -> tuple[Move, ...]:
            self._check_target(shared.robot)
            return kept_up(self.target, *target)

        moves = site.follow(self, ("target",), put, lambda: (self.target,))
        call = Call(
            loops.write_posture,
            site.law(self),
            shared.positions,
            len(shared.positions),
            steps,
            target,
            target.shape[1],
            joints,
        )
        if not (joints[loops.KIND] == loops.MANIFOLD).any():
            return Plan((call,), moves, linear=True)

        def measure(tick: Tick) -> None:
            steps[:] = towards(tick.state, target[0])[own]

        why = "some of its joints have no position of their own; the robot tells the way to a configuration"
        return Plan((call,), moves, measure, why, linear=True)

    def _joints(self, shared: Workspace, own: NDArray[np.intp]) -> NDArray[np.int64]:
        """The arguments of its loop for every row, shape (5, rows); see :mod:`tasks.joints.kernels.joints`."""
        from .kernels import joints as loops

        size, rows, told = len(self.target(0.0)[0]), np.arange(len(own)), joint_kinds(shared, own)
        positions = self.joints is not None and size == len(own)
        told[loops.RATE] = -1 if stands_still(self.target) else rows if size == len(own) else own
        if positions:
            places = shared.position_indices[own]
            check_positioned(shared.robot, own[places < 0], f"{self.full_name()}: joint")
            told[loops.KIND], told[loops.PLACE], told[loops.GOAL] = loops.LINE, places, rows
        return told

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        names, units = joint_names(robot), joint_units(robot)
        return [(names[i], units[i]) for i in self.variables(robot)]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        rows = self.size(robot)
        size = np.shape(self.target(0.0)[0])
        allowed = {(rows,), (robot.nq,)} if self.joints is not None else {(robot.nq,)}
        moving = not stands_still(self.target)
        if size not in allowed or (moving and size not in {(rows,), (robot.nv,)}):
            shapes = " or ".join(map(str, sorted(allowed)))
            if size in allowed:
                shapes = (
                    f"trajectories of {(rows,)}: its {robot.nq} positions have {robot.nv} velocities; name the joints"
                )
                raise InvalidInput(f"{self.full_name()}: target has shape {size}; the robot takes {shapes}")
            raise InvalidInput(
                f"{self.full_name()}: target has shape {size}; the robot takes {shapes}, one angle a joint"
            )
        if self.joints is not None and size == (rows,):
            check_positioned(robot, self.variables(robot), f"{self.full_name()}: joint")
        self._check_target(robot)
        super().check(robot, order, dt)

    def _check_target(self, robot: Robot) -> None:
        """Refuse a target of the size of a configuration that is none."""
        target = self.target(0.0)[0]
        if len(target) == robot.nq != robot.nv and stands_still(self.target):
            check_configuration(robot, target, f"{self.full_name()}: target")

    def _shown(self) -> list[str]:
        return [*super()._shown(), *([] if self.joints is None else [f"joints={list(self.joints)}"])]


def check_configuration(robot: Robot, q: Array, what: str) -> None:
    """Refuse a configuration in which a circle or a quaternion has not norm 1, as in states; a free base is left aside.

    An angle in place of a cosine would be read as another angle, and zeros as where the joint is.

    Raises
    ------
    InvalidInput
    """
    if on_pinocchio(robot):
        fault = robot.on_manifold(robot.on_base(robot.neutral, q))[1]
        if fault is not None:
            raise InvalidInput(f"{what}: {fault}")


def joint_kinds(shared: Workspace, own: NDArray[np.intp]) -> NDArray[np.int64]:
    """The arguments of loops for joints whose goals are configurations, shape (5, joints); see the loops of joints."""
    from .kernels import joints as loops

    told = np.full((loops.JOINT_FIELDS, len(own)), -1, dtype=np.int64)
    places, circles = shared.position_indices[own], shared.circles[own]
    told[loops.COLUMN] = own
    told[loops.KIND] = np.where(circles >= 0, loops.CIRCLE, np.where(places >= 0, loops.LINE, loops.MANIFOLD))
    told[loops.PLACE] = told[loops.GOAL] = np.where(circles >= 0, circles, places)
    if not shared.numbered:
        told[loops.KIND] = loops.MANIFOLD
    return told


def named_joints(joints: Iterable[str | int] | None, what: str, *, some: bool = True) -> tuple[str | int, ...] | None:
    """Names and numbers of joints, as they are kept.

    Raises
    ------
    InvalidInput
        If one is neither, or, where there are to be some, there is none.
    """
    if joints is None:
        return None
    kept = tuple(listed(joints, what, "joints"))
    if some and not kept:
        raise InvalidInput(f"{what} = []; name at least one, or leave it out for all")
    for joint in kept:
        if not isinstance(joint, str | Integral) or isinstance(joint, bool):
            raise InvalidInput(f"{what.removesuffix('s')} {brief(joint)} must be a name or a number")
    return kept


@lru_cache(maxsize=256)
def columns(joints: tuple[str | int, ...] | None, names: tuple[str, ...], base: int) -> NDArray[np.intp]:
    """Which joint velocities these joints are; without any, all but those of a floating base.

    Raises
    ------
    InvalidInput
        If there is no such joint, or one is named twice.
    """
    if joints is None:
        return np.arange(base, len(names))
    found = [joint_index(names, joint, "joint") for joint in joints]
    if len(set(found)) != len(found):
        raise InvalidInput(f"joints = {list(joints)} names one twice")
    return np.array(found, dtype=np.intp)
