"""DAQP's own hierarchy: right on rows of norm one, and no more than that; never an exception."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import Hierarchy, Level, Settings, Solver, Status, certify, solve
from hqp.backends.daqp import DaqpProblem
from hqp.problems import random_hierarchy

pytest.importorskip("daqp")


def unit_rows(m: int, n: int, seed: int = 0) -> np.ndarray:
    A = np.random.default_rng(seed).standard_normal((m, n))
    return A / np.linalg.norm(A, axis=1)[:, None]


def of_norm_one(h: Hierarchy) -> Hierarchy:
    """The hierarchy as DAQP sees it: every row and its bounds divided by the norm of the row, no weights."""
    norms = h.row_norms()
    seen = h.copy()
    seen.A /= norms[h.columns < 0, None]
    seen.lower /= norms
    seen.upper /= norms
    seen.weights[:] = 1.0
    return seen


TOPS = {
    "bounds on top": Level.bounds(-np.ones(5), np.ones(5)),
    "bounds on some": Level.bounds(-np.ones(2), np.ones(2), indices=[0, 3]),
    "equalities on top": Level.equality(unit_rows(2, 5, 1), [0.5, -0.5]),
    "infeasible top": Level.equality(np.concatenate([unit_rows(1, 5, 2)] * 2), [0.0, 1.0]),
    "overdetermined top": Level.equality(unit_rows(7, 5, 3), np.arange(7.0)),
    "an empty level on top": Level(np.zeros((0, 5)), [], []),
    "zero and free rows on top": Level([[0.0] * 5, [1.0] * 5], [1.0, -np.inf], [1.0, np.inf]),
}


@pytest.mark.parametrize("top", TOPS)
def test_rows_of_norm_one_are_certified(top: str) -> None:
    h = Hierarchy(
        [
            TOPS[top],
            Level(unit_rows(2, 5, 4), [-np.inf, 0.2], [-0.3, np.inf]),
            Level.equality(unit_rows(2, 5, 5), [2.0, -2.0]),
        ]
    )
    solution = solve(h, backend="daqp", x_ref=[0.1, 0.2, 0.3, 0.4, 0.5])
    assert solution.ok, solution.message
    assert solution.certify().ok, solution.certify()


def test_a_level_that_cannot_be_met_is_met_as_if_its_rows_had_norm_one() -> None:
    """The measured limit that its registry entry tells of."""
    h = Hierarchy([Level.equality([[3.0, 0.0], [1.0, 0.0]], [3.0, -1.0], weights=[1.0, 5.0])])
    solution = solve(h, backend="daqp")
    np.testing.assert_allclose(solution.x, 0.0, atol=1e-8)  # half way; the weights would have it elsewhere
    assert not solution.certify().ok
    assert certify(of_norm_one(h), solution.x).ok
    assert solve(h).certify().ok


def test_whatever_the_numbers_the_answer_is_a_status_and_finite() -> None:
    for seed in range(200):
        h = random_hierarchy(np.random.default_rng(seed))
        solution = Solver("daqp").solve(h)
        assert solution.status in (Status.OPTIMAL, Status.FAILED)
        assert np.isfinite(solution.x).all()
    for level in (Level.equality([[1e25, 1.0], [0.0, 1e-25]], [1e29, 1.0]), Level([[np.nan, 1.0]], [0.0], [1.0])):
        assert np.isfinite(Solver("daqp").solve(Hierarchy([level, Level.equality(np.eye(2), 1.0)])).x).all()


def test_giving_up_is_told() -> None:
    h = Hierarchy([Level.bounds(-np.ones(5), np.ones(5)), Level.equality(unit_rows(3, 5), [3.0, 3.0, 3.0])])
    solution = solve(h, backend="daqp", x_ref=np.full(5, 0.5), settings=Settings(qp_iterations=1))
    assert solution.status is Status.FAILED
    assert "DAQP failed (exit flag" in solution.message
    assert solution.x.tolist() == [0.5] * 5


def test_leading_bounds_need_no_rows() -> None:
    h = Hierarchy(
        [
            Level.bounds([-1.0, -np.inf], [1.0, np.inf]),
            Level.equality([[1.0, 1.0], [0.0, 0.0]], [1.0, 1.0]),
            Level.bounds([0.5], [0.5], indices=[1]),
        ]
    )
    rows = DaqpProblem.of(h)
    np.testing.assert_array_equal(rows.A, [[1.0, 1.0], [0.0, 1.0]])
    np.testing.assert_array_equal(rows.upper, [1.0, 1.0, 0.5])
    np.testing.assert_array_equal(rows.lower, [-1.0, 1.0, 0.5])
    np.testing.assert_array_equal(rows.sense, [0, 5, 5])
    np.testing.assert_array_equal(rows.break_points, [1, 2, 3])
    assert rows.sense.dtype == rows.break_points.dtype == np.intc
    assert len(DaqpProblem.of(Hierarchy([], n=3)).upper) == 0
