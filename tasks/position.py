"""Where the tip is."""

from __future__ import annotations

from ._checks import Array
from .robots.robot import RobotState
from .task import TargetTask


class PositionTask(TargetTask):
    """Bring the tip to (x, y) [m] in the base frame: the first task of the thesis, r1 of Eq. 4.2.

    Parameters
    ----------
    target : array, shape (2,), or Trajectory
        (x, y) [m].
    gain, damping_ratio, weight, name
        See :class:`tasks.Task`.
    """

    rows = 2

    def measure(self, state: RobotState) -> Array:
        return state.pose[:2]

    def jacobian(self, state: RobotState) -> Array:
        return state.jacobian[:2]

    def drift(self, state: RobotState) -> Array:
        return state.drift[:2]
