r"""An axis of a frame that points at a point: a camera that follows, a lamp, a hand that faces its grasp.

With the point c at the distance :math:`\rho` in the direction :math:`d = (c - p) / \rho`, which turns as the frame
moves, the axis turns against it by

.. math:: \omega - d \times \dot d = \omega + d \times u / \rho, \qquad u = \dot p - \dot c,

whose derivative is :math:`\dot\omega + d \times \dot u / \rho + 2 (d \cdot u) (d \times u) / \rho^2`. The rest is
:mod:`tasks.axis`.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ._checks import Array, finite
from .axis import half_a_turn, shortest_turn, unit
from .frame_task import FrameTask
from .motion.trajectories import Trajectory, as_trajectory
from .part import Tick
from .robots.frame import Frame
from .robots.robot import Robot, RobotState
from .rotations import cross, perpendicular

#: Nearer than this [m] the point has no direction.
NEAR = 1e-9


class LookAtTask(FrameTask):
    """Point an axis of a frame at a point: two rows, and the third rotation stays free.

    Parameters
    ----------
    point : array, shape (3,), or Trajectory
        c [m], in the world or in `relative_to`.
    axis : array, shape (3,)
        In the frame; by default its z axis.
    frame, relative_to, gain, damping_ratio, weight, name
        See :class:`~tasks.frame_task.FrameTask`.

    Raises
    ------
    InvalidInput
        If the axis has no direction.
    """

    rows = 2
    spatial: ClassVar[bool] = True

    def __init__(
        self,
        point: ArrayLike | Trajectory,
        *,
        axis: ArrayLike = (0.0, 0.0, 1.0),
        frame: str | None = None,
        relative_to: str | None = None,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.target = as_trajectory(point, 3, self.label())
        self.axis = unit(finite(axis, f"{self.label()}: axis"), f"{self.label()}: axis")
        self._across = perpendicular(self.axis)
        super().__init__(frame, relative_to, gain=gain, damping_ratio=damping_ratio, weight=weight, name=name)

    def _sight(self, state: RobotState, t: float) -> tuple[Frame, Array, Array, float]:
        """The frame, the rows U R^T, and direction and distance of the point."""
        frame = self.seen(state)
        away = self.target(t)[0] - frame.position
        distance = max(float(np.linalg.norm(away)), NEAR)
        return frame, self._across @ frame.rotation.T, away / distance, distance

    def error(self, state: RobotState, t: float) -> Array:
        frame, _, d, _ = self._sight(state, t)
        turn = shortest_turn(self._across, self.axis, frame.rotation.T @ d)
        return half_a_turn(self.jacobian(state, t)) if turn is None else turn

    def jacobian(self, state: RobotState, t: float = 0.0) -> Array:
        frame, across, d, distance = self._sight(state, t)
        return np.asarray(across @ (frame.angular + cross(d, frame.linear) / distance))

    def drift(self, state: RobotState, t: float = 0.0) -> Array:
        """For a point that stands still, where it is at time t."""
        frame, across, d, distance = self._sight(state, t)
        u, omega = frame.linear @ state.v, frame.angular @ state.v
        passing = np.cross(d, u) / distance
        turning = np.cross(d, frame.linear_drift) / distance + 2.0 * (d @ u) / distance * passing
        return np.asarray(across @ (frame.angular_drift + turning - np.cross(omega, omega + passing)))

    def motion(self, tick: Tick) -> tuple[Array, Array | float]:
        drift = 0.0 if tick.order == "velocity" else self.drift(tick.state, tick.t)
        return self.jacobian(tick.state, tick.t), drift

    def rates(self, state: RobotState, t: float) -> tuple[Array, Array]:
        """What the motion of the point takes."""
        frame, across, d, distance = self._sight(state, t)
        _, velocity, acceleration = self.target(t)
        p_dot, omega = frame.linear @ state.v, frame.angular @ state.v
        u = p_dot - velocity
        change = np.cross(d, acceleration) / distance - np.cross(omega, np.cross(d, velocity)) / distance
        change -= 2.0 * ((d @ u) * np.cross(d, u) - (d @ p_dot) * np.cross(d, p_dot)) / distance**2
        return across @ (np.cross(d, velocity) / distance), across @ change

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        return [("across 1", "rad"), ("across 2", "rad")]

    def _shown(self) -> list[str]:
        return [repr(self.target), f"axis={self.axis.tolist()}", *super()._shown()]
