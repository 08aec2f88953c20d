"""The surface that a contact touches, at rest or moving."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import Array
from ..base.live import Live, structure
from ..rows.site import Move, kept_up
from ..targets.trajectories import Trajectory, as_trajectory
from ..targets.turns import RotationTrajectory, as_rotation
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

        position = place[at.P : at.P + 3], place[at.V : at.V + 3], place[at.CHANGE : at.CHANGE + 3]
        turning = place[at.V + 3 : at.V + 6], place[at.CHANGE + 3 : at.CHANGE + 6]
        rotation = place[at.R : at.R + 9].reshape(3, 3)
        return *kept_up(self.position, *position), *kept_up(self.rotation, rotation, *turning)

    def __repr__(self) -> str:
        return f"Surface({self.position!r}, {self.rotation!r})"
