"""Kernels that stand apart: what most solves never come to, and all solvers share, called by addresses.

So they are compiled once, not as a part of every solver; and a single solve, which need not wait for what it does not
need, is started without them. If it needs one, it says so, and is repeated when that is ready.
"""

from __future__ import annotations

from . import layout as at
from .active_set import STALLED
from .call import called_on
from .compile import inner, integer
from .memory import ints


@inner
def proves(here):
    """Whether the certificate accepts x, see :func:`.proof.proves`; False, and LACKS is set, while it is not ready."""
    head = ints(here, 0, at.HEAD)
    if head[at.CERTIFICATE] == 0:
        head[at.LACKS] = 1
        return False
    return called_on(head[at.CERTIFICATE], here, 0) == at.PASSES


@inner
def active_set(here, last, known):
    """The safe method, see :func:`.active_set.active_set`; STALLED, and LACKS is set, while it is not ready."""
    head = ints(here, 0, at.HEAD)
    if head[at.SAFE_METHOD] == 0:
        head[at.LACKS] = 1
        return integer(STALLED), integer(0)
    head[at.LEVEL] = last
    status = called_on(head[at.SAFE_METHOD], here, known)
    return status, head[at.LEVEL]
