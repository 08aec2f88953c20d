"""The rows that a softened level hands over: the levels below must keep them at the values that this level reached."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array, length
from .certificate import LevelCertificate

#: How far lower levels may move such a row, in units of the tolerance: more than the kernels neglect as round-off.
MARGIN = 10.0


class Handed(NamedTuple):
    """The rows of one level that lower levels must keep.

    Attributes
    ----------
    level : int
    rows : array, shape (any, n)
        Combinations of its weighted rows, without those that are declared soft.
    length : float
        Norm of all its weighted rows together, to which round-off is relative.
    reached : array, shape (n,)
        The x of its own stage.
    """

    level: int
    rows: Array
    length: float
    reached: Array


def left_alone(handed: Handed, name: str, x: Array, tolerance: float) -> LevelCertificate:
    """Judge whether x keeps these rows at the values that the level reached; the residual is how far x moved them.

    Parameters
    ----------
    handed : Handed
        The rows of the softened level.
    name : str
        Name of the level.
    x : array, shape (n,)
        The point to judge.
    tolerance : float
        As of :func:`hqp.certify`.
    """
    with np.errstate(all="ignore"):  # a huge x is judged without warnings
        moved = length(handed.rows @ (x - handed.reached))
        size = handed.length * (length(x) + length(handed.reached))
    share = moved / size if size > 0.0 else 0.0
    ok = share <= MARGIN * tolerance
    left = "handed over" if not name else f"{name}, handed over"
    return LevelCertificate(
        handed.level, left, ok, moved, share, 0.0 if ok else moved**2 / 2, 0.0 if ok else moved, np.zeros(0)
    )
