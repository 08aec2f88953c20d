"""What must hold of any strict hierarchy, whatever its numbers."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hqp import Hierarchy, Level, Solver, solve
from hqp.problems import random_hierarchy

seeds = st.integers(0, 2**32 - 1)


def residuals(h: Hierarchy) -> np.ndarray:
    return np.array([level.residual_norm for level in solve(h).levels])


def rebuilt(h: Hierarchy, change) -> Hierarchy:
    """The hierarchy with `change(k, A, lower, upper, weights)` applied to every level, bounds as dense rows."""
    levels = []
    for k, level in enumerate(h.levels):
        A, lower, upper, weights = change(k, h.matrix(k), level.lower, level.upper, level.weights)
        levels.append(Level(A, lower, upper, weights=weights, name=level.name))
    return Hierarchy(levels, n=h.n)


def close(a: np.ndarray, b: np.ndarray, scale: float = 1.0) -> None:
    np.testing.assert_allclose(a, b, rtol=1e-7, atol=1e-7 * scale)


@given(seeds)
def test_a_lower_level_never_changes_a_higher_residual(seed: int) -> None:
    h = random_hierarchy(np.random.default_rng(seed))
    all_levels = residuals(h)
    for k in range(len(h.levels)):
        close(residuals(Hierarchy(h.levels[: k + 1], n=h.n)), all_levels[: k + 1])


@given(seeds)
def test_the_order_of_rows_inside_a_level_does_not_matter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)

    def shuffle(k, A, lower, upper, weights):
        order = rng.permutation(len(A))
        return A[order], lower[order], upper[order], weights[order]

    close(solve(rebuilt(h, shuffle)).x, solve(h).x, 10.0)


@given(seeds)
def test_bounds_and_dense_rows_say_the_same(seed: int) -> None:
    h = random_hierarchy(np.random.default_rng(seed))
    close(solve(rebuilt(h, lambda k, *numbers: numbers)).x, solve(h).x, 10.0)


@given(seeds, st.sampled_from([1e-4, 0.3, 1e4]))
def test_scaling_all_rows_of_a_level_does_not_matter(seed: int, factor: float) -> None:
    h = random_hierarchy(np.random.default_rng(seed))
    scaled = rebuilt(h, lambda k, A, lower, upper, weights: (factor * A, factor * lower, factor * upper, weights))
    close(solve(scaled).x, solve(h).x, 10.0)


@given(seeds, st.sampled_from([1e-3, 1e3]))
def test_weights_are_row_scalings(seed: int, factor: float) -> None:
    """A weight d on a row is the row, and its bounds, times d."""
    h = random_hierarchy(np.random.default_rng(seed))

    def into_rows(k, A, lower, upper, weights):
        return weights[:, None] * A, weights * lower, weights * upper, np.full(len(A), factor)

    close(solve(rebuilt(h, into_rows)).x, solve(h).x, 10.0)


@given(seeds)
def test_an_orthogonal_change_of_the_equality_rows_of_a_level_does_not_matter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)

    def turn(k, A, lower, upper, weights):
        rows = np.flatnonzero(lower == upper)
        Q = np.linalg.qr(rng.standard_normal((len(rows), len(rows))))[0] * weights[rows]
        A[rows], lower[rows], weights[rows] = Q @ A[rows], Q @ lower[rows], 1.0
        upper[rows] = lower[rows]
        return A, lower, upper, weights

    close(solve(rebuilt(h.copy(), turn)).x, solve(h).x, 10.0)


@given(seeds, st.sampled_from([1e-3, 1e3]))
def test_the_unit_of_x_does_not_matter(seed: int, factor: float) -> None:
    h = random_hierarchy(np.random.default_rng(seed))
    finer = rebuilt(h, lambda k, A, lower, upper, weights: (A / factor, lower, upper, weights))
    close(solve(finer).x / factor, solve(h).x, 10.0)


@given(seeds)
def test_a_warm_start_changes_the_time_not_the_answer(seed: int) -> None:
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)
    solver = Solver()
    solver.solve(h)
    shift = 0.05 * rng.standard_normal(h.m)
    h.lower += shift
    h.upper += shift
    close(solver.solve(h).x, solve(h).x, 10.0)


@given(seeds)
def test_adding_a_free_row_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)
    free = Level(rng.standard_normal((2, h.n)), -np.inf, np.inf, name="free")
    close(solve(Hierarchy([free, *h.levels, free])).x, solve(h).x, 10.0)


@given(seeds)
def test_x_ref_is_the_origin_of_x(seed: int) -> None:
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)
    x_ref = rng.standard_normal(h.n)
    from_there = h.copy()
    for k, level in enumerate(from_there.levels):
        level.lower[:] -= h.matrix(k) @ x_ref
        level.upper[:] -= h.matrix(k) @ x_ref
    close(x_ref + solve(from_there).x, solve(h, x_ref=x_ref).x, 10.0)


@given(seeds)
def test_x_ref_changes_no_residual_and_an_optimum_is_its_own(seed: int) -> None:
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)
    elsewhere = solve(h, x_ref=10.0 * rng.standard_normal(h.n))
    close(np.array([level.residual_norm for level in elsewhere.levels]), residuals(h))
    close(solve(h, x_ref=elsewhere.x).x, elsewhere.x, 10.0)
