"""Linear algebra of a few rows: what it says of a matrix is so, to round-off, and NumPy agrees."""

from __future__ import annotations

import numpy as np
import pytest
from kernels import compiled, plain

from tasks.base.kernels import algebra

NAMES = ("decompose", "alone", "best_way", "root", "solve_upper", "solve_lower", "times")


@pytest.fixture(scope="module", params=["compiled", "plain"])
def kernels(request):
    return compiled(algebra, *NAMES) if request.param == "compiled" else plain(algebra)


def matrices(count, most=10, scale=200):
    """Of all shapes; easy ones, graded ones, with rows that depend on each other, of integers; large and small."""
    rng = np.random.default_rng(7)
    for trial in range(count):
        m, n = int(rng.integers(1, most + 1)), int(rng.integers(1, 13))
        J = rng.standard_normal((m, n))
        if trial % 5 == 1:
            J[rng.integers(m)] *= 10.0 ** rng.uniform(-16, 0)
        elif trial % 5 == 2:
            k = min(m, n)
            sizes = 10.0 ** -rng.uniform(0, 18, k)
            left, right = (np.linalg.qr(rng.standard_normal((size, size)))[0][:, :k] for size in (m, n))
            J = left * sizes @ right.T
        elif trial % 5 == 3:
            J[-1] = J[0] * rng.integers(-1, 2)
        elif trial % 5 == 4:
            J = np.round(J)
        yield J * 10.0 ** rng.uniform(-scale, scale) if trial % 7 == 0 else J


def decomposed(kernels, J):
    m, n = J.shape
    rows, ways, sizes = J.flatten(), np.empty(m * m), np.empty(m)
    kernels.decompose(rows, m, n, ways, sizes)
    return rows.reshape(m, n), ways.reshape(m, m), sizes


def test_singular_values_and_their_directions(kernels):
    for J in matrices(400):
        m = len(J)
        rows, ways, sizes = decomposed(kernels, J)
        expected = np.zeros(m)
        expected[: min(J.shape)] = np.linalg.svd(J, compute_uv=False)
        round_off = 1e-13 * expected[0]
        assert np.abs(sizes - expected).max() <= round_off
        np.testing.assert_allclose(ways @ ways.T, np.eye(m), rtol=0, atol=1e-13)
        assert np.abs(ways.T @ rows - J).max() <= round_off
        away = rows / max(sizes[0], 1e-300)
        assert np.abs(away @ away.T - np.diag(np.diag(away @ away.T))).max() <= 1e-13
        assert (np.diff(sizes) <= round_off).all()


def test_rows_that_are_many_and_all_alike_come_to_an_end(kernels):
    """More rows than columns, and of no length but round-off."""
    rng = np.random.default_rng(2)
    for J in (np.ones((10, 3)), np.ones((6, 6)) + 1e-16 * rng.standard_normal((6, 6)), np.zeros((4, 2)), np.eye(7, 2)):
        rows, ways, sizes = decomposed(kernels, J)
        np.testing.assert_allclose(ways.T @ rows, J, atol=1e-13)
        np.testing.assert_allclose(sizes[: J.shape[1]], np.linalg.svd(J, compute_uv=False)[: len(sizes)], atol=1e-13)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_gives_nan(kernels, bad):
    J = np.ones((3, 4))
    J[1, 2] = bad
    for found in decomposed(kernels, J):
        assert np.isnan(found).all()
    x, work = np.empty(4), np.empty(100)
    for damping in 0.0, 0.1:
        kernels.alone(J.ravel(), 3, 4, np.ones(3), damping, x, work)
        assert np.isnan(x).all()
        kernels.alone(np.ones(12), 3, 4, np.array([0.0, bad, 0.0]), damping, x, work)
        assert np.isnan(x).all()
    way = np.empty(3)
    kernels.best_way(J.ravel(), 3, 4, way, work)
    assert np.isnan(way).all()
    kernels.root(np.full(4, bad), 2, x)
    assert np.isnan(x).all()


def alone(kernels, J, h, damping=0.0):
    m, n = J.shape
    x = np.empty(n)
    kernels.alone(J.ravel(), m, n, h, damping, x, np.empty(m * (n + m + 1)))
    return x


