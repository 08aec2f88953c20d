"""Frames of a planar arm for loops."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol
from weakref import WeakKeyDictionary

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from .kernels import block as at
from .state import RobotState

if TYPE_CHECKING:
    from ..base.loops import Call
    from .source import Flag


class Links(Protocol):
    """The arm as its loops need it: links, frames and dynamics; see :class:`tasks.robots.planar.PlanarArm`."""

    lengths: Array
    nv: int

    def links_to(self, frame: str | None) -> int: ...

    def mass_matrix(self, q: Array) -> Array: ...

    def bias(self, q: Array, v: Array) -> Array: ...


class PlanarSource:
    """Every frame by a loop over the links; see :class:`tasks.robots.source.Source`.

    Parameters
    ----------
    arm : PlanarArm
    q, v : array, shape (n,)
        They hold the state of the tick.
    """

    def __init__(self, arm: Links, q: Array, v: Array) -> None:
        self._arm, self._q, self._v = arm, q, v
        self._matrices: list[Array] = []
        self._biases: list[Array] = []

    def frame(self, name: str | None, block: Array, drifts: Flag) -> Call:
        return _written(self._arm, block, drifts, self._q, self._v, self._arm.links_to(name))

    def center_of_mass(self, block: Array, drifts: Flag) -> Call:
        raise NotImplementedError("a planar arm does not tell its centre of mass")

    def axes(self) -> None:
        """Asked for with the centre of mass alone."""

    def mass_matrix(self, M: Array) -> None:
        self._matrices.append(M)

    def bias(self, b: Array) -> None:
        self._biases.append(b)

    def momentum(self, G: Array, drift: Array) -> None:
        raise InvalidInput(f"{self._arm!r} does not tell its momentum")

    def update(self, state: RobotState, drifts: bool) -> None:
        for M in self._matrices:
            M[:] = self._arm.mass_matrix(self._q)
        for b in self._biases:
            b[:] = self._arm.bias(self._q, self._v)


class _Ends(threading.local):
    """The loops of this thread, by arm and frame, with the arrays they read and write: q, v, block."""

    def __init__(self) -> None:
        self.of: WeakKeyDictionary[Links, dict[str | None, tuple[Callable[[], object], Array, Array, Array]]]
        self.of = WeakKeyDictionary()


_ends = _Ends()


def block_of(arm: Links, q: Array, v: Array, name: str | None) -> Array:
    """The block of one frame at (q, v)."""
    try:
        run, place, rate, block = _ends.of[arm][name]
    except KeyError:
        place, rate, block = np.zeros(arm.nv), np.zeros(arm.nv), np.zeros(at.size(arm.nv))
        run = _written(arm, block, np.ones(1, dtype=np.int64), place, rate, arm.links_to(name)).run
        _ends.of.setdefault(arm, {})[name] = run, place, rate, block
    place[:], rate[:] = q, v
    run()
    return block.copy()


def _written(arm: Links, block: Array, drifts: Flag, q: Array, v: Array, links: int) -> Call:
    from ..base.loops import Call
    from .kernels.frames import planar_frame

    return Call(planar_frame, arm.nv, block, drifts, arm.lengths, q, v, links)
