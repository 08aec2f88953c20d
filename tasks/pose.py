"""Where a frame is and how it is turned, on one level."""

from __future__ import annotations

from numpy.typing import ArrayLike

from .motion.trajectories import Trajectory, as_trajectory
from .motion.turns import RotationTrajectory, as_rotation
from .place import Mask, PlaceTask, Reference, chosen

AXES = ("x", "y", "z", "rx", "ry", "rz")


class PoseTask(PlaceTask):
    """Bring a frame to a point and turn it to a rotation: position and orientation weighed against each other.

    Where they conflict neither has priority; ``PositionTask(...) >> OrientationTask(...)`` gives it to the first.

    Parameters
    ----------
    position : array, shape (3,), or Trajectory
        [m].
    rotation : array, shape (3, 3), or RotationTrajectory
        Its columns are the axes that the frame is to have.
    frame, relative_to
        See :class:`~tasks.place.PlaceTask`.
    mask : str or sequence of bool, optional
        The coordinates to be controlled, as in ``"x y rz"``.
    reference : {"local_world_aligned", "local", "world"}
        Pinocchio's names. Along the axes of the world, the linear rows those of the origin of the frame; along the axes
        of the frame; or the spatial velocity, its linear rows those of the point that is passing the world's origin.
    gain, damping_ratio, weight, name
        See :class:`tasks.Task`; a gain or a weight may be one number a row, in [m] before [rad].
    """

    def __init__(
        self,
        position: ArrayLike | Trajectory,
        rotation: ArrayLike | RotationTrajectory,
        *,
        frame: str | None = None,
        relative_to: str | None = None,
        mask: Mask | None = None,
        reference: Reference = "local_world_aligned",
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        name: str | None = None,
    ) -> None:
        self._call(name)
        super().__init__(
            as_trajectory(position, 3, f"{self.label()}, position"),
            as_rotation(rotation, f"{self.label()}, rotation"),
            frame=frame,
            relative_to=relative_to,
            mask=chosen(mask, AXES, self.label()),
            reference=reference,
            gain=gain,
            damping_ratio=damping_ratio,
            weight=weight,
            name=name,
        )

    def _shown(self) -> list[str]:
        mask = " ".join(AXES[i] for i in self.mask)
        targets = [repr(self.position), repr(self.rotation)]
        return [*targets, *super()._shown(), *([] if self.rows == 6 else [f"mask={mask!r}"])]
