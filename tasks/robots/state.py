"""The state of a robot at one instant, as tasks see it."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from ..base.checks import Array
from .frame import Frame


@runtime_checkable
class RobotState(Protocol):
    """One robot at one instant: everything that tasks of the same tick share, computed once.

    Attributes
    ----------
    q : array, shape (nq,)
        Configuration: joint positions [rad, m], and other numbers of the configuration, if any.
    v : array, shape (nv,)
        Joint velocities [rad/s, m/s].
    """

    @property
    def q(self) -> Array: ...
    @property
    def v(self) -> Array: ...

    def frame(self, name: str | None = None) -> Frame:
        """The frame of that name, by default the tip of the robot."""
        ...
