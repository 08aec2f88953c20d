"""The length of x to which tolerances are relative; it includes the round-off of the starting point x_0."""

from __future__ import annotations

from . import layout as at
from .compile import inner
from .memory import ints, vector
from .orthogonal import length


@inner
def extent(x, here):
    """``||x||`` + BLUR: x starts at x_0, so round-off of the size of x_0 is in it (see :func:`.solver.note_blur`)."""
    return length(x, ints(here, 0, at.HEAD)[at.N]) + vector(here, at.OPTION)[at.BLUR]


@inner
def far(here):
    """Whether x is so much shorter than its start x_0 that the round-off of x_0 matters: BLUR > ``||x||``."""
    return vector(here, at.OPTION)[at.BLUR] > length(vector(here, at.X), ints(here, 0, at.HEAD)[at.N])
