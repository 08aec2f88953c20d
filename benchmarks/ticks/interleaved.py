"""Drivers in turn on one motion, a few ticks each, so that disturbances of the machine affect all alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from hqp.arrays import Array

from ..tables import Row
from ..timing import undisturbed
from .driver import STAGES, Driver
from .stream import Stream

#: Ticks of one driver in a row; every so many-th tick is put to the certificate.
BLOCK, EVERY = 50, 100
#: By how much a tick may pass a limit and still keep it [rad]: what solvers take for zero.
SLACK = 1e-6


@dataclass(frozen=True, eq=False)
class Measured:
    """One driver on one motion.

    Attributes
    ----------
    name : str
    ns : array, shape (rounds, ticks)
        Whole ticks.
    stages : array, shape (ticks, 3)
        Their parts, timed in a round of their own.
    v : array, shape (ticks, unknowns)
        Its answers; NaN where it has none.
    proved : list of bool
        Certificates of its answers, where there are any.
    """

    name: str
    ns: Array
    stages: Array
    v: Array
    proved: list[bool]

    @property
    def median(self) -> float:
        """Of the whole ticks [ns]."""
        return float(np.median(self.ns))


def measure(drivers: Sequence[Driver], rounds: int, progress: Callable[[], None] = lambda: None) -> list[Measured]:
    """Time all drivers on the motion they were made for, that often from its beginning to its end."""
    ticks = len(drivers[0].stream)
    ns = {d.name: np.zeros((rounds, ticks)) for d in drivers}
    stages = {d.name: np.zeros((ticks, len(STAGES))) for d in drivers}
    v = {d.name: np.zeros((ticks, d.unknowns)) for d in drivers}
    for driver in drivers:  # imports, memory, compilers
        driver.run(0, min(BLOCK, ticks))
        driver.split(0, min(BLOCK, ticks))
    with undisturbed():
        for number in range(rounds):
            for driver, block in turns(drivers, ticks):
                driver.run(max(block.start - 1, 0), max(block.start, 1))  # caches are full of what others have run
                ns[driver.name][number, block], v[driver.name][block] = driver.run(block.start, block.stop)
            progress()
        for driver, block in turns(drivers, ticks):
            stages[driver.name][block] = driver.split(block.start, block.stop)
        progress()
    sample = range(0, ticks, EVERY)
    proofs = {d.name: [p for k in sample if (p := d.proved(k, v[d.name][k])) is not None] for d in drivers}
    return [Measured(name, ns[name], stages[name], v[name], proofs[name]) for name in ns]


def turns(drivers: Sequence[Driver], ticks: int) -> Iterator[tuple[Driver, slice]]:
    """Who runs which ticks: block by block, everyone in turn, and another one first each time."""
    for number, first in enumerate(range(0, ticks, BLOCK)):
        turn = number % len(drivers)
        for driver in (*drivers[turn:], *drivers[:turn]):
            yield driver, slice(first, min(first + BLOCK, ticks))


def table(stream: Stream, measured: Sequence[Measured]) -> list[Row]:
    """One row a method; the first of `measured` is the one that the answers of the others are compared with.

    Columns
    -------
    to pink, to mink
        Ratio of the medians, to the fastest of that library.
    off
        Distance from the first one's answer, relative to its length; median. Weights are no priorities, and pink and
        mink measure a position in the logarithm of a pose, so that it need not be small.
    kept
        Share of the ticks whose answer keeps the limits of position and velocity.
    """
    best = {
        peer: min((m.median for m in measured if m.name.startswith(peer)), default=None) for peer in ("pink", "mink")
    }
    return [_row(stream, m, measured[0], best) for m in measured]


def _row(stream: Stream, m: Measured, first: Measured, best: dict[str, float | None]) -> Row:
    us = 1e-3 * m.ns.ravel()
    off = np.linalg.norm(m.v - first.v, axis=1) / np.maximum(np.linalg.norm(first.v, axis=1), 1e-12)
    parts = [part[np.isfinite(part)] for part in m.stages.T]
    return (
        {"scene": stream.scene.name, "method": m.name, "median us": f"{1e-3 * m.median:.1f}"}
        | {f"p{p} us": f"{np.quantile(us, 0.01 * p):.1f}" for p in (90, 99)}
        | {f"to {peer}": "" if median is None else f"{m.median / median:.3g}" for peer, median in best.items()}
        | {
            stage: f"{1e-3 * np.median(part):.1f}" if len(part) else ""
            for stage, part in zip(STAGES, parts, strict=True)
        }
        | {
            "off": f"{np.nanmedian(off):.0e}" if np.isfinite(off).any() else "",
            "kept": f"{100 * np.mean(_kept(stream, m.v)):.4g}%",
            "proved": f"{sum(m.proved)}/{len(m.proved)}" if m.proved else "",
        }
    )


def _kept(stream: Stream, v: Array) -> Array:
    """Whether each answer keeps the limits, shape (ticks,); where there is none, it does not."""
    robot, dt = stream.robot, stream.scene.dt
    kept = np.isfinite(v).all(axis=1)
    if robot.velocity_limit is not None:
        kept &= (dt * (np.abs(v) - robot.velocity_limit) <= SLACK).all(axis=1)
    if robot.position_limit is not None:
        low, high = robot.position_limit
        joints = np.array([robot.at(q, stream.v[0]).joints for q in stream.q]) + dt * v
        kept &= ((joints >= low - SLACK) & (joints <= high + SLACK)).all(axis=1)
    return kept
