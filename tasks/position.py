"""Where a frame is."""

from __future__ import annotations

from numpy.typing import ArrayLike

from hqp import InvalidInput

from .motion.trajectories import Spread, Trajectory, as_trajectory
from .place import Mask, PlaceTask, Reference, as_reference, chosen

AXES = ("x", "y", "z")


class PositionTask(PlaceTask):
    """Bring a frame to a point: the first task of the thesis, r1 of Eq. 4.2.

    Parameters
    ----------
    target : array, shape (3,), or of one number a coordinate of the mask, or Trajectory
        [m]. Two numbers are x and y: all there is of a planar arm, and a line to stay on for a spatial robot.
    frame, relative_to, reference
        See :class:`~tasks.place.PlaceTask`.
    mask : str or sequence of bool, optional
        The coordinates to be controlled, as in ``"z"`` or ``(False, False, True)``.
    gain, damping_ratio, weight, name
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
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.target = as_trajectory(target, None, self.label())
        size, local = len(self.target(0.0)[0]), as_reference(reference, self.label()) == "local"
        axes = chosen("xy" if mask is None and size == 2 else mask, AXES, self.label())
        if size != 3 and (size != len(axes) or local):
            sizes = {3} if local else {2, 3} if mask is None else {len(axes), 3}
            allowed = " or ".join(f"({size},)" for size in sorted(sizes))
            raise InvalidInput(f"{self.label()}: target has shape ({size},); it must be {allowed}")
        super().__init__(
            self.target if size == 3 else Spread(self.target, axes),
            None,
            frame=frame,
            relative_to=relative_to,
            mask=axes,
            reference=reference,
            gain=gain,
            damping_ratio=damping_ratio,
            weight=weight,
            name=name,
        )

    def _shown(self) -> list[str]:
        mask = "".join(AXES[i] for i in self.mask)
        return [repr(self.target), *super()._shown(), *([] if mask in ("xy", "xyz") else [f"mask={mask!r}"])]
