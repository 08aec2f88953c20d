"""Exit of every command: wrong input, Ctrl-C and a closed pipe end it without a traceback."""

from __future__ import annotations

import errno
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any

WRONG_INPUT, INTERRUPTED, UNREAD = 2, 130, 141


def run(app: Callable[..., Any], name: str, arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code.

    Parameters
    ----------
    app : typer.Typer, or what makes and calls one
        What it imports may be interrupted.
    name : str
        As it is called; the last word of it begins what is told on stderr.
    arguments : sequence of str, optional
        Used instead of ``sys.argv[1:]``.

    Returns
    -------
    int
        2 for wrong input, told in one line on stderr; 130 for an interruption (Ctrl-C); 141 where
        stdout is no longer read; otherwise the code of the command, also if stdout is closed.
    """
    _open_what_is_closed()
    with _interruptions() as heard:
        try:
            code = app(args=None if arguments is None else list(arguments), prog_name=name, standalone_mode=False)
            sys.stdout.flush()
        except BaseException as error:
            code = INTERRUPTED if heard else _ended(name, error)
    if code == INTERRUPTED:
        code = _told(name, "interrupted; what was finished is kept", INTERRUPTED)
    try:
        sys.stdout.flush()
    except OSError:  # as was told
        _silence(sys.stdout)
    return code if isinstance(code, int) else 0


def _ended(name: str, error: BaseException) -> int:
    """The exit code for an exception that ended a command, reported in one line; internal errors are raised again."""
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    # So typer and rich answer a broken pipe.
    if isinstance(error.__context__ if isinstance(error, SystemExit) else error, BrokenPipeError):
        _silence(sys.stdout)
        return UNREAD

    import typer

    from ..errors import HqpError

    if isinstance(error, typer.Abort):
        return INTERRUPTED
    # Newer typer carries a click of its own; BadParameter leads to the common base of either's errors.
    wrong_words: type[typer.BadParameter] = typer.BadParameter.__mro__[2]
    if isinstance(error, wrong_words):
        return _told(name, error.format_message(), WRONG_INPUT)
    if isinstance(error, HqpError):
        return _told(name, str(error), WRONG_INPUT)
    if isinstance(error, OSError):
        place = f"{error.filename}: " if error.filename else ""
        return _told(name, f"{place}{error.strerror or error}", WRONG_INPUT)
    if isinstance(error, MemoryError):
        return _told(name, f"it takes more memory than there is: {error}".rstrip(": "), WRONG_INPUT)
    raise error


def _told(name: str, message: str, code: int) -> int:
    try:
        print(f"{name.split()[-1]}: {' '.join(message.split())}", file=sys.stderr, flush=True)
    except OSError:  # nobody reads that either
        _silence(sys.stderr)
    return code


@contextmanager
def _interruptions() -> Iterator[list[int]]:
    """Collect the interruptions (Ctrl-C) inside the block.

    Each is raised as usual, but the interrupted code may turn it into another error, as an import of numpy does.
    """
    heard: list[int] = []

    def hear(number: int, frame: FrameType | None) -> None:
        heard.append(number)
        signal.default_int_handler(number, frame)

    mine = threading.current_thread() is threading.main_thread()
    if not mine or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:  # ignored, or another's
        yield heard
        return
    signal.signal(signal.SIGINT, hear)
    try:
        yield heard
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _open_what_is_closed() -> None:
    """Open the null device for a closed stdout or stderr; otherwise files opened later would take their numbers.

    Python has None for them then, which is no stream to write to.
    """
    for name, number in ("stdout", 1), ("stderr", 2):
        if getattr(sys, name) is None:
            place = os.open(os.devnull, os.O_WRONLY)
            if place != number and not _is_open(number):
                os.dup2(place, number)
                os.close(place)
                place = number
            setattr(sys, name, open(place, "w", encoding="utf-8", closefd=False))  # noqa: SIM115


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError as error:
        return error.errno != errno.EBADF
    return True


def _silence(stream: Any) -> None:
    """Let what is still buffered go nowhere, or it would break once more at the exit."""
    try:
        number = stream.fileno()
    except (OSError, ValueError, AttributeError):  # no file
        return
    place = os.open(os.devnull, os.O_WRONLY)
    os.dup2(place, number)
    os.close(place)
