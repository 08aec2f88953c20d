"""Round-off is relative to the way that x has come: exact answers pass at every scale, wrong ones at none.

The answers are exact by construction: x and the multipliers are chosen first, and then the targets that they make
optimal.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from hard_draws import of_mixed_scales
from hypothesis import given
from hypothesis import strategies as st

from hqp import Hierarchy, Level, Solver, certify, solve, solve_batch
from hqp.arrays import Array
from hqp.backends.graded import gradings
from hqp.kernels import layout as at
from hqp.problems import random_hierarchy

seeds = st.integers(0, 2**32 - 1)

#: Round-off of a solver, and an error beyond all round-off, relative to the way.
NOISE, WRONG = 8 * np.finfo(np.float64).eps, 1e-6


def planar_arm(rng: np.random.Generator, n: int) -> Array:
    """The Jacobian of position and orientation of an arm with n joints, shape (3, n)."""
    angles, lengths = np.cumsum(rng.uniform(-1.5, 1.5, n)), rng.uniform(0.3, 1.0, n)
    steps = lengths * np.array([-np.sin(angles), np.cos(angles)])
    return np.concatenate([np.cumsum(steps[:, ::-1], axis=1)[:, ::-1], np.ones((1, n))])


def direction(rng: np.random.Generator, n: int) -> Array:
    d = rng.standard_normal(n)
    return d / np.linalg.norm(d)


def at_rest(rng: np.random.Generator, tiny: float) -> tuple[Hierarchy, Array, float]:
    """Limits, a reach whose targets are next to nothing, and a far posture; with the answer and the way."""
    n = int(rng.integers(4, 9))
    J, x = planar_arm(rng, n), tiny * rng.standard_normal(n)
    size = 10.0 ** rng.uniform(-3, 5)
    limits = Level.bounds(np.full(n, -20.0 * size), np.full(n, 20.0 * size))
    stops, sides = rng.random(n) < 0.15, rng.choice([-1.0, 1.0], n)  # joints at a limit
    limits.lower[stops & (sides < 0)] = x[stops & (sides < 0)]
    limits.upper[stops & (sides > 0)] = x[stops & (sides > 0)]
    posture = x + size * (J.T @ rng.standard_normal(3) + stops * sides * rng.uniform(0.5, 1.0, n))
    levels = [limits, Level.equality(J[:2], J[:2] @ x), Level.equality(J[2:], J[2:] @ x)]
    return Hierarchy([*levels, Level.equality(np.eye(n), posture)]), x, float(np.linalg.norm(posture - x))


@pytest.mark.parametrize("seeds", [range(100), pytest.param(range(100, 334), marks=pytest.mark.sweep)], ids=str)
@pytest.mark.parametrize("tiny", [0.0, 1e-17, 1e-13])
def test_at_rest_above_a_posture(tiny: float, seeds: range) -> None:
    for seed in seeds:
        rng = np.random.default_rng(seed)
        h, x, way = at_rest(rng, tiny)
        d = direction(rng, h.n)
        assert certify(h, x).ok, seed
        assert certify(h, x + NOISE * way * d).ok, seed
        assert not certify(h, x + WRONG * way * d).ok, seed


def test_at_rest_as_floating_point_finds_it() -> None:
    """x = p + pinv(J) (t - J p), as it is computed: what is left of the posture p is round-off."""
    for seed in range(300):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(4, 9))
        J, t = planar_arm(rng, n), rng.uniform(-1e-17, 1e-17, 3)
        p = J.T @ rng.standard_normal(3) * 10.0 ** rng.uniform(-3, 5)
        x = p + np.linalg.pinv(J) @ (t - J @ p)
        assert np.linalg.norm(x) < 1e-9 * np.linalg.norm(p)
        assert certify(Hierarchy([Level.equality(J, t), Level.equality(np.eye(n), p)]), x).ok, seed
        assert certify(Hierarchy([Level.equality(J, t)]), x, x_ref=p).ok, seed


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3, 1e7])
def test_rows_through_zero_and_a_far_reference(size: float) -> None:
    """A x <= 0 and A x = 0, and the point next to x_ref is zero."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(2, 13))
        A = rng.standard_normal((int(rng.integers(1, n + 3)), n))
        lower = np.where(rng.random(len(A)) < 0.5, 0.0, -np.inf)
        x_ref = size * A.T @ np.where(lower == 0.0, rng.standard_normal(len(A)), rng.uniform(0.1, 1.0, len(A)))
        h, d, way = Hierarchy([Level(A, lower, np.zeros(len(A)))]), direction(rng, n), float(np.linalg.norm(x_ref))
        assert certify(h, np.zeros(n), x_ref).ok, seed
        assert certify(h, NOISE * way * d, x_ref).ok, seed
        assert not certify(h, WRONG * way * d, x_ref).ok, seed


