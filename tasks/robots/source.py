"""The protocol by which a robot keeps the numbers of its frames up to date for compiled loops."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..base.checks import Array

if TYPE_CHECKING:
    from ..base.loops import Call
    from .state import RobotState

#: Whether drifts and velocities are asked for, of all frames: one number, 0 or not.
Flag: TypeAlias = NDArray[np.int64]


class Source(Protocol):
    """Keeps the frame blocks and dynamics of one robot up to date, tick after tick."""

    def frame(self, name: str | None, block: Array, drifts: Flag) -> Call | None:
        """Begin to keep the block of a frame; the loop that does, or None if :meth:`update` does it itself."""
        ...

    def center_of_mass(self, block: Array, drifts: Flag) -> Call | None: ...

    def axes(self) -> Array | None:
        """Along what every velocity turns, in the axes of the world: rows 3 to 5 of (6, n), by columns, written before
        any loop runs. None where that is not known, or not one axis a velocity."""
        ...

    def mass_matrix(self, M: Array) -> Call | None: ...

    def bias(self, b: Array) -> None: ...

    def momentum(self, G: Array, drift: Array) -> Call | None:
        """Begin to keep the map of the centroidal momentum, by columns (6 x n), and its drift ``dG v`` (6,)."""
        ...

    def update(self, state: RobotState, drifts: bool) -> None:
        """Compute the numbers that the loops read, at this state."""
        ...
