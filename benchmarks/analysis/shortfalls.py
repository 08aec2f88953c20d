"""Families in which the native solver is not certified throughout, or not the fastest."""

from __future__ import annotations

import pandas as pd

from ..tables import Row
from .metrics import METRICS, entrants, of_entrant, ratios, share, solved
from .summary import YARDSTICK


def shortfalls(rows: pd.DataFrame) -> list[Row]:
    """Families and starts in which it is not certified throughout, or another one, no more often wrong, is faster.

    Both are judged on the problems that both were given.
    """
    found = []
    for (family, start), here in rows.groupby(["family", "start"], observed=True):
        native = of_entrant(here, *YARDSTICK)
        if native.empty:
            continue
        missed = 1.0 - native["certified"].mean()
        faster = _faster(here, native)
        if missed or faster:
            found.append(
                {
                    "family": str(family),
                    "start": str(start),
                    "native us": METRICS["median"].text(native),
                    "not certified": share(missed) if missed else "",
                    "faster": ", ".join(f"{name} ({ratio:.2f})" for name, ratio in faster),
                }
            )
    return found


def _faster(here: pd.DataFrame, native: pd.DataFrame) -> list[tuple[str, float]]:
    """Who takes less time, median of the ratios, and has as many answers that can be used."""
    times = ratios(here, YARDSTICK)
    found = []
    for method, setting in entrants(here):
        mine = of_entrant(here, method, setting)
        ours = native[native["draw"].isin(mine["draw"])]
        middle = times.reindex(mine.index).median()
        if middle < 1.0 and solved(mine).mean() >= solved(ours).mean():
            name = method if setting == YARDSTICK[1] else f"{method}, {setting}"
            found.append((name, float(middle)))
    return sorted(found, key=lambda one: one[1])
