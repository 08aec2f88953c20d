"""``python -m benchmarks solve``: problems of controllers, cold and warm, compared with DAQP's own hierarchy."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.progress import Progress

from hqp import InvalidInput
from hqp.commands.options import integer, real
from hqp.commands.terminal import console
from hqp.files.whole import writable

from .families.control import CONTROL
from .methods import METHODS, required
from .race import COLD, FEW, ONE_SHOT, REPETITIONS, race, raced
from .ratios import table, yardstick
from .registry import select
from .tables import Out, Row, save, show, terminal

#: How far the targets move between two ticks, as a share of their standard deviation.
SHARES = (0.0, 0.02, 0.1)


def solve(
    family: Annotated[
        list[str] | None, typer.Option("--family", "-f", help="Only this one; may be given several times.")
    ] = None,
    method: Annotated[
        list[str] | None,
        typer.Option("--method", "-m", help="Only this one, or any backend; may be given several times."),
    ] = None,
    seeds: Annotated[int, integer("--seeds", least=1, help="Seeds of each family.")] = 8,
    draws: Annotated[int, integer("--draws", least=1, help="Problems of each seed.")] = 8,
    moved: Annotated[
        list[float] | None,
        real("--moved", least=0.0, help="By what share targets move; may be given several times."),
    ] = None,
    out: Out = None,
) -> None:
    """Time solvers on problems of controllers: cold, in one shot, and warm after the targets have moved."""
    families = select(family, CONTROL, "family")
    methods = required(select(method, METHODS, "method")) if method else raced()
    shares = list(dict.fromkeys(SHARES if moved is None else moved))
    if not np.isfinite(shares).all():
        raise InvalidInput(f"--moved {', '.join(map(str, shares))}: give finite shares")
    if out is not None:
        writable(out.parent, [out.name])
    printer = console(110)
    rows: list[Row] = []
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for f in families:
            bar = progress.add_task(f.name, total=seeds * draws)
            timings = race(f, methods, seeds, draws, shares, lambda bar=bar: progress.advance(bar))
            if not timings:
                printer.print(f"{f.name}: left out, no method takes it")
                continue
            here = table(f.name, timings)
            rows += here
            to = yardstick(timings)
            title = f"{f.name}: {f.about}" + (f"; ratios to {to}" if to else "")
            show(printer, terminal(title, here, group="start"))
            if out is not None:
                save(out, rows)
    printer.print(
        f"{COLD}: nothing remembered but the sizes; {ONE_SHOT}: one call of hqp.solve, nothing made before;\n"
        f"2 %: warm, targets moved by so much since the problem just solved\n"
        f"us: best of {REPETITIONS} calls from Python; ratio, its p90: of the ratios, draw by draw\n"
        f"error: largest relative distance from a certified answer; cascades are slow: {FEW} draws at most"
    )
