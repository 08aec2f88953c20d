"""Ticks at 200 Hz with sleep in between, when caches are cold, compared with ticks back to back."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from ..standing.ours import OursStanding
from ..standing.scenes import SCENES as STANDING
from ..standing.stream import record as record_standing
from ..tables import Row
from ..timing import undisturbed
from .driver import Driver
from .ours import Ours
from .scenes import SCENES
from .stream import record

#: Ticks a second; ticks of one kind in a row, and in all.
RATE, BLOCK, MOST = 200.0, 20, 500


def paced(ticks: int) -> list[Row]:
    """A Panda and a G1 that stands, at most `MOST` ticks of each."""
    ticks = min(ticks, MOST)
    arm = Ours(record(SCENES[0], ticks), name=SCENES[0].name)
    humanoid = OursStanding(record_standing(STANDING[0], ticks), name=STANDING[0].name)
    return compared([arm, humanoid], ticks)


def compared(drivers: Sequence[Driver], ticks: int) -> list[Row]:
    """A row a driver: medians back to back and paced, of the same ticks, block by block in turn, and their ratio.

    Times are of the processor: who waits for it is not late by the state of caches.
    """
    rows = []
    for driver in drivers:
        driver.clock = time.thread_time_ns
        times: dict[bool, list[float]] = {False: [], True: []}
        driver.run(0, min(BLOCK, ticks))
        with undisturbed():
            for first in range(0, ticks, BLOCK):
                for sleeps, own in times.items():
                    for k in range(first, min(first + BLOCK, ticks)):
                        if sleeps:
                            time.sleep(1.0 / RATE)
                        ns, _ = driver.run(k, k + 1)
                        own.append(1e-3 * float(ns[0]))
        close, far = (np.median(times[sleeps]) for sleeps in (False, True))
        rows.append(
            {
                "method": driver.name,
                "back to back us": f"{close:.1f}",
                f"at {RATE:g} Hz us": f"{far:.1f}",
                "p99 us": f"{np.quantile(times[True], 0.99):.1f}",
                "ratio": f"{far / close:.2f}",
            }
        )
    return rows
