"""A closed chain as a model file describes it: two frames of a robot that are held together."""

from __future__ import annotations

from typing import NamedTuple

from ..base.checks import Array


class Closure(NamedTuple):
    """Two frames that a file holds together; :meth:`tasks.Loop.of` makes parts of a stack of them.

    Attributes
    ----------
    name : str
        Name of the element in the file.
    a, b : str
        The frames; "universe" is the world.
    at, at_b : array, shape (3,)
        The point of each frame that is held, in the coordinates of that frame [m].
    rotation : array, shape (3, 3), or None
        The axes of a in those of b; None if one may rotate relative to the other.
    """

    name: str
    a: str
    b: str
    at: Array
    at_b: Array
    rotation: Array | None
