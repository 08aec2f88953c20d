"""Joints that move together."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import of_type

from ._checks import Array, finite_scalar
from .motion.trajectories import Trajectory
from .part import Order
from .robots.robot import (
    Robot,
    RobotState,
    check_positioned,
    joint_index,
    joint_names,
    joint_positions,
    joint_units,
    numbered,
    robot_of,
)
from .task import TargetTask

#: The unit of a sum over joints that turn and joints that slide.
MIXED = "(rad, m)"


class JointCouplingTask(TargetTask):
    """Keep a sum of joint positions, each with its factor, at a value.

    ``JointCouplingTask({"left": 1, "right": -1}, gain=5.0)`` makes two joints move alike.

    Parameters
    ----------
    factors : dict of name or number to float
        Joint -> factor; not all zero.
    target : float or Trajectory
        What ``sum(factor * position)`` is to be: in rad where all of these joints turn, in m where all slide; of both
        kinds, in the unit that the factors give it.
    gain, damping_ratio, weight, name
        See :class:`tasks.Task`.

    Raises
    ------
    InvalidInput
        If a factor is not finite, or all are zero; and, with a robot, if it has no such joint.
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
        name: str | None = None,
    ) -> None:
        self._call(name)
        given = of_type(factors, Mapping, f"{self.label()}: factors")  # type: ignore[type-abstract]
        self.factors = {joint: finite_scalar(f, f"{self.label()}: factor of {joint!r}") for joint, f in given.items()}
        if not any(self.factors.values()):
            raise InvalidInput(f"{self.label()}: factors = {self.factors}; one must not be zero")
        super().__init__(target, gain=gain, damping_ratio=damping_ratio, weight=weight, name=name)

    def measure(self, state: RobotState) -> Array:
        return self.jacobian(state) @ joint_positions(state)

    def jacobian(self, state: RobotState) -> Array:
        robot = robot_of(state)
        names = numbered(len(state.v)) if robot is None else joint_names(robot)
        row = np.zeros((1, len(state.v)))
        for joint, factor in self.factors.items():
            row[0, joint_index(names, joint, f"{self.label()}: joint")] += factor
        return row

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        super().check(robot, order, dt)
        if not self.jacobian(self.at_rest(robot)).any():
            raise InvalidInput(f"{self.label()}: factors = {self.factors} cancel each other; name each joint once")
        check_positioned(robot, np.flatnonzero(self.jacobian(self.at_rest(robot))), f"{self.label()}: joint")

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        units = joint_units(robot)
        own = {units[i] for i in np.flatnonzero(self.jacobian(self.at_rest(robot))[0])}
        return [("sum", own.pop() if len(own) == 1 else MIXED)]

    def _shown(self) -> list[str]:
        return [repr(self.factors), *super()._shown()]
