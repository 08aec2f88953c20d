"""Products that are exact but for one rounding: both ways to them agree with rational numbers."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from kernels import compiled

from hqp import FixedDamping, Hierarchy, Level, solve
from hqp.arrays import Array, products
from hqp.kernels import sums


def cancelling(count: int) -> Iterator[tuple[Array, Array]]:
    """Rows and an x along which they cancel, but for a share of 1 to 1e-20 of the lengths."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        n = int(rng.integers(1, 20))
        rows = rng.standard_normal((3, n)) * 10.0 ** rng.uniform(-6.0, 6.0, (3, n))
        x = rng.standard_normal(n) * 10.0 ** rng.uniform(-8.0, 8.0, n)
        x[-1] = x[-1] if n == 1 else -(rows[0, :-1] @ x[:-1]) / rows[0, -1]
        yield rows, x


def exact(row: Array, x: Array) -> Fraction:
    return sum((Fraction(a) * Fraction(b) for a, b in zip(row.tolist(), x.tolist(), strict=True)), Fraction(0))


def test_products_are_rounded_once() -> None:
    for rows, x in cancelling(200):
        assert products(rows, x).tolist() == [float(exact(row, x)) for row in rows]
    assert products(np.zeros((0, 3)), np.ones(3)).shape == (0,)


def test_so_are_those_of_the_kernel_but_for_round_off_of_round_off() -> None:
    product, lost = compiled(sums, "product").product, []
    for rows, x in cancelling(200):
        n = len(x)
        for row in rows:
            right, sizes = exact(row, x), float(np.abs(row) @ np.abs(x))
            assert abs(Fraction(product(row, x, n)) - right) <= 2.0**-52 * abs(right) + (n * 2.0**-52) ** 2 * sizes
            lost.append(abs(Fraction(float(row @ x)) - right) > 1e-3 * abs(right))
    assert any(lost)  # where the sum as it comes has no digit left


def test_what_a_damped_level_has_reached_stays_whatever_the_length_of_x() -> None:
    """Two rows are nearly the same. Damped as little as they differ, x is long; on the levels below it is short."""
    for backend in "native", "pseudoinverse":
        claimed = 0
        for seed in range(40):
            rng = np.random.default_rng(seed)
            (row, other), gap = rng.standard_normal((2, 4)), 10.0 ** rng.uniform(-12.0, -9.5)
            rows, b = np.array([row, rng.uniform(0.5, 2.0) * (row + gap * other)]), rng.standard_normal((2, 4))
            h = Hierarchy([Level.equality(rows, b[0, :2]), Level.equality(np.eye(4), b[1])])
            solution = solve(h, damping={0: FixedDamping(gap)}, backend=backend)
            claimed += solution.ok
            assert solution.certify().ok or not solution.ok, seed
        assert claimed > 20
