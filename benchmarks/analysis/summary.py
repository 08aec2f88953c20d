"""What is printed when a run is done: one row a method, ratios first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import pandas as pd

from ..sweep.cell import STARTS
from ..tables import Row, show, terminal
from .metrics import METRICS, entrants, of_entrant, ratios

if TYPE_CHECKING:
    from rich.console import Console

    from ..sweep.store import Store

#: To whose time those of the others are compared, where it took part.
YARDSTICK = ("native", "tight")
#: What is told of the answers: on a page, and where there is less room.
_TOLD = ("problems", "certified", "silent", "failures", "gap", "violation", "late")
_BRIEFLY = ("problems", "certified", "silent", "gap", "late")


def overview(rows: pd.DataFrame, metrics: Sequence[str] = _TOLD) -> list[Row]:
    """One row an entrant, over all families of these rows; times of both starts, and these metrics of both together."""
    times = {start: ratios(rows[rows["start"] == start], YARDSTICK) for start in STARTS}
    table = []
    for method, setting in entrants(rows):
        mine = of_entrant(rows, method, setting)
        row = {"method": method, "setting": setting}
        for start in STARTS:
            here = mine[mine["start"] == start]
            row[start] = ratio(times[start].reindex(here.index))
            row[f"{start} us"] = METRICS["median"].text(here)
        table.append(row | {name: METRICS[name].text(mine) for name in metrics})
    return table


def ratio(values: pd.Series) -> str:
    """Their median, or nothing where there is none."""
    known = values.dropna()
    if known.empty:
        return ""
    middle = known.median()
    return f"{middle:.{0 if middle >= 100 else 1 if middle >= 10 else 2}f}"


def summary(printer: Console, store: Store) -> None:
    """Print the overview of what a run has so far."""
    rows = store.table()
    problems = rows.drop_duplicates(["family", "seed", "draw"])
    title = f"{store.plan.name}: {len(problems)} problems of {problems['family'].nunique()} families"
    show(printer, terminal(title, overview(rows, _BRIEFLY)))
    printer.print(
        f"cold, warm: time over that of {YARDSTICK[0]} on the same problem, median; us: median of the times\n"
        "certified, silent (wrong, but claimed), late (over 1 ms): % of the answers; gap: the largest"
    )
