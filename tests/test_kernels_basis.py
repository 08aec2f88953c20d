"""Rows and an orthonormal basis: what is taken off a row along the basis, and what is left, make the row."""

from __future__ import annotations

import numpy as np
import pytest
from kernels import compiled, plain

from hqp.kernels import lines, orthogonal, single_lines, vectors
from hqp.kernels.layout import padded


@pytest.fixture(scope="module", params=["compiled", "plain"])
def kernels(request):
    names = "project", "split"
    return (
        compiled(orthogonal, *names) if request.param == "compiled" else plain(vectors, lines, single_lines, orthogonal)
    )


def rows(count):
    """Dense rows, rows of one entry, as of plain bounds, and of none; with a basis of some directions."""
    rng = np.random.default_rng(11)
    for trial in range(count):
        n = int(rng.integers(2, 20))
        c = int(rng.integers(1, n + 1))
        V = np.linalg.qr(rng.standard_normal((n, n)))[0].copy()
        row = rng.standard_normal(n)
        if trial % 3 == 1:
            row[np.arange(n) != rng.integers(n)] = 0.0
        elif trial % 3 == 2:
            row[:] = 0.0
        yield row * 10.0 ** rng.uniform(-8, 8), V, int(rng.integers(0, c)), c


def test_a_row_is_its_parts_along_the_basis_and_what_is_left(kernels):
    for row, V, first, c in rows(120):
        left, parts = row.copy(), np.zeros(c)
        kernels.project(left, len(row), V, first, c, parts)
        round_off = 1e-14 * np.abs(row).sum()
        assert np.abs(V[first:c] @ left).max() <= round_off
        assert np.abs(left + parts @ V[:c] - row).max() <= round_off
        assert not parts[:first].any()


def test_so_it_is_where_rows_end_in_zeros_and_all_that_stood_there_is_written(kernels):
    for row, V, first, c in rows(120):
        n, wide = len(row), padded(len(row))
        basis, left, parts = np.zeros((n, wide)), np.zeros(wide), np.full(c, np.nan)
        basis[:, :n], left[:n] = V, row
        kernels.split(left, wide, basis, first, c, parts)
        round_off = 1e-14 * np.abs(row).sum()
        assert np.abs(basis[first:c] @ left).max() <= round_off
        assert np.abs(left[:n] + parts[first:] @ V[first:c] - row).max() <= round_off
        assert not left[n:].any()
        assert np.isnan(parts[:first]).all()
