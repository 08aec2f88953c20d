"""``python -m benchmarks batch``: many hierarchies in one call, compared with a loop over single warm calls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

import numpy as np
import typer

from hqp import Batch, BatchSolver, Hierarchy, Solver
from hqp.commands.options import integer
from hqp.commands.terminal import console

from .families import Family, moved
from .families.control import CONTROL
from .registry import select
from .tables import Row, show, terminal
from .timing import timed

#: How far the targets move since the problems just solved, and how often all is repeated.
SHARE, REPETITIONS = 0.02, 9


def batch(
    family: Annotated[
        list[str] | None, typer.Option("--family", "-f", help="Only this one; may be given several times.")
    ] = None,
    count: Annotated[int, integer("--count", "-n", least=1, help="Hierarchies of each family.")] = 256,
    threads: Annotated[
        list[int] | None, integer("--threads", least=1, help="May be given several times; 1 and 2 by default.")
    ] = None,
) -> None:
    """Race batches, warm after the targets have moved by 2 %, against as many single warm calls."""
    rows = [row for f in select(family, CONTROL, "family") for row in compare(f, count, threads or [1, 2])]
    printer = console(110)
    show(printer, terminal(f"{count} hierarchies, warm, targets moved by {100 * SHARE:g} %", rows, group="problem"))
    printer.print(
        f"us: a hierarchy, median of {REPETITIONS} runs over all; ratio: to a loop over single warm calls, each by a"
        " solver of its own\nproved: certified, and the same to the last bit whatever the number of threads"
    )


def compare(family: Family, count: int, threads: list[int]) -> list[Row]:
    """The loop, and the batch on so many threads."""
    base = list(family.problems(count, 0))
    then = [moved(h, np.random.default_rng([0, k]), SHARE) for k, h in enumerate(base)]
    solvers = [Solver("native") for _ in base]

    def loop(hierarchies: list[Hierarchy]) -> None:
        for solver, hierarchy in zip(solvers, hierarchies, strict=True):
            solver.solve(hierarchy)

    alone = _median(lambda: loop(base), lambda: loop(then))
    rows = [_row(family, "single calls", alone / count, 1.0, "")]
    before, after = Batch.of(base), Batch.of(then)
    first = None
    for number in threads:
        solver = BatchSolver(threads=number)
        seconds = _median(lambda s=solver: s.solve(before), lambda s=solver: s.solve(after))
        solver.solve(before)
        solution = solver.solve(after)
        first = solution.x if first is None else first
        proved = sum(solution[b].certify().ok for b in range(count)) if np.array_equal(first, solution.x) else 0
        name = f"batch, {number} thread{'s' if number > 1 else ''}"
        rows.append(_row(family, name, seconds / count, seconds / alone, f"{proved}/{count}"))
    return rows


def _row(family: Family, what: str, seconds: float, ratio: float, proved: str) -> Row:
    return {
        "problem": family.name,
        "method": what,
        "us": f"{1e6 * seconds:.2f}",
        "ratio": f"{ratio:.3g}",
        "proved": proved,
    }


def _median(before: Callable[[], object], run: Callable[[], object]) -> float:
    """Seconds of `run`, each time right after `before`."""
    seconds = []
    for _ in range(REPETITIONS):
        before()
        seconds.append(timed(run)[0])
    return float(np.median(seconds))
