"""The native solver where a row holds a level by a thread, and where a level determines x: what then needs no proof."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import Hierarchy, Level, Solver, certify
from hqp.backends.native import Native, warm_up
from hqp.kernels import layout as at
from hqp.settings import Settings

#: Unknowns: a cold start of the first takes the guess and a sweep, of the second goes level by level.
FEW, MANY = 2, 15
#: A multiplier, relative to the forces of its level: too small for the certificate, large enough for the solver.
THREAD = 5e-9


def outcome(h: Hierarchy) -> tuple[np.ndarray, bool, bool]:
    """x of a cold start; whether the kernel claims that it is optimal, and whether it had to ask the certificate."""
    warm_up()
    native = Native(Settings())
    x = np.empty(h.n)
    told = native.prepare(h.structure).run(h.numbers, x)
    memory = native._memory
    assert memory is not None
    return memory.x.copy(), told >= 0, bool(memory.head[at.FAILS] != at.UNJUDGED)


def cornered(n: int, wants: np.ndarray, boxed: bool) -> list[Level]:
    """x_0 .. x_k may not be positive, all others are zero; then rows that want some of the former to be larger."""
    k = wants.shape[1]
    rest = np.eye(n)[k:]
    above = Level.bounds(np.full(k, -np.inf), np.zeros(k), indices=np.arange(k))
    if not boxed:
        above = Level(np.eye(n)[:k] + 0.0, np.full(k, -np.inf), np.zeros(k))
    levels = [above] + ([Level.equality(rest, np.zeros(n - k))] if n > k else [])
    return [*levels, Level.equality(np.hstack([wants, np.zeros((len(wants), n - k))]), np.ones(len(wants)))]


def away(n: int, k: int) -> Level:
    """Asks x_0 .. x_k to leave the corner."""
    return Level.equality(np.eye(n)[:k], np.full(k, -1.0))


@pytest.mark.parametrize("boxed", [True, False])
@pytest.mark.parametrize("n", [FEW, MANY])
@pytest.mark.parametrize("firm", [1.0, 1e-3])
def test_a_row_that_alone_holds_the_level_by_a_thread_leaves_no_doubt_where_x_is_determined(
    n: int, boxed: bool, firm: float
) -> None:
    h = Hierarchy([*cornered(n, np.array([[firm, firm * THREAD]]), boxed), away(n, 2)])
    x, optimal, judged = outcome(h)
    assert optimal
    assert not judged
    np.testing.assert_allclose(x, 0.0, atol=1e-12)
    assert certify(h, x).ok


@pytest.mark.parametrize("boxed", [True, False])
@pytest.mark.parametrize("n", [FEW + 1, MANY])
def test_rows_of_a_level_that_tell_a_row_one_by_one_leave_no_doubt_though_x_is_not_determined(
    n: int, boxed: bool
) -> None:
    wants = np.array([[1.0, 1.0], [1.0, -1.0 + 2.0 * THREAD]])  # together they hardly want more of x_1
    levels = cornered(n, wants, boxed)
    free = Level.equality(np.eye(n)[2:3], [1.0])
    if n > 3:
        levels[1] = Level.equality(np.eye(n)[3:], np.zeros(n - 3))
    else:
        del levels[1]
    h = Hierarchy([*levels, away(n, 2), free])
    x, optimal, judged = outcome(h)
    assert optimal
    assert not judged
    np.testing.assert_allclose(x, np.eye(n)[2], atol=1e-12)
    assert certify(h, x).ok


@pytest.mark.parametrize("boxed", [True, False])
@pytest.mark.parametrize("n", [FEW + 1, MANY])
def test_two_rows_by_a_thread_that_one_row_cannot_tell_are_judged(n: int, boxed: bool) -> None:
    h = Hierarchy([*cornered(n, np.array([[1.0, THREAD, THREAD]]), boxed), away(n, 3)])
    x, optimal, judged = outcome(h)
    assert judged
    assert not optimal or certify(h, x).ok


@pytest.mark.parametrize("seed", range(3))
def test_no_claim_is_refused_where_multipliers_are_tiny(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(100):
        k, n = int(rng.integers(2, 5)), int(rng.integers(5, 18))
        wants = rng.uniform(0.5, 2.0, (int(rng.integers(1, 4)), k)) * 10.0 ** -rng.choice([0.0, 7.5, 8.5, 9.5], k)
        levels = cornered(n, wants, bool(rng.integers(2)))
        lower = Level.equality(rng.standard_normal((2, n)), rng.standard_normal(2))
        h = Hierarchy([*levels, *[lower] * int(rng.integers(2)), away(n, k)])
        x, optimal, _ = outcome(h)
        assert not optimal or certify(h, x).ok


@pytest.mark.parametrize("seed", range(5))
def test_levels_below_one_that_determines_x_take_no_step_and_change_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = MANY
    A, b = rng.standard_normal((n, n)), rng.standard_normal(n)
    middle = b + 0.1 * rng.standard_normal(n)
    below = [
        Level(rng.standard_normal((6, n)), -np.ones(6), np.ones(6)),
        Level.equality(rng.standard_normal((n, n)), middle),
        Level(rng.standard_normal((20, n)), np.zeros(20), np.full(20, np.inf)),
    ]
    for kept in range(len(below) + 1):
        h = Hierarchy([Level.equality(A, b), *below[:kept]])
        solver = Solver()
        cold, warm = solver.solve(h), solver.solve(h)
        assert cold.ok
        assert certify(h, cold.x).ok
        assert cold.counts.iterations == 0
        np.testing.assert_allclose(cold.x, np.linalg.solve(A, b), rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(warm.x, cold.x, rtol=1e-9, atol=1e-9)
