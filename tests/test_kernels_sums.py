"""Products and sums of rows, four in each pass: as NumPy's for any number of rows and columns."""

from __future__ import annotations

from itertools import product

import kernels
import numpy as np

from hqp.kernels import sums

NAMES = "multiply", "add_rows", "add_to_each", "add_squares"


def test_sums_of_rows_are_those_of_numpy() -> None:
    rng = np.random.default_rng(0)
    for loops in kernels.compiled(sums, *NAMES), kernels.plain(sums):
        for count, n in product(range(10), (1, 3, 4, 9)):
            rows, x, shares = rng.normal(size=(count, n)), rng.normal(size=n), rng.normal(size=count)
            out, before = np.empty(count), rng.normal(size=n)
            loops.multiply(rows, count, x, n, out)
            np.testing.assert_allclose(out, rows @ x, atol=1e-14)
            for first in range(count + 1):
                out = before.copy()
                loops.add_rows(shares, rows, first, count, n, out)
                np.testing.assert_allclose(out, before + shares[first:] @ rows[first:], atol=1e-14)
            changed = rows.copy()
            loops.add_to_each(changed, count, shares, x, n)
            np.testing.assert_allclose(changed, rows + np.outer(shares, x), atol=1e-14)
            M = np.outer(before, before)
            out = M.copy()
            loops.add_squares(np.empty(count), rows, count, n, -0.5, out)
            np.testing.assert_allclose(out, M - 0.5 * rows.T @ rows, atol=1e-14)
