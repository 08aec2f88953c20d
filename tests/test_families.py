"""The adversarial families are reproducible, and each has the difficulty that its name promises."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from hqp import Hierarchy, InvalidInput, Level, Solver, Status, solve
from hqp.problems import FAMILIES, hierarchies

COUNT = 60
#: What the cascade certifies always; elsewhere it may lose rows that are short beside others of their level.
EASY = [name for name, family in FAMILIES.items() if family.expect == "certified" and name != "weights"]

#: Made of inequality rows and of equalities which pull against them, and of nothing else.
PURE = ("vertex", "one point", "thin slab", "single point")


def named(hierarchy: Hierarchy, name: str) -> list[Level]:
    return [level for level in hierarchy.levels if level.name.startswith(name)]


def dense(hierarchy: Hierarchy, name: str) -> np.ndarray:
    return np.concatenate([level.A for level in named(hierarchy, name)])


def numbers(hierarchy: Hierarchy) -> tuple[bytes, ...]:
    h = hierarchy
    return tuple(array.tobytes() for array in (h.A, h.lower, h.upper, h.weights))


def parallel(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Sines of the angles between rows: all of A against all of B."""
    A, B = (rows / np.linalg.norm(rows, axis=1, keepdims=True) for rows in (A, B))
    across = B[None] - (A @ B.T)[:, :, None] * A[:, None]
    return np.linalg.norm(across, axis=2)


@pytest.mark.parametrize("name", FAMILIES)
def test_a_case_is_named_by_family_seed_and_number(name: str) -> None:
    first, again = list(hierarchies(name, 5, seed=3)), list(hierarchies(name, 7, seed=3))
    assert [numbers(h) for h in first] == [numbers(h) for h in again[:5]]
    assert [h.structure for h in first] == [h.structure for h in again[:5]]
    assert len({numbers(h) for h in [*again, *hierarchies(name, 7, seed=4)]}) == 14
    one = FAMILIES[name].hierarchy(np.random.default_rng(5))
    assert numbers(one) == numbers(FAMILIES[name].hierarchy(np.random.default_rng(5)))


@pytest.mark.parametrize("name", FAMILIES)
def test_sizes_are_those_of_a_robot_and_numbers_are_valid_unless_refused(name: str) -> None:
    made = list(hierarchies(name, COUNT))
    assert {h.n for h in made} <= set(range(2, 13))
    assert all(1 <= len(h.levels) <= 6 for h in made)
    assert len({h.n for h in made}) > 8
    assert all((h.find_fault() is not None) == (FAMILIES[name].expect == "refused") for h in made)
    assert FAMILIES[name].about.endswith(".")
    assert "\n" not in FAMILIES[name].about


def test_all_kinds_of_rows_are_mixed() -> None:
    for name in FAMILIES:
        made = list(hierarchies(name, COUNT))
        lower, upper = (np.concatenate([getattr(h, side) for h in made]) for side in ("lower", "upper"))
        assert (lower == upper).any(), name
        assert (np.isinf(lower) != np.isinf(upper)).any(), name
        if name not in PURE:
            assert (np.isfinite(lower) & np.isfinite(upper) & (lower < upper)).any(), name
            assert any((h.columns >= 0).any() for h in made), name


@pytest.mark.parametrize(("name", "count", "seed"), [("nonsense", 1, 0), ("vertex", -1, 0), ("vertex", 1, -1)])
def test_wrong_input_is_refused_at_once(name: str, count: int, seed: int) -> None:
    with pytest.raises(
        InvalidInput, match="unknown family 'nonsense'.*vertex" if name == "nonsense" else "= -1 must be"
    ):
        hierarchies(name, count, seed)


def spread(values: Iterator[float] | list[float], least: float, most: float, decades: float) -> None:
    """All between the two, and over so many decades."""
    found = np.array(list(values))
    assert least <= found.min()
    assert found.max() <= most
    assert np.log10(found.max() / found.min()) > decades


def test_nearly_singular_levels_have_one_small_singular_value() -> None:
    shares = []
    for h in hierarchies("nearly singular", COUNT):
        singular = np.linalg.svd(dense(h, "nearly singular"), compute_uv=False)
        assert singular[-2] == pytest.approx(singular[0])
        shares.append(singular[-1] / singular[0])
    spread(shares, 0.9e-14, 0.1, 10)


