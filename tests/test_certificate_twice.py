"""The compiled certificate says what the one by NumPy says, of optima, of points beside them, and of wrong numbers."""

from __future__ import annotations

from collections.abc import Iterable

import by_numpy
import numpy as np
import proving
import pytest
from proving import Point

import hqp
from hqp import Hierarchy, Level, certify
from hqp.certificate.judging import judged
from hqp.kernels.span import SOLVED_RANK
from hqp.problems import FAMILIES

UNDECIDABLE = [name for name, family in FAMILIES.items() if family.expect == "undecidable rank"]


def agree(points: Iterable[Point]) -> tuple[int, int, int]:
    """How many points were judged, how many of them have a decided verdict, and how many are optimal.

    Where the rank of a family is undecidable, one point of a thousand may be judged otherwise, as the smallest singular
    value is estimated in two ways.
    """
    judged = decided = proved = apart = 0
    for point in points:
        judged, said = judged + 1, proving.expected(point)
        if said is None:
            continue
        decided += 1
        proved += said
        agrees = certify(*point[1:]).ok == said
        if not agrees and point.name.split(",")[0] in UNDECIDABLE:
            apart += 1
            continue
        assert agrees, f"{point.name}: by NumPy {said}"
    assert apart <= 1e-3 * decided
    return judged, decided, proved


def test_of_what_breaks_solvers() -> None:
    judged, decided, proved = agree(proving.of_families(3, 12))
    assert judged > 500
    assert decided > 0.9 * judged
    assert 0.2 * judged < proved < 0.7 * judged


def test_of_what_is_decided_by_the_tolerances_of_rows() -> None:
    judged, decided, proved = agree(proving.far_out(40))
    assert decided > 0.7 * judged
    assert 0.1 * judged < proved < 0.7 * judged


def test_of_rows_that_are_nearly_parallel() -> None:
    """Some of them are optimal only for slacks within the tolerances, as of the first four seeds."""
    judged, decided, proved = agree(proving.nearly_parallel((13, 168, 328, 374, *range(20))))
    assert decided > 0.9 * judged
    assert 0.2 * judged < proved < 0.9 * judged


def test_of_whole_body_ticks_and_of_others_with_one_bound_changed() -> None:
    judged, decided, proved = agree(proving.recorded())
    assert judged > 200
    assert decided > 0.9 * judged
    assert 0.2 * judged < proved < 0.7 * judged


@pytest.mark.sweep
def test_of_many_of_each_family() -> None:
    print(agree(proving.of_families(60, 40)))
    print(agree(proving.far_out(1000)))


def test_the_multipliers_of_free_rows_are_the_shortest() -> None:
    """Where rows depend on each other, and all balance the level."""
    for seed in range(200):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(2, 8))
        A = rng.standard_normal((int(rng.integers(1, 2 * n)), n)) * 10.0 ** rng.uniform(-2, 2)
        again = rng.standard_normal((int(rng.integers(1, 4)), len(A))) @ A
        levels = [Level.equality(A, A @ np.ones(n)), Level.equality(again, again @ np.ones(n))]
        h = Hierarchy([*levels, Level.equality(rng.standard_normal((3, n)), rng.standard_normal(3))])
        x = hqp.solve(h).x
        for mine, wanted in zip(certify(h, x).levels, by_numpy.judge(h, x, np.zeros(n)), strict=True):
            norms = h.row_norms()[: len(wanted.multipliers)]
            size = np.linalg.norm(norms * wanted.multipliers)
            np.testing.assert_allclose(norms * mine.multipliers, norms * wanted.multipliers, atol=1e-7 * size, rtol=0)


def test_the_first_level_that_fails_is_the_same_whether_or_not_those_below_it_are_judged() -> None:
    """Of optima, and of points beside them along what no row determines: rows of a task and single variables."""
    determined = 0
    for seed in range(100):
        rng = np.random.default_rng(seed)
        n, rows = 8, int(rng.integers(1, 6))
        asked = rng.permutation(n)[: int(rng.integers(1, n + 1))]
        task = Level.equality(rng.standard_normal((rows, n)), rng.standard_normal(rows))
        h = Hierarchy([task, Level.equality(np.eye(n)[asked], rng.standard_normal(len(asked)))])
        x = hqp.solve(h).x
        _, sizes, directions = np.linalg.svd(np.vstack([level.A for level in h.levels]))
        free = directions[np.count_nonzero(sizes > 1e-9) :]
        determined += len(free) == 0
        for beside in (np.zeros(n), *free):
            failed, _, _ = judged(h, x + beside, np.zeros(n), 1e-9, every=False)
            assert failed == (2 if beside.any() else None), seed
            assert failed == judged(h, x + beside, np.zeros(n), 1e-9)[0], seed
    assert 20 < determined < 80


@pytest.mark.parametrize("little", [1e-15, 1e-11, 1e-8, 1e-4])
def test_a_doubtful_rank_is_what_singular_values_or_the_parts_of_rows_say(little: float) -> None:
    """Each of the last two rows adds a little to what is there, their difference the square of it."""
    rows = np.array([[1.0, 0.0, 0.0], [1.0, little, 0.0], [0.0, 1.0, little]])
    levels = [Level.equality(row[None], [0.0]) for row in rows]
    first, second, third = (Hierarchy([*levels, Level.equality(target[None], [1.0])]) for target in np.eye(3))
    assert certify(first, np.zeros(3)).ok
    assert certify(second, np.zeros(3)).ok  # the first two rows alone hold it, or the third one does
    by_values = all(level.ok for level in by_numpy.judge(third, np.zeros(3), np.zeros(3)))
    assert certify(third, np.zeros(3)).ok == (by_values or little > SOLVED_RANK)
