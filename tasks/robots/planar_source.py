"""Frames of a planar arm for loops."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .._checks import Array
from .robot import RobotState

if TYPE_CHECKING:
    from ..rows.plan import Call
    from .planar import PlanarArm


class PlanarSource:
    """Every frame by a loop over the links; see :class:`tasks.rows.blocks.Source`.

    Parameters
    ----------
    arm : PlanarArm
    q, v : array, shape (n,)
        They hold the state of the tick.
    """

    def __init__(self, arm: PlanarArm, q: Array, v: Array) -> None:
        self._arm, self._q, self._v = arm, q, v
        self._matrices: list[Array] = []
        self._biases: list[Array] = []

    def frame(self, name: str | None, block: Array, drifts: Array) -> Call:
        from ..kernels.robots import planar_frame
        from ..rows.plan import Call

        arm = self._arm
        return Call(planar_frame, arm.nv, block, drifts, arm.lengths, self._q, self._v, arm.links_to(name))

    def center_of_mass(self, block: Array, drifts: Array) -> Call:
        raise NotImplementedError("a planar arm does not tell its centre of mass")

    def mass_matrix(self, M: Array) -> None:
        self._matrices.append(M)

    def bias(self, b: Array) -> None:
        self._biases.append(b)

    def update(self, state: RobotState, drifts: bool) -> None:
        for M in self._matrices:
            M[:] = self._arm.mass_matrix(self._q)
        for b in self._biases:
            b[:] = self._arm.bias(self._q, self._v)
