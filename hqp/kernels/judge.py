"""The entry of the certificate: for a point that anybody has found, and for solvers that call it by its address."""

from __future__ import annotations

from . import layout as at
from .compile import entry, stamp
from .memory import given, ints
from .proof import proves
from .solver import load


@stamp
@entry
def judge(here, numbers):
    """Judge x, in the memory of this directory.

    It is that of the hierarchy at the address `numbers`, which must be valid; if that is 0, of one that a solver has
    loaded, with its ``side``.

    Returns
    -------
    failed : int
        The first level that fails, or PASSES; see :func:`.proof.proves`.
    """
    if numbers != 0:
        given(here, numbers)
        load(here, False, True)
    proves(here)
    return ints(here, 0, at.HEAD)[at.FAILS]
