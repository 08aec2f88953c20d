"""How every command ends: wrong input, Ctrl-C and a reader who leaves, each without a traceback."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

import typer

WRONG_INPUT, INTERRUPTED, UNREAD = 2, 130, 141

# Newer typer carries a click of its own; BadParameter leads to the common base of either's errors.
_CommandLineError: type[typer.BadParameter] = typer.BadParameter.__mro__[2]


def run(app: typer.Typer, name: str, arguments: Sequence[str] | None = None) -> int:
    """Run a command; its exit code.

    Parameters
    ----------
    app : typer.Typer
    name : str
        As it is called; the last word of it begins what is told on stderr.
    arguments : sequence of str, optional
        What to use in place of ``sys.argv[1:]``.

    Returns
    -------
    int
        2 for wrong input, told in one line on stderr; 130 for an interruption (Ctrl-C); 141 where
        nobody reads stdout any more; otherwise what the command says.
    """
    from hqp import HqpError

    try:
        code = app(args=None if arguments is None else list(arguments), prog_name=name, standalone_mode=False)
        sys.stdout.flush()
    except (typer.Abort, KeyboardInterrupt):
        code = INTERRUPTED
    except _CommandLineError as error:
        return _told(name, error.format_message(), WRONG_INPUT)
    except BrokenPipeError:
        return _unread()
    except SystemExit as leaving:  # so typer and rich answer a broken pipe
        if isinstance(leaving.__context__, BrokenPipeError):
            return _unread()
        raise
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        return _told(name, f"{place}{error.strerror or error}", WRONG_INPUT)
    except HqpError as error:
        return _told(name, str(error), WRONG_INPUT)
    if code == INTERRUPTED:
        return _told(name, "interrupted; what was finished is kept", INTERRUPTED)
    return code if isinstance(code, int) else 0


def path(text: str) -> Path:
    """What follows ``--out``; an empty word is refused, for it would mean the current folder."""
    if not str(text):
        raise typer.BadParameter("it is empty; the current folder is '.'")
    return Path(text)


def _told(name: str, message: str, code: int) -> int:
    print(f"{name.split()[-1]}: {' '.join(message.split())}", file=sys.stderr)
    return code


def _unread() -> int:
    """Let what is still buffered go nowhere, or it would break once more at the exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return UNREAD
