"""The surface that a contact touches, at rest or moving."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import Array
from ..base.live import Live, structure
from ..rows.site import Move
from ..targets.trajectories import Trajectory, as_trajectory
from ..targets.turns import RotationTrajectory, as_rotation, stands_still
from .kernels import layout as at


class Surface(Live):
    """A body in the world on which a contact stands, such as a cart or a tilting platform.

    Parameters
    ----------
    position : array, shape (3,), or Trajectory
        Position of its origin [m].
    rotation : array, shape (3, 3), or RotationTrajectory, optional
        Its orientation; the normals of contacts are given in its axes.

    Examples
    --------
    >>> from tasks import Contact, Surface, from_rpy
    >>> ramp = Surface([0.0, 0.0, 0.0], from_rpy(0.0, 0.1, 0.0))
    >>> Contact("left_ankle_roll_link", plane=(0.2, 0.1), friction=0.6, surface=ramp, name="left foot")
    Contact('left_ankle_roll_link', friction=0.6, name='left foot')
    """

    position: Trajectory = structure()
    rotation: RotationTrajectory = structure()
    _instead = "a surface that moves takes a trajectory, such as a Setpoint"

    def __init__(
        self,
        position: ArrayLike | Trajectory = (0.0, 0.0, 0.0),
        rotation: ArrayLike | RotationTrajectory | None = None,
    ) -> None:
        self.position = as_trajectory(position, 3, "Surface: position")
        self.rotation = as_rotation(np.eye(3) if rotation is None else rotation, "Surface: rotation")

    def kept_up(self, place: Array) -> tuple[Move, ...]:
        """Write its motion into `place` (:mod:`tasks.contacts.kernels.layout`) now and, if it moves, every tick."""

        def move(t: float) -> None:
            p, velocity, acceleration = self.position(t)
            R, omega, alpha = self.rotation(t)
            place[at.P : at.P + 3], place[at.R : at.R + 9] = p, np.ravel(R)
            place[at.V : at.V + 6] = *velocity, *omega
            place[at.CHANGE : at.CHANGE + 6] = *acceleration, *alpha

        move(0.0)
        return () if stands_still(self.position) and stands_still(self.rotation) else (move,)

    def __repr__(self) -> str:
        return f"Surface({self.position!r}, {self.rotation!r})"
