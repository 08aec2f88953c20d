"""What a solution says of itself, lazily and of the numbers that were solved."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import Hierarchy, Level, Settings, Side, Solver, Status, solve


def reach() -> Hierarchy:
    """A limit x0 <= 1, a reach x0 + x1 = 3 with x1 <= 1, then x2 = 5."""
    return Hierarchy(
        [
            Level.bounds([-1.0, -1.0], [1.0, 1.0], indices=[0, 1], name="limits"),
            Level.equality([[1.0, 1.0, 0.0]], [3.0], weights=[2.0], name="reach"),
            Level.equality([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], [5.0, 0.0], name="rest"),
        ]
    )


def test_slack_residual_rank_active_multipliers() -> None:
    solution = solve(reach())
    np.testing.assert_allclose(solution.x, [1.0, 1.0, 5.0], atol=1e-9)
    limits, hand, rest = solution.levels
    assert (limits.name, hand.name, rest.name) == ("limits", "reach", "rest")
    assert limits.active.tolist() == [Side.UPPER, Side.UPPER]
    np.testing.assert_allclose(limits.slack, 0.0, atol=1e-9)
    assert limits.rank == 0  # satisfied inequalities fix nothing
    np.testing.assert_allclose(hand.slack, [-1.0], atol=1e-9)  # raw, in the unit of the row
    assert hand.residual_norm == pytest.approx(2.0)  # weighted
    assert hand.rank == 1
    assert hand.active.tolist() == [Side.EQUALITY]
    np.testing.assert_allclose(hand.multipliers, [4.0, 4.0], atol=1e-8)
    np.testing.assert_allclose(rest.slack, [0.0, 1.0], atol=1e-9)
    assert rest.rank == 2
    assert len(rest.multipliers) == 3


def test_rank_counts_what_is_new_in_the_null_space_above() -> None:
    rng = np.random.default_rng(0)
    A = rng.standard_normal((3, 6))
    inside = rng.standard_normal((2, 3)) @ A
    h = Hierarchy(
        [
            Level.equality(A, rng.standard_normal(3)),
            Level.equality(inside, rng.standard_normal(2)),
            Level.equality(np.concatenate([A[:1], rng.standard_normal((1, 6))]), [0.0, 1.0]),
            Level.equality(np.eye(6), 0.0),
        ]
    )
    assert [level.rank for level in solve(h).levels] == [3, 0, 1, 2]
    assert [level.rank for level in solve(h, backend="pseudoinverse").levels] == [3, 0, 1, 2]


@pytest.mark.parametrize(("tolerance", "rank"), [(1e-9, 1), (1e-6, 0)])
def test_rank_is_told_by_the_tolerance_that_it_was_decided_by(tolerance: float, rank: int) -> None:
    h = Hierarchy([Level.equality([[1.0, 0.0]], [1.0]), Level.equality([[1.0, 1e-7]], [1.0])])
    assert solve(h, settings=Settings(rank_tolerance=tolerance)).levels[1].rank == rank


def test_levels_are_built_when_first_asked_for_and_from_the_snapshot() -> None:
    h = reach()
    solution = Solver().solve(h)
    assert "levels" not in vars(solution)
    h.lower[:] = -9.0
    h.upper[:] = 9.0
    assert solution.levels[1].residual_norm == pytest.approx(2.0)
    assert solution.levels is solution.levels
    assert solution.certify().ok


def test_a_solution_is_frozen() -> None:
    with pytest.raises(AttributeError):
        solve(reach()).status = Status.FAILED  # type: ignore[misc]


def test_repr_is_worth_reading() -> None:
    text = repr(solve(reach()))
    assert "optimal by native" in text
    assert "'reach': residual_norm=2" in text
    assert "2 of 2 rows at a bound" in text


def test_x_belongs_to_the_caller() -> None:
    solver, h = Solver(), reach()
    first = solver.solve(h)
    kept = first.x.copy()
    solver.solve(Hierarchy([*reach().levels[:2], Level.equality([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], [-5.0, 0.0])]))
    np.testing.assert_array_equal(first.x, kept)
    x_ref = np.zeros(3)
    solve(Hierarchy([], n=3), x_ref=x_ref).x[:] = 7.0
    assert x_ref.tolist() == [0.0, 0.0, 0.0]


def test_an_answer_is_judged_by_its_present_numbers_however_often_it_was_judged_before() -> None:
    solution = solve(Hierarchy([Level.bounds([-1.0, -1.0], [1.0, 1.0]), Level.equality([[1.0, 1.0]], [3.0])]))
    assert solution.certify().ok
    assert solution.certify(unique=False).levels[1].residual_norm == solution.certify().levels[1].residual_norm == 1.0
    solution.x[0] = 0.5
    assert not solution.certify().ok
    assert "short by 1.5" in str(solution.explain())
    solution.x[0] = 1.0
    solution.hierarchy.levels[0].upper[:] = 2.0
    assert not solution.certify(unique=False).ok
    solution.hierarchy.levels[0].upper[:] = 1.0
    assert solution.certify().ok