def test_stopped_next_to_nothing() -> None:
    """Rows stop a far target 1e-14 from where x starts: what ``min ||x||`` leaves there is round-off of the target."""
    for seed in range(200):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(3, 15))
        stop, along = rng.standard_normal((2, n)), rng.standard_normal(n)
        x = 1e-14 * (rng.uniform(0.5, 1.0, 2) @ stop + along)
        tip = np.array([-rng.uniform(0.5, 1.0, 2) @ stop, along])
        levels = [Level(stop, stop @ x, np.inf), Level.equality(tip, tip @ x + [1.0, 0.0])]
        way = float(np.linalg.norm(tip[0])) / float((tip * tip).sum(axis=1).max())
        h, d = Hierarchy(levels), direction(rng, n)
        assert certify(h, x).ok, seed
        assert certify(h, x + NOISE * way * d).ok, seed
        assert not certify(h, x + WRONG * way * d).ok, seed


@pytest.mark.parametrize(
    ("short", "alone"), [(1e-6, True), (1e-10, True), (1e-17, True), (1e-6, False), (1e-17, False)]
)
def test_a_task_that_nothing_can_serve_hides_nothing(short: float, alone: bool) -> None:
    """A robot in a singular position: the rows of a task are round-off, and ask for x next to infinity."""
    task = short * np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.0]])[: 1 if alone else 2]
    limits, posture = Level.bounds([-1.0] * 3, [1.0] * 3), Level.equality(np.eye(3), [0.5, 0.2, -0.3])
    h = Hierarchy([limits, Level.equality(task, np.full(len(task), 0.1)), posture])
    assert certify(h, [1.0, 1.0, -0.3]).ok
    for wrong in ([1.0, 1.0 - 1e-6, -0.3], [1.0, 1.0, -0.3 + 1e-6], [1.0 + 1e-6, 1.0, -0.3]):
        assert not certify(h, wrong).ok


def scaled(h: Hierarchy, rows: float, length: float) -> Hierarchy:
    """The same in other units: rows of A times `rows`, x times `length`."""
    numbers = h.copy()
    numbers.A[:] *= rows
    for level in numbers.levels:
        factor = length if level.indices is not None else length * rows
        level.lower[:], level.upper[:] = factor * level.lower, factor * level.upper
    return numbers


@given(seeds, st.integers(-20, 20), st.integers(-20, 20), st.sampled_from([0.0, 1e-12, 1e-9, 1e-5]))
def test_verdicts_know_no_units(seed: int, rows: int, length: int, error: float) -> None:
    """Powers of two, so that all numbers are the same to the last bit: 1e-6 to 1e6."""
    rng = np.random.default_rng(seed)
    h, length_, rows_ = random_hierarchy(rng), 2.0**length, 2.0**rows
    x_ref = rng.standard_normal(h.n) * 10.0 ** rng.uniform(-3, 6)
    x = solve(h, x_ref=x_ref).x
    x = x + error * np.linalg.norm(x) * direction(rng, h.n)
    if any(level.indices is not None for level in h.levels):
        rows_ = 1.0  # plain bounds have no units of their own
    verdict = [level.ok for level in certify(h, x, x_ref).levels]
    assert [level.ok for level in certify(scaled(h, rows_, length_), x * length_, x_ref * length_).levels] == verdict


