"""How the joints stand."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.checks import listed
from hqp.errors import brief

from ._checks import Array
from .motion.trajectories import Fixed, Trajectory, as_trajectory
from .part import Order
from .robots.robot import (
    Robot,
    RobotState,
    base,
    check_positioned,
    joint_index,
    joint_names,
    joint_positions,
    joint_units,
    numbered,
    robot_of,
    towards,
)
from .task import TargetTask, Task


class PostureTask(TargetTask):
    """Bring joints to given positions (r2 = theta, Eq. 3.18): J = I, so all of them use up all freedom left.

    Parameters
    ----------
    target : array, shape (nq,), or Trajectory; or (number of joints,), where joints are named
        A configuration, or the positions of the named joints: [rad], [m]. A trajectory of configurations needs nq = nv.
        A floating base is left alone.
    joints : names or numbers, optional
        The joints to be brought there (default: all). Each must have one position.
    gain, damping_ratio, weight, name
        See :class:`tasks.Task`.

    Raises
    ------
    InvalidInput
        If the target fits neither the joints nor, with a robot, its configurations, or there is no such joint.
    """

    plain = True

    def __init__(
        self,
        target: ArrayLike | Trajectory,
        *,
        joints: Iterable[str | int] | None = None,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.joints = None if joints is None else tuple(listed(joints, f"{self.label()}: joints", "joints"))
        for joint in self.joints or ():
            if not isinstance(joint, str | Integral) or isinstance(joint, bool):
                raise InvalidInput(f"{self.label()}: joint {brief(joint)} must be a name or a number")
        if self.joints is not None:
            self.rows = len(self.joints)
        self._call(name)
        self.target = as_trajectory(target, None, self.label())
        size = len(self.target(0.0)[0])
        if self.joints is not None and size < len(self.joints):
            raise InvalidInput(
                f"{self.label()}: target has shape ({size},); it must be ({len(self.joints)},), one number a joint,"
                " or a configuration of the robot"
            )
        Task.__init__(self, gain=gain, damping_ratio=damping_ratio, weight=weight, name=name)

    def size(self, robot: Robot) -> int:
        return len(self.variables(robot))

    def variables(self, robot: Robot) -> NDArray[np.intp]:
        return columns(self.joints, joint_names(robot), base(robot))

    def error(self, state: RobotState, t: float) -> Array:
        target, own = self.target(t)[0], self._own(state)
        if self.joints is not None and len(target) == len(own):
            return target - joint_positions(state)[own]
        return towards(state, target)[own]

    def jacobian(self, state: RobotState) -> Array:
        return np.eye(len(state.v))[self._own(state)]

    def rates(self, state: RobotState, t: float) -> tuple[Array | float, Array | float]:
        if isinstance(self.target, Fixed):
            return 0.0, 0.0
        own = self._own(state)
        _, velocity, acceleration = self.target(t)
        return (velocity, acceleration) if len(velocity) == len(own) else (velocity[own], acceleration[own])

    def _own(self, state: RobotState) -> NDArray[np.intp]:
        robot = robot_of(state)
        if robot is not None:
            return self.variables(robot)
        return columns(self.joints, numbered(len(state.v)), 0)

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        names, units = joint_names(robot), joint_units(robot)
        return [(names[i], units[i]) for i in self.variables(robot)]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        rows = self.size(robot)
        size = np.shape(self.target(0.0)[0])
        allowed = {(rows,), (robot.nq,)} if self.joints is not None else {(robot.nq,)}
        moving = not isinstance(self.target, Fixed)
        if size not in allowed or (moving and size not in {(rows,), (robot.nv,)}):
            shapes = " or ".join(map(str, sorted(allowed)))
            if size in allowed:
                shapes = (
                    f"trajectories of {(rows,)}: its {robot.nq} positions have {robot.nv} velocities; name the joints"
                )
                raise InvalidInput(f"{self.label()}: target has shape {size}; the robot takes {shapes}")
            raise InvalidInput(f"{self.label()}: target has shape {size}; the robot takes {shapes}, one angle a joint")
        if self.joints is not None and size == (rows,):
            check_positioned(robot, self.variables(robot), f"{self.label()}: joint")
        super().check(robot, order, dt)

    def _shown(self) -> list[str]:
        return [*super()._shown(), *([] if self.joints is None else [f"joints={list(self.joints)}"])]


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
