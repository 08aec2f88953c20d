"""The entry of the certificate: a point that anybody has found, judged in memory that is laid out as a solver's."""

from __future__ import annotations

from . import layout as at
from .compile import entry, stamp
from .memory import given, ints
from .proof import proves
from .solver import load


@stamp
@entry
def judge(here, numbers):
    """Judge x for the hierarchy at the address `numbers`, which must be valid, in the memory of this directory.

    Returns
    -------
    failed : int
        The first level that fails, or PASSES; see :func:`.proof.proves`.
    """
    given(here, numbers)
    load(here, False, True)
    proves(here)
    return ints(here, 0, at.HEAD)[at.FAILS]
