"""``python -m benchmarks report``, ``plot``, ``export``: a run as a page, as a figure, as a table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hqp import InvalidInput
from hqp.commands.options import file, path
from hqp.commands.terminal import console
from hqp.files.whole import writable

from .extra import required_packages

#: What the files are called that are written.
PAGE, FIGURE, ROWS = ("a page", (".md",)), ("a figure", (".png", ".pdf", ".svg")), ("a table", (".csv", ".parquet"))
Run = Annotated[Path, typer.Argument(help="The folder of a run.", metavar="RUN", parser=path)]


def report(
    run: Run,
    out: Annotated[
        Path, typer.Option("--out", "-o", help="The page; figures go to 'images' beside it.", parser=file(*PAGE))
    ] = Path("out/benchmarks/report/benchmark-results.md"),
) -> None:
    """Write a run as a Markdown page with figures."""
    required_packages()
    from .analysis.report import report as write
    from .sweep.store import Store

    store = Store.open(run)
    images = out.parent / "images"
    writable(out.parent, [out.name])
    writable(images, [])
    printer = console(120)
    if missing := len(store.missing()):
        printer.print(f"the run is not finished: {missing} of {len(store.plan.cells())} cells are missing")
    for written in write(store, out, images):
        printer.print(str(written), markup=False, soft_wrap=True)


def plot(
    run: Run,
    figure: Annotated[str, typer.Argument(help="profiles, growth, accuracy, or tails.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="A PNG, PDF or SVG file.", parser=file(*FIGURE))] = Path(
        "plot.png"
    ),
) -> None:
    """Draw one figure of a run."""
    required_packages()
    from .analysis.figures import FIGURES
    from .sweep.store import Store

    if figure not in FIGURES:
        raise InvalidInput(f"unknown figure {figure!r}; there are {', '.join(FIGURES)}")
    rows = Store.open(run).table()
    writable(out.parent, [out.name])
    FIGURES[figure](rows, out)


def export(
    run: Run,
    out: Annotated[Path, typer.Argument(help="A CSV or Parquet file.", metavar="FILE", parser=file(*ROWS))],
) -> None:
    """Write all rows of a run into one file."""
    required_packages()
    from .sweep.store import Store

    rows = Store.open(run).table()
    writable(out.parent, [out.name])
    if out.suffix.lower() == ".csv":
        rows.assign(gaps=[" ".join(map(repr, map(float, gaps))) for gaps in rows["gaps"]]).to_csv(out, index=False)
    else:
        rows.to_parquet(out, index=False)