def test_the_motion_that_a_task_would_make_alone(kernels):
    rng = np.random.default_rng(3)
    for J in matrices(300, most=6, scale=100):
        h = rng.standard_normal(len(J))
        sizes = np.linalg.svd(J, compute_uv=False)
        shares = sizes / max(sizes[0], 1e-300)
        if ((shares > 1e-10) & (shares < 1e-8)).any():  # on the edge of what counts
            continue
        counted = sizes[shares > algebra.RANK_TOLERANCE]
        expected = np.linalg.pinv(J, rcond=algebra.RANK_TOLERANCE) @ h
        # A direction is known to round-off over its own size.
        tolerance = 1e-12 * np.linalg.norm(h) / counted[-1] * (counted[0] / counted[-1]) if len(counted) else 0.0
        np.testing.assert_allclose(alone(kernels, J, h), expected, rtol=1e-12, atol=tolerance)


def test_one_row_and_no_row_to_follow(kernels):
    assert alone(kernels, np.array([[3.0, 4.0]]), np.array([5.0])) == pytest.approx([0.6, 0.8], rel=1e-15)
    assert alone(kernels, np.zeros((1, 2)), np.array([5.0])).tolist() == [0.0, 0.0]
    assert alone(kernels, np.zeros((2, 3)), np.ones(2)).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("damping", [1e-3, 0.1, 10.0])
def test_the_damped_motion(kernels, damping):
    """Its normal equations; and never more than ``||h|| / 2 lambda``."""
    rng = np.random.default_rng(4)
    for _ in range(60):
        m, n = int(rng.integers(1, 7)), int(rng.integers(1, 9))
        J, h = rng.standard_normal((m, n)), rng.standard_normal(m)
        if m > 1:
            J[-1] = J[0] * (1.0 + 10.0 ** rng.uniform(-17, 0))
        x = alone(kernels, J, h, damping)
        size = np.linalg.norm(J, 2)
        round_off = 1e-14 * np.linalg.norm(h) * (size + damping) * (1.0 + size / damping) ** 2
        np.testing.assert_allclose(J.T @ (J @ x - h) + damping**2 * x, 0.0, atol=round_off)
        assert np.linalg.norm(x) <= np.linalg.norm(h) / (2.0 * damping) * (1.0 + 1e-12)


def test_the_way_in_which_joints_turn_best(kernels):
    rng = np.random.default_rng(5)
    for _ in range(100):
        J = rng.standard_normal((2, int(rng.integers(1, 9))))
        way = np.empty(2)
        kernels.best_way(J.ravel(), *J.shape, way, np.empty(100))
        best = np.linalg.svd(J)[0][:, 0]
        best *= np.sign(best[np.argmax(np.abs(best))])  # its larger entry is positive
        np.testing.assert_allclose(way, best, atol=1e-10)
    kernels.best_way(np.zeros(8), 2, 4, way, np.empty(100))
    assert np.linalg.norm(way) == 1.0


def test_roots_and_triangles(kernels):
    rng = np.random.default_rng(6)
    for _ in range(60):
        n = int(rng.integers(1, 12))
        B = rng.standard_normal((n, n)) * 10.0 ** rng.uniform(-3, 3, n)
        M = B @ B.T + 1e-3 * np.diag(np.diag(B @ B.T))
        A = np.empty((n, n))
        assert kernels.root(M.ravel(), n, A.ravel())  # a view: A is filled
        np.testing.assert_allclose(A, np.linalg.cholesky(M).T, rtol=1e-9, atol=1e-11 * np.abs(A).max())
        b, x, back = rng.standard_normal(n), np.empty(n), np.empty(n)
        for solve, triangle in (kernels.solve_upper, A), (kernels.solve_lower, A.T):
            x[:] = b
            solve(A.ravel(), n, x)
            kernels.times(triangle.ravel(), n, n, x, back)
            np.testing.assert_allclose(back, b, atol=1e-9 * np.abs(triangle).max() * np.abs(x).max())


@pytest.mark.parametrize("M", [[[1.0, 2.0], [2.0, 1.0]], [[0.0]], [[-1.0]], [[np.nan]], [[1.0, 1.0], [1.0, 1.0]]])
def test_no_root_of_what_is_not_positive_definite(kernels, M):
    A = np.zeros(np.size(M))
    assert not kernels.root(np.array(M).ravel(), len(M), A)
    assert np.isnan(A).all()
