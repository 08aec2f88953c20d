"""A planar arm in the scenes that spatial robots have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tasks import PlanarArm

from ..ticks.scenes import Scene

#: Of every joint: positions to either side [rad], speed [rad/s], acceleration [rad/s^2].
RANGE, SPEED, ACCELERATION = 2.8, 2.0, 40.0


class Planar(PlanarArm):
    """An arm with limits of all three kinds, and what scenes ask of a robot: a configuration at home, and no base."""

    base = 0

    def __init__(self, lengths: tuple[float, ...], home: tuple[float, ...]) -> None:
        limits = {"position_limit": (-RANGE, RANGE), "velocity_limit": SPEED, "acceleration_limit": ACCELERATION}
        super().__init__(lengths, **limits, name="planar")
        self.home = np.array(home)


@dataclass(frozen=True, kw_only=True)
class PlanarScene(Scene):
    """A scene of a planar arm: its link lengths [m] and its joint angles at the start [rad]."""

    robot: str = "planar"
    lengths: tuple[float, ...]
    home: tuple[float, ...]

    def load(self) -> Planar:
        """The arm."""
        return Planar(self.lengths, self.home)
