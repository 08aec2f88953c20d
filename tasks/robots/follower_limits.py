"""The range and speed that mimic joints leave to the joint that they follow."""

from __future__ import annotations

from typing import NamedTuple


class FollowerLimits(NamedTuple):
    """What its followers leave to a joint: lowest and highest position [rad], [m], and speed [rad/s], [m/s]."""

    low: float
    high: float
    speed: float

    def seen_through(self, factor: float, offset: float) -> FollowerLimits:
        """These limits as limits of the follower, where ``follower = factor * leader + offset``."""
        low, high = sorted((factor * self.low + offset, factor * self.high + offset))
        return FollowerLimits(low, high, abs(factor) * self.speed)
