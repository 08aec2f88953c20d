"""On the way into a singularity: where solvers and closed forms agree, where they need not, and what is judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hqp import Hierarchy, Settings, Solution, Solver
from hqp.validation import (
    PLACES,
    RELATIONS,
    SIGMAS,
    TARGETS,
    ZONES,
    approach,
    compare,
    conditioning,
    part,
    zone,
)
from hqp.validation.conditioning import near_singular, stream

EPS = float(np.finfo(float).eps)
CLEAR = (1.0, 1e-2, 1e-4, 1e-5)
GONE = (1e-12, 1e-13, 1e-14)


def test_the_grid_has_the_ends_of_the_zones_on_it() -> None:
    assert {1.0, 1e-6, 1e-9, 1e-12, 1e-14} <= set(SIGMAS)
    assert [zone(sigma) for sigma in (1.0, 1e-6, 9e-7, 1e-9, 2e-12, 1e-12, 1e-14)] == [
        *[ZONES[0]] * 2,
        *[ZONES[1]] * 3,
        *[ZONES[2]] * 2,
    ]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("sigma", [1e-1, 1e-4])
def test_the_singular_values_are_what_they_are_said_to_be(place: str, sigma: float) -> None:
    stack = near_singular(place, "any", sigma, np.random.default_rng(0))
    J1, J2 = stack.matrix(0), stack.matrix(1)
    projected = J2 - J2 @ np.linalg.pinv(J1) @ J1
    matrix = {"inside level 0": J1, "inside level 1": J2, "between the levels": projected}[place]
    assert np.linalg.svd(matrix)[1].min() == pytest.approx(sigma, rel=1e-9)
    if place == "between the levels":
        assert np.linalg.svd(J1)[1] == pytest.approx(1.0)
        assert np.linalg.svd(J2)[1] == pytest.approx(np.hypot(1.0, sigma))


@pytest.mark.parametrize("place", PLACES)
def test_where_the_rank_is_clear_the_difference_is_round_off_over_sigma(general_backend: str, place: str) -> None:
    for point in approach(general_backend, place, 2, seed=3, sigmas=CLEAR):
        assert point.x.max() < 200 * EPS / point.sigma
        assert point.certified == 2
        assert point.ok
        assert point.outside == 0


@pytest.mark.parametrize("place", PLACES)
def test_below_the_tolerance_both_truncate(general_backend: str, place: str) -> None:
    for point in approach(general_backend, place, 2, seed=3, sigmas=GONE):
        assert point.x.max() < 20 * point.sigma + 1e-9
        assert point.length.max() < 1e3  # and not 1 / sigma
        assert point.ok


@pytest.mark.parametrize("place", ["inside level 1", "between the levels"])
def test_at_the_threshold_x_may_part_while_residuals_agree(place: str) -> None:
    (point,) = [
        p
        for p in approach("native", place, 10, 0, sigmas=(1e-9,))
        if (p.targets, p.formula) == (TARGETS[0], "Eq. 3.17")
    ]
    assert point.x.max() > 1e-2
    assert point.residual.max() < 1e-6
    assert point.outside > 0
    assert point.ok  # shown, not judged


def test_near_a_singularity_it_is_the_formula_that_leaves_a_residual() -> None:
    stack = near_singular("between the levels", "in reach", 1e-7, stream(0, "residual"))
    left = {
        name: np.linalg.norm(stack.matrix(1) @ Solver(name).solve(stack).x - stack.levels[1].lower)
        for name in ("native", "pseudoinverse")
    }
    assert left["native"] < 1e-14
    assert left["pseudoinverse"] > 1e-11


def test_regularisation_shows_without_polish_and_promises_nothing() -> None:
    sigma = Settings().proximal_weight  # its square is far below the weight
    rough, fine = (
        approach("cascade:osqp", "inside level 1", 2, 0, sigmas=(10 * sigma,), polished=polished)[0]
        for polished in (False, True)
    )
    assert rough.x.min() > 1e-3
    assert fine.x.max() < 1e-8
    assert rough.ok
    assert rough.outside == 2
    assert rough.name == "cascade:osqp, unpolished"


def test_eq_48_has_no_algorithmic_singularity() -> None:
    for point in approach("native", "between the levels", 3, 0, sigmas=(1e-3, 1e-7, 1e-9, 1e-11)):
        if point.formula == "Eq. 4.8":
            assert point.x.max() < 1e-12
            assert point.length.max() < 1e2


class Off:
    """A solver whose answers are 1e-4 too long."""

    def __init__(self, name: str, settings: Settings | None = None) -> None:
        self.exact = Solver("pseudoinverse")

    def solve(self, hierarchy: Hierarchy) -> Solution:
        solution = self.exact.solve(hierarchy)
        return replace(solution, x=solution.x * (1 + 1e-4))


def test_what_is_outside_is_counted_everywhere_and_judged_where_the_rank_is_clear(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def solver(name: str, settings: Settings | None = None) -> Off | Solver:
        return (Off if name == "cascade:proxsuite" else Solver)(name, settings)

    monkeypatch.setattr(conditioning, "Solver", solver)
    for point in approach("cascade:proxsuite", "inside level 1", 3, 0, sigmas=(1e-2, 1e-8, 1e-13)):
        if point.formula == "Eq. 3.17":
            assert point.outside == 3
            assert point.ok == (zone(point.sigma) == "undecidable")


def test_all_meet_the_same_stacks_whatever_else_is_asked() -> None:
    few, many = (approach("native", "inside level 0", 2, 7, sigmas=sigmas) for sigmas in ((1e-3,), (1e-2, 1e-3)))
    for a in few:
        (b,) = [b for b in many if (b.formula, b.targets, b.sigma) == (a.formula, a.targets, a.sigma)]
        assert (a.x == b.x).all()


@pytest.mark.parametrize("relation", RELATIONS)
def test_the_formulas_coincide_where_they_have_to_and_nowhere_else(relation: str) -> None:
    (parting,) = compare(relation, 20, seed=1)
    assert parting.ok
    assert parting.coincide == (parting.certified == 20) == (parting.x.max() < 1e-9)
    if not parting.coincide:
        assert parting.x.min() > 1e-3
        assert parting.residual.min() > 1e-6


def test_between_the_levels_the_strict_stack_grows_and_eq_48_does_not() -> None:
    clear, near, gone = part("between the levels", 5, 0, sigmas=(1e-2, 1e-5, 1e-13))
    assert np.median(near.strict) > 100 * np.median(clear.strict)
    assert near.joint.max() < 10
    assert near.residual.min() > 1e-2
    assert gone.coincide
    assert gone.x.max() < 1e-11
    assert gone.ok
