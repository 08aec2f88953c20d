"""``hqp validate``: every backend against the closed forms of the thesis."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .._terminal import console

if TYPE_CHECKING:
    from rich.table import Table

    from hqp.validation import Report

OUTSIDE_ITS_CLASS = 1


def validate(
    count: Annotated[int, typer.Option("--count", "-n", min=1, help="Random stacks per case.")] = 100,
    backend: Annotated[
        list[str] | None, typer.Option("--backend", "-b", help="Only this one; may be given several times.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of the random stacks.")] = 0,
    jobs: Annotated[int, typer.Option("--jobs", "-j", help="Processes; -1 for one a core.")] = -1,
    cases: Annotated[bool, typer.Option("--cases", help="One row a case, not one a backend.")] = False,
) -> None:
    """Compare every backend with Eq. 3.17 and Eq. 4.8 on random equality stacks in every rank case.

    Exit code 1 if a backend is outside its accuracy class anywhere.
    """
    from joblib import Parallel, delayed
    from rich.console import Console
    from rich.progress import track

    from hqp import Solver, available_backends, backend_info
    from hqp.errors import InvalidInput
    from hqp.problems import equality_cases
    from hqp.validation import FORMULAS, merge, validate_case

    if jobs == 0:
        raise InvalidInput("--jobs 0: give a number of processes, or -1 for one a core")
    names = [backend_info(name).name for name in backend or available_backends()]
    work = [(name, case) for name in names for case in equality_cases()]
    for name in names:
        Solver(name)  # what has to be compiled is compiled once, not by every process
    parallel = Parallel(n_jobs=jobs, return_as="generator")
    done = parallel(delayed(validate_case)(name, case, count, seed) for name, case in work)
    out = console(120 if cases else 80)
    reports = [
        report
        for batch in track(done, "solving", total=len(work), console=Console(stderr=True), transient=True)
        for report in batch
    ]
    for formula, closed_form in FORMULAS.items():
        rows = [report for report in reports if report.formula == formula]
        out.print(_table(f"{formula} ({closed_form})", rows if cases else merge(rows), cases))
    out.print(
        "x, residual: largest relative difference from the closed form\n"
        "solved, met: levels a stack which the named QP solver solved, and which needed none"
    )
    wrong = sorted({report.backend for report in reports if not report.ok})
    if wrong:
        out.print(f"outside their class: {', '.join(wrong)}", style="bold red")
        raise typer.Exit(OUTSIDE_ITS_CLASS)
    out.print(f"{sum(report.count for report in reports)} solves, every backend inside its class", style="green")


def _table(title: str, reports: list[Report], cases: bool) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=0, collapse_padding=True)
    table.add_column("backend", no_wrap=True)
    if cases:
        table.add_column("n; rows, rank", no_wrap=True)
    for column in ("stacks", "x", "residual", "certified", "solved", "met", "ms"):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True, min_width=2)
    for report in reports:
        table.add_row(
            report.backend,
            *([report.case] if cases else []),
            str(report.count),
            f"{report.worst_x:.0e}",
            f"{report.worst_residual:.0e}",
            f"{report.certified / report.count:.1%}",
            f"{report.levels_solved / report.count:.2f}",
            f"{report.levels_met / report.count:.2f}",
            f"{1e3 * report.seconds / report.count:.2f}",
            "ok" if report.ok else f"[bold red]> {report.allowed:.0e}[/]",
        )
    return table
