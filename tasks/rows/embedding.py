"""Rows of the joint motion inside rows of all unknowns, of which the forces of contacts are the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base.checks import Array
from .unknowns import Unknowns

if TYPE_CHECKING:
    from ..base.loops import Call
    from .row_writer import RowWriter


class Embedding:
    """Gives parts that know of joints alone rows to write, and copies these into the hierarchy.

    Parameters
    ----------
    unknowns : Unknowns
    """

    def __init__(self, unknowns: Unknowns) -> None:
        self._unknowns = unknowns
        self._pairs: list[tuple[RowWriter, Array, Array]] = []

    def of_joints(self, part: RowWriter, rows: Array) -> Array:
        """Where a part writes, shape (rows, nv): in its rows of the hierarchy, or, where these are wider, beside them.

        A part that is `wide` writes all of them itself, (rows, n).
        """
        n, nv = self._unknowns.n, self._unknowns.nv
        if part.wide or n == nv:
            return rows
        joints = rows[:, :nv].copy()
        self._pairs.append((part, joints, rows))
        return joints

    def calls(self) -> list[Call]:
        """The loop that copies what changes, every tick."""
        moving = [(joints, rows) for part, joints, rows in self._pairs if not part.plain]
        if not moving:
            return []
        from ..base.loops import Call, Table
        from .kernels.embedding import embed_joints

        told = [entry for joints, rows in moving for entry in (joints, rows, len(rows))]
        return [Call(embed_joints, len(moving), self._unknowns.nv, self._unknowns.n, Table(*told))]

    def copy_plain(self) -> None:
        """Copy rows that stay as they are."""
        for part, joints, rows in self._pairs:
            if part.plain:
                rows[:, : self._unknowns.nv] = joints