def test_algorithmic_singularities_lie_all_but_in_the_level_above() -> None:
    left = []
    for h in hierarchies("algorithmic singularity", COUNT):
        J1, J2 = dense(h, "first"), dense(h, "second")
        rest = J2 - J2 @ np.linalg.pinv(J1) @ J1
        left.append(np.linalg.norm(rest) / np.linalg.norm(J2))
    spread(left, 1e-16, 0.7, 8)


def test_nearly_parallel_rows_have_a_neighbour_that_is_not_quite_the_same() -> None:
    sines, levels = [], set()
    for h in hierarchies("nearly parallel", COUNT):
        both = np.concatenate([dense(h, "parallel"), *(level.A for level in named(h, "beside"))])
        half = len(both) // 2
        sines += list(np.diag(parallel(both[:half], both[half:])))
        levels.add(len(named(h, "beside")))
    spread(sines, 1e-11, 1e-2, 5)
    assert levels == {0, 1}


def test_rows_come_again_scaled_and_negated() -> None:
    factors = []
    for h in hierarchies("rows again", COUNT):
        own = named(h, "again")
        repeated = parallel(own[0].A, np.concatenate([level.A for level in own[1:]])) < 1e-7
        for i, j in np.argwhere(repeated):
            later = np.concatenate([level.A for level in own[1:]])[j]
            factors.append(later @ own[0].A[i] / (own[0].A[i] @ own[0].A[i]))
    assert min(factors) < -1
    assert max(factors) > 1
    spread(list(np.abs(factors)), 1e-7, 1e7, 3)


def test_a_repeated_row_contradicts_the_level_above() -> None:
    for h in hierarchies("repeated conflict", COUNT):
        above, *below = [*named(h, "once"), *named(h, "again")]
        for level in below:
            i, j = np.argwhere((above.A[:, None] == level.A[None]).all(axis=2))[0]
            assert above.lower[i] != level.lower[j]
            above = level


CORNERS = [("vertex", "vertex"), ("one point", "corner"), ("single point", "point")]


@pytest.mark.parametrize(("name", "level"), CORNERS)
def test_the_one_sided_rows_are_active_in_one_point(name: str, level: str) -> None:
    more = 0
    for h in hierarchies(name, COUNT):
        own = named(h, level)
        A, lower, upper = (np.concatenate([getattr(k, field) for k in own]) for field in ("A", "lower", "upper"))
        one = np.isinf(lower) != np.isinf(upper)
        value = np.where(np.isinf(lower), upper, lower)[one]
        point = np.linalg.lstsq(A[one], value)[0]
        np.testing.assert_allclose(A[one] @ point, value, atol=1e-9)
        more += one.sum() > h.n
    assert more > COUNT // 2


@pytest.mark.parametrize(("name", "level"), [*CORNERS, ("thin slab", "slab")])
def test_the_pull_is_held_back_at_the_corner(name: str, level: str) -> None:
    solver, held = Solver(), 0
    for h in hierarchies(name, 10):
        found = [k for k in solver.solve(h).levels if k.name in (level, "pull")]
        held += any(np.isin(k.active, (-1, 1, 2)).any() for k in found if k.name == level) and any(
            k.residual_norm > 1e-3 for k in found if k.name == "pull"
        )
    assert held >= 8


def test_a_vertex_has_4n_integer_rows() -> None:
    for h in hierarchies("vertex", COUNT):
        A = dense(h, "vertex")
        assert A.shape == (4 * h.n, h.n)
        assert np.array_equal(A, np.round(A))


def test_slabs_are_thin_and_not_empty() -> None:
    widths = []
    for h in hierarchies("thin slab", COUNT):
        (slab,) = named(h, "slab")
        half = len(slab) // 2
        lower = slab.lower if np.isfinite(slab.lower).all() else -slab.upper[half:]
        widths += list(slab.upper[: len(lower)] - lower)
    spread(widths, 0.9e-12, 1e-3, 6)


def test_the_top_is_infeasible() -> None:
    for h in hierarchies("infeasible top", COUNT):
        half = len(h.levels[0]) // 2
        np.testing.assert_array_equal(h.matrix(0)[:half], h.matrix(0)[half:])
        assert (h.levels[0].lower[:half] > h.levels[0].upper[half:]).all()


