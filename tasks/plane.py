"""How far a frame is in front of a plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ._checks import Array, finite
from .axis import unit
from .frame_task import FrameTask
from .motion.trajectories import Trajectory, as_trajectory
from .robots.robot import Robot, RobotState


class PlaneTask(FrameTask):
    """Bring the origin of a frame to a distance from a plane: one row, n . p.

    ``AtLeast(PlaneTask([0, 0, 1], 0.02, gain=5.0))`` keeps the tip 2 cm above the floor.

    Parameters
    ----------
    normal : array, shape (3,)
        n, in the world or in `relative_to`, of any length but 0: it points to where distances are positive.
    distance : float or Trajectory
        From the plane through the origin with this normal [m].
    frame, relative_to, gain, damping_ratio, weight, name
        See :class:`~tasks.frame_task.FrameTask`.

    Raises
    ------
    InvalidInput
        If the normal has no direction, or the distance is not finite.
    """

    rows = 1

    def __init__(
        self,
        normal: ArrayLike,
        distance: ArrayLike | Trajectory,
        *,
        frame: str | None = None,
        relative_to: str | None = None,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.normal = unit(finite(normal, f"{self.label()}: normal"), f"{self.label()}: normal")
        self.target = as_trajectory(distance, 1, self.label())
        super().__init__(frame, relative_to, gain=gain, damping_ratio=damping_ratio, weight=weight, name=name)

    def error(self, state: RobotState, t: float) -> Array:
        return self.target(t)[0] - self.normal @ self.seen(state).position

    def jacobian(self, state: RobotState) -> Array:
        return np.asarray(self.normal @ self.seen(state).linear)[None]

    def drift(self, state: RobotState) -> Array:
        return np.asarray(self.normal @ self.seen(state).linear_drift)[None]

    def feedforward(self, t: float) -> tuple[Array, Array]:
        _, velocity, acceleration = self.target(t)
        return velocity, acceleration

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        return [("distance", "m")]

    def _shown(self) -> list[str]:
        return [str(self.normal.tolist()), repr(self.target), *super()._shown()]
