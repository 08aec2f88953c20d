"""How the joints stand."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from hqp import InvalidInput

from ._checks import Array
from .robots.robot import Robot, RobotState
from .task import TargetTask


class PostureTask(TargetTask):
    """Bring every joint to a given angle (r2 = theta, Eq. 3.18): J = I, so it uses up all freedom left.

    Parameters
    ----------
    target : array, shape (nq,), or Trajectory
        Joint angles [rad].
    gain, damping_ratio, weight, name
        See :class:`tasks.Task`.
    """

    plain: ClassVar[bool] = True

    def measure(self, state: RobotState) -> Array:
        return state.q

    def jacobian(self, state: RobotState) -> Array:
        return np.eye(len(state.v))

    def check(self, robot: Robot, order: str, dt: float | None) -> None:
        rows = np.shape(self.target(0.0)[0])
        if rows != (robot.nv,):
            raise InvalidInput(
                f"{self.label()}: target has shape {rows}; the robot takes ({robot.nv},), one angle a joint"
            )
        super().check(robot, order, dt)
