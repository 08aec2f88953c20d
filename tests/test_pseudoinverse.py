"""The closed forms against the thesis's own words, and their refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.linalg import pinv

from hqp import Hierarchy, Level, Solver, Status, Unsupported, certify, solve
from hqp.backends.pseudoinverse import joint_form
from hqp.problems import CASES, Case, equality_cases

seeds = st.integers(0, 2**32 - 1)
cases = st.sampled_from(list(equality_cases()))


def two_tasks(seed: int, n: int = 6, m1: int = 2, m2: int = 3) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    return rng.standard_normal((m1, n)), rng.standard_normal(m1), rng.standard_normal((m2, n)), rng.standard_normal(m2)


@given(seeds)
def test_eq_3_17(seed: int) -> None:
    J1, r1, J2, r2 = two_tasks(seed)
    z = np.random.default_rng(seed + 1).standard_normal(6)
    I = np.eye(6)  # noqa: E741
    N1 = I - pinv(J1) @ J1
    J2_hat = J2 @ N1
    expected = pinv(J1) @ r1 + pinv(J2_hat) @ (r2 - J2 @ pinv(J1) @ r1) + N1 @ (I - pinv(J2_hat) @ J2_hat) @ z
    h = Hierarchy([Level.equality(J1, r1), Level.equality(J2, r2)])
    solution = solve(h, backend="pseudoinverse", x_ref=z)
    np.testing.assert_allclose(solution.x, expected, rtol=1e-9, atol=1e-9)
    assert solution.certify().ok


@given(seeds)
def test_eq_4_8(seed: int) -> None:
    J1, h1, J2, h2 = two_tasks(seed)
    expected = pinv(J1) @ h1 + (np.eye(6) - pinv(J1) @ J1) @ pinv(J2) @ h2
    h = Hierarchy([Level.equality(J1, h1), Level.equality(J2, h2)])
    x = solve(h, backend="pseudoinverse:joint").x
    np.testing.assert_allclose(x, expected, rtol=1e-9, atol=1e-9)
    assert certify(joint_form(h), x).ok
    assert not certify(h, x).ok  # Eq. 4.8 is not the optimum of {J1} > {J2}


@given(seeds)
def test_eq_3_18_is_eq_3_17_in_joint_space(seed: int) -> None:
    J1, r1, _, _ = two_tasks(seed)
    r2 = np.random.default_rng(seed + 1).standard_normal(6)
    h = Hierarchy([Level.equality(J1, r1), Level.equality(np.eye(6), r2)])
    expected = pinv(J1) @ r1 + (np.eye(6) - pinv(J1) @ J1) @ r2
    for backend in ("pseudoinverse", "pseudoinverse:joint"):
        np.testing.assert_allclose(solve(h, backend=backend).x, expected, rtol=1e-9, atol=1e-9)


@given(seeds)
def test_the_two_formulas_coincide_where_the_tasks_are_orthogonal(seed: int) -> None:
    J1, r1, J2, r2 = two_tasks(seed)
    J2 = J2 @ (np.eye(6) - pinv(J1) @ J1)
    h = Hierarchy([Level.equality(J1, r1), Level.equality(J2, r2)])
    strict, joint = solve(h, backend="pseudoinverse").x, solve(h, backend="pseudoinverse:joint").x
    np.testing.assert_allclose(strict, joint, rtol=1e-8, atol=1e-8)


@given(cases, seeds)
def test_certified_in_every_rank_case(case: Case, seed: int) -> None:
    h = case.hierarchy(np.random.default_rng(seed))
    assert solve(h, backend="pseudoinverse").certify().ok


@pytest.mark.parametrize("rank", CASES)
def test_the_rank_cut_is_relative_to_the_original_task(rank: str) -> None:
    """A task inside the one above leaves J2 N1 ~ 1e-16, which must not be inverted."""
    rng = np.random.default_rng(0)
    h = Case(7, (3, 4), rank).hierarchy(rng)
    if rank == "second inside first":
        assert solve(h, backend="pseudoinverse").levels[1].rank == 0
    assert np.abs(solve(h, backend="pseudoinverse").x).max() < 1e3


def test_weights_are_honoured_and_free_rows_ignored() -> None:
    h = Hierarchy([Level([[1.0], [1.0], [1.0]], [0.0, 1.0, -np.inf], [0.0, 1.0, np.inf], weights=[1.0, 2.0, 5.0])])
    assert solve(h, backend="pseudoinverse").x == pytest.approx([0.8])


@pytest.mark.parametrize("backend", ["pseudoinverse", "pseudoinverse:joint"])
def test_an_inequality_is_refused_with_a_way_out(backend: str) -> None:
    h = Hierarchy([Level.equality(np.eye(2), 0.0), Level([[1.0, 0.0], [0.0, 1.0]], [0.0, 1.0], [0.0, 2.0], name="box")])
    message = r'level 1 \(\'box\'\), row 1 is an inequality.*use backend="native"'
    with pytest.raises(Unsupported, match=message):
        solve(h, backend=backend)
    solution = Solver(backend).solve(h)
    assert solution.status is Status.UNSUPPORTED
    with pytest.raises(Unsupported, match=message):
        raise Unsupported(solution.message)
    assert np.isfinite(solution.x).all()
