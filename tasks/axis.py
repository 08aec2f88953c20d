r"""Which way an axis of a frame points, while the frame may turn about it.

With the axis a and the wanted direction d, unit vectors in the world, the shortest turn from a to d is
:math:`\vartheta` about :math:`a \times d`. It has no part along a: two rows, U, perpendicular to the axis in the frame
say all of it,

.. math:: e = U R^T \vartheta \frac{a \times d}{\lVert a \times d \rVert}, \qquad J = U R^T J_\omega.
"""

from __future__ import annotations

from math import atan2
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from ._checks import Array, finite
from .frame_task import FrameTask, Reading
from .motion.trajectories import Trajectory, as_trajectory
from .robots.robot import Robot, RobotState
from .rotations import perpendicular

#: Below this sine a x d has no direction to speak of; at half a turn any is right.
PARALLEL = 1e-9


class AxisTask(FrameTask):
    """Point an axis of a frame in a direction: two rows, and the third rotation stays free.

    Parameters
    ----------
    direction : array, shape (3,), or Trajectory
        d, in the world or in `relative_to`, of any length but 0.
    axis : array, shape (3,)
        a, in the frame; by default its z axis.
    frame, relative_to : str, optional
        See :class:`~tasks.frame_task.FrameTask`.
    gain, damping_ratio, weight, name
        See :class:`tasks.Task`.

    Raises
    ------
    InvalidInput
        If a direction is zero or not finite.
    """

    rows = 2
    spatial: ClassVar[bool] = True

    def __init__(
        self,
        direction: ArrayLike | Trajectory,
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
        self.target = as_trajectory(direction, 3, self.label())
        unit(self.target(0.0)[0], f"{self.label()}: direction")
        self.axis = unit(finite(axis, f"{self.label()}: axis"), f"{self.label()}: axis")
        self._across = perpendicular(self.axis)
        super().__init__(frame, relative_to, gain=gain, damping_ratio=damping_ratio, weight=weight, name=name)

    def _direction(self, t: float) -> tuple[Array, Array, Array]:
        """d, and the angular velocity and acceleration with which it turns by itself, in the world."""
        d, velocity, acceleration = self.target(t)
        square = d @ d
        spin = np.cross(d, velocity) / square
        return d / np.sqrt(square), spin, np.cross(d, acceleration) / square - 2.0 * (d @ velocity) / square * spin

    def error(self, state: RobotState, t: float) -> Array:
        direction = self.seen(state).rotation.T @ self._direction(t)[0]
        turn = shortest_turn(self._across, self.axis, direction)
        return half_a_turn(self.jacobian(state)) if turn is None else turn

    def jacobian(self, state: RobotState) -> Array:
        frame = self.seen(state)
        return np.asarray((self._across @ frame.rotation.T) @ frame.angular)

    def drift(self, state: RobotState) -> Array:
        frame = self.seen(state)
        return np.asarray((self._across @ frame.rotation.T) @ frame.angular_drift)

    def rates(self, state: RobotState, t: float) -> tuple[Array, Array]:
        frame = self.seen(state)
        _, spin, change = self._direction(t)
        across = self._across @ frame.rotation.T
        return across @ spin, across @ (change - np.cross(frame.angular @ state.v, spin))

    def reading(self) -> Reading:
        from .kernels.frames import LOCAL

        return Reading(LOCAL, np.hstack([np.zeros((2, 3)), self._across]))

    def desired_velocity(self, t: float) -> Array:
        return np.concatenate([np.zeros(3), self._direction(t)[1]])

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        return [("across 1", "rad"), ("across 2", "rad")]

    def _shown(self) -> list[str]:
        return [repr(self.target), f"axis={self.axis.tolist()}", *super()._shown()]


def shortest_turn(across: Array, axis: Array, direction: Array) -> Array | None:
    """The shortest turn from an axis to a direction along the two rows `across`, all in one frame [rad], shape (2,).

    None at half a turn, where all ways round are as short.
    """
    turn = np.cross(axis, direction)
    sine, cosine = float(np.linalg.norm(turn)), float(axis @ direction)
    if sine < PARALLEL:
        return np.zeros(2) if cosine > 0.0 else None
    return np.asarray(across @ turn) * (atan2(sine, cosine) / sine)


def half_a_turn(jacobian: Array) -> Array:
    """Half a turn the way round that the joints turn best: along the long axis of what J can do [rad], shape (2,)."""
    if not np.isfinite(jacobian).all():
        return np.full(2, np.nan)
    ways, _, _ = np.linalg.svd(jacobian)
    way = ways[:, 0]
    return np.asarray(np.pi * way * (1.0 if way[np.argmax(np.abs(way))] > 0.0 else -1.0))


def unit(vector: Array, what: str) -> Array:
    """`vector`, made of length one.

    Raises
    ------
    InvalidInput
        If it is not three numbers, or has no direction.
    """
    if vector.shape != (3,):
        raise InvalidInput(f"{what} has shape {vector.shape}; it must be (3,)")
    norm = float(np.linalg.norm(vector))
    if not 0.0 < norm < np.inf:
        raise InvalidInput(f"{what} = {vector.tolist()} has no direction; its length must be positive")
    return vector / norm
