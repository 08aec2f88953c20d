"""Products and sums of rows with room for whole lines: as NumPy's for any number of rows and columns."""

from __future__ import annotations

from itertools import product

import kernels
import numpy as np

from hqp.kernels import lines, orthogonal, single_lines, sums, vectors
from hqp.kernels.layout import padded

NAMES = "multiply", "multiply_long", "add_rows", "add_long", "add_to_each", "add_squares"


def with_room(array):
    """The same numbers in rows of whole lines; what else is in these means nothing."""
    room = np.full((*array.shape[:-1], padded(array.shape[-1])), np.nan)
    room[..., : array.shape[-1]] = array
    return room


def test_sums_of_rows_are_those_of_numpy() -> None:
    rng = np.random.default_rng(0)
    for loops in kernels.compiled(sums, *NAMES), kernels.plain(vectors, lines, single_lines, orthogonal, sums):
        for count, n in product(range(10), (1, 3, 4, 8, 9, 20)):
            rows, x, shares = rng.normal(size=(count, n)), rng.normal(size=n), rng.normal(size=count)
            out, before = np.full(count + 1, np.nan), rng.normal(size=n)
            for multiply in loops.multiply, loops.multiply_long:
                multiply(with_room(rows), count, x, n, out)
                np.testing.assert_allclose(out, [*rows @ x, np.nan], atol=1e-14)
            for first in range(count + 1):
                out = with_room(before)
                loops.add_rows(shares, with_room(rows), first, count, n, out)
                np.testing.assert_allclose(out[:n], before + shares[first:] @ rows[first:], atol=1e-14)
                for begin in range(n):
                    out = with_room(before)
                    loops.add_long(shares, with_room(rows), first, count, begin, n, out)
                    np.testing.assert_allclose(
                        out[begin:n], (before + shares[first:] @ rows[first:])[begin:], atol=1e-14
                    )
            changed = with_room(rows)
            loops.add_to_each(changed, count, shares, with_room(x), n)
            np.testing.assert_allclose(changed[:, :n], rows + np.outer(shares, x), atol=1e-14)
            M = np.outer(before, before)
            out = with_room(M)
            loops.add_squares(np.empty(count), with_room(rows), count, n, -0.5, out)
            np.testing.assert_allclose(out[:, :n], M - 0.5 * rows.T @ rows, atol=1e-14)
