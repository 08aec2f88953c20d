"""Small problems of the default damping: directions that a speed leads to, rows turned into what they ask for."""

from __future__ import annotations

from types import SimpleNamespace

import kernels
import numpy as np
import pytest

from hqp.kernels import brake, hand_over


@pytest.fixture(scope="module")
def spread() -> SimpleNamespace:
    return kernels.compiled(brake, "spread")


@pytest.fixture(scope="module")
def invert() -> SimpleNamespace:
    return kernels.compiled(hand_over, "invert")


@pytest.mark.parametrize("n", [1, 2, 3, 4, 7, 21])
def test_directions_that_a_speed_leads_to(n: int, spread: SimpleNamespace) -> None:
    rng = np.random.default_rng(n)
    A, v = rng.normal(size=(n, n)), rng.normal(size=n)
    A = A @ A.T
    basis, T = np.full((n + 4, n + 1), np.nan), np.full((n, n), np.nan)
    count = spread.spread(A, v, np.linalg.norm(v), n, basis, T)
    assert count == min(n, brake.DIRECTIONS)
    B = basis[:count, :n]
    np.testing.assert_allclose(B @ B.T, np.eye(count), atol=1e-13)
    np.testing.assert_allclose(T[:count, :count], B @ A @ B.T, atol=1e-12 * np.abs(A).max())
    for power in range(count):
        led = np.linalg.matrix_power(A, power) @ v
        np.testing.assert_allclose(B.T @ (B @ led), led, atol=1e-12 * np.linalg.norm(led))


def test_a_speed_along_eigenvectors_leads_to_no_other_direction(spread: SimpleNamespace) -> None:
    Q = np.linalg.qr(np.random.default_rng(0).normal(size=(6, 6)))[0]
    A = Q @ np.diag([0.0, 0.0, 1.0, 1.0, 2.0, 3.0]) @ Q.T
    for v, wanted in ((Q[:, 4], 1), (Q[:, 2] + Q[:, 3], 1), (Q[:, 2] + Q[:, 4], 2), (Q[:, 0] + Q[:, 4] + Q[:, 5], 3)):
        basis, T = np.empty((10, 7)), np.empty((6, 6))
        assert spread.spread(A, v, np.linalg.norm(v), 6, basis, T) == wanted


@pytest.mark.parametrize("shape", [(1, 1), (2, 5), (3, 3), (3, 7), (6, 21)])
def test_rows_are_turned_into_what_they_ask_for(shape: tuple[int, int], invert: SimpleNamespace) -> None:
    count, d = shape
    G = np.random.default_rng(d).normal(size=shape)
    L, half = np.empty((count, count)), np.empty(shape)
    assert invert.invert(G @ G.T, G, L, half, count, d, 0.0)
    np.testing.assert_allclose(half, np.linalg.pinv(G).T, atol=1e-10)
    np.testing.assert_array_equal(L, np.eye(count))


def test_rows_that_are_nearly_dependent_are_refused(invert: SimpleNamespace) -> None:
    G = np.array([[1.0, 0.0, 0.0], [1.0, 1e-5, 0.0]])
    assert not invert.invert(G @ G.T, G, np.empty((2, 2)), np.empty((2, 3)), 2, 3, 0.0)
