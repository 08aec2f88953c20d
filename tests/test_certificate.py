"""The certificate: accepts optima with the right multipliers, refuses everything else, and says where."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hqp import Hierarchy, InvalidInput, Level, certify, solve
from hqp.kernels.span import FREE_RANK
from hqp.problems import random_hierarchy

seeds = st.integers(0, 2**32 - 1)


def reach_behind_a_limit() -> Hierarchy:
    """x <= 1 above x = 3: the optimum is x = 1, held back by the limit with multiplier 2."""
    return Hierarchy([Level.bounds([-np.inf], [1.0], name="limit"), Level.equality([[1.0]], [3.0], name="reach")])


def test_the_multiplier_balances_the_slack() -> None:
    certificate = certify(reach_behind_a_limit(), [1.0])
    assert certificate.ok
    limit, reach, last = certificate.levels
    assert limit.residual_norm == 0.0
    assert reach.residual_norm == pytest.approx(2.0)
    assert reach.multipliers == pytest.approx([2.0])  # w = -2 pulls up, an upper bound holds: positive
    assert last.multipliers == pytest.approx([0.0, -1.0])


def test_the_multiplier_of_a_lower_bound_is_negative() -> None:
    h = Hierarchy([Level([[2.0]], [2.0], [np.inf]), Level.equality([[1.0]], [-3.0])])
    certificate = certify(h, [1.0])
    assert certificate.ok
    assert certificate.levels[1].multipliers == pytest.approx([-2.0])


def test_weights_enter_squared() -> None:
    h = Hierarchy([Level.equality([[1.0], [1.0]], [0.0, 1.0], weights=[1.0, 2.0])])
    assert certify(h, [0.8]).ok  # (0 + 4 * 1) / 5
    assert not certify(h, [0.5]).ok
    assert certify(h, [0.8]).levels[0].residual_norm == pytest.approx(np.hypot(0.8, 2 * 0.2))


@pytest.mark.parametrize(
    ("x", "level", "why"),
    [
        (0.5, 1, "the reach could go on"),
        (1.5, 0, "the limit is broken"),
        (3.0, 0, "the limit is broken, however well the reach is met"),
    ],
)
def test_it_names_the_highest_level_that_falls_short(x: float, level: int, why: str) -> None:
    certificate = certify(reach_behind_a_limit(), [x])
    assert not certificate.ok, why
    assert not certificate
    assert certificate.failed is not None
    assert certificate.failed.level == level
    assert f"level {level}" in str(certificate).splitlines()[0]


def test_the_gap_bounds_what_is_missing() -> None:
    h = Hierarchy([Level.equality(np.eye(2), [1.0, 2.0], name="goal")])
    for x in ([0.0, 0.0], [1.0, 1.9], [5.0, 2.0]):
        level = certify(h, x).levels[0]
        missing = np.linalg.norm(np.subtract(x, [1.0, 2.0]))  # the optimum has no residual
        assert missing * (1 - 1e-9) <= level.shortfall <= level.residual_norm * (1 + 1e-9)
        assert level.gap >= missing**2 / 2 * (1 - 1e-9)


def test_unique_includes_the_implicit_last_level() -> None:
    h = Hierarchy([Level.equality([[1.0, 1.0]], [2.0])])
    assert certify(h, [1.0, 1.0]).ok
    assert not certify(h, [2.0, 0.0]).ok
    assert certify(h, [2.0, 0.0], unique=False).ok
    assert certify(h, [2.0, 0.0], x_ref=[2.0, 0.0]).ok
    assert certify(h, [2.0, 0.0], x_ref=[1.0, -1.0]).ok


def test_a_free_row_and_a_zero_row_hold_nothing() -> None:
    h = Hierarchy(
        [
            Level([[1.0, 0.0], [0.0, 0.0]], [-np.inf, 1.0], [np.inf, 2.0], name="idle"),
            Level.equality([[1.0, 0.0]], [3.0]),
        ]
    )
    certificate = certify(h, [3.0, 0.0])
    assert certificate.ok
    assert certificate.levels[0].residual_norm == pytest.approx(1.0)  # 0 x >= 1 cannot be helped


def test_conflicting_duplicates_share_the_blame() -> None:
    h = Hierarchy([Level.equality([[1.0]], [0.0]), Level.equality([[1.0]], [1.0])])
    assert certify(h, [0.0]).ok
    assert not certify(h, [0.5]).ok
    same = Hierarchy([Level.equality([[1.0], [1.0]], [0.0, 1.0])])
    assert certify(same, [0.5]).ok


@given(seeds, st.sampled_from([1e-3, 1e-1, 10.0]))
def test_moved_answers_are_refused(seed: int, step: float) -> None:
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)
    x = solve(h).x
    assert certify(h, x).ok
    direction = rng.standard_normal(h.n)
    moved = x + step * max(1.0, np.linalg.norm(x)) * direction / np.linalg.norm(direction)
    assert not certify(h, moved).ok


@given(seeds)
def test_the_multipliers_are_a_proof_that_anybody_can_check(seed: int) -> None:
    """Stationarity, signs and complementarity, recomputed here from the definition."""
    h = random_hierarchy(np.random.default_rng(seed))
    x = solve(h).x
    rows = np.concatenate([h.matrix(k) for k in range(len(h.levels))] or [np.zeros((0, h.n))])
    value = rows @ x
    w = value - np.clip(value, h.lower, h.upper)
    near = 1e-7 * (1 + np.abs(value) + np.linalg.norm(rows, axis=1) * np.linalg.norm(x))
    for k, level in enumerate(certify(h, x, unique=False).levels):
        own, above = slice(h.pointers[k], h.pointers[k + 1]), h.pointers[k]
        force = rows[own].T @ (h.weights[own] ** 2 * np.where(np.abs(w[own]) > near[own], w[own], 0.0))
        scale = np.abs(rows[own]).sum() * (1 + np.abs(w[own]).max(initial=0.0)) * h.weights[own].max(initial=1.0) ** 2
        held = rows[:above].T @ level.multipliers
        assert np.linalg.norm(force + held) <= 1e-6 * (1 + scale)
        for i, multiplier in enumerate(level.multipliers):
            if h.lower[i] == h.upper[i] or abs(w[i]) > near[i] or abs(multiplier) <= 1e-7 * (1 + scale):
                continue
            assert value[i] >= h.upper[i] - near[i] if multiplier > 0 else value[i] <= h.lower[i] + near[i]


def _light_rows() -> dict[str, tuple[Hierarchy, list[float], list[float]]]:
    """Wrong points beside the right one, where something much larger tries to hide the error."""
    fixed = Level.bounds([0.0], [0.0], indices=[0])
    eye = np.eye(2)
    return {
        "hair over a bound, to reach below": (
            Hierarchy([Level.bounds([-10.0] * 4, [1.0, 10, 10, 10]), Level.equality([[1.0, 0, 0, 0]], [0.0])]),
            [1 + 6e-9, 0, 0, 0],
            [0, 0, 0, 0],
        ),
        "a heavy satisfied neighbour": (
            Hierarchy([Level(eye, -10, [1.0, 10.0], weights=[1, 1e3]), Level.equality([[1.0, 0.0]], [0.0])]),
            [1.0005, 0],
            [0, 0],
        ),
        "a heavy row out of reach": (
            Hierarchy([fixed, Level.equality(eye, [1.0, 1.0], weights=[2e4, 1.0])], n=2),
            [0, 0],
            [0, 1],
        ),
        "a heavier row out of reach, a small error": (
            Hierarchy([fixed, Level.equality(eye, [1.0, 1.0], weights=[1e3, 1.0])], n=2),
            [0, 0.999],
            [0, 1],
        ),
        "a far target out of reach": (Hierarchy([fixed, Level.equality(eye, [1e9, 1.0])], n=2), [0, 0], [0, 1]),
    }


@pytest.mark.parametrize("case", _light_rows())
def test_nothing_large_hides_an_error_in_something_small(case: str) -> None:
    hierarchy, wrong, right = _light_rows()[case]
    assert certify(hierarchy, right).ok
    assert not certify(hierarchy, wrong).ok


def test_either_rank_decision_passes_where_nobody_can_tell() -> None:
    """A row that depends on the one above up to 1e-10: followed 1e10 far, or taken for dependent."""
    h = Hierarchy([Level.equality([[1.0, 0.0]], [1.0]), Level.equality([[1.0, 1e-10]], [2.0])])
    assert certify(h, [1.0, 1e10]).ok
    assert certify(h, [1.0, 0.0]).ok


@pytest.mark.parametrize("share", [1e-11, 5e-10, 3e-9])
def test_and_passes_for_the_levels_below(share: float) -> None:
    """The limit holds the reach back, so the level below cannot have x[0] move away from it, whatever the rank."""
    limit = Level([[1.0, 0.0]], -np.inf, [0.0], name="limit")
    reach = Level.equality([[1.0, share]], [1.0], name="reach")
    h = Hierarchy([limit, reach, Level.equality(np.eye(2), [-1000.0, 0.0], name="rest")])
    assert certify(h, [0.0, 0.0]).ok
    assert certify(h, [0.0, 1.0 / share]).ok
    for x in ([-1.0, 0.0], [-1e-6, 0.0]):
        assert not certify(h, x).ok


def test_an_optimum_passes_whoever_found_it_however_parallel_rows_are() -> None:
    """Singular values of 3e-10 and more magnify the round-off of this method in another way than that of a solver."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(4, 8))
        A = rng.standard_normal((int(rng.integers(1, n // 2)), n))
        rows = [A, A + 10.0 ** rng.uniform(-9.0, -7.0) * rng.standard_normal(A.shape), rng.standard_normal((1, n))]
        h = Hierarchy([Level.equality(A, rng.standard_normal(len(A))) for A in rows])
        x = np.linalg.lstsq(np.concatenate(rows), h.lower, rcond=FREE_RANK)[0]
        assert certify(h, x).ok
        beside = np.linalg.svd(np.concatenate(rows))[2][-1]  # in the null space of all rows
        assert not certify(h, x + 1e-5 * np.linalg.norm(x) * beside).ok


@pytest.mark.parametrize(("tangential", "ok"), [(0.0, True), (2.5e-10, True), (5e-10, False)])
def test_the_limit_gives_way_to_shifts_of_the_last_level(tangential: float, ok: bool) -> None:
    """x may be 1e-9 off in each number: in both together, only if the multiplier of the limit changes with them."""
    normal = np.array([1.0, 0.1]) / np.hypot(1.0, 0.1)
    h = Hierarchy([Level(normal[None], [1.0], np.inf)])
    assert certify(h, normal + tangential * np.array([-normal[1], normal[0]])).ok == ok


@pytest.mark.parametrize("seed", range(60))
def test_a_shift_of_x_passes_however_its_entries_are_to_their_tolerances(seed: int) -> None:
    """A row moves x from x_ref, along itself, by less than the tolerance of some entries, and more than that of others.

    Those that are within count as zero at first; without them, nothing balances the others.
    """
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 6))
    row, x_ref = rng.standard_normal(n) * 10.0 ** rng.uniform(-3.0, 0.0, n), rng.standard_normal(n)
    x_ref *= 10.0 ** rng.uniform(-3.0, 2.0, n)
    shift = 10.0 ** rng.uniform(-10.0, -7.0) * np.abs(x_ref).max() * row / np.linalg.norm(row)
    h = Hierarchy([Level.equality([row], [row @ (x_ref + shift)])])
    assert certify(h, x_ref + shift, x_ref).ok
    assert not certify(h, x_ref + shift + 1e-5 * np.abs(x_ref).max() * (row != row[0]), x_ref).ok


@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-8])
def test_a_violation_that_nobody_can_tell_frees_no_row(off: float) -> None:
    """A short row ends below its bound; above it by the round-off of two long rows of its level, it must not be held.

    The bound is 1, and the level below asks for 0.
    """
    long, short = 1e5, 1e-3
    rows = [[long, 0.0], [long, 0.0], [0.0, short]]
    h = Hierarchy(
        [Level(rows, [long, 2 * long, -np.inf], [long, 2 * long, short]), Level.equality([[0.0, 1.0]], [0.0])]
    )
    assert certify(h, [1.5, 0.0]).ok
    refused = certify(h, [1.5, 1.0 + off])
    assert not refused.ok
    assert refused.failed is not None
    assert refused.failed.level == 1


