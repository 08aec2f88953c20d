"""A last level that asks for single variables: the same answer without a basis of its own, warm and cold."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from hqp import Hierarchy, Level, Settings, certify
from hqp.backends.native import Memory, warm_up
from hqp.certificate import excess
from hqp.kernels import layout as at
from hqp.kernels.active_set import OPTIMAL


@pytest.fixture(autouse=True, scope="module")
def compiled() -> None:
    warm_up()


def standing(rng: np.random.Generator, n: int, free: int, dense: bool, far: float = 3.0) -> Hierarchy:
    """Bounds, equations that tell how `free` variables follow, limits, a task, and weights on the other variables."""
    rows, points = n // 3, n // 6
    equations = rng.standard_normal((rows, n)) / np.sqrt(n)
    equations[:free, :free] += 2.0 * np.eye(free)
    face = np.array([[1.0, 0.0, -0.7], [-1.0, 0.0, -0.7], [0.0, 1.0, -0.7], [0.0, -1.0, -0.7]])
    cones = np.hstack([np.zeros((4 * points, n - 3 * points)), np.kron(np.eye(points), face)])
    limits = np.vstack([cones, rng.standard_normal((rows, n)) / np.sqrt(n)])
    low = np.r_[np.full(len(cones), -np.inf), np.full(rows, -1.0)]
    asked = np.arange(free, n)
    rest, weights = 0.3 * rng.standard_normal(len(asked)), rng.choice([1.0, 0.05, 0.01], len(asked))
    ball = Level.bounds(np.full(n // 4, -2.0), np.full(n // 4, 2.0), indices=np.arange(n - n // 4, n))
    last = (
        Level.equality(np.eye(n)[asked], rest, weights=weights)
        if dense
        else Level.bounds(rest, rest, indices=asked, weights=weights)
    )
    return Hierarchy(
        [
            ball,
            Level.equality(equations, 0.3 * rng.standard_normal(rows)),
            Level(limits, low, np.where(np.isinf(low), 0.0, 1.0)),
            Level.equality(rng.standard_normal((3, n)) / np.sqrt(n), far * rng.standard_normal(3)),
            last,
        ],
        n=n,
    )


def draws(count: int) -> Iterator[Hierarchy]:
    for seed in range(count):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(12, 40))
        yield standing(rng, n, int(rng.integers(0, n // 6 + 1)), seed % 2 == 0, far=10.0 ** rng.uniform(-2.0, 1.0))


def moved(h: Hierarchy, rng: np.random.Generator) -> Hierarchy:
    """The same with other targets."""
    shift = 0.05 * rng.standard_normal(h.m) * (h.lower == h.upper)
    other = h.with_numbers(h.numbers.copy())
    other.lower += shift
    other.upper += shift
    return other


def test_it_is_the_answer_that_a_basis_of_all_levels_gives() -> None:
    closed = 0
    for seed, h in enumerate(draws(80)):
        mine, theirs = Memory(h.structure, Settings()), Memory(h.structure, Settings())
        theirs.head[at.BASIS] = 1
        rng = np.random.default_rng([seed, 1])
        for tick in range(4):
            outcomes = mine.run(h.address), theirs.run(h.address)
            assert mine.head[at.CLOSES] == 1
            assert theirs.head[at.CLOSES] == 0
            if outcomes == (OPTIMAL, OPTIMAL):
                closed += 1
                assert certify(h, mine.x).ok, (seed, tick)
                assert np.abs(mine.x - theirs.x).max() <= 1e-8 * np.abs(theirs.x).max(), (seed, tick)
            h = moved(h, rng)
    assert closed >= 310


def test_it_keeps_what_the_levels_above_decide_to_round_off() -> None:
    for seed, h in enumerate(draws(40)):
        memory = Memory(h.structure, Settings())
        if memory.run(h.address) == OPTIMAL:
            equations = h.levels[1]
            assert equations.A is not None
            off = np.abs(equations.A @ memory.x - equations.lower).max()
            assert off <= 1e-12 * (1.0 + np.abs(memory.x).max()), seed


def test_it_keeps_bounds_to_round_off() -> None:
    """However uneven the weights of the last level are, which magnify it."""
    met = 0
    for seed, h in enumerate(draws(60)):
        memory, rng = Memory(h.structure, Settings()), np.random.default_rng([seed, 1])
        for tick in range(4):
            if memory.run(h.address) == OPTIMAL:
                off = np.abs(excess(h.dense() @ memory.x, h.lower, h.upper)) / (1.0 + np.abs(memory.x).max())
                bounds = np.r_[off[: h.pointers[1]], off[h.pointers[2] : h.pointers[3]]].max()
                if bounds < 1e-7:  # else the limits contradict the equations
                    met += 1
                    assert bounds <= 1e-13, (seed, tick)
            h = moved(h, rng)
    assert met >= 200


@pytest.mark.parametrize(
    ("last", "closes"),
    [
        (Level.bounds(np.ones(3), np.ones(3), indices=[0, 2, 3], weights=[1.0, 0.1, 0.1]), True),
        (Level.equality(3.0 * np.eye(5)[[1, 4]], np.ones(2)), True),
        (Level.equality(-np.eye(5)[[1, 4]], np.ones(2)), False),
        (Level.equality(np.ones((1, 5)), np.ones(1)), False),
        (Level.bounds(np.ones(2), np.ones(2), indices=[1, 1]), False),
        (Level.bounds(np.zeros(2), np.ones(2), indices=[1, 2]), False),
        (Level.bounds(np.ones(2), np.ones(2), indices=[1, 2], weights=[1.0, 1e-4]), False),
    ],
    ids=["weighted", "as rows", "backwards", "several", "twice", "inequality", "uneven"],
)
def test_only_one_equality_a_variable_with_weights_that_are_not_too_uneven(last: Level, closes: bool) -> None:
    rng = np.random.default_rng(5)
    h = Hierarchy([Level.equality(rng.standard_normal((3, 5)), rng.standard_normal(3)), last])
    memory = Memory(h.structure, Settings())
    assert memory.run(h.address) == OPTIMAL
    assert memory.head[at.CLOSES] == closes
    assert certify(h, memory.x).ok


@pytest.mark.parametrize("told", [True, False], ids=["told", "not told"])
def test_a_row_that_just_touches_needs_a_basis_only_where_nothing_else_determines_x(told: bool) -> None:
    rng = np.random.default_rng(7)
    n, asked = 12, np.arange(1, 12)
    equations = rng.standard_normal((2, n))
    equations[:, 0] = (3.0, 0.0) if told else 0.0
    touching = np.eye(n)[[5]] if told else np.eye(n)[[0]] + np.eye(n)[[5]]
    rest = rng.standard_normal(n)
    x = rest.copy()
    x[0] = 1.0  # the row is met with equality there, and no level presses on it
    h = Hierarchy(
        [
            Level.equality(equations, equations @ x),
            Level(touching, [-np.inf], touching @ x),
            Level.equality(np.eye(n)[asked], rest[asked]),
        ]
    )
    memory = Memory(h.structure, Settings())
    pressed = h.copy()
    pressed.levels[1].upper[:] -= 1.0
    assert memory.run(pressed.address) == OPTIMAL
    assert memory.run(h.address) == OPTIMAL
    assert certify(h, memory.x, memory.x_ref).ok
    cut = memory.ints(at.CUT)
    assert (cut[3] == cut[2]) == told
