"""Closed loops of several libraries run in turn, each from the state that it has reached itself."""

from __future__ import annotations

import logging
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from hqp.arrays import Array

from ..ticks.driver import Driver
from ..ticks.interleaved import BLOCK, turns
from ..ticks.stream import Stream
from ..timing import undisturbed

#: The first ticks of a turn find the caches of somebody else, and are not timed.
COLD = 5


@dataclass(frozen=True, eq=False)
class Run:
    """The motion of one library after a stream of targets.

    Attributes
    ----------
    name : str
    q : array, shape (ticks + 1, nq)
        Where the robot was, from the start to what the last tick led to.
    v : array, shape (ticks, nv)
        Joint velocities; zero in ticks without an answer.
    held : array of bool, shape (ticks,)
        Ticks without an answer.
    raised : Counter
        Their exceptions, by name.
    ns : array, shape (rounds, ticks)
        Whole ticks; NaN at the beginning of a turn.
    """

    name: str
    q: Array
    v: Array
    held: Array
    raised: Counter[str]
    ns: Array


def drive(
    stream: Stream,
    makers: Sequence[Callable[[Stream], Driver]],
    rounds: int = 1,
    progress: Callable[[], None] = lambda: None,
) -> list[Run]:
    """Run all libraries on the targets, for a number of rounds; the motions are those of the first round."""
    with _quiet(), undisturbed():
        _round(stream, [make(stream) for make in makers], min(BLOCK, len(stream)))  # imports, memory, compilers
        all_rounds = []
        for _ in range(rounds):
            all_rounds.append(_round(stream, [make(stream) for make in makers], len(stream)))
            progress()
    first = all_rounds[0]
    times = [np.vstack([each[i].ns for each in all_rounds]) for i in range(len(first))]
    return [Run(r.name, r.q, r.v, r.held, r.raised, ns) for r, ns in zip(first, times, strict=True)]


def _round(stream: Stream, drivers: Sequence[Driver], ticks: int) -> list[Run]:
    runs = [_standing(stream, driver, ticks) for driver in drivers]
    of = dict(zip(drivers, runs, strict=True))
    for driver, block in turns(drivers, ticks):
        for k in range(block.start, block.stop):
            _tick(stream, driver, of[driver], k)
        of[driver].ns[:, block][:, :COLD] = np.nan
    for driver in drivers:
        driver.close()
    return runs


def _standing(stream: Stream, driver: Driver, ticks: int) -> Run:
    """A run that has not begun."""
    q, v = np.tile(stream.q[0], (ticks + 1, 1)), np.zeros((ticks, stream.robot.nv))
    return Run(driver.name, q, v, np.zeros(ticks, dtype=bool), driver.raised, np.zeros((1, ticks)))


def _tick(stream: Stream, driver: Driver, run: Run, k: int) -> None:
    """One tick of one library; one that has no answer holds the robot, as its users do."""
    driver.stand(k, run.q[k], run.v[k - 1] if k else run.v[0])
    run.ns[:, k], (v,) = driver.run(k, k + 1)
    run.held[k] = not np.isfinite(v).all()
    run.v[k] = 0.0 if run.held[k] else v
    run.q[k + 1] = stream.robot.integrate(run.q[k], stream.scene.dt * run.v[k])


@contextmanager
def _quiet() -> Iterator[None]:
    """Without what libraries say at every tick of a robot that is outside its ranges."""
    logging.disable(logging.WARNING)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(logging.NOTSET)
