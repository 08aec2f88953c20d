"""Sums over rows, a line at a time: as NumPy's for any number of rows and entries, and nothing else is written."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from kernels import compiled, plain

from hqp.kernels import lines, single_lines, transforms, vectors
from hqp.kernels.layout import PAD

NAMES = (
    "add_lines",
    "add_lines_behind",
    "add_to_lines",
    "multiply_first",
    "multiply_chosen",
    "multiply_lines",
    "pick_entries",
    "product",
    "scale_behind",
    "scale_line",
    "subtract_chosen",
    "subtract_lines",
    "take_out",
    "weigh",
)
SINGLE = "add_line", "add_scaled", "clear_line", "copy_line", "eliminate", "multiply_line", "reflect_below"
TRANSFORMS = "reflect", "rotate", "subtract_both"
WIDTHS = PAD * np.array([1, 2, 3, 4, 7])


@pytest.fixture(scope="module", params=["compiled", "plain"])
def loops(request):
    if request.param == "compiled":
        found = compiled(lines, *NAMES), compiled(single_lines, *SINGLE), compiled(transforms, *TRANSFORMS)
    else:
        found = [plain(vectors, lines, module) for module in (lines, single_lines, transforms)]
    return SimpleNamespace(**{name: value for loops in found for name, value in vars(loops).items() if name[0] != "_"})


def close(one, other):
    return np.allclose(one, other, rtol=0.0, atol=1e-13, equal_nan=True)


def test_products_and_sums_are_those_of_numpy(loops):
    rng = np.random.default_rng(0)
    for end, wide in product(range(10), WIDTHS):
        rows, x, shares = rng.normal(size=(12, wide)), rng.normal(size=wide), rng.normal(size=12)
        ids = rng.permutation(12)
        out = np.full(12, np.nan)
        loops.multiply_chosen(rows, ids, end, x, wide, out)
        assert close(out, np.where(np.arange(12) < end, rows[ids] @ x, np.nan))
        changed = x.copy()
        loops.subtract_chosen(rows, ids, end, shares, wide, changed)
        assert close(changed, x - shares[:end] @ rows[ids[:end]])
        for first in range(end + 1):
            out = np.full(12, np.nan)
            loops.multiply_lines(rows, first, end, x, wide, out)
            assert close(out[first:end], rows[first:end] @ x)
            assert np.isnan(out[:first]).all()
            assert np.isnan(out[end:]).all()
            for sign, change in (1.0, loops.add_lines), (-1.0, loops.subtract_lines):
                changed = x.copy()
                change(rows, first, end, shares, wide, changed)
                assert close(changed, x + sign * shares[first:end] @ rows[first:end])


def test_a_direction_is_taken_out_of_the_rows_that_are_left(loops):
    rng = np.random.default_rng(1)
    for count, wide in product(range(10), WIDTHS):
        rows, slots, ids = rng.normal(size=(12, wide)), rng.permutation(12), rng.permutation(15)[:12]
        unit = rng.normal(size=wide)
        unit /= np.linalg.norm(unit)
        for first in range(count + 1):
            left, parts, sizes = rows.copy(), np.full((15, 3), np.nan), np.full(12, np.nan)
            loops.take_out(left, slots, first, count, unit, wide, parts, ids, 1, sizes)
            mine = slots[first:count]
            expected = rows.copy()
            expected[mine] -= np.outer(rows[mine] @ unit, unit)
            assert close(left, expected)
            assert close(parts[ids[first:count], 1], rows[mine] @ unit)
            assert close(sizes[first:count], np.linalg.norm(expected[mine], axis=1))
            assert np.isnan(parts).sum() == parts.size - (count - first)
            assert np.isnan(np.delete(sizes, np.arange(first, count))).all()


def test_rows_of_any_length_are_read_and_written_to_their_end_and_no_further(loops):
    """What stands beside them is no number: a sum that read it would be none."""
    rng = np.random.default_rng(2)
    for count in range(4 * PAD):
        row, x = (np.r_[np.full(3, np.nan), rng.normal(size=count), np.full(PAD, np.nan)] for _ in range(2))
        mine, other, out = row[3:], x[3:], np.full(count + PAD, np.nan)
        assert close(loops.product(mine, other, count), mine[:count] @ other[:count])
        assert close(loops.weigh(mine, -2.0, count, out), mine[:count] @ mine[:count])
        assert close(out, np.r_[-2.0 * mine[:count], np.full(PAD, np.nan)])


def test_rows_of_one_line_at_most_are_multiplied_added_and_eliminated(loops):
    """What stands behind their entries means nothing."""
    rng = np.random.default_rng(4)
    for count, n in product(range(10), range(1, PAD + 1)):
        rows, x, shares = np.full((12, PAD), np.nan), np.full(PAD, np.nan), rng.normal(size=12)
        rows[:, :n], x[:n] = rng.normal(size=(12, n)), rng.normal(size=n)
        out = np.full(12, np.nan)
        loops.multiply_line(rows, count, x, n, out)
        assert close(out, np.r_[rows[:count, :n] @ x[:n], np.full(12 - count, np.nan)])
        for first in range(count + 1):
            changed = x.copy()
            loops.add_line(shares, rows, first, count, changed)
            assert close(changed[:n], x[:n] + shares[first:count] @ rows[first:count, :n])
        if count <= n:
            for j in range(count):
                changed, behind = rows.copy(), slice(j + 1, count)
                loops.eliminate(changed, j, count, 0.3)
                expected = rows.copy()
                expected[behind, :n] -= 0.3 * np.outer(rows[j, behind], rows[j, :n])
                assert close(changed, expected)


@pytest.mark.parametrize("wide", WIDTHS)
def test_entries_are_picked_and_scaled(loops, wide):
    rng = np.random.default_rng(3)
    row, places, out = rng.normal(size=70), rng.permutation(70), np.full(70, np.nan)
    loops.pick_entries(row, places, wide, out)
    assert (out[:wide] == row[places[:wide]]).all()
    assert np.isnan(out[wide:]).all()
    loops.scale_line(row, 3.0, wide, out)
    assert close(out[:wide], 3.0 * row[:wide])
    assert np.isnan(out[wide:]).all()


def test_matrices_change_as_numpys(loops):
    rng = np.random.default_rng(1)
    for count, wide in product(range(10), WIDTHS):
        rows, u, p = rng.normal(size=(12, wide)), rng.normal(size=wide), rng.normal(size=wide)
        shares, before = rng.normal(size=12), rows.copy()
        rest = slice(count, None)

        changed = rows.copy()
        loops.add_to_lines(changed, count, shares, u, wide)
        assert close(changed[:count], (rows + np.outer(shares, u))[:count])
        assert (changed[rest] == before[rest]).all()

        if count <= wide:
            changed, last = rows.copy(), slice(wide - PAD, wide)
            loops.reflect_below(changed, 11, 0, count, 0.7, p, 0.3, wide - PAD, wide)
            full = np.r_[p[:count], np.zeros(11 - count), 0.7]
            assert close(changed[:, last], (rows - 0.3 * np.outer(full, full @ rows))[:, last])
            assert (changed[:, : wide - PAD] == before[:, : wide - PAD]).all()

        changed = u.copy()
        loops.add_scaled(p, -0.3, wide, changed)
        assert close(changed, u - 0.3 * p)
        loops.copy_line(p, wide, changed)
        assert (changed == p).all()
        loops.clear_line(changed, wide)
        assert (changed == 0.0).all()

        n = min(count, wide)
        changed = rows.copy()
        loops.subtract_both(changed, n, u, p, wide)
        assert close(changed[:n], rows[:n] - np.outer(u[:n], p) - np.outer(p[:n], u))
        assert (changed[n:] == before[n:]).all()

        changed = rows.copy()
        loops.reflect(changed, count, u, 0.3, wide)
        assert close(changed[:count], (rows - 0.3 * np.outer(rows @ u, u))[:count])
        assert (changed[rest] == before[rest]).all()

        changed = rows.copy()
        loops.rotate(changed[0], changed[1], 0.36, -0.64, wide)  # squares, with the signs of sine and cosine
        assert close(changed[:2], np.array([[-0.8, -0.6], [0.6, -0.8]]) @ rows[:2])

        for begin in range(wide):
            out = np.full(wide, np.nan)
            loops.scale_behind(u, 0.3, begin, wide, out)
            assert close(out, np.where(np.arange(wide) < begin, 0.0, 0.3 * u))
            changed = u.copy()
            loops.add_lines_behind(rows, 0, count, shares, begin, wide, changed)
            assert close(changed[begin:], (u + shares[:count] @ rows[:count])[begin:])


def test_products_of_first_entries_leave_out_all_others(loops):
    rng = np.random.default_rng(2)
    for count, n in product(range(10), range(1, 20)):
        rows, x = np.full((12, -(-n // PAD) * PAD), np.nan), rng.normal(size=n)
        rows[:, :n] = rng.normal(size=(12, n))
        out = np.full(12, np.nan)
        loops.multiply_first(rows, count, x, n, out)
        assert close(out, np.where(np.arange(12) < count, rows[:, :n] @ x, np.nan))