def test_nothing_is_said_by_zero_rows_free_rows_and_empty_levels() -> None:
    for h in hierarchies("nothing said", COUNT):
        assert (h.row_norms() == 0).sum() >= 3
        assert any(len(level) == 0 for level in h.levels)
        assert any(len(level) and np.isinf(level.lower).all() and np.isinf(level.upper).all() for level in h.levels)


def test_nothing_is_left_below_a_top_of_full_rank() -> None:
    tall = set()
    for h in hierarchies("nothing left", COUNT):
        assert np.linalg.matrix_rank(h.matrix(0)) == h.n
        tall.add(len(h.levels[0]) > h.n)
    assert tall == {False, True}


@pytest.mark.parametrize(
    ("name", "measure", "decades"),
    [
        ("scaled levels", lambda h: [np.median(level) for level in _norms(h)], 9),
        ("scaled rows", lambda h: max(_norms(h), key=lambda norms: norms.max() / norms.min()), 9),
        ("scaled variables", lambda h: np.median(np.abs(h.A), axis=0), 4),
    ],
)
def test_scales_lie_decades_apart(name: str, measure: Callable[[Hierarchy], np.ndarray], decades: float) -> None:
    apart = []
    for h in hierarchies(name, COUNT):
        sizes = np.array(measure(h)) if _norms(h) else np.ones(1)
        sizes = sizes[sizes > 0]
        apart.append(np.log10(sizes.max() / sizes.min()) if len(sizes) else 0.0)
    assert max(apart) > decades


def _norms(hierarchy: Hierarchy) -> list[np.ndarray]:
    """Of the rows of each level that has any; zero rows have no scale."""
    norms = [np.linalg.norm(level.A, axis=1) for level in hierarchy.levels if level.A is not None]
    return [level[level > 0] for level in norms if (level > 0).any()]


def test_the_rows_of_a_scaled_level_keep_their_scale() -> None:
    """Another reason to fail is another family."""
    for h in hierarchies("scaled levels", COUNT):
        assert all(level.max() / level.min() < 1e3 for level in _norms(h))


@pytest.mark.parametrize(("name", "level"), [("weights", "weighted"), ("weighted conflict", "conflict")])
def test_weights_lie_decades_apart_in_one_level(name: str, level: str) -> None:
    own = [found for h in hierarchies(name, COUNT) for found in named(h, level)]
    spread([weight for k in own for weight in k.weights], 1e-3, 1e3, 5)
    assert np.log10(max(k.weights.max() / k.weights.min() for k in own)) > 4


def test_a_weighted_conflict_cannot_be_met() -> None:
    for h in hierarchies("weighted conflict", COUNT):
        (level,) = named(h, "conflict")
        met = np.linalg.lstsq(level.A, level.lower)[0]
        assert np.abs(level.A @ met - level.lower).max() > 1e-3


def test_bounds_come_twice_again_and_fix_unknowns() -> None:
    crossed = 0
    for h in hierarchies("bounds", COUNT):
        limits, task, fixed, again = (named(h, name)[0] for name in ("limits", "crossing", "fixed", "again"))
        assert len(np.unique(limits.indices)) < len(limits)
        assert (fixed.lower == fixed.upper).all()
        assert set(fixed.indices) | set(again.indices) <= set(limits.indices)
        reach = np.abs(task.A[:, limits.indices[: h.n]]) @ limits.upper[: h.n]
        crossed += (np.abs(task.lower) > reach).any()
    assert crossed > 5


def test_bad_numbers_are_refused_and_their_place_is_named() -> None:
    solver, seen = Solver(), set()
    for h in hierarchies("bad numbers", COUNT):
        rows = np.isfinite(h.dense()).all(axis=1)
        fine = rows & (h.lower <= h.upper)
        (row,) = np.flatnonzero(~fine)
        level, inside = h.locate(row)
        solution = solver.solve(h)
        assert solution.status is Status.INVALID
        assert solution.message.startswith(f"{h.level_name(level)}, row {inside}: ")
        with pytest.raises(InvalidInput, match=f"level {level} .*row {inside}"):
            solve(h)
        seen.add("A" if not rows[row] else "NaN" if np.isnan(h.lower[row] + h.upper[row]) else "crossed")
    assert seen == {"A", "NaN", "crossed"}


@pytest.mark.parametrize("name", EASY)
def test_the_cascade_is_certified(name: str) -> None:
    solver = Solver("cascade:proxsuite")
    assert [k for k, h in enumerate(hierarchies(name, 20)) if not solver.solve(h).certify().ok] == []
