"""What is printed when a run is done: one row a method, ratios first."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ..sweep.cell import STARTS
from ..tables import Row, terminal
from .metrics import METRICS, entrants, of_entrant, ratios

if TYPE_CHECKING:
    from rich.console import Console

    from ..sweep.store import Store

#: To whose time those of the others are compared, where it took part.
YARDSTICK = ("native", "tight")
_SHOWN = ("problems", "certified", "silent", "failures", "gap", "violation", "late")


def overview(rows: pd.DataFrame) -> list[Row]:
    """One row an entrant, over all families of these rows."""
    times = {start: ratios(rows[rows["start"] == start], YARDSTICK) for start in STARTS}
    table = []
    for method, setting in entrants(rows):
        mine = of_entrant(rows, method, setting)
        row = {"method": method, "setting": setting}
        for start in STARTS:
            here = mine[mine["start"] == start]
            row[f"{start} ratio"] = ratio(times[start].reindex(here.index))
            row[f"{start} us"] = METRICS["median"].text(here)
        table.append(row | {name: METRICS[name].text(mine) for name in _SHOWN})
    return table


def ratio(values: pd.Series) -> str:
    """Their median, or nothing where there is none."""
    middle = values.median()
    return "" if np.isnan(middle) else f"{middle:.{0 if middle >= 100 else 1 if middle >= 10 else 2}f}"


def summary(printer: Console, store: Store) -> None:
    """Print the overview of what a run has so far."""
    rows = store.table()
    problems = rows.drop_duplicates(["family", "seed", "draw"])
    title = f"{store.plan.name}: {len(problems)} problems of {problems['family'].nunique()} families"
    printer.print(terminal(title, overview(rows)))
    printer.print(
        f"ratio: to {YARDSTICK[0]}, median of the ratios, problem by problem; us: median of the shortest rounds\n"
        "certified, silent, failures, late: % of the answers, cold and warm; see 'list' for what the columns mean"
    )
