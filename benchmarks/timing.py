"""Timing of one call."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def undisturbed() -> Iterator[None]:
    """A context without the garbage collector."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def timed(call: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of a call, and what it returns."""
    with undisturbed():
        start = time.perf_counter_ns()
        answer = call()
        end = time.perf_counter_ns()
    return 1e-9 * (end - start), answer
