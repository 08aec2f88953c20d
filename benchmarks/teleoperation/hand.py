"""How the hand of an operator moves a target: a sum of waves, as data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hqp.arrays import Array
from tasks import quintic
from tasks.base.rotations import exp

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Sway:
    """One wave, which begins where the target is: sin(2 pi rate t + phase) - sin(phase).

    Attributes
    ----------
    rate : float
        [Hz].
    move : tuple, shape (3,)
        Amplitude of the position [m].
    turn : tuple, shape (3,)
        Amplitude of the rotation vector [rad].
    phase : float
        [rad]; with - pi / 2 the wave goes out to twice its amplitude and back, and never to the other side.
    """

    rate: float
    move: Vector = (0.0, 0.0, 0.0)
    turn: Vector = (0.0, 0.0, 0.0)
    phase: float = 0.0

    def at(self, t: float) -> float:
        """The wave at time t [s]."""
        return float(np.sin(2.0 * np.pi * self.rate * t + self.phase) - np.sin(self.phase))


@dataclass(frozen=True)
class Hand:
    """A motion of a target, from rest.

    Attributes
    ----------
    sways : tuple of Sway
        They add up.
    ease : float
        How long it takes until they have their full size [s].
    until : float
        When it stops; then the target stands [s].
    """

    sways: tuple[Sway, ...]
    ease: float = 1.0
    until: float = np.inf

    def at(self, t: float, position: Array, rotation: Array) -> tuple[Array, Array]:
        """The target at time t [s] of a frame that started there."""
        t = min(t, self.until)
        size = quintic(min(t / self.ease, 1.0))[0]
        waves = [size * sway.at(t) for sway in self.sways]
        move, turn = (
            sum(wave * np.asarray(getattr(sway, what)) for wave, sway in zip(waves, self.sways, strict=True))
            for what in ("move", "turn")
        )
        return position + move, exp(turn) @ rotation
