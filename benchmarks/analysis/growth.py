"""How time grows with unknowns, levels and rows: medians along a curve, and an exponent fitted to them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from hqp.arrays import Array

from .metrics import entrants, of_entrant

#: The curves, and what grows along them.
CURVES = {"n": "unknowns", "levels": "levels", "rows": "inequalities"}


class Growth(NamedTuple):
    """One entrant on one curve.

    Attributes
    ----------
    sizes, seconds : array
        The points: medians of the time [s].
    exponent : float
        p of the fit ``c size^p`` to the upper half of the points, where overheads no longer hide it.
    """

    curve: str
    method: str
    setting: str
    start: str
    sizes: Array
    seconds: Array
    exponent: float


def growth(rows: pd.DataFrame) -> list[Growth]:
    """All entrants on all curves that have at least three points."""
    found = []
    for (curve, start), here in rows[rows["curve"] != ""].groupby(["curve", "start"]):
        for method, setting in entrants(here):
            medians = of_entrant(here, method, setting).groupby("at")["seconds"].median()
            if len(medians) >= 3:
                sizes, seconds = medians.index.to_numpy(dtype=float), medians.to_numpy()
                found.append(Growth(curve, method, setting, start, sizes, seconds, _exponent(sizes, seconds)))
    return found


def _exponent(sizes: Array, seconds: Array) -> float:
    upper = slice(len(sizes) // 2, None) if len(sizes) > 3 else slice(None)
    return float(np.polyfit(np.log(sizes[upper]), np.log(seconds[upper]), 1)[0])