def test_wrong_input_is_refused() -> None:
    h = reach_behind_a_limit()
    with pytest.raises(InvalidInput, match=r"x has shape \(2,\); it must be \(1,\)"):
        certify(h, [1.0, 2.0])
    with pytest.raises(InvalidInput, match=r"x\[0\] = nan must be finite"):
        certify(h, [np.nan])
    with pytest.raises(InvalidInput, match=r"x reaches 1e\+80; nothing beyond 1e\+60 can be judged"):
        certify(h, [1e80])
    with pytest.raises(InvalidInput, match=r"x_ref reaches 1e\+300; nothing beyond 1e\+60 can be judged"):
        certify(h, [1.0], x_ref=[1e300])
    with pytest.raises(InvalidInput, match="x_ref has shape"):
        certify(h, [1.0], x_ref=[1.0, 1.0])
    for tolerance in (0.0, -1.0, np.inf, np.nan, 1.0, "a"):
        with pytest.raises(InvalidInput, match="tolerance"):
            certify(h, [1.0], tolerance=tolerance)  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match="must be a Hierarchy"):
        certify(None, [1.0])  # type: ignore[arg-type]
    h.levels[0].upper[0] = np.nan
    with pytest.raises(InvalidInput, match=r"level 0 \('limit'\), row 0"):
        certify(h, [1.0])


