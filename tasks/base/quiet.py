"""Captures what C++ libraries print to stdout and stderr."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from tempfile import TemporaryFile

STDERR = 2


@contextmanager
def caught() -> Iterator[list[str]]:
    """Capture what any library prints to standard error inside the block; the list is filled when the block ends."""
    lines: list[str] = []
    try:
        kept = os.dup(STDERR)
    except OSError:  # a process without standard error
        yield lines
        return
    if sys.stderr is not None:
        sys.stderr.flush()
    with TemporaryFile() as file:
        os.dup2(file.fileno(), STDERR)
        try:
            yield lines
        finally:
            os.dup2(kept, STDERR)
            os.close(kept)
            file.seek(0)
            lines += file.read().decode(errors="replace").splitlines()


def reason(lines: list[str], error: Exception) -> str:
    """Why a library failed, in one line: the first error that it printed, or else the first line of its exception."""
    told = [line.strip().removeprefix("Error:").strip() for line in lines if line.lstrip().startswith("Error")]
    return next(iter(told or str(error).strip().splitlines()), type(error).__name__)
