"""``hqp thesis``: the figures of chapter 4 and the table of its claims."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .command import path


def thesis(
    figure: Annotated[
        list[str] | None,
        typer.Option(
            "--figure", "-f", help="A figure of chapter 4, such as 4.7; may be given several times.", metavar="N"
        ),
    ] = None,
    backend: Annotated[
        str | None, typer.Option("--backend", "-b", help="The solver; see 'hqp backends'.", metavar="NAME")
    ] = None,
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for figures and tables.", metavar="DIR", parser=path)
    ] = Path("out/thesis"),
) -> None:
    """Simulate figures of the thesis, draw them, and check what its text says of them.

    Without --figure: figures 4.6 to 4.9. Every figure, and its rows of claims.md and claims.csv, is on
    disk as soon as it is finished.
    """
    from ..thesis.report import DEFAULT_FIGURES, report

    report(figure or DEFAULT_FIGURES, backend, out)
