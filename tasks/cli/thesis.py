"""``hqp thesis``: the figures of the text and the table of its claims."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hqp.commands.options import integer, path


def thesis(
    figure: Annotated[
        list[str] | None,
        typer.Option(
            "--figure",
            "-f",
            help="Which: 2.1, 3.1 to 3.5, 4.1 to 4.37; argument, priorities, workspace; lines, stacks; may be given"
            " several times.",
            metavar="N",
        ),
    ] = None,
    backend: Annotated[
        str | None, typer.Option("--backend", "-b", help="The solver; see 'hqp backends'.", metavar="NAME")
    ] = None,
    law: Annotated[
        list[str] | None,
        typer.Option(
            "--law",
            "-l",
            help="Control law: thesis, strict, limits or damped; may be given several times.",
            metavar="NAME",
        ),
    ] = None,
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for figures and tables.", metavar="DIR", parser=path)
    ] = Path("out/thesis"),
    form: Annotated[
        str,
        typer.Option(
            "--format", help="File format: png, pdf or svg; the plain figures are a png and a pdf, or svg.", metavar="F"
        ),
    ] = "png",
    animate: Annotated[bool, typer.Option("--animate", help="Write each figure as a GIF, too.")] = False,
    jobs: Annotated[int, integer("--jobs", "-j", help="Processes; -1 for one a core.")] = -1,
) -> None:
    """Reproduce the figures of the thesis, and check its claims.

    Without --figure: all of them. Each figure of chapter 4 is drawn in full, all laws side by side, and
    plain, as the text has it, for a paper: of the first law that is asked for. 2.1, 3.1 to 3.5 and 4.1
    are drawings and simulate nothing; lines and stacks are studies, a table each, without a picture.

    What is finished is kept: after an interruption the same command goes on where it was.
    """
    from ..thesis.laws import NAMES
    from ..thesis.report import report

    report(figure or [], backend, out, laws=law or NAMES, form=form, animated=animate, processes=jobs)
