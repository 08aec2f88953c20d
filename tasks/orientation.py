"""Which way the tip points."""

from __future__ import annotations

from ._checks import Array
from .robots.robot import RobotState
from .task import TargetTask


class OrientationTask(TargetTask):
    """Turn the last link to phi [rad] against the x axis: the second task of the thesis, r2 of Eq. 4.3.

    phi is the plain sum of the joint angles, unwrapped: a target 2 pi away is a full turn away.

    Parameters
    ----------
    target : float, array of shape (1,), or Trajectory
        phi [rad], counter-clockwise.
    gain, damping_ratio, weight, name
        See :class:`tasks.Task`.
    """

    rows = 1

    def measure(self, state: RobotState) -> Array:
        return state.pose[2:3]

    def jacobian(self, state: RobotState) -> Array:
        return state.jacobian[2:3]

    def drift(self, state: RobotState) -> Array:
        return state.drift[2:3]
