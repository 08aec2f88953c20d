"""Watches the limits of a user's own robot class, which does not report changes, by comparison every tick."""

from __future__ import annotations

import numpy as np

from ..robots.robot import Robot, limits_reader


class OwnLimits:
    """Detects changes of the limits of a robot that is not a :class:`tasks.base.live.Live`.

    Parameters
    ----------
    robot : Robot
        No :class:`tasks.base.live.Live`, which would tell.
    """

    def __init__(self, robot: Robot) -> None:
        self._read = limits_reader(robot)
        self.note()

    def note(self) -> None:
        """Take those that it has now as known."""
        self._given = self._read()
        self._numbers = [None if value is None else np.array(value) for value in self._given]
        #: Whether each may hold other numbers, and be the same object.
        self._open = [not _stays(value) for value in self._given]

    def changed(self) -> bool:
        """Whether one of them holds other numbers than those that are known."""
        for value, given, numbers, is_open in zip(self._read(), self._given, self._numbers, self._open, strict=True):
            if value is given and not is_open:
                continue
            if value is None or numbers is None or not np.array_equal(value, numbers):
                return True
        return False


def _stays(value: object) -> bool:
    """Whether it will hold the same numbers as long as it is the same object."""
    return value is None or (isinstance(value, np.ndarray) and not value.flags.writeable)
