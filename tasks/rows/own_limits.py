"""The limits of a robot that tells nobody when they are set: looked at every tick."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..robots.robot import Robot

#: The limits that a robot may have of its own.
NAMES = ("position_limit", "velocity_limit", "acceleration_limit", "torque_limit")


class OwnLimits:
    """Whether a robot of somebody's own still has the limits that were taken from it.

    Parameters
    ----------
    robot : Robot
        No :class:`tasks.live.Live`, which would tell.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.note()

    def note(self) -> None:
        """Take those that it has now as known."""
        given = [getattr(self._robot, name, None) for name in NAMES]
        #: What was given, whether it may be written into, and what it held.
        self._known = [(value, not _stays(value), None if value is None else np.array(value)) for value in given]

    def changed(self) -> bool:
        """Whether one of them holds other numbers than those that are known."""
        for name, (given, writeable, numbers) in zip(NAMES, self._known, strict=True):
            value = getattr(self._robot, name, None)
            if value is given and not writeable:
                continue
            if value is None or numbers is None or not np.array_equal(value, numbers):
                return True
        return False


def _stays(value: Any) -> bool:
    """Whether it will hold the same numbers as long as it is the same object."""
    return value is None or (isinstance(value, np.ndarray) and not value.flags.writeable)
