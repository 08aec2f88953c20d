"""What happened in a closed loop."""

from __future__ import annotations

from dataclasses import dataclass

from hqp import Status

from .._checks import Array


@dataclass(frozen=True)
class Stop:
    """Why a run ended before its time.

    Attributes
    ----------
    t : float
        When [s].
    reason : str
    diverged : bool
        Whether the motion left all bounds; otherwise the solver had no answer.
    """

    t: float
    reason: str
    diverged: bool


@dataclass(frozen=True, eq=False)
class Record:
    """What happened, read-only arrays: N ticks and the N + 1 states around them.

    Attributes
    ----------
    t : array, shape (N + 1,)
        Time [s].
    q, v : array, shape (N + 1, n)
        Joint positions [rad] and velocities [rad/s]; at velocity order v[k + 1] is the command of tick k.
    a : array, shape (N, n)
        Joint accelerations [rad/s^2] over each tick; at velocity order (v[k + 1] - v[k]) / dt.
    pose : array, shape (N + 1, ...)
        Of the tip, in the coordinates of the robot.
    errors : dict of arrays, shape (N + 1, rows)
        Of every task, by its name, desired - actual.
    status : tuple of hqp.Status, length N
    checked, certified : int
        How many ticks were put to the certificate, and how many passed.
    stopped : Stop or None
        None for a run that went to its end.
    """

    t: Array
    q: Array
    v: Array
    a: Array
    pose: Array
    errors: dict[str, Array]
    status: tuple[Status, ...]
    checked: int
    certified: int
    stopped: Stop | None

    @property
    def certified_share(self) -> float:
        """Share of the checked ticks which the certificate accepts; NaN if none was checked."""
        return self.certified / self.checked if self.checked else float("nan")

    @property
    def diverged_at(self) -> float | None:
        """When the motion left all bounds [s], or None."""
        return self.stopped.t if self.stopped and self.stopped.diverged else None

    def __len__(self) -> int:
        """Number of ticks N."""
        return len(self.a)

    def __repr__(self) -> str:
        end = f", stopped: {self.stopped.reason}" if self.stopped else ""
        proof = f", {self.certified} of {self.checked} checked ticks certified" if self.checked else ""
        return f"Record({len(self)} ticks, t = {self.t[0]:g} .. {self.t[-1]:g} s{proof}{end})"
