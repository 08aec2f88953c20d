"""Python's garbage collector, while what lives long is made: Numba's modules, and what it compiles."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

#: Thresholds of the collector meanwhile. Numba makes millions of objects that live as long as it compiles; the usual
#: thresholds look at them again and again, which takes a sixth of the time.
RARELY = 50_000, 20, 1_000
#: Who may set thresholds. It is not held meanwhile: whoever imports or compiles may wait for others who do.
_LOCK = Lock()
#: The thresholds that were found, by the first of those who are at work.
_FOUND: list[tuple[int, int, int]] = []


@contextmanager
def collected_rarely() -> Iterator[None]:
    """Let the collector look rarely, and leave it as it was found; one that is off, or rarer still, stays."""
    with _LOCK:
        _FOUND.append(_FOUND[0] if _FOUND else gc.get_threshold())
        if 0 < _FOUND[0][0] < RARELY[0]:
            gc.set_threshold(*RARELY)
    try:
        yield
    finally:
        with _LOCK:
            found = _FOUND.pop()
            if not _FOUND:
                gc.set_threshold(*found)
