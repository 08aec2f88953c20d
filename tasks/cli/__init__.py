"""The ``hqp`` command: one small file per subcommand, which imports what it needs when it is called.

An error in the input gives one line on stderr and exit code 2. An interruption (Ctrl-C) gives exit code 130 and keeps
every finished file; see :mod:`hqp.commands.command`. Nothing is imported before, so that this holds from the start.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence
from typing import Any

from hqp.commands import command


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command and leave with its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Used instead of ``sys.argv[1:]``.
    """
    code = run(arguments)
    if code == command.INTERRUPTED:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # a second Ctrl-C ends the process silently
    sys.exit(code)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    return command.run(_app, "hqp", arguments)


def _app(**options: Any) -> Any:
    from .app import app

    return app(**options)
