"""The span that grows block by block is that of the singular value decomposition, and so is what it combines."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hqp.arrays import Array
from hqp.certificate.subspace import FEW, RowSpace, row_space

TOLERANCE = 1e-12


def unit(rows: Array) -> Array:
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def blocks(rng: np.random.Generator) -> list[Array]:
    """Of all kinds: new rows, rows again, combinations of earlier ones, and of those up to a little."""
    n = int(rng.integers(1, 3 * FEW))
    found, above = [], np.zeros((0, n))
    for _ in range(int(rng.integers(1, 6))):
        block = rng.standard_normal((int(rng.integers(0, 8)), n))
        if len(above) and len(block):
            some = rng.random(len(block)) < 0.4
            block[some] = rng.standard_normal((int(some.sum()), len(above))) @ above
            if rng.random() < 0.3:
                block[some] += 10.0 ** rng.uniform(-9, -1) * rng.standard_normal((int(some.sum()), n))
        found.append(unit(block))
        above = np.concatenate([above, found[-1]])
    return found


@given(st.integers(0, 2**32 - 1))
def test_it_is_the_span_of_the_singular_value_decomposition(seed: int) -> None:
    rng = np.random.default_rng(seed)
    parts = blocks(rng)
    rows, vector = np.concatenate(parts), rng.standard_normal(parts[0].shape[1])
    space, count = RowSpace(rows.shape[1], TOLERANCE), 0
    for part in parts:
        count += len(part)
        space.grow(part)
        basis, _, smallest = row_space(rows[:count], TOLERANCE)
        assert space.basis.shape == basis.shape
        assert space.basis.T @ space.basis == pytest.approx(np.eye(basis.shape[1]), abs=1e-12)
        off = np.linalg.norm(space.project(vector) - (vector - basis @ (basis.T @ vector)))
        assert off <= 1e-13 * np.linalg.norm(vector) / smallest
        wanted = basis @ (basis.T @ vector)
        found, shortest = space.combine(vector), np.linalg.lstsq(rows[:count].T, vector, rcond=TOLERANCE)[0]
        assert np.linalg.norm(found @ rows[:count] - wanted) <= 1e-12 * np.linalg.norm(vector) / smallest
        assert np.linalg.norm(found - shortest) <= 1e-11 * np.linalg.norm(vector) / smallest**2


@pytest.mark.parametrize("little", [1e-15, 1e-11, 1e-8, 1e-4])
def test_where_the_pivots_leave_a_doubt_singular_values_decide(little: float) -> None:
    """Each of the last two rows adds a little to what is there, their difference the square of it."""
    rows = np.zeros((3, FEW + 2))
    rows[:, :3] = unit(np.array([[1.0, 0.0, 0.0], [1.0, little, 0.0], [0.0, 1.0, little]]))
    space = RowSpace(rows.shape[1], TOLERANCE)
    for count in (1, 2, 3):
        space.grow(rows[count - 1 : count])
        assert space.basis.shape == row_space(rows[:count], TOLERANCE)[0].shape
