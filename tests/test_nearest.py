"""The last level in another norm: the weighted pseudoinverse, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hqp import Hierarchy, InvalidInput, Level, nearest, solve

seeds = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize("backend", ["native", "cascade:proxsuite", "pseudoinverse"])
@given(seed=seeds, spread=st.sampled_from([0.0, 1.0, 2.0]))
@settings(max_examples=20)
def test_below_a_task_it_is_the_weighted_pseudoinverse(backend, seed, spread):
    rng = np.random.default_rng(seed)
    J, r, x_ref = rng.standard_normal((3, 7)), rng.standard_normal(3), rng.standard_normal(7)
    Q = np.linalg.qr(rng.standard_normal((7, 7)))[0]
    M = Q @ np.diag(10.0 ** rng.uniform(-spread, spread, 7)) @ Q.T
    inertia = np.linalg.inv(J @ np.linalg.solve(M, J.T))
    expected = x_ref + np.linalg.solve(M, J.T) @ inertia @ (r - J @ x_ref)
    solution = solve(Hierarchy([Level.equality(J, r), nearest(x_ref, M)]), backend=backend)
    np.testing.assert_allclose(solution.x, expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max())
    assert solution.certify().ok


def test_the_residual_is_the_distance():
    x_ref, M = np.array([1.0, 2.0]), np.array([[2.0, 1.0], [1.0, 3.0]])
    solution = solve(Hierarchy([Level.bounds([-1.0, -1.0], [0.5, 0.5]), nearest(x_ref, M, name="inertia")]))
    away = solution.x - x_ref
    assert solution.levels[1].residual_norm == pytest.approx(np.sqrt(away @ M @ away))
    assert solution.levels[1].name == "inertia"


@pytest.mark.parametrize(
    ("M", "message"),
    [
        (np.ones((2, 3)), r"level 'nearest': M has shape \(2, 3\); it must be square"),
        ([[1.0, 0.5], [0.4, 1.0]], r"M\[0, 1\] = 0.5, but M\[1, 0\] = 0.4; M must be symmetric"),
        ([[1.0, 2.0], [2.0, 1.0]], "positive definite, and its smallest eigenvalue is -1"),
        ([[1.0, np.nan], [0.0, 1.0]], r"M\[0, 1\] = nan must be finite"),
        (np.eye(3), r"x_ref has shape \(2,\); it must be \(3,\)"),
    ],
)
def test_refusals(M, message):
    with pytest.raises(InvalidInput, match=message):
        nearest([0.0, 0.0], M)
