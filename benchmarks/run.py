"""``python -m benchmarks run``: measure a plan, on one core or many; finished cells are kept."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from hqp import InvalidInput
from hqp.commands.options import integer, path
from hqp.commands.terminal import console
from hqp.files.whole import writable

from .extra import required_packages
from .sweep.plans import PLANS

_INCOMPLETE = 1


def run(
    plan: Annotated[str, typer.Argument(help="Which plan: see 'list'.")] = "full",
    family: Annotated[
        list[str] | None, typer.Option("--family", "-f", help="Only these: a key or a pattern, as in 'motion/*'.")
    ] = None,
    method: Annotated[
        list[str] | None, typer.Option("--method", "-m", help="Only these: a name or a pattern, as in 'cascade:*'.")
    ] = None,
    setting: Annotated[list[str] | None, typer.Option("--setting", "-s", help="Only these.")] = None,
    draws: Annotated[int | None, integer("--draws", least=1, help="Problems of each family.")] = None,
    seed: Annotated[int | None, integer("--seed", least=0)] = None,
    jobs: Annotated[int, integer("--jobs", "-j", help="Processes; -1 for one a core.")] = 1,
    dask: Annotated[
        str | None,
        typer.Option("--dask", help="Address of a Dask scheduler, as in tcp://10.0.0.1:8786.", metavar="ADDRESS"),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Where the run is kept, and goes on.", parser=path)
    ] = None,
) -> None:
    """Measure families x methods x settings. The same call continues an interrupted run.

    The picture of the run is put beside its cells; the last line says which backend to use, for what.
    Exit code 1 if a cell could not be measured.
    """
    required_packages()
    from .analysis.advice import conclude
    from .analysis.summary import summary
    from .sweep.store import Store, place
    from .sweep.workers import Failed

    if jobs == 0:
        raise InvalidInput("--jobs 0: give a number of processes, or -1 for one a core")
    if jobs != 1 and dask is not None:
        raise InvalidInput("--jobs and --dask: give one of them")
    if plan not in PLANS:
        raise InvalidInput(f"unknown plan {plan!r}; there are {', '.join(PLANS)}")
    asked = {"families": family, "methods": method, "settings": setting, "draws": draws, "seed": seed}
    changed = {
        name: tuple(value) if isinstance(value, list) else value for name, value in asked.items() if value is not None
    }
    resolved, left_out = replace(PLANS[plan], **changed).resolved()
    folder = out or place(resolved)
    writable(folder, [])
    store = Store.begin(folder, resolved, left_out)
    printer = console(120)
    for line in left_out:
        printer.print(f"left out: {line}", markup=False)
    everything, missing, failed = len(resolved.cells()), store.missing(), []
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    screen = Console(stderr=True)
    with Progress(*columns, console=screen, transient=True, disable=not screen.is_terminal) as progress:
        bar = progress.add_task("cells", total=everything, completed=everything - len(missing))
        for cell, result in _worked(resolved, missing, jobs, dask):
            if isinstance(result, Failed):
                failed.append(store.fail(cell, result.why))
            else:
                store.add(cell, result.rows, result.machine)
            progress.update(bar, advance=1, description=cell.name)
    if len(failed) < everything:
        summary(printer, store)
    printer.print(f"{everything - len(failed)} of {everything} cells in {folder}", markup=False, soft_wrap=True)
    for file in failed:
        printer.print(f"not measured, see {file}", markup=False, soft_wrap=True)
    if len(failed) < everything:
        conclude(printer, store)
    if failed:
        raise typer.Exit(_INCOMPLETE)


def _worked(plan: object, cells: Sequence[object], jobs: int, dask: str | None) -> Iterator[tuple[object, object]]:
    """Measure the cells: in this process, in several, or on a cluster."""
    from hqp import Solver
    from hqp.certificate import judging

    from .sweep import workers

    if not cells:
        return iter(())
    Solver("native")  # compiled once, not by every process
    judging.warm_up()
    if dask is not None:
        return workers.cluster(plan, cells, dask)
    if jobs != 1:
        return workers.processes(plan, cells, jobs)
    return workers.serial(plan, cells)
