"""``hqp validate``: every backend against closed forms, known answers, singularities, certificate and each other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .options import integer, path
from .terminal import console

OUTSIDE_ITS_CLASS = 1


def validate(
    count: Annotated[
        int,
        integer(
            "--count", "-n", least=1, help="Random stacks a case; a fifteenth as many at every σ, a fifth at each size."
        ),
    ] = 20,
    backend: Annotated[
        list[str] | None,
        typer.Option("--backend", "-b", help="Only this one; may be given several times.", metavar="NAME"),
    ] = None,
    seed: Annotated[int, integer("--seed", least=0, help="Seed of the random stacks.")] = 0,
    jobs: Annotated[int, integer("--jobs", "-j", help="Processes; -1 for one a core.")] = -1,
    cases: Annotated[bool, typer.Option("--cases", help="Print one row a case, not one a backend.")] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Folder for the report: text, picture, numbers.", metavar="DIR", parser=path),
    ] = None,
) -> None:
    """Check every backend against closed forms and known answers.

    The closed forms are Eq. 3.17 and Eq. 4.8 of the thesis, near singularities too. Random hierarchies, with
    inequalities at every level, are judged by the certificate, and the backends are compared with each other.

    With --out, validation.md, validation.png and validation.csv are written there. Exit code 1 if a backend is less
    accurate than its class promises, except where the rank is undecidable.
    """
    from ..backends import available_backends, backend_info
    from ..errors import InvalidInput
    from ..files.whole import writable
    from ..validation import report, tables
    from ..validation.results import run

    if jobs == 0:
        raise InvalidInput("--jobs 0: give a number of processes, or -1 for one a core")
    names = list(dict.fromkeys(backend_info(name).name for name in backend or available_backends()))
    if out is not None:
        writable(out, report.FILES)
    results = run(names, count, seed, jobs)

    printer = console(120 if cases else 80)
    for table in tables.closed_forms(results.reports, cases):
        printer.print(table.terminal())
    printer.print(
        "x, residual: largest relative difference from the closed form\n"
        "solved, met: levels a stack which the named QP solver solved, and which needed none\n"
    )
    for table in tables.near_singular(results.points, cases):
        printer.print(table.terminal())
    printer.print(
        "σ: the smallest singular value; from 1e-6 up everybody has to keep its direction, from 1e-12\n"
        "down nobody. x, residual, outside: between these the rank is not decidable; shown, not judged\n",
        soft_wrap=True,
    )
    printer.print(tables.two_formulas(results.partings).terminal())
    printer.print(tables.random_hierarchies(results.judgements, cases).terminal())
    printer.print(
        "proved: by the certificate; refuted: at a level which the backend claims; failed: not claimed;\n"
        "beaten: another backend attains less at a level, and the same above\n",
        soft_wrap=True,
    )
    printer.print(tables.known(results.findings).terminal())
    missed = tables.misses(results.findings)
    if missed.rows:
        printer.print(missed.terminal())
    if out is not None:
        report.write(results, out)
        printer.print(f"{', '.join(report.FILES)}: in {out}", soft_wrap=True)
    if results.wrong:
        printer.print(f"outside their class: {', '.join(results.wrong)}", style="bold red", soft_wrap=True)
        raise typer.Exit(OUTSIDE_ITS_CLASS)
    solves = sum(item.count for item in results.reports)
    near, whole = sum(len(point.x) for point in results.points), sum(item.count for item in results.judgements)
    printer.print(f"{solves} solves, every backend inside its class", style="green")
    printer.print(
        f"{near} near singularities, {whole} of random hierarchies, {len(results.findings)} of known answers, too",
        style="green",
        soft_wrap=True,
    )
