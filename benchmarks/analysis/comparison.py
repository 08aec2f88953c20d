"""What changed from one run to another, beyond noise.

Answers are compared one by one: but for times, two runs of the same sources are equal. ProxQP's last bits change with
where its memory lies, so numbers, which are relative to the size of a problem, are equal to `ROUND_OFF`.

Times are compared problem by problem, and what a machine does to all methods alike, its drift, is taken out: the median
of what the other methods say. A change counts where it is larger than `LEAST` and than the noise: a 99.9 % interval,
of three errors that do not know of each other. The median's own, what those of the other methods have, typically, and
by how much the other methods disagree about the drift, as this one may without having changed. Of few others that is
known roughly, and so is the interval.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from hqp.arrays import Array

from ..sweep.schema import COLUMNS, KEYS, TIMES
from ..tables import Row
from .metrics import ENTRANT, METRICS

#: A change of time that is always taken for noise; and problems that it takes to say anything.
LEAST, FEWEST = 0.05, 6
#: A drift of the machine that is worth a word.
UNSTEADY = 0.15
#: A standard deviation over the MAD; a median's standard error over MAD / sqrt(n); half of a 99.9 % interval over
#: either.
_NORMAL, _ERROR, _SURE = 1.4826, 1.4826 * 1.2533, 3.29
#: What an answer is; and from where on two numbers of it differ.
ROUND_OFF = 1e-9
ANSWERS = tuple(name for name in COLUMNS if name not in (*KEYS, *TIMES))
#: What is told of answers that changed.
_TOLD = ("certified", "silent", "failures", "gap", "violation", "error", "iterations")


class Change(NamedTuple):
    """The time of one entrant on the problems of one group, from one start.

    Attributes
    ----------
    factor : float
        Time after over time before, the drift of the machine taken out.
    drift : float
        That drift; 1 where there is no other method to tell.
    noise : float
        A factor that cannot be told from 1.
    """

    where: str
    method: str
    setting: str
    start: str
    problems: int
    factor: float
    drift: float
    noise: float

    @property
    def real(self) -> bool:
        """Whether it is beyond noise."""
        return abs(np.log(self.factor)) > max(np.log(self.noise), np.log1p(LEAST))


def paired(before: pd.DataFrame, after: pd.DataFrame) -> pd.DataFrame:
    """The rows that both have, side by side."""
    plain = [frame.astype({key: str for key in KEYS if key not in ("seed", "draw")}) for frame in (before, after)]
    return plain[0].merge(plain[1], on=list(KEYS), suffixes=("", " after"), validate="one_to_one")


def differences(pairs: pd.DataFrame) -> dict[str, int]:
    """For each column that is not a time: the number of rows in which it differs."""
    unequal = {name: ~_same(pairs[name], pairs[f"{name} after"]) for name in ANSWERS}
    return {name: int(rows.sum()) for name, rows in unequal.items() if rows.any()}


def _same(before: pd.Series, after: pd.Series) -> NDArray[np.bool_]:
    """Where they are the same, numbers to `ROUND_OFF`."""
    if before.name == "gaps":  # a list a row, or None
        return np.array([_close(a, b).all() for a, b in zip(before, after, strict=True)], dtype=bool)
    if before.dtype == float:
        return _close(before, after)
    return np.asarray(before == after, dtype=bool)


def _close(a: Any, b: Any) -> NDArray[np.bool_]:
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    return np.isclose(a, b, rtol=0.0, atol=ROUND_OFF, equal_nan=True) if a.shape == b.shape else np.array(False)


def answers(pairs: pd.DataFrame) -> list[Row]:
    """Entrants whose answers differ, with the metrics of these before and after."""
    after = pairs[[f"{name} after" for name in ANSWERS]].set_axis(list(ANSWERS), axis="columns")
    found = []
    for (method, setting), mine in pairs.groupby(ENTRANT, sort=False):
        if differences(mine):
            texts = {name: [METRICS[name].text(rows.loc[mine.index]) for rows in (pairs, after)] for name in _TOLD}
            told = {name: old if old == new else f"{old} -> {new}" for name, (old, new) in texts.items()}
            found.append({"method": method, "setting": setting} | told)
    return found


def changes(pairs: pd.DataFrame, by: str) -> list[Change]:
    """The times of all entrants, group by group or family by family."""
    logs = np.log(pairs["seconds after"] / pairs["seconds"])
    found = []
    for (where, start), here in pairs.groupby([by, "start"], sort=False):
        each = {key: logs[mine.index].to_numpy() for key, mine in here.groupby(ENTRANT, sort=False)}
        for (method, setting), own in each.items():
            if len(own) < FEWEST:
                continue
            others = [values for key, values in each.items() if key[0] != method]
            medians, errors = ([of(values) for values in others] or [0.0] for of in (np.median, _error))
            drift, middle = float(np.median(medians)), float(np.median(own))
            noise = _SURE * np.linalg.norm([_error(own), np.median(errors), _NORMAL * _mad(np.array(medians))])
            numbers = map(float, np.exp([middle - drift, drift, noise]))
            found.append(Change(where, method, setting, start, len(own), *numbers))
    return found


def _mad(values: Array) -> float:
    """Median of the absolute distances from the median."""
    return float(np.median(np.abs(values - np.median(values))))


def _error(values: Array) -> float:
    """Standard error of their median."""
    return _ERROR * _mad(values) / np.sqrt(len(values))
