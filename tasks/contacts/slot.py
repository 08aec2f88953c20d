"""State of a contact in a controller: whether it is on, where it was made, and how large its forces may be now.

The rows of a contact always exist. While a contact is off its rows have no bounds and its forces are fixed at 0. So the
structure of the hierarchy does not change when a foot is lifted or put down.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..base.checks import Array
from ..targets.timing import Timing, cubic
from .kernels import layout as at

#: How far the bounds of the motion open during a release, just before they are removed [m/s^2].
WIDE = 100.0


class Slot:
    """What a contact keeps from tick to tick.

    Parameters
    ----------
    points : int
        Number of points whose normal forces are bounded.

    Attributes
    ----------
    numbers : array
        Numbers that the loops of the contact read and write, see :mod:`tasks.contacts.kernels.layout`.
    caps : array, shape (points,)
        The largest normal force at each point at present [N].
    axes : array, shape (18,)
        At the last tick, in world coordinates: the axes t1, t2 and n of the surface, then the rotation matrix of the
        frame, row by row.
    surface : array
        Pose and velocity of the surface.
    """

    def __init__(self, points: int) -> None:
        self.numbers = np.zeros(at.SLOT_SIZE)
        self.numbers[[at.ON, at.LOADED, at.BEARS]] = 1.0
        self.caps = np.full(points, np.inf)
        self.axes = np.concatenate([np.eye(3).ravel()] * 2)
        self.surface = np.zeros(at.SURFACE_SIZE)
        self.surface[at.R : at.R + 9] = np.eye(3).ravel()
        self._ramp: Callable[[float], None] | None = None

    @property
    def on(self) -> bool:
        """Whether the contact is on; also True while it is being released."""
        return bool(self.numbers[at.ON])

    @property
    def loaded(self) -> bool:
        """Whether the contact may have forces."""
        return bool(self.numbers[at.LOADED])

    @property
    def bears(self) -> bool:
        """Whether it counts as support: on, and not being released."""
        return bool(self.numbers[at.BEARS])

    def release(self, forces: Array, duration: float, law: Timing = cubic) -> None:
        """Lower the caps of the normal forces to 0 in `duration` [s], then open the bounds of the motion in as long."""
        self.numbers[at.BEARS] = 0.0

        def ramp(share: float) -> None:
            if share < 1.0:
                self.caps[:] = forces * (1.0 - law(share)[0])
            elif share < 2.0:
                self.caps[:] = self.numbers[at.LOADED] = 0.0
                self.numbers[at.OPEN] = WIDE * law(share - 1.0)[0]
            else:
                self.let_go()

        self._begin(ramp, duration, 2.0)

    def make(self, most: float, duration: float, law: Timing = cubic) -> None:
        """Hold the position from now on; the cap on the sum of normal forces rises to `most` [N] in `duration` [s]."""
        self.numbers[[at.ON, at.LOADED, at.BEARS]] = 1.0
        self.numbers[[at.TAKEN, at.OPEN]] = 0.0

        def ramp(share: float) -> None:
            self.caps[:] = most / len(self.caps) * law(share)[0] if share < 1.0 else np.inf
            if share >= 1.0:
                self._ramp = None

        self._begin(ramp, duration, 1.0)

    def _begin(self, ramp: Callable[[float], None], duration: float, end: float) -> None:
        """Start a ramp at the next tick; its argument is the time since then, divided by `duration` [s]."""
        begin: float | None = None

        def at_time(t: float) -> None:
            nonlocal begin
            begin = t if begin is None else begin
            ramp(end if duration == 0.0 else (t - begin) / duration)

        self._ramp = at_time

    def let_go(self) -> None:
        """Switch the contact off."""
        self.numbers[[at.ON, at.LOADED, at.BEARS, at.OPEN]] = self.caps[:] = 0.0
        self._ramp = None

    def move(self, t: float) -> None:
        """Advance the ramp to time t [s]."""
        if self._ramp is not None:
            self._ramp(t)