def test_it_prints_a_line_a_level() -> None:
    text = str(certify(reach_behind_a_limit(), [1.0]))
    assert text.startswith("certified: lexicographically optimal at all 3 levels")
    for name in ("level 0 (limit)", "level 1 (reach)", "level 2 (min ||x - x_ref||)"):
        assert name in text


@pytest.mark.parametrize("short", [1e-16, 1e-13, 1e-8])
def test_a_short_row_out_of_reach_hides_nothing(short):
    """Its bound is 0.5 / short away, and yet the other row of its level must be met as exactly as without it."""
    limits = Level.bounds([-1.0, -1.0], [1.0, 1.0])
    level = Level.equality([[short, 0.0], [0.0, 1.0]], [-0.5, 0.2])
    assert not certify(Hierarchy([limits, level]), [0.0, 0.0]).ok
    assert not certify(Hierarchy([limits, level]), [-1.0, 0.2 + 1e-6]).ok
    assert certify(Hierarchy([limits, level]), [-1.0, 0.2]).ok


def test_rows_that_depend_on_free_ones_push_nowhere() -> None:
    """Once more as inequalities, equalities hold nothing back: what projection leaves of them is round-off."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(2, 6))
        A = rng.standard_normal((n - 1, n))
        again = rng.standard_normal((3, n - 1)) @ A
        h = Hierarchy(
            [Level.equality(A, np.zeros(n - 1)), Level(again, -np.inf, 0.0), Level.equality(np.eye(n)[:1], [1.0])]
        )
        assert not certify(h, np.zeros(n), unique=False).ok  # x[0] is free to go to 1
        assert certify(h, solve(h).x).ok
