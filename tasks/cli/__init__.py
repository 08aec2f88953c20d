"""The ``hqp`` command: one small file a subcommand, its imports done when it is called.

Whatever is wrong with the input is told in one line on stderr, with exit code 2. An interruption
(Ctrl-C) ends with exit code 130 and keeps every finished file. See :mod:`hqp.commands.command`; so that this
holds from the start, nothing is imported before.
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
        What to use in place of ``sys.argv[1:]``.
    """
    code = run(arguments)
    if code == command.INTERRUPTED:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # once more ends it without a word
    sys.exit(code)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command; its exit code."""
    return command.run(_app, "hqp", arguments)


def _app(**options: Any) -> Any:
    from .app import app

    return app(**options)