@pytest.mark.parametrize(
    "seeds",
    [
        range(100),
        [1252, 13501],  # a conflict of long rows, whose round-off moves a short one off its bound
        [2788],  # slacks must shift along rows of which a billionth is left
        pytest.param(range(100, 20_000), marks=pytest.mark.sweep),
    ],
    ids=str,
)
def test_what_is_claimed_among_mixed_scales_is_certified(seeds: Iterable[int]) -> None:
    for seed in seeds:
        solution = solve(of_mixed_scales(np.random.default_rng(seed)))
        assert not solution.ok or solution.certify().ok, seed


def parts_of(h: Hierarchy) -> list[list[list[float]]]:
    """The longest entry of each row, level by level, of every grading."""
    return [
        [np.abs(graded.matrix(k)).max(axis=1).tolist() for k in range(len(graded.levels))] for graded in gradings(h)
    ]


def test_long_rows_come_first_where_lengths_leave_a_gap() -> None:
    uneven = Level.equality(np.diag([1.0, 0.0, 3e6, 30.0]), [1.0, 2.0, 3.0, 4.0], weights=[1.0, 1.0, 1.0, 0.1])
    bounds = Level.bounds([0.0, 0.0], [1.0, 1.0], weights=[1.0, 5e4])
    assert parts_of(Hierarchy([uneven, bounds], n=4)) == [
        [[3e6], [30.0, 1.0, 0.0], [1.0], [1.0]],  # lengths are those of weighted rows; a row of zeros is no gap
    ]
    steps = Level.equality(np.diag([1.0, 50.0, 1e5]), [0.0, 0.0, 0.0])
    assert parts_of(Hierarchy([steps])) == [[[1e5], [50.0, 1.0]], [[1e5], [50.0], [1.0]]]
    assert parts_of(Hierarchy([Level.equality(np.eye(3), 1.0)])) == []


@given(seeds)
def test_a_grading_parts_levels_and_loses_no_row(seed: int) -> None:
    h = of_mixed_scales(np.random.default_rng(seed))
    for graded in gradings(h):
        rows = np.column_stack([graded.dense(), graded.lower, graded.upper, graded.weights])
        given_rows = np.column_stack([h.dense(), h.lower, h.upper, h.weights])
        assert set(h.pointers) < set(graded.pointers)
        for first, end in zip(h.pointers[:-1], h.pointers[1:], strict=True):
            order, back = (np.lexsort(of[first:end].T) for of in (rows, given_rows))
            np.testing.assert_array_equal(rows[first:end][order], given_rows[first:end][back])


@pytest.mark.parametrize("seed", [1252, 8666, 13034, 13501, 22429])
def test_round_off_of_long_rows_in_conflict_does_not_end_a_solve(seed: int) -> None:
    """A short row beside them: which side of its bound it is on is decided by their round-off."""
    h = of_mixed_scales(np.random.default_rng(seed))
    for solution in solve(h), Solver().solve(h), solve_batch([h, h])[1]:
        assert solution.ok
        assert solution.certify().ok


@pytest.mark.parametrize(("share", "judged"), [(1e-7, True), (1e-3, False)])
def test_the_certificate_judges_where_next_to_nothing_is_left_of_a_row(share: float, judged: bool) -> None:
    """What such a row asks for is magnified, and the round-off of all rows with it."""
    h = Hierarchy([Level.equality([[1.0, 0.0, 0.5]], [1.0]), Level.equality([[1.0, share, 0.5]], [2.0])])
    solver = Solver()
    assert solver.solve(h).ok
    head = solver._backend._memory.head  # type: ignore[attr-defined]
    assert head[at.FAILS] == (at.PASSES if judged else at.UNJUDGED)
