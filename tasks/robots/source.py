"""The protocol by which a robot keeps the numbers of its frames up to date for compiled loops."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..base.checks import Array

if TYPE_CHECKING:
    from ..base.loops import Call
    from .state import RobotState

#: Whether drifts and velocities of frames are needed: one number, 0 for no.
Flag: TypeAlias = NDArray[np.int64]


class Source(Protocol):
    """Keeps the frame blocks and dynamics of one robot up to date, tick after tick."""

    def frame(self, name: str | None, block: Array, drifts: Flag) -> Call | None:
        """Start to keep the block of a frame up to date; the loop for it, or None if :meth:`update` does it."""
        ...

    def center_of_mass(self, block: Array, drifts: Flag) -> Call | None: ...

    def axes(self) -> Array | None:
        """The axis of rotation of every velocity in world axes, or None if unknown or not one axis per velocity.

        They are rows 3 to 5 of a column-major array (6, n), which is written before any loop runs.
        """
        ...

    def mass_matrix(self, M: Array) -> Call | None: ...

    def bias(self, b: Array) -> None: ...

    def momentum(self, G: Array, drift: Array) -> Call | None:
        """Start to keep the centroidal momentum matrix up to date, (6, n) column-major, and its drift ``dG v`` (6,)."""
        ...

    def update(self, state: RobotState, drifts: bool) -> None:
        """Compute the numbers that the loops read, at this state."""
        ...
