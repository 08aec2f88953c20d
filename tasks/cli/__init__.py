"""The ``hqp`` command: one small file a subcommand, its imports done when it is called.

Whatever is wrong with the input is told in one line on stderr, with exit code 2. An interruption
(Ctrl-C) ends with exit code 130 and keeps every finished file.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from .backends import backends
from .thesis import thesis
from .validate import validate

WRONG_INPUT, INTERRUPTED = 2, 130

app = typer.Typer(
    name="hqp",
    help="Strict task priorities as a lexicographic sequence of QPs, with proof.",
    rich_markup_mode=None,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command()(thesis)
app.command()(validate)
app.command()(backends)


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and leave.")] = False,
) -> None:
    if version:
        from hqp import __version__

        print(f"hqp {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())


# Newer typer carries a click of its own; BadParameter leads to the common base of either's errors.
_CommandLineError: type[typer.BadParameter] = typer.BadParameter.__mro__[2]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command and leave with its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        What to use in place of ``sys.argv[1:]``.
    """
    sys.exit(run(arguments))


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command; its exit code."""
    from hqp import HqpError

    try:
        code = app(args=None if arguments is None else list(arguments), prog_name="hqp", standalone_mode=False)
    except (typer.Abort, KeyboardInterrupt):
        code = INTERRUPTED
    except _CommandLineError as error:
        return _told(error.format_message(), WRONG_INPUT)
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        return _told(f"{place}{error.strerror or error}", WRONG_INPUT)
    except HqpError as error:
        return _told(str(error), WRONG_INPUT)
    if code == INTERRUPTED:
        return _told("interrupted; what was finished is kept", INTERRUPTED)
    return code if isinstance(code, int) else 0


def _told(message: str, code: int) -> int:
    print("hqp: " + " ".join(message.split()), file=sys.stderr)
    return code
