"""Eigenvalues of small symmetric matrices by loops: as NumPy's, whatever the matrix, compiled and interpreted."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

import kernels
import numpy as np
import pytest

from hqp.arrays import Array
from hqp.kernels import definite, lines, orthogonal, single_lines, sums, symmetric, transforms, vectors
from hqp.kernels.layout import PAD

#: By their names, what makes a matrix of this size.
KINDS: dict[str, Callable[[np.random.Generator, int], Array]] = {
    "random": lambda rng, n: rng.normal(size=(n, n)),
    "graded": lambda rng, n: rng.normal(size=(n, n)) * np.outer(*2 * [10.0 ** rng.uniform(-9, 0, n)]),
    "few values": lambda rng, n: _turned(rng, rng.integers(-1, 2, n).astype(float)),
    "small values": lambda rng, n: _turned(rng, 10.0 ** rng.uniform(-16, 0, n)),
    "diagonal": lambda rng, n: np.diag(rng.integers(-2, 3, n).astype(float)),
    "integers": lambda rng, n: rng.integers(-1, 2, (n, n)).astype(float),  # pivots that are exactly zero
    "sparse": lambda rng, n: rng.normal(size=(n, n)) * (rng.random((n, n)) < 0.15),
    "path": lambda rng, n: np.eye(n, k=1),
    "large": lambda rng, n: 1e140 * rng.normal(size=(n, n)),
    "small": lambda rng, n: 1e-140 * rng.normal(size=(n, n)),
    "zero": lambda rng, n: np.zeros((n, n)),
}


def _turned(rng: np.random.Generator, values: Array) -> Array:
    Q = np.linalg.qr(rng.normal(size=2 * values.shape))[0]
    turned: Array = Q * values @ Q.T
    return turned


def room(n: int) -> tuple[int, int]:
    """The shape of what eigenvectors are written to."""
    return n, -(-n // PAD) * PAD


def with_room(A: Array) -> Array:
    """A copy, in rows that have room for whole lines."""
    M = np.full(room(len(A)), np.nan)
    M[:, : len(A)] = A
    return M


def solvers() -> list[SimpleNamespace]:
    return [
        kernels.compiled(symmetric, "eigen"),
        kernels.plain(vectors, lines, single_lines, orthogonal, sums, transforms, symmetric),
    ]


@pytest.mark.parametrize("n", [1, 2, 3, 5, 8, 21])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("noise", [0.0, symmetric.NOISE])
def test_the_eigenvectors_of_any_matrix(kind: str, n: int, noise: float) -> None:
    rng = np.random.default_rng(n)
    for _ in range(3):
        A = KINDS[kind](rng, n)
        A = A + A.T
        size = np.abs(A).max() or 1.0
        for solver in solvers():
            M, U, values = np.full(room(n + 2), np.nan), np.full(room(n + 2), np.nan), np.full(room(n + 2)[1], np.nan)
            M[:n, :n] = A
            with np.errstate(divide="ignore"):
                solver.eigen(M, U, values, n, noise)
            found, axes = values[:n], U[:n, :n]
            np.testing.assert_allclose(np.sort(found) / size, np.linalg.eigvalsh(A / size), atol=1e-13)
            np.testing.assert_allclose(axes @ axes.T, np.eye(n), atol=1e-13)
            np.testing.assert_allclose(axes.T * (found / size) @ axes, A / size, atol=1e-13)


@pytest.mark.parametrize("n", [1, 2, 3, 5, 8, 21])
def test_factor_and_largest_eigenvalue_of_a_positive_matrix(n: int) -> None:
    rng = np.random.default_rng(n)
    for rank in range(1, n + 1):
        rows = rng.normal(size=(rank, n))
        A = rows.T @ rows
        for solver in (
            kernels.compiled(symmetric, "largest"),
            kernels.plain(vectors, lines, single_lines, orthogonal, sums, transforms, symmetric),
        ):
            M, values = with_room(A), np.full(room(n)[1], np.nan)
            assert solver.largest(M, values, n) == pytest.approx(np.linalg.norm(A, 2), rel=1e-12)
        for solver in (
            kernels.compiled(definite, "upper_factor"),
            kernels.plain(vectors, lines, single_lines, orthogonal, sums, definite),
        ):
            R, B, values = np.full(room(n), np.nan), A + 1e-3 * np.eye(n), np.full(room(n)[1], np.nan)
            assert solver.upper_factor(with_room(B), R, n, values)
            np.testing.assert_allclose(R[:, :n], np.linalg.cholesky(B).T, atol=1e-9)
            assert not solver.upper_factor(with_room(A - 1e-3 * np.eye(n)), R, n, values) or rank == n


@pytest.mark.parametrize("n", [1, 2, 3, 8, 21])
def test_the_bound_of_the_smallest_eigenvalue_is_that_of_the_moments_of_the_inverse(n: int) -> None:
    rng = np.random.default_rng(n)
    for solver in (
        kernels.compiled(definite, "smallest"),
        kernels.plain(vectors, lines, single_lines, orthogonal, sums, definite),
    ):
        rows = rng.normal(size=(n + 3, n))
        A, work = rows.T @ rows, [np.full(room(n), np.nan) for _ in range(2)]
        inverse = 1.0 / np.linalg.eigvalsh(A)
        wanted = 1.0 / (inverse.mean() + inverse.std() * np.sqrt(n - 1))
        shares = np.full(room(n)[1], np.nan)
        assert solver.smallest(with_room(A), *work, shares, n) == pytest.approx(wanted, rel=1e-9)
        assert solver.smallest(with_room(-A), *work, shares, n) == 0.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("n", [1, 2, 5, 9])
def test_the_part_of_a_matrix_with_eigenvalues_of_one_sign(n: int, sign: float) -> None:
    rng = np.random.default_rng(n)
    A = rng.normal(size=(n, n))
    A = A + A.T
    found, axes = np.linalg.eigh(A)
    for solver in (
        kernels.compiled(symmetric, "eigen", "bring_forward", "add_spectrum"),
        kernels.plain(vectors, lines, single_lines, orthogonal, sums, transforms, symmetric),
    ):
        M, U, values, part = with_room(A), np.empty(room(n)), np.empty(room(n)[1]), with_room(A)
        solver.eigen(M, U, values, n, 0.0)
        count = solver.bring_forward(U, values, n, sign)
        assert count == np.sum(sign * found > 0.0)
        solver.add_spectrum(U, values, n, count, -1.0, np.empty(n), part)  # what is left has the other sign
        np.testing.assert_allclose(part[:, :n], axes * np.where(sign * found > 0.0, 0.0, found) @ axes.T, atol=1e-12)
