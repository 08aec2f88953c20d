"""The entry of the safe method, for solvers that call it by its address."""

from __future__ import annotations

from . import layout as at
from .active_set import active_set
from .compile import entry, stamp
from .memory import ints


@stamp
@entry
def safe_method(here, known):
    """Solve levels 0 .. LEVEL from x, of which those above `known` are optimal there; see :func:`.active_set`.

    Returns
    -------
    status : int
        LEVEL is that of the status.
    """
    head = ints(here, 0, at.HEAD)
    status, head[at.LEVEL] = active_set(here, head[at.LEVEL], known)
    return status
