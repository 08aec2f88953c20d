"""The ``hqp`` command and its subcommands."""

from __future__ import annotations

from typing import Annotated

import typer

from hqp.commands.backends import backends
from hqp.commands.convert import convert
from hqp.commands.solve import solve
from hqp.commands.validate import validate

from .ik import Numbers, ik
from .live import live
from .thesis import thesis
from .warmup import warmup

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
app.command()(solve)
app.command()(convert)
app.command(cls=Numbers)(ik)
app.command()(live)
app.command()(warmup)


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
