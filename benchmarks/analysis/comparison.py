"""What changed from one run to another, beyond noise.

Answers are compared one by one: but for times, two runs of the same sources are equal. Times are compared problem by
problem, and what a machine does to all methods alike, its drift, is taken out: the median over all other methods of the
same families. A change counts where it is larger than the 99 % interval of both medians, and than `LEAST`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from hqp.arrays import Array

from ..sweep.schema import COLUMNS, KEYS, TIMES
from .metrics import METRICS, of_entrant

#: A change of time that is always taken for noise; and problems that it takes to say anything.
LEAST, FEWEST = 0.05, 6
#: Half of the 99 % interval of a median over its standard error, and that error over MAD / sqrt(n).
_SURE, _ERROR = 2.58, 1.4826 * 1.2533
#: What an answer is, to the last bit.
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
    """Column -> in how many rows it differs, of all that is no time."""
    return {
        name: number
        for name in ANSWERS
        if (number := sum(not _same(a, b) for a, b in zip(pairs[name], pairs[f"{name} after"], strict=True)))
    }


def _same(a: object, b: object) -> bool:
    return bool(np.array_equal(a, b, equal_nan=isinstance(a, float | np.ndarray)))


def answers(before: pd.DataFrame, after: pd.DataFrame, pairs: pd.DataFrame) -> list[dict[str, str]]:
    """Entrants whose answers are worth more or less than before, on the problems of both."""
    shared = pd.MultiIndex.from_frame(pairs[list(KEYS)])
    found = []
    for method, setting in dict.fromkeys(zip(pairs["method"], pairs["setting"], strict=True)):
        texts = []
        for frame in before, after:
            mine = of_entrant(frame, method, setting)
            keys = pd.MultiIndex.from_frame(mine[list(KEYS)].astype({"family": str, "method": str, "setting": str}))
            texts.append({name: METRICS[name].text(mine[keys.isin(shared)]) for name in _TOLD})
        if texts[0] != texts[1]:
            told = {name: a if a == texts[1][name] else f"{a} -> {texts[1][name]}" for name, a in texts[0].items()}
            found.append({"method": method, "setting": setting} | told)
    return found


def changes(pairs: pd.DataFrame, by: str) -> list[Change]:
    """The times of all entrants, group by group or family by family."""
    logs = np.log(pairs["seconds after"] / pairs["seconds"])
    found = []
    for (where, start), here in pairs.groupby([by, "start"], sort=False):
        for (method, setting), mine in here.groupby(["method", "setting"], sort=False):
            others = logs[here.index[here["method"] != method]]
            own = logs[mine.index]
            if len(own) < FEWEST:
                continue
            drift, shaky = _median(others.to_numpy()) if len(others) else (0.0, 0.0)
            middle, unsure = _median(own.to_numpy())
            numbers = np.exp([middle - drift, drift, np.hypot(shaky, unsure)])
            found.append(Change(where, method, setting, start, len(own), *map(float, numbers)))
    return found


def _median(values: Array) -> tuple[float, float]:
    """The median, and half of its 99 % interval."""
    middle = float(np.median(values))
    return middle, _SURE * _ERROR * float(np.median(np.abs(values - middle))) / np.sqrt(len(values))
