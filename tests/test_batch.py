"""Many hierarchies at once: each as if it were alone, whatever the number of threads."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import Batch, BatchSolver, Hierarchy, InvalidInput, Level, Settings, Solver, Status, solve, solve_batch
from hqp.problems import hierarchies


def draw(rng: np.random.Generator, scale: float = 0.5) -> Hierarchy:
    """A small arm: bounds on 7 joints, two tasks, a two-sided level, a posture for some of them."""
    n = 7
    A, B, C = rng.standard_normal((3, n)), rng.standard_normal((3, n)), rng.standard_normal((2, n))
    return Hierarchy(
        [
            Level.bounds(-np.ones(n), np.ones(n), name="limits"),
            Level.equality(A, A @ (scale * rng.standard_normal(n)), name="hand"),
            Level(C, C @ rng.standard_normal(n) - 0.3, np.inf, name="sides"),
            Level.equality(B, rng.standard_normal(3), name="gaze"),
            Level.bounds([0.1, -0.2], [0.1, -0.2], indices=[2, 4], name="posture"),
        ]
    )


def many(count: int, seed: int = 0) -> list[Hierarchy]:
    rng = np.random.default_rng(seed)
    return [draw(rng) for _ in range(count)]


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_every_answer_is_that_of_a_single_call_to_the_last_bit(threads):
    given = many(40)
    solution = BatchSolver(threads=threads).solve(Batch.of(given))
    assert solution.ok.all()
    for b, h in enumerate(given):
        np.testing.assert_array_equal(solution.x[b], solve(h, backend="native").x)
        assert solution[b].certify().ok
        assert solution[b].counts == solve(h, backend="native").counts


def test_each_is_warm_from_its_own_last_time():
    batch, solver = Batch.of(many(30)), BatchSolver(threads=2)
    first = solver.solve(batch)
    again = solver.solve(batch)
    assert (again.sweeps == 1).all()
    np.testing.assert_allclose(again.x, first.x, rtol=1e-12, atol=1e-12)
    batch.levels[1].lower[:] += 1e-3
    batch.levels[1].upper[:] = batch.levels[1].lower
    moved = solver.solve(batch)
    cold = BatchSolver(threads=1).solve(batch)
    np.testing.assert_allclose(moved.x, cold.x, rtol=1e-9, atol=1e-9)
    assert all(moved[b].certify().ok for b in range(30))
    solver.forget()
    np.testing.assert_array_equal(solver.solve(batch).x, cold.x)
    solver.solve(Batch.of(many(5)))  # another size: afresh
    assert solver.solve(batch).ok.all()


def test_views_are_the_numbers_of_each():
    batch = Batch(many(1)[0], 4)
    batch.levels[1].A[2] = 7.0
    batch.levels[3].weights[:, 1] = 2.0
    batch.levels[4].upper[3, 0] = 9.0
    assert batch.levels[0].A is None
    assert [float(batch[b].levels[1].A[0, 0]) == 7.0 for b in range(4)] == [False, False, True, False]
    assert all(batch[b].levels[3].weights[1] == 2.0 for b in range(4))
    assert [float(batch[b].levels[4].upper[0]) for b in range(4)] == [0.1, 0.1, 0.1, 9.0]
    assert len(batch) == 4


@pytest.mark.parametrize("shared", [True, False])
def test_x_ref(shared):
    given, rng = many(9), np.random.default_rng(1)
    x_ref = rng.standard_normal(7 if shared else (9, 7))
    solution = solve_batch(given, x_ref=x_ref, threads=2)
    for b, h in enumerate(given):
        own = x_ref if shared else x_ref[b]
        np.testing.assert_array_equal(solution.x[b], solve(h, backend="native", x_ref=own).x)
        assert solution[b].certify().ok
    solver = BatchSolver(threads=2)
    solver.solve(Batch.of(given), x_ref)
    assert solver.solve(Batch.of(given))[4].certify().ok  # and zero again


def test_a_number_that_means_nothing_concerns_its_own_hierarchy_alone():
    batch = Batch.of(many(6))
    batch.levels[1].A[3, 1, 2] = np.nan
    batch.levels[0].lower[5, 6] = 2.0
    solution = BatchSolver(threads=2).solve(batch)
    assert [str(status) for status in solution.statuses] == ["optimal"] * 3 + ["invalid", "optimal", "invalid"]
    assert solution.messages[3].startswith("level 1 ('hand'), row 1: A[2] = nan")
    assert solution.messages[5].startswith("level 0 ('limits'), row 6: lower = 2.0 > upper = 1.0")
    assert np.isfinite(solution.x).all()
    assert solution.ok.tolist() == [True, True, True, False, True, False]
    with pytest.raises(InvalidInput, match=r"hierarchy 3 of the batch: level 1 \('hand'\), row 1"):
        solve_batch(batch)


def test_rows_that_only_look_too_long_are_solved():
    h = Hierarchy([Level.equality([[0.9e30, 0.9e30, 0.9e30]], [0.9e30])])
    solution = solve_batch([h, h])
    assert solution.ok.all()
    np.testing.assert_allclose(solution.x, 1 / 3, rtol=1e-12)


def test_a_budget_ends_each_on_its_own():
    settings = Settings(iterations=1)
    hard = [h for h in hierarchies("one point", 200) if not Solver("native", settings).solve(h).ok]
    assert hard
    for h in hard[:5]:
        solution = BatchSolver(settings, threads=1).solve(Batch.of([h, h]))
        assert solution.statuses == (Status.SUBOPTIMAL, Status.SUBOPTIMAL)
        assert "the budget ran out at level" in solution.messages[1]
        assert all(level.ok for level in solution[1].certify().levels[: solution.levels[1]])


@pytest.mark.parametrize("count", [0, 1])
def test_few_or_nothing(count):
    solution = BatchSolver().solve(Batch(Hierarchy([], n=3), count), x_ref=[1.0, 2.0, 3.0])
    assert solution.x.tolist() == [[1.0, 2.0, 3.0]] * count
    assert len(solution) == count


def test_refusals_say_what_is_wrong():
    a, b = many(1)[0], Hierarchy([Level.equality([[1.0]], [1.0])])
    for wrong, message in (
        (lambda: Batch.of([a, b]), "hierarchy 1 of the batch has another structure than hierarchy 0"),
        (lambda: Batch.of([]), "a batch of no hierarchies has no structure"),
        (lambda: Batch.of([a, 3]), "hierarchy 1 of the batch"),
        (lambda: Batch(a, -1), "count"),
        (lambda: BatchSolver(threads=0), "threads"),
        (lambda: BatchSolver().solve(a), "what a BatchSolver solves"),
        (lambda: solve_batch([a], x_ref=[1.0]), r"x_ref has shape \(1,\); it must be \(7,\) or \(1, 7\)"),
        (lambda: solve_batch([a], x_ref=np.full(7, np.nan)), "x_ref must be finite"),
    ):
        with pytest.raises(InvalidInput, match=message):
            wrong()
