"""Measurements as rows: for the terminal, and as CSV."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from .measure import YARDSTICK, Measurement

COLUMNS = ("backend", "cold us", "warm us", "p99 us", "ratio", "error", "certified", "rejected", "failed")


def rows(measurements: Sequence[Measurement]) -> list[tuple[str, ...]]:
    """One row a backend, in the order of `COLUMNS`; ratio: median of warm times over the yardstick's, pair by pair."""
    yardstick = next((m for m in measurements if m.backend == YARDSTICK), None)
    table = []
    for m in measurements:
        ratio = "" if yardstick is None else f"{np.median(np.divide(m.warm, yardstick.warm)):.2f}"
        table.append(
            (
                m.backend,
                f"{1e6 * np.median(m.cold):.0f}",
                f"{1e6 * np.median(m.warm):.0f}",
                f"{1e6 * np.quantile(m.warm, 0.99):.0f}",
                ratio,
                f"{m.error:.0e}",
                f"{m.certified / m.solved:.2%}",
                f"{m.rejected / m.solved:.2%}",
                str(m.failed),
            )
        )
    return table


def terminal(title: str, measurements: Sequence[Measurement]) -> Table:
    """A table that fits 90 columns."""
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    for column in COLUMNS:
        table.add_column(column, justify="left" if column == "backend" else "right", no_wrap=True)
    for row in rows(measurements):
        table.add_row(*row)
    return table


def save(path: Path, measurements: Sequence[Measurement]) -> None:
    """All families into one CSV file."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("family", *COLUMNS))
        for family in dict.fromkeys(m.family for m in measurements):
            group = [m for m in measurements if m.family == family]
            writer.writerows((family, *row) for row in rows(group))
