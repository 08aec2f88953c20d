"""Every problem family is what it says it is."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest

from benchmarks.families import FAMILIES, Family, moved
from benchmarks.families.control import CONTRADICTION, CONTROL
from benchmarks.families.sizes import LEVELS, ROWS, UNKNOWNS
from benchmarks.registry import select
from hqp import Hierarchy, InvalidInput, solve

HERE = [family for family in FAMILIES.values() if not family.needs or find_spec(family.needs) is not None]


def numbers(h: Hierarchy) -> np.ndarray:
    return np.concatenate([h.A.ravel(), h.lower, h.upper, h.weights])


def structure(h: Hierarchy) -> tuple[object, ...]:
    return h.n, [len(level) for level in h.levels], h.columns.tolist()


@pytest.mark.parametrize("family", HERE, ids=lambda family: family.key)
def test_a_family_keeps_what_it_says(family: Family) -> None:
    assert family.about
    assert "\n" not in family.about
    for draw in range(3):
        before, now = family.sample(0, draw)
        np.testing.assert_array_equal(numbers(now), numbers(family.sample(0, draw).now))
        assert structure(before) == structure(now)
        equal = now.lower == now.upper
        assert family.inequalities or equal.all()
        if family.feasible:
            assert solve(now).levels[0].residual_norm <= 1e-9
        if family.posture:
            last = now.levels[-1]
            assert last.indices is not None
            assert sorted(last.indices) == list(range(now.n))
            assert (last.lower == last.upper).all()
            assert (last.weights == 1.0).all()
    if family.draws is None:
        assert not np.array_equal(numbers(family.sample(0, 0).now), numbers(family.sample(1, 0).now))


def test_some_family_has_inequalities_where_it_says_so() -> None:
    for family in HERE:
        rows = [family.sample(0, draw).now for draw in range(5)]
        assert family.inequalities == any((h.lower < h.upper).any() for h in rows), family.key


def test_growth_curves_grow_along_one_thing() -> None:
    curves = {curve: [f for f in HERE if f.curve == curve] for curve in ("n", "levels", "rows")}
    sizes = {"n": UNKNOWNS, "levels": LEVELS, "rows": ROWS}
    for curve, families in curves.items():
        assert tuple(f.at for f in families) == sizes[curve]
        for f in families:
            h = f.sample(0, 0).now
            inequalities = sum(len(level) for level in h.levels[1:-1] if (level.lower < level.upper).all())
            assert {"n": h.n, "levels": len(h.levels), "rows": inequalities}[curve] == f.at
            if curve == "levels" and f.at > 3:
                assert (h.n, h.m - 2 * h.n) == (36, 6 + 18)


def test_random_families_have_what_they_control() -> None:
    for share in (0.0, 0.25, 0.5, 0.75):
        h = FAMILIES[f"random/rank {share:.0%}"].sample(0, 0).now
        for k, level in enumerate(h.levels[1:4], start=1):
            assert np.linalg.matrix_rank(h.matrix(k), tol=1e-9) == max(1, len(level) - round(share * len(level)))
        h = FAMILIES[f"random/conflict {share:.0%}"].sample(0, 0).now
        first = h.matrix(1)
        below = np.vstack([h.matrix(2), h.matrix(3)])
        rest = below - below @ np.linalg.pinv(first) @ first
        assert (np.linalg.norm(rest, axis=1) < 1e-9).sum() == round(share * len(below))
        h = FAMILIES[f"random/active {share:.0%}"].sample(0, 0).now
        free = solve(Hierarchy(list(h.levels[1:]), n=h.n)).x
        outside = (np.abs(free) > h.levels[0].upper * (1 + 1e-9)).sum()
        assert outside == pytest.approx(share * h.n, abs=1.0)


def test_patterns_select_and_unknown_ones_are_refused() -> None:
    assert select(["control/*"], FAMILIES, "family") == list(CONTROL.values())
    assert select(["control/P2", "control/P1"], FAMILIES, "family") == [CONTROL["P1"], CONTROL["P2"]]
    assert select(None, CONTROL, "family") == list(CONTROL.values())
    with pytest.raises(InvalidInput, match=r"unknown family 'nothing/\*'; there are P1, P2"):
        select(["nothing/*"], CONTROL, "family")


SHAPES = {
    "P1": (3, (2, 1, 3)),
    "P2": (7, (7, 3, 3, 7)),
    "P3": (30, (30, 12, 3, 6, 10, 30)),
    "P3h": (30, (30, 12, 3, 6, 11, 30)),
    "P4": (60, (60, 12, 6, 6, 12, 6, 10, 60)),
    "W48": (48, (48, 18, 40, 6, 6, 3, 48)),
}


def test_a_whole_body_is_saturated_and_solved() -> None:
    for h in CONTROL["WB"].problems(4, 0):
        assert (h.n, tuple(len(level) for level in h.levels)) == (59, (18, 61, 3, 6, 53))
        solution = solve(h)
        assert solution.certify().ok
        assert solution.levels[0].residual_norm <= 1e-9
        assert all(level.residual_norm > 1.0 for level in solution.levels[2:])
        assert np.count_nonzero(solution.levels[1].active) >= 20


@pytest.mark.parametrize("name", SHAPES)
def test_the_families_of_a_controller_are_made_as_told(name: str) -> None:
    n, rows = SHAPES[name]
    for h in CONTROL[name].problems(4, 0):
        assert (h.n, tuple(len(level) for level in h.levels)) == (n, rows)
        np.testing.assert_allclose(h.row_norms(), 1.0, rtol=1e-14)
        if name != "P1":
            assert (h.levels[0].lower == -1).all()
            assert (h.levels[0].upper == 1).all()
        for level in h.levels:
            equal = level.lower == level.upper
            assert equal.all() or not equal.any()
    assert CONTROL[name].about.startswith(f"n = {n}: ")


def test_p3h_has_a_level_that_cannot_be_met() -> None:
    for h in CONTROL["P3h"].problems(4, 0):
        level = h.levels[4]
        assert level.A is not None
        np.testing.assert_array_equal(level.A[0], level.A[-1])
        assert level.lower[-1] - level.upper[0] == pytest.approx(CONTRADICTION)
        assert solve(h).levels[4].residual_norm >= CONTRADICTION / np.sqrt(2) - 1e-9


@pytest.mark.parametrize("name", SHAPES)
def test_moved_changes_equality_targets_and_nothing_else(name: str) -> None:
    for h in CONTROL[name].problems(2, 0):
        before = numbers(h)
        still, twin = (moved(h, np.random.default_rng(3), share) for share in (0.0, 0.1))
        np.testing.assert_array_equal(numbers(h), before)
        np.testing.assert_array_equal(numbers(still), before)
        np.testing.assert_array_equal(twin.A, h.A)
        equal = h.lower == h.upper
        np.testing.assert_array_equal(twin.lower == twin.upper, equal)
        np.testing.assert_array_equal(twin.lower[~equal], h.lower[~equal])
        np.testing.assert_array_equal(twin.upper[~equal], h.upper[~equal])
        for level, other in zip(h.levels, twin.levels, strict=True):
            if (level.lower == level.upper).all() and len(level) > 1:
                assert (level.lower != other.lower).all()
