"""Performance profiles (Dolan, Moré 2002): the share of the problems that are solved within a factor of the fastest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from hqp.arrays import Array

from .metrics import PROBLEM, entrants, of_entrant


class Profile(NamedTuple):
    """One entrant: on the share ``shares[i]`` of all problems it needs at most ``factors[i]`` times the least time."""

    method: str
    setting: str
    factors: Array
    shares: Array

    def at(self, factor: float) -> float:
        """The share of the problems that are solved within this factor."""
        within = int(np.searchsorted(self.factors, factor, side="right"))
        return float(self.shares[within - 1]) if within else 0.0


def profiles(rows: pd.DataFrame, good: pd.Series) -> list[Profile]:
    """Profiles of the rows of one start over the problems of all methods; only `good` answers count.

    Who has no good answer to a problem never solves it, whatever the factor.
    """
    everyone = entrants(rows)
    given = rows.groupby(PROBLEM, observed=True)["method"].size()
    common = given.index[given == len(everyone)]
    seconds = rows.assign(seconds=rows["seconds"].where(good, np.inf)).set_index(PROBLEM)
    seconds = seconds[seconds.index.isin(common)]
    least = seconds.groupby(PROBLEM, observed=True)["seconds"].min()
    found = []
    for method, setting in everyone:
        mine = of_entrant(seconds, method, setting)["seconds"]
        with np.errstate(invalid="ignore"):
            factors = np.sort((mine / least.reindex(mine.index)).to_numpy())
        factors = factors[np.isfinite(factors)]
        shares = np.arange(1, len(factors) + 1) / max(1, len(common))
        found.append(Profile(method, setting, factors, shares))
    return found
