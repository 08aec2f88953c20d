"""Statistics of the timings of one family: medians, tails, and ratios to the better form of DAQP."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np

from .methods.daqp_direct import DAQP_COST, DAQP_ROWS
from .race import Timing
from .tables import Row


def yardstick(timings: Sequence[Timing]) -> str | None:
    """The form of DAQP's hierarchy that is faster in most pairs, or None if neither was timed."""
    forms = {
        form: {(t.draw, t.start): t.seconds for t in timings if t.method == form} for form in (DAQP_ROWS, DAQP_COST)
    }
    raced = [form for form, seconds in forms.items() if seconds]
    if len(raced) < 2:
        return raced[0] if raced else None
    rows, cost = forms.values()
    return DAQP_COST if np.median([cost[pair] / rows[pair] for pair in rows]) < 1.0 else DAQP_ROWS


def table(family: str, timings: Sequence[Timing]) -> list[Row]:
    """One row a method and start, start by start.

    Columns
    -------
    median, p90, p99
        Of the seconds, draw by draw.
    ratio, its p90
        Median and 90th percentile of the ratios to the yardstick's seconds, draw by draw.
    of medians
        Ratio of the medians, over the draws that both have.
    """
    form = yardstick(timings)
    starts = list(dict.fromkeys(t.start for t in timings))
    methods = list(dict.fromkeys(t.method for t in timings))
    cells: dict[tuple[str, str | None], dict[int, Timing]] = defaultdict(dict)
    for t in timings:
        cells[t.start, t.method][t.draw] = t
    return [
        {"family": family, "start": start, "method": method} | _row(here, cells.get((start, form), {}))
        for start in starts
        for method in methods
        if (here := cells.get((start, method)))
    ]


def _row(here: Mapping[int, Timing], reference: Mapping[int, Timing]) -> Row:
    seconds = np.array([t.seconds for t in here.values()])
    both = [draw for draw in here if draw in reference]
    mine, theirs = (np.array([of[draw].seconds for draw in both]) for of in (here, reference))
    return {
        "median us": f"{1e6 * np.median(seconds):.1f}",
        "p90 us": f"{1e6 * np.quantile(seconds, 0.9):.1f}",
        "p99 us": f"{1e6 * np.quantile(seconds, 0.99):.1f}",
        "ratio": f"{np.median(mine / theirs):.3g}" if both else "",
        "its p90": f"{np.quantile(mine / theirs, 0.9):.3g}" if both else "",
        "of medians": f"{np.median(mine) / np.median(theirs):.3g}" if both else "",
        "error": f"{max(t.error for t in here.values()):.0e}",
        "certified": f"{sum(t.certified for t in here.values())}/{len(here)}",
    }
