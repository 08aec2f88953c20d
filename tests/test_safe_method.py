"""The safe method by itself: the solver seldom needs it, so that little else would see it go wrong."""

from __future__ import annotations

from itertools import chain
from typing import NamedTuple

import numpy as np
import pytest
from loops.safe_method import safe_method

from hqp import Hierarchy, Settings, Side, certify
from hqp.backends.native import Memory, warm_up
from hqp.certificate import row_states
from hqp.kernels import layout as at
from hqp.kernels.active_set import OPTIMAL, SUBOPTIMAL
from hqp.problems import FAMILIES, hierarchies, random_hierarchy

CERTIFIED = [name for name, family in FAMILIES.items() if family.expect == "certified"]
#: Where the active set has most to do.
DEGENERATE = ("vertex", "one point", "single point", "weights")


class Outcome(NamedTuple):
    status: int
    level: int
    last: int
    iterations: int
    x: np.ndarray
    sides: np.ndarray


def safely(
    h: Hierarchy, x_ref: np.ndarray | None = None, start: np.ndarray | None = None, iterations: int = 10_000
) -> Outcome:
    """The answer of the safe method, from `start`: if none is given, x_ref, as if nothing were known."""
    warm_up()
    memory = Memory(h.structure, Settings(iterations=iterations))
    sides = np.zeros(h.m, dtype=np.int64)
    memory.x_ref[:] = 0.0 if x_ref is None else x_ref
    memory.x[:] = memory.x_ref if start is None else start
    memory.head[at.SIDES] = sides.ctypes.data
    last = safe_method(memory.head.ctypes.data, h.address)
    status, level, count = memory.head[[at.OUTCOME, at.LEVEL, at.ITERATIONS]].tolist()
    return Outcome(status, level, last, count, memory.x.copy(), sides)


def draw(seed: int) -> tuple[Hierarchy, np.random.Generator]:
    """A random hierarchy, and a generator to do something with it."""
    return random_hierarchy(np.random.default_rng(seed)), np.random.default_rng([seed, 1])


def degenerate(count: int) -> list[Hierarchy]:
    return list(chain.from_iterable(hierarchies(name, count) for name in DEGENERATE))


@pytest.mark.parametrize("seeds", [range(100), pytest.param(range(100, 300), marks=pytest.mark.sweep)], ids=str)
def test_random_hierarchies_are_certified_whatever_x_ref(seeds: range) -> None:
    wrong = []
    for seed in seeds:
        h, rng = draw(seed)
        x_ref = 10.0 ** rng.uniform(-3, 3) * rng.standard_normal(h.n)
        found = safely(h, x_ref)
        if found.status != OPTIMAL or found.level != found.last + 1 or not certify(h, found.x, x_ref).ok:
            wrong.append(seed)
    assert wrong == []


@pytest.mark.parametrize("name", CERTIFIED)
def test_families_that_can_be_certified_are(name: str) -> None:
    wrong = []
    for k, h in enumerate(hierarchies(name, 40)):
        found = safely(h)
        if found.status != OPTIMAL or not certify(h, found.x).ok:
            wrong.append(k)
    assert wrong == []


def test_where_it_starts_changes_the_way_not_the_answer() -> None:
    """The last level leaves one optimum."""
    ways = 0
    for h in [draw(seed)[0] for seed in range(100)] + degenerate(20):
        cold, rng = safely(h), np.random.default_rng(h.m)
        far = safely(h, start=3.0 * rng.standard_normal(h.n))
        assert far.status == cold.status == OPTIMAL
        assert np.linalg.norm(far.x - cold.x) <= 1e-7 * (1.0 + np.linalg.norm(cold.x))
        ways += far.iterations != cold.iterations
    assert ways >= 20


def test_from_the_optimum_it_stays_there() -> None:
    for h in degenerate(20):
        cold = safely(h)
        again = safely(h, start=cold.x)
        assert again.status == OPTIMAL
        assert np.linalg.norm(again.x - cold.x) <= 1e-7 * (1.0 + np.linalg.norm(cold.x))


def test_the_sides_it_leaves_are_where_the_rows_are() -> None:
    """What is violated is on its side, and what is on a side is at that bound or beyond."""
    off = active = 0
    for h in [draw(seed)[0] for seed in range(100)] + degenerate(20):
        found = safely(h)
        states = row_states(h, found.x, np.zeros(h.n), tolerance=1e-7)
        for i in range(h.pointers[found.last]):
            side, violated = found.sides[i], states.violated[i]
            if states.norms[i] == 0.0:  # says nothing of x
                assert side == Side.INACTIVE
            elif violated:
                assert side == Side.EQUALITY or side == np.sign(states.slack[i])
            elif side != Side.INACTIVE:
                assert states.sides[i] in (side, Side.EQUALITY)
            off += violated
            active += side != Side.INACTIVE
    assert active > off > 100


@pytest.mark.parametrize("iterations", [1, 2, 3, 5, 8, 13])
def test_what_a_budget_leaves_is_exact_above_the_level_where_it_stopped(iterations: int) -> None:
    stopped = below = 0
    for h in [draw(seed)[0] for seed in range(100)] + degenerate(20):
        found = safely(h, iterations=iterations)
        certificate = certify(h, found.x)
        assert np.isfinite(found.x).all()
        if found.status == OPTIMAL:
            assert found.iterations <= iterations
            assert certificate.ok
            continue
        assert found.status == SUBOPTIMAL
        assert found.iterations == iterations
        assert found.level <= found.last
        assert all(level.ok for level in certificate.levels[: found.level])
        stopped += 1
        below += found.level > 0
    assert stopped >= 20
    if iterations > 1:  # the first one goes into level 0
        assert below >= 10
