"""The time since a first tick, for what begins there and takes a while."""

from __future__ import annotations


class Stopwatch:
    """Time since the first tick that asks [s].

    If time is set back, as by a second run from t = 0, it goes on from the time that it showed last.
    """

    def __init__(self) -> None:
        self._begin: float | None = None
        self._last = 0.0

    def elapsed(self, t: float) -> float:
        """Time since the first tick that asked, at time t [s]."""
        if self._begin is None:
            self._begin = t
        elif t < self._last:
            self._begin += t - self._last
        self._last = t
        return t - self._begin
