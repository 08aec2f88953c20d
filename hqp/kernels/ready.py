"""Kernels that Python calls: compiled, or read from disk, before their first call."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import int64
from numba.core import event

from .collector import collected_rarely
from .compile import INTERPRETED

#: Of the kernels: two addresses, an outcome.
SIGNATURE = int64(int64, int64)

#: What this process has told of.
_ANNOUNCED: set[str] = set()


class _Announcement(event.Listener):
    """Says in one line that a kernel is being compiled: this takes its time, once."""

    def __init__(self, what: str) -> None:
        self._what = what

    def on_start(self, event: event.Event) -> None:
        if not self.said and self._what not in _ANNOUNCED:
            _ANNOUNCED.add(self._what)
            print(f"hqp: compiling {self._what}, once for this version and machine ...", file=sys.stderr, flush=True)
        self.said = True

    def on_end(self, event: event.Event) -> None:
        """Nothing to say."""

    said = False


def make_ready(function: Any, what: str, signature: Any = SIGNATURE) -> bool:
    """The same for any kernel, by default of two addresses, see :func:`hqp.kernels.compile.entry`."""
    if INTERPRETED or function.signatures:
        return False
    listener = _Announcement(what)
    try:
        with collected_rarely(), event.install_listener("numba:compile", listener):
            function.compile(signature)
    except OSError:  # a full disk: compiled, but not kept
        if not function.signatures:
            raise
    return listener.said


def door(function: Any, signature: Any = SIGNATURE) -> Callable[..., Any]:
    """A kernel that is ready, to be called by its addresses; where the interpreter runs loops, the loop itself.

    No kernel warns: what is beyond all numbers is for a status to report.
    """
    found: Callable[..., Any]
    found = np.errstate(all="ignore")(function) if INTERPRETED else function.get_overload(signature)
    return found
