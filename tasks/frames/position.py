"""Task: the position of a frame."""

from __future__ import annotations

from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.live import number
from ..targets.trajectories import Spread, Trajectory, as_trajectory
from ..targets.turns import position_of
from .placement import Mask, PlacementTask, Reference, as_reference, chosen

AXES = ("x", "y", "z")


class PositionTask(PlacementTask):
    """Bring a frame to a point: the first task of the thesis, r1 of Eq. 4.2.

    Parameters
    ----------
    target : array, shape (3,), or of one number a coordinate of the mask, or Trajectory
        [m]. Two numbers are x and y: the position of a planar arm, or a vertical line for a spatial robot.
    frame : str, optional
        The name of a frame of the robot (default: its tip).
    relative_to : str, optional
        A frame of the robot in place of the world: all coordinates and motions are relative to it.
    reference : {"world", "local", "local_world_aligned"}
        The axes of the rows: of the world (or of `relative_to`), or of the frame itself, which turn with it.
        "local_world_aligned" is Pinocchio's name for the former.
    mask : str or sequence of bool, optional
        The coordinates to be controlled, as in ``"z"`` or ``(False, False, True)``.
    gain : float or array, shape (rows,)
        K [1/s]: the rate at which the error decays.
    damping_ratio : float
        The zeta of acceleration order; 1 is critical damping.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level, against those of other tasks joined by ``+``.
    cap : float or array, shape (rows,), optional
        Length to which the error is cut off, in its unit; a far target is approached at K times that.
    deceleration : float, optional
        The deceleration with which it comes to rest at its target [m/s^2], [rad/s^2].
    name : str, optional
        Used in messages, tables and records (default: "position").

    Raises
    ------
    InvalidInput
        If the target does not fit the mask; and, with a robot, if it has no such frame.

    Examples
    --------
    >>> from tasks import Controller, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> Controller(arm, PositionTask([1.0, 0.2], gain=2.0))(q).v.round(3)
    array([ 0.538,  0.002, -0.206])
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
        size, local = _size(target, self.full_name()), as_reference(reference, self.full_name()) == "local"
        super().__init__(
            mask=chosen("xy" if mask is None and size == 2 and not local else mask, AXES, self.full_name()),
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
        self._two = False  # the mask is chosen: a target of two coordinates no longer takes another one

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """The target position of the frame [m]: three coordinates, or those of the mask; or a trajectory."""
        what = self.full_name()
        trajectory = as_trajectory(position_of(value, what), None, what)
        size, local = len(trajectory(0.0)[0]), self.reference == "local"
        sizes = {3} if local else {len(self.mask), 3} | ({2} if self._two else set())
        if size not in sizes or size not in (3, len(self.mask)):
            raise InvalidInput(
                f"{what}: target has shape ({size},); it must be {' or '.join(f'({n},)' for n in sorted(sizes))}"
            )
        return trajectory

    @property
    def position(self) -> Trajectory:
        """The target as a trajectory of three coordinates, those outside the mask zero."""
        return self.target if len(self.target(0.0)[0]) == 3 else Spread(self.target, self.mask)

    @position.setter
    def position(self, value: ArrayLike | Trajectory) -> None:
        self.target = value

    def _shown(self) -> list[str]:
        mask = "".join(AXES[i] for i in self.mask)
        return [repr(self.target), *super()._shown(), *([] if mask in ("xy", "xyz") else [f"mask={mask!r}"])]


def _size(target: ArrayLike | Trajectory, what: str) -> int:
    """How many coordinates a target has."""
    return len(as_trajectory(position_of(target, what), None, what)(0.0)[0])
