"""Ctrl-C for a child that is to hear it, whatever shell the tests themselves run in."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def heard() -> Iterator[None]:
    """What is started in here can be interrupted.

    A job in the background, and all that it starts, ignores SIGINT: that is inherited, and Python then raises no
    KeyboardInterrupt. Only a signal that is ignored is inherited as such, so for this long it is not.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
