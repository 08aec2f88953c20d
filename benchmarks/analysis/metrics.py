"""The metrics: each a number out of the rows of one method, setting and start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

#: A tick of a controller at 1 kHz [s], what an answer that is wrong or missing counts as in a mean, and its shift.
DEADLINE, PENALTY, SHIFT = 1e-3, 1e-2, 1e-5
#: What names one problem, and one entrant.
PROBLEM, ENTRANT = ["family", "seed", "draw"], ["method", "setting"]
#: Rows that a quantile of 99.9 % needs to mean anything.
THOUSAND = 1000


@dataclass(frozen=True)
class Metric:
    """One metric.

    Attributes
    ----------
    name, about : str
    unit : str
        ``us``, ``%``, ``1`` for a count, or nothing.
    of : callable
        From rows to the number, in SI units and shares.
    """

    name: str
    about: str
    unit: str
    of: Callable[[pd.DataFrame], float]

    def text(self, rows: pd.DataFrame) -> str:
        """The number as a table shows it."""
        value = self.of(rows)
        if np.isnan(value):
            return ""
        if self.unit == "us":
            return f"{1e6 * value:.{0 if value >= 1e-4 else 1}f}"
        if self.unit == "%":
            return share(value)
        if self.unit == "1":
            return f"{value:.0f}"
        return f"{value:.0e}" if 0.0 < value < 0.1 else f"{value:.3g}"


def share(value: float) -> str:
    """A share in per cent that says 100 and 0 only where nothing is missing."""
    percent = 100.0 * value if value in (0.0, 1.0) else float(np.clip(100.0 * value, 0.01, 99.99))
    return f"{percent:.2f}" if 99.9 < percent < 100.0 else f"{percent:.3g}"


def solved(rows: pd.DataFrame) -> pd.Series:
    """Which answers can be used: claimed, and as good as the best to 1e-5."""
    return rows["claimed"] & ~rows["wrong"]


def shifted_geometric_mean(rows: pd.DataFrame) -> float:
    """``exp(mean(log(t + s))) - s`` of the seconds, with the penalty where the answer cannot be used."""
    seconds = np.where(solved(rows), rows["seconds"], PENALTY)
    return float(np.exp(np.mean(np.log(seconds + SHIFT))) - SHIFT)


def _quantile(share: float, least: int) -> Callable[[pd.DataFrame], float]:
    return lambda rows: float(rows["seconds"].quantile(share)) if len(rows) >= least else float("nan")


METRICS: dict[str, Metric] = {
    metric.name: metric
    for metric in (
        Metric("problems", "how many were given", "1", lambda rows: float(len(rows[PROBLEM].drop_duplicates()))),
        Metric("certified", "answers that the certificate accepts", "%", lambda rows: float(rows["certified"].mean())),
        Metric(
            "silent",
            "answers that are wrong, and claimed to be right",
            "%",
            lambda rows: float((rows["wrong"] & rows["claimed"]).mean()),
        ),
        Metric("failures", "no answer claimed", "%", lambda rows: float((~rows["claimed"]).mean())),
        Metric("gap", "largest lexicographic gap to the best", "", lambda rows: float(rows["gap"].abs().max())),
        Metric("violation", "largest slack where the best has none", "", lambda rows: float(rows["violation"].max())),
        Metric("error", "largest distance from the best", "", lambda rows: float(rows["error"].max())),
        Metric("mean", "shifted geometric mean of the time", "us", shifted_geometric_mean),
        Metric("median", "of the time", "us", _quantile(0.5, 1)),
        Metric("p99", "of the time, of a hundred problems or more", "us", _quantile(0.99, 100)),
        Metric("p99.9", "of the time, of a thousand problems or more", "us", _quantile(0.999, THOUSAND)),
        Metric("worst", "time", "us", _quantile(1.0, 1)),
        Metric(
            "late",
            "problems that take longer than a tick at 1 kHz",
            "%",
            lambda rows: float((rows["seconds"] > DEADLINE).mean()),
        ),
        Metric(
            "spread",
            "slowest to fastest round, median",
            "",
            lambda rows: float((rows["slowest"] / rows["seconds"]).median()),
        ),
        Metric("iterations", "median, as the method counts", "1", lambda rows: float(rows["iterations"].median())),
    )
}


def entrants(rows: pd.DataFrame) -> list[tuple[str, str]]:
    """Methods and settings, in their order."""
    return [key for key, _ in rows.groupby(ENTRANT, observed=True)]


def of_entrant(rows: pd.DataFrame, method: str, setting: str) -> pd.DataFrame:
    """The rows of one entrant."""
    return rows[(rows["method"] == method) & (rows["setting"] == setting)]


def ratios(rows: pd.DataFrame, reference: tuple[str, str]) -> pd.Series:
    """Seconds of every row, of one start, over those of the reference on the same problem; NaN where it has none."""
    theirs = of_entrant(rows, *reference).set_index(PROBLEM)["seconds"]
    index = pd.MultiIndex.from_frame(rows[PROBLEM])
    return pd.Series(rows["seconds"].to_numpy() / theirs.reindex(index).to_numpy(), index=rows.index)
