"""Cost of the default damping: times of strict and damped ticks at the same states, in and out of reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hqp.arrays import Array

from ..tables import Row
from ..ticks.interleaved import turns
from ..ticks.ours import Ours
from ..ticks.stream import Stream
from ..timing import undisturbed
from .loop import COLD, Run
from .returns import REACHED


def timed(stream: Stream, run: Run, rounds: int) -> tuple[Array, Array]:
    """Whole ticks of the default and of the strict stack at the states of a run, shape (ticks,) [us].

    They take turns; of each tick the shortest of all rounds; NaN at the beginning of a turn.
    """
    states = replace(stream, q=run.q[: len(stream)], v=np.vstack([run.v[:1], run.v[:-1]]))
    ns = np.full((2, rounds, len(stream)), np.nan)
    with undisturbed():
        for number in range(rounds):
            both = [Ours(states, name=name, strict=strict) for name, strict in (("default", False), ("strict", True))]
            for driver, block in turns(both, len(stream)):
                took, _ = driver.run(block.start, block.stop)
                ns[both.index(driver), number, block.start + COLD : block.stop] = took[COLD:]
    default, strict = 1e-3 * ns.min(axis=1)
    return default, strict


def cost(scene: str, default: Array, strict: Array, forced: Array) -> list[Row]:
    """A row for the ticks in reach, and one for those out of it, where there are any."""
    inside = forced <= REACHED
    return [
        _row(scene, where, default[ticks], strict[ticks])
        for where, ticks in (("in reach", inside), ("out of reach", ~inside))
        if np.isfinite(default[ticks]).any()
    ]


def ratio(row: Row) -> float:
    """By how much the median tick is longer than the strict one."""
    return float(row["ratio p50"])


def _row(scene: str, where: str, default: Array, strict: Array) -> Row:
    row = {"scene": scene, "where": where, "ticks": str(int(np.isfinite(default).sum()))}
    quantiles = [[_quantile(us, share) for share in (0.5, 0.99)] for us in (strict, default)]
    for name, (half, most) in zip(("strict", "default"), quantiles, strict=True):
        row |= {f"{name} p50": f"{half:.1f}", f"{name} p99": f"{most:.1f}"}
    for k, name in enumerate(("p50", "p99")):
        row[f"ratio {name}"] = f"{quantiles[1][k] / quantiles[0][k]:.2f}"
    return row


def _quantile(us: Array, share: float) -> float:
    return float(np.nanquantile(us, share))


def over_all(rows: Sequence[Row]) -> str:
    """The worst ratio in reach and out of it, in words."""
    worst = {
        where: max((ratio(row) for row in rows if row["where"] == where), default=None)
        for where in ("in reach", "out of reach")
    }
    return ", ".join(f"{where} at most {value:.2f}" for where, value in worst.items() if value is not None)
