"""The validation finds what it is meant to find."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hqp import Hierarchy, Solution, Solver
from hqp.problems import CASES, SHAPES, equality_cases
from hqp.validation import closed_forms, merge, validate_case


def test_it_covers_every_shape_in_every_rank_case() -> None:
    cases = list(equality_cases())
    assert len(cases) == len(SHAPES) * len(CASES) == 24
    assert "7; 3,4 repeated row" in {case.name for case in cases}


def test_every_case_has_the_rank_that_it_says() -> None:
    for case in equality_cases():
        h = case.hierarchy(np.random.default_rng(0))
        first, second = h.matrix(0), h.matrix(1)
        full = min(case.rows[0], case.n)
        expected = max(1, case.rows[0] - 1) if case.rank == "rank deficient" else full
        assert np.linalg.matrix_rank(first) == expected
        together = np.linalg.matrix_rank(np.concatenate([first, second]))
        if case.rank == "second inside first":
            assert together == expected
        elif case.rank == "repeated row":
            assert together == min(case.n, full + case.rows[1] - 1)


@pytest.mark.parametrize("case", list(equality_cases())[:8], ids=lambda case: case.name)
def test_the_default_backend_is_inside_its_class(case) -> None:
    for report in validate_case("cascade:proxsuite", case, 10, seed=1):
        assert report.ok
        assert report.worst_x < 1e-9
        assert report.certified == report.count == 10
        assert report.levels_solved > 0


def test_the_same_seed_gives_the_same_stacks() -> None:
    case = next(equality_cases())
    a, b = (validate_case("cascade:proxsuite", case, 5, seed=4)[0] for _ in range(2))
    assert (a.worst_x, a.worst_residual) == (b.worst_x, b.worst_residual)


class Off:
    """A solver whose answers are 1e-4 too long."""

    def __init__(self, name: str) -> None:
        self.exact = Solver("pseudoinverse")

    def solve(self, hierarchy: Hierarchy, x_ref: np.ndarray) -> Solution:
        solution = self.exact.solve(hierarchy, x_ref)
        return replace(solution, x=solution.x * (1 + 1e-4))


def test_a_wrong_backend_is_outside_its_class(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(closed_forms, "Solver", lambda name: (Off if name == "cascade:proxsuite" else Solver)(name))
    report = validate_case("cascade:proxsuite", next(equality_cases()), 3, seed=0)[0]
    assert not report.ok
    assert report.worst_x == pytest.approx(1e-4, rel=1e-3)
    assert report.certified == 0


def test_merge_keeps_the_worst() -> None:
    cases = list(equality_cases())[:3]
    reports = [report for case in cases for report in validate_case("pseudoinverse", case, 3, seed=0)]
    merged = {report.formula: report for report in merge(reports)}
    assert set(merged) == {"Eq. 3.17", "Eq. 4.8"}
    eq48 = [report for report in reports if report.formula == "Eq. 4.8"]
    assert merged["Eq. 4.8"].worst_x == max(report.worst_x for report in eq48)
    assert merged["Eq. 4.8"].count == 9


@pytest.mark.sweep
@pytest.mark.parametrize("case", list(equality_cases()), ids=lambda case: case.name)
def test_1000_stacks_of_each_case(general_backend: str, case) -> None:
    for report in validate_case(general_backend, case, 1000, seed=0):
        assert report.ok, report
