"""``python -m benchmarks backends``, ``solve``, ``batch``, ``tick``, ``ik``, ``singularities``: a small file each."""

from __future__ import annotations

import sys

import typer

from tasks.cli.command import run

from .backends import backends
from .batch import batch
from .ik import ik
from .singularities import singularities
from .solve import solve
from .teleop import teleop
from .tick import tick

app = typer.Typer(
    help="Measurements: every backend on every problem family; what a controller solves, and its tick, against peers.",
    rich_markup_mode=None,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command()(backends)
app.command()(solve)
app.command()(batch)
app.command()(tick)
app.command()(teleop)
app.command()(ik)
app.command()(singularities)


@app.callback(invoke_without_command=True)
def _root(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())


def main() -> None:
    """Run, and leave with the exit code; see :func:`tasks.cli.command.run`."""
    sys.exit(run(app, "python -m benchmarks"))


if __name__ == "__main__":
    main()
