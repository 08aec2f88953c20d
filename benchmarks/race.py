"""Timing of several methods on the problems of one family: interleaved in one run, every answer checked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from hqp import Hierarchy
from hqp.arrays import Array

from .families import Family, moved
from .methods import METHODS, Call, Method
from .methods.daqp_direct import DAQP_COST, DAQP_ROWS
from .sweep.judge import proved
from .timing import timed

#: The methods that are raced where none is named, as far as they are here.
RACED = (
    "native",
    DAQP_ROWS,
    DAQP_COST,
    "cascade:proxsuite",
    "cascade:qpsolvers/daqp",
    "cascade:qpsolvers/quadprog",
    "pseudoinverse",
)
#: The shortest of so many calls from the same start counts: what the machine adds is never negative.
REPETITIONS = 3
#: Draws that a slow method gets at most, spread over all.
FEW = 16
#: How the starts without any memory are called: a solver that knows the sizes, and one call of :func:`hqp.solve`.
COLD, ONE_SHOT = "cold", "one shot"


@dataclass(frozen=True)
class Timing:
    """One method on one problem.

    Attributes
    ----------
    method, start : str
        Start is `COLD`, `ONE_SHOT`, or how far the targets moved since the problem just solved, as in ``2 %``.
    draw : int
    seconds : float
    certified : bool
    error : float
        Distance from a certified answer, relative to its length; NaN where no method has one.
    """

    method: str
    start: str
    draw: int
    seconds: float
    certified: bool
    error: float


def raced() -> list[Method]:
    """Those of `RACED` that are installed."""
    return [METHODS[name] for name in RACED if not METHODS[name].missing()]


def race(
    family: Family,
    methods: Sequence[Method],
    seeds: int,
    draws: int,
    shares: Sequence[float],
    tick: Callable[[], None] = lambda: None,
) -> list[Timing]:
    """Time the methods that take the family on `draws` draws of each of `seeds` seeds."""
    able = [method for method in methods if not method.refusal(family)]
    every = -(-seeds * draws // FEW)
    timings: list[Timing] = []
    if not able:
        return timings
    for seed in range(seeds):
        for k, base in enumerate(family.problems(draws, seed)):
            draw = seed * draws + k
            here = [method for method in able if draw % every == 0 or not method.slow]
            if draw == 0:
                _warm_up(here, base)
            starts = {COLD: base, ONE_SHOT: base} | {
                f"{100 * s:g} %": moved(base, np.random.default_rng([seed, k, 1]), s) for s in shares
            }
            for number, (start, problem) in enumerate(starts.items(), start=draw):
                turn = number % max(1, len(here))
                timings += _problem(here[turn:] + here[:turn], start, draw, base, problem)
            tick()
    return timings


def _problem(methods: Sequence[Method], start: str, draw: int, base: Hierarchy, problem: Hierarchy) -> Iterator[Timing]:
    """Timings of all methods on one problem, cold or warm."""
    found: dict[str, tuple[float, Array]] = {}
    for method in methods:
        prepare = {COLD: partial(method.cold, problem), ONE_SHOT: partial(method.one_shot, problem)}
        found[method.name] = _shortest(method, prepare.get(start, partial(method.warm, base, problem)))
    certified = {name: proved(problem, x) for name, (_, x) in found.items()}
    truth = next((x for name, (_, x) in found.items() if certified[name]), np.full(problem.n, np.nan))
    for name, (seconds, x) in found.items():
        error = float(np.linalg.norm(x - truth)) / (float(np.linalg.norm(truth)) or 1.0)
        yield Timing(name, start, draw, seconds, certified[name], error)


def _shortest(method: Method, prepare: Callable[[], Call]) -> tuple[float, Array]:
    """Seconds and x of the shortest of some calls, each prepared anew."""
    shortest, x = np.inf, np.zeros(0)
    for _ in range(REPETITIONS):
        seconds, answer = timed(prepare())
        shortest, x = min(shortest, seconds), method.outcome(answer).x
    return shortest, x


def _warm_up(methods: Sequence[Method], problem: Hierarchy) -> None:
    """Let everything be imported and compiled."""
    for method in methods:
        method.cold(problem)()
        method.one_shot(problem)()
        method.warm(problem, problem)()
