"""Task: the position of a frame."""

from __future__ import annotations

from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.live import number
from ..targets.trajectories import Spread, Trajectory, as_trajectory
from ..targets.turns import place_of
from .placement import Mask, PlacementTask, Reference, as_reference, chosen

AXES = ("x", "y", "z")


class PositionTask(PlacementTask):
    """Bring a frame to a point: the first task of the thesis, r1 of Eq. 4.2.

    Parameters
    ----------
    target : array, shape (3,), or of one number a coordinate of the mask, or Trajectory
        [m]. Two numbers are x and y: all there is of a planar arm, and a line to stay on for a spatial robot. Of a
        transform, (4, 4) or ``pinocchio.SE3``, and of a PoseSetpoint it is the position.
    frame, relative_to, reference
        See :class:`~tasks.frames.placement.PlacementTask`.
    mask : str or sequence of bool, optional
        The coordinates to be controlled, as in ``"z"`` or ``(False, False, True)``.
    gain, damping_ratio, weight, cap, deceleration, name
        See :class:`tasks.Task`.

    Raises
    ------
    InvalidInput
        If the target does not fit the mask; and, with a robot, if it has no such frame.
    """

    def __init__(
        self,
        target: ArrayLike | Trajectory,
        *,
        frame: str | None = None,
        relative_to: str | None = None,
        mask: Mask | None = None,
        reference: Reference = "world",
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        self._call(name)
        size, local = _size(target, self.label()), as_reference(reference, self.label()) == "local"
        super().__init__(
            mask=chosen("xy" if mask is None and size == 2 and not local else mask, AXES, self.label()),
            reference=reference,
            frame=frame,
            relative_to=relative_to,
            gain=gain,
            damping_ratio=damping_ratio,
            weight=weight,
            cap=cap,
            deceleration=deceleration,
            name=name,
        )
        self._two = mask is None and not local
        self.target = target

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """Where the frame is to be [m]: three coordinates, or those of the mask; or a trajectory."""
        what = self.label()
        trajectory = as_trajectory(place_of(value, what), None, what)
        size, local = len(trajectory(0.0)[0]), self.reference == "local"
        sizes = {3} if local else {len(self.mask), 3} | ({2} if self._two else set())
        if size not in sizes or (size != 3 and size != len(self.mask)):
            raise InvalidInput(
                f"{what}: target has shape ({size},); it must be {' or '.join(f'({n},)' for n in sorted(sizes))}"
            )
        return trajectory

    @property
    def position(self) -> Trajectory:
        """The same among three coordinates."""
        return self.target if len(self.target(0.0)[0]) == 3 else Spread(self.target, self.mask)

    @position.setter
    def position(self, value: ArrayLike | Trajectory) -> None:
        self.target = value

    def _shown(self) -> list[str]:
        mask = "".join(AXES[i] for i in self.mask)
        return [repr(self.target), *super()._shown(), *([] if mask in ("xy", "xyz") else [f"mask={mask!r}"])]


def _size(target: ArrayLike | Trajectory, what: str) -> int:
    """How many coordinates a target has."""
    return len(as_trajectory(place_of(target, what), None, what)(0.0)[0])
