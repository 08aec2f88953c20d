"""The length of x that tolerances are relative to, not shorter than the round-off of the way x came."""

from __future__ import annotations

from . import layout as at
from .compile import inner
from .memory import ints, vector
from .orthogonal import length


@inner
def extent(x, here):
    """The length of x to which tolerances are relative, and what the round-off of x_0, where x comes from, adds."""
    return length(x, ints(here, 0, at.HEAD)[at.N]) + vector(here, at.OPTION)[at.BLUR]


@inner
def far(here):
    """Whether x is so much shorter than x_0, where it comes from, that the round-off of that shows."""
    return vector(here, at.OPTION)[at.BLUR] > length(vector(here, at.X), ints(here, 0, at.HEAD)[at.N])
