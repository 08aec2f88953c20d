"""What the programs here share: a target that swings, and how far a motion was off."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tasks import Record

Array = NDArray[np.float64]


class Swing:
    """center + amplitude sin(rate t + phase), with its velocity and acceleration for the feed-forward."""

    def __init__(self, center: ArrayLike, amplitude: ArrayLike, rate: float, phase: float = 0.0) -> None:
        self.center, self.amplitude = np.broadcast_arrays(np.asarray(center, float), np.asarray(amplitude, float))
        self.rate, self.phase = rate, phase

    def __call__(self, t: float) -> tuple[Array, Array, Array]:
        angle = self.rate * t + self.phase
        wave = self.amplitude * np.sin(angle)
        return self.center + wave, self.rate * self.amplitude * np.cos(angle), -(self.rate**2) * wave


def off(record: Record, *names: str, since: float = 0.0) -> float:
    """The largest distance of these tasks from their targets since a time [mm], or the largest angle [mrad]."""
    return max(1e3 * float(np.linalg.norm(record.errors[name][record.t >= since], axis=1).max()) for name in names)
