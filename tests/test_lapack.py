"""LAPACK called directly says what numpy says, and refuses what it cannot do."""

from __future__ import annotations

import numpy as np
import pytest

from hqp.backends.lapack import least_squares, row_space
from hqp.certificate import subspace


def projector(basis: np.ndarray) -> np.ndarray:
    return basis @ basis.T


@pytest.mark.parametrize("shape", [(1, 3), (3, 3), (2, 5), (6, 2), (0, 4), (3, 0)])
@pytest.mark.parametrize("seed", range(5))
def test_row_and_null_space_are_those_of_numpy(shape: tuple[int, int], seed: int) -> None:
    rows = np.random.default_rng(seed).standard_normal(shape)
    rows[1:] *= [1e-12, 1.0][seed % 2]  # below the tolerance, every second time
    mine, theirs = row_space(rows, 1e-9), subspace.row_space(rows, 1e-9)
    for basis, expected in zip(mine, theirs[:2], strict=True):
        assert basis.shape == expected.shape
        np.testing.assert_allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-14)
        np.testing.assert_allclose(projector(basis), projector(expected), atol=1e-12)


@pytest.mark.parametrize("shape", [(3, 3), (6, 2), (4, 1), (3, 0)])
def test_least_squares_are_those_of_numpy(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    A, b = rng.standard_normal(shape), rng.standard_normal(shape[0])
    np.testing.assert_allclose(least_squares(A, b), np.linalg.lstsq(A, b)[0], atol=1e-13)


def test_what_has_no_answer_is_refused() -> None:
    with pytest.raises(np.linalg.LinAlgError):
        least_squares(np.diag([1.0, 0.0]), np.ones(2))
    with pytest.raises(np.linalg.LinAlgError):
        row_space(np.full((2, 2), np.nan), 1e-9)
