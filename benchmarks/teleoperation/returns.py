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
    since : int
        The tick in which the target came back that time; 0 where `slowest` is None.
    """

    slowest: float | None
    caught: int
    since: int = 0


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
    inside, there = forced <= REACHED, excess <= allowed(speed, gain)
    begins = np.flatnonzero(inside[1:] & ~inside[:-1]) + 1
    slowest, caught = (-1, 0), 0
    for begin in begins:
        stays = np.flatnonzero(~inside[begin:])
        visit = there[begin : begin + int(stays[0]) if len(stays) else None]
        arrived = np.flatnonzero(visit)
        if len(arrived):
            slowest = max(slowest, (int(arrived[0]), int(begin)))
        elif dt * len(visit) > patience:
            caught += 1
    took, since = slowest
    return Returns(None if took < 0 else dt * took, caught, since)


def allowed(speed: Array, gain: float) -> Array:
    """By how much a hand that is there may be off, beside what is forced: `speed` is that of its target [m/s]."""
    return THERE + speed / gain
