"""State of a contact in a controller: whether it is on, where it was made, and how large its forces may be now.

The rows of a contact always exist. While a contact is off its rows have no bounds and its forces are fixed at 0. So the
structure of the hierarchy does not change when a foot is lifted or put down.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, field

import numpy as np

from ..base.checks import Array
from ..base.stopwatch import Stopwatch
from ..targets.timing import Timing, cubic
from .kernels import layout as at

#: How far the bounds of the motion open during a release, just before they are removed [m/s^2].
WIDE = 100.0


@dataclass
class Ramp:
    """How the caps of the normal forces rise or fall.

    Attributes
    ----------
    forces : array, shape (points,)
        The caps at its upper end [N].
    duration : float
        [s]; a release takes it twice, the second time to open the bounds of the motion.
    law : callable
        Timing law of the caps.
    releases : bool
        Whether they fall.
    """

    forces: Array
    duration: float
    law: Timing
    releases: bool
    since: Stopwatch = field(default_factory=Stopwatch)

    def share(self, t: float) -> float:
        """Time since its first tick, divided by its duration."""
        return self.since.elapsed(t) / self.duration if self.duration > 0.0 else np.inf


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
    lowest : array, shape (1, 3)
        Of what rolls: where it touches at the last tick, in the coordinates of the frame [m].
    """

    def __init__(self, points: int) -> None:
        self.numbers = np.zeros(at.SLOT_SIZE)
        self.numbers[[at.ON, at.LOADED, at.BEARS, at.SHARE]] = 1.0
        self.caps = np.full(points, np.inf)
        self.axes = np.concatenate([np.eye(3).ravel()] * 2)
        self.surface = np.zeros(at.SURFACE_SIZE)
        self.surface[at.R : at.R + 9] = np.eye(3).ravel()
        self.lowest = np.zeros((1, 3))
        self._ramp: Ramp | None = None

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
        self._ramp = Ramp(forces, duration, law, releases=True)

    def make(self, most: float, duration: float, law: Timing = cubic) -> None:
        """Hold the position from now on; the cap on the sum of normal forces rises to `most` [N] in `duration` [s]."""
        self.numbers[[at.ON, at.LOADED, at.BEARS]] = 1.0
        self.numbers[[at.OPEN, at.SHARE]] = 0.0
        self.settle()
        self._ramp = Ramp(np.full(len(self.caps), most / len(self.caps)), duration, law, releases=False)

    def settle(self) -> None:
        """Hold the position that the next tick finds."""
        self.numbers[at.TAKEN] = 0.0

    def let_go(self) -> None:
        """Switch the contact off."""
        self.numbers[[at.ON, at.LOADED, at.BEARS, at.OPEN, at.SHARE]] = self.caps[:] = 0.0
        self._ramp = None

    def take(self, other: Slot) -> None:
        """Become as another slot of the same contact."""
        self.numbers[:], self.caps[:], self._ramp = other.numbers, other.caps, deepcopy(other._ramp)

    def move(self, t: float) -> None:
        """Advance the ramp to time t [s]."""
        ramp = self._ramp
        if ramp is None:
            return
        share = ramp.share(t)
        if not ramp.releases:
            self.numbers[at.SHARE] = ramp.law(share)[0] if share < 1.0 else 1.0
            self.caps[:] = ramp.forces * self.numbers[at.SHARE] if share < 1.0 else np.inf
            self._ramp = ramp if share < 1.0 else None
        elif share < 1.0:
            self.numbers[at.SHARE] = 1.0 - ramp.law(share)[0]
            self.caps[:] = ramp.forces * self.numbers[at.SHARE]
        elif share < 2.0:
            self.caps[:] = self.numbers[[at.LOADED, at.SHARE]] = 0.0
            self.numbers[at.OPEN] = WIDE * ramp.law(share - 1.0)[0]
        else:
            self.let_go()
