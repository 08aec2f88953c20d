"""``python -m benchmarks``: one file for each command."""

from __future__ import annotations

import sys

import typer

from hqp.commands.command import run

from .batch import batch
from .compare import compare
from .compile import compile_
from .ik import ik
from .list import list_
from .parts import parts
from .report import export, plot, report
from .run import run as run_plan
from .singularities import singularities
from .solve import solve
from .teleop import teleop
from .tick import tick

app = typer.Typer(
    help="Measurements: every method on every problem family; what a controller solves, and its tick, against peers.",
    rich_markup_mode=None,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("list")(list_)
app.command("run")(run_plan)
app.command()(report)
app.command()(compare)
app.command()(plot)
app.command()(export)
app.command()(solve)
app.command()(batch)
app.command()(tick)
app.command()(parts)
app.command("compile")(compile_)
app.command()(teleop)
app.command()(ik)
app.command()(singularities)


@app.callback(invoke_without_command=True)
def _root(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())


def main() -> None:
    """Run, and leave with the exit code; see :func:`hqp.commands.command.run`."""
    sys.exit(run(app, "python -m benchmarks"))


if __name__ == "__main__":
    main()
