"""``python -m benchmarks backends``: time, accuracy and certified share of every backend on every family."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from hqp import InvalidInput, available_backends, backend_info
from tasks._checks import writable
from tasks._terminal import console
from tasks.cli.command import path

from .families import FAMILIES, select
from .measure import PERTURBATION, YARDSTICK, measure, table
from .tables import Row, save, terminal


def backends(
    count: Annotated[int, typer.Option("--count", "-n", min=1, help="Problems per family.")] = 200,
    backend: Annotated[
        list[str] | None, typer.Option("--backend", "-b", help="Only this one; may be given several times.")
    ] = None,
    family: Annotated[
        list[str] | None, typer.Option("--family", "-f", help="Only this one; may be given several times.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0)] = 0,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Also write the rows to this CSV file.", parser=path)
    ] = None,
) -> None:
    """Measure every backend on every problem family, interleaved in one run."""
    infos = list(dict.fromkeys(backend_info(name) for name in backend or available_backends()))
    chosen = select(family, FAMILIES)
    left_out = {f: why for f in chosen if (why := f.left_out(infos))}
    if len(left_out) == len(chosen):
        raise InvalidInput(f"nothing to measure; {'; '.join(left_out.values())}")
    if out is not None:
        writable(out.parent, [out.name])
    printer = console(110)
    rows: list[Row] = []
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for f in chosen:
            if f in left_out:
                printer.print(left_out[f])
                continue
            bar = progress.add_task(f.name, total=count)
            measured = measure(f, [info.name for info in infos], count, seed, lambda bar=bar: progress.advance(bar))
            here = table(measured)
            rows += here
            printer.print(terminal(f"{f.name}: {f.about} ({count} problems)", here))
            if out is not None:
                save(out, rows)
    printer.print(
        f"cold: a fresh solver; warm: the same problem again; ratio: warm, to {YARDSTICK}, median of pairs\n"
        f"error: largest relative distance from a certified answer; rejected: answers moved by {PERTURBATION:g}"
        " that the certificate refuses"
    )
