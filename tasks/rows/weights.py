"""The weights of all rows of a stack, and the rows of weight 0, which ask for nothing."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..base.checks import Array
from ..robots.robot import Robot

if TYPE_CHECKING:
    from .row_writer import RowWriter
    from .site import Site


class Weights:
    """Writes the weights of parts into a hierarchy; a row of weight 0, which no solver takes, has no bounds instead.

    Parameters
    ----------
    robot : Robot

    Attributes
    ----------
    unbounded : list of (array, array, array of int)
        Of parts with rows of weight 0: lower and upper bounds, to be opened every tick, and which rows.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._parts: list[tuple[RowWriter, Site, Array]] = []
        self._without: list[NDArray[np.intp]] = []
        self.unbounded: list[tuple[Array, Array, NDArray[np.intp]]] = []

    def add(self, part: RowWriter, site: Site, weights: Array) -> None:
        """Add the next part, with its place in the hierarchy."""
        self._parts.append((part, site, weights))
        self._without.append(np.zeros(0, dtype=np.intp))

    def take(self, which: Iterable[int]) -> None:
        """Take the weights that these parts have now, by their numbers."""
        for k in which:
            part, _, place = self._parts[k]
            weights = part.weights(self._robot)
            without = self._without[k] = np.flatnonzero(weights == 0.0)
            place[:], place[without] = weights, 1.0
        pairs = zip(self._parts, self._without, strict=True)
        self.unbounded = [(site.lower, site.upper, rows) for (_, site, _), rows in pairs if rows.size]
