"""What a kernel works in: a block of integers and one of floats, and the directory that tells where its arrays are."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from . import layout as at


class Workspace:
    """Memory for hierarchies of one structure, laid out by :func:`hqp.kernels.layout.lay_out`.

    Attributes
    ----------
    head : int64 array
        What the kernel is told, and what it reports; see :mod:`hqp.kernels.layout`.
    address : int
        Of the directory.
    x, x_ref : array, shape (n,)
        Views: the next run overwrites them.
    option : array
        Tolerances and limits, in the places of :mod:`hqp.kernels.layout`.
    """

    def __init__(self, structure: tuple[Any, ...], damped: tuple[int, ...] = (), rows: bool = False) -> None:
        directory, self._owned, (ints, floats) = _layout(structure, damped, rows)
        self._directory = directory.copy()
        self._blocks = np.empty(ints, dtype=np.int64), aligned(floats)  # nothing is read before it is written
        self._entries = self._directory[at.HEAD :].reshape(-1, 3)
        for block, places in zip(self._blocks, at.PLACES, strict=True):
            self._entries[places, 0] = block.ctypes.data + 8 * self._entries[places, 0]
        self.head = self._directory[: at.HEAD]
        self.address = int(self._directory.ctypes.data)
        self.x, self.x_ref, self.option = (self.floats(place)[:, 0] for place in (at.X, at.X_REF, at.OPTION))

    def floats(self, place: int) -> Array:
        """The float64 array at this place of the directory: a view."""
        return self._view(self._blocks[1], place)

    def ints(self, place: int) -> NDArray[np.int64]:
        """The int64 array at this place of the directory: a view."""
        return self._view(self._blocks[0], place)

    def _view(self, block: NDArray[Any], place: int) -> NDArray[Any]:
        address, rows, columns = self._entries[place].tolist()
        first = (address - block.ctypes.data) // 8
        return block[first : first + rows * columns].reshape(rows, columns)


def aligned(count: int) -> Array:
    """Room for so many floats, at an address at which a line of the processor's cache begins."""
    room = np.empty(count + at.PAD - 1)
    first = -room.ctypes.data // room.itemsize % at.PAD
    return room[first : first + count]


_layout = lru_cache(maxsize=64)(at.lay_out)
