"""Frame blocks of one robot, each written once a tick: by loops if the robot has them, else from its states.

See :mod:`tasks.robots.kernels.block` for what a block holds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from ..robots.block import fill
from ..robots.kernels import block as at
from ..robots.robot import Robot, RobotState
from ..robots.source import Flag, Source

if TYPE_CHECKING:
    from ..base.loops import Call


class StateSource:
    """Frame blocks filled from the states of any robot, frame by frame."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._frames: list[tuple[str | None, Array]] = []
        self._centres: list[Array] = []
        self._matrices: list[Array] = []
        self._biases: list[Array] = []

    def frame(self, name: str | None, block: Array, drifts: Flag) -> None:
        self._frames.append((name, block))

    def center_of_mass(self, block: Array, drifts: Flag) -> None:
        self._centres.append(block)

    def axes(self) -> None:
        """A state does not tell them."""

    def mass_matrix(self, M: Array) -> None:
        self._matrices.append(M)

    def bias(self, b: Array) -> None:
        self._biases.append(b)

    def momentum(self, G: Array, drift: Array) -> None:
        raise InvalidInput(f"{self._robot!r} does not tell its momentum")

    def update(self, state: RobotState, drifts: bool) -> None:
        for name, block in self._frames:
            fill(block, state.frame(name), state.v, drifts)
        for block in self._centres:
            fill(block, state.center_of_mass, state.v, drifts)  # type: ignore[attr-defined]  # checked
        for M in self._matrices:
            M[:] = self._robot.mass_matrix(state.q)  # type: ignore[attr-defined]  # checked
        for b in self._biases:
            b[:] = self._robot.bias(state.q, state.v)  # type: ignore[attr-defined]  # checked


class Blocks:
    """The frame blocks that the parts of one stack need, each kept once.

    Parameters
    ----------
    robot : Robot
    source : Source
    n : int
        Joint velocities.
    """

    def __init__(self, source: Source, n: int) -> None:
        self._source, self._n = source, n
        self._blocks: dict[object, Array] = {}
        #: What writes them, when the source is at the state.
        self.calls: list[Call] = []
        self.drifts: Flag = np.zeros(1, dtype=np.int64)

    def frame(self, name: str | None, relative_to: str | None = None) -> Array:
        """The block of a frame, in the coordinates of the world or of another frame."""
        return self._of(("frame", name), relative_to)

    def center_of_mass(self, relative_to: str | None = None) -> Array:
        """The block of the centre of mass, along the axes of the world or of a frame."""
        return self._of(("center of mass", None), relative_to)

    def axes(self) -> Array | None:
        """The Jacobian of all joints, each on its own, (6, n) by columns, or None; see :class:`Source`."""
        return self._source.axes()

    def mass_matrix(self) -> Array:
        """M, shape (n, n)."""
        if "M" not in self._blocks:
            self._blocks["M"] = M = np.zeros((self._n, self._n))
            self._add(self._source.mass_matrix(M))
        return self._blocks["M"]

    def bias(self) -> Array:
        """b, shape (n,)."""
        if "b" not in self._blocks:
            self._blocks["b"] = b = np.zeros(self._n)
            self._source.bias(b)
        return self._blocks["b"]

    def momentum(self) -> tuple[Array, Array]:
        """The map of the centroidal momentum, by columns, shape (6 n,), and its drift, shape (6,)."""
        if "G" not in self._blocks:
            self._blocks["G"], self._blocks["G drift"] = G, drift = np.zeros(6 * self._n), np.zeros(6)
            self._add(self._source.momentum(G, drift))
        return self._blocks["G"], self._blocks["G drift"]

    def update(self, state: RobotState) -> None:
        """Have all of them ready to be written for this state."""
        self._source.update(state, self.drifts.item() != 0)

    def _of(self, key: tuple[str, str | None], relative_to: str | None) -> Array:
        if key not in self._blocks:
            self._blocks[key] = block = np.zeros(at.size(self._n))
            centre = key[0] == "center of mass"
            self._add(
                self._source.center_of_mass(block, self.drifts)
                if centre
                else self._source.frame(key[1], block, self.drifts)
            )
        if relative_to is None:
            return self._blocks[key]
        seen = (*key, relative_to)
        if seen not in self._blocks:
            root, frame, out = self.frame(relative_to), self._blocks[key], np.zeros(at.size(self._n))
            from ..base.loops import Call
            from ..robots.kernels.frames import relative_frame

            self._blocks[seen] = out
            self._add(Call(relative_frame, self._n, out, self.drifts, root, frame))
        return self._blocks[seen]

    def _add(self, call: Call | None) -> None:
        if call is not None:
            self.calls.append(call)
