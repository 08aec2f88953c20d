"""How soon the hand is at its target again, each time that the target comes back into reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hqp.arrays import Array

#: What is forced up to here counts as in reach [m].
REACHED = 1e-3
#: By how much the hand may be off, beside what following a moving target costs, to be there [m].
THERE = 5e-3


@dataclass(frozen=True)
class Returns:
    """Of all times that the target came back.

    Attributes
    ----------
    slowest : float or None
        How long it took at most until the hand was there [s]; None where it never left, or was never there again.
    caught : int
        How often the hand was not there before the target left again, or the motion ended.
    """

    slowest: float | None
    caught: int


def returns(forced: Array, excess: Array, speed: Array, gain: float, dt: float, patience: float) -> Returns:
    """Whether and how soon the hand follows back into reach.

    Parameters
    ----------
    forced, excess : array, shape (ticks,)
        Distance of the hand from its target that no configuration avoids, and what comes on top of it [m].
    speed : array, shape (ticks,)
        Of the target [m/s]: at a gain K it is followed at a distance of speed / K.
    gain : float
        K [1/s].
    dt : float
        [s].
    patience : float
        The target must stay in reach that long for the hand to count as caught [s].
    """
    inside, there = forced <= REACHED, excess <= THERE + speed / gain
    begins = np.flatnonzero(inside[1:] & ~inside[:-1]) + 1
    times, caught = [], 0
    for begin in begins:
        stays = np.flatnonzero(~inside[begin:])
        visit = there[begin : begin + int(stays[0]) if len(stays) else None]
        arrived = np.flatnonzero(visit)
        if len(arrived):
            times.append(dt * float(arrived[0]))
        elif dt * len(visit) > patience:
            caught += 1
    return Returns(max(times, default=None), caught)
