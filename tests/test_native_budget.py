"""The native solver stopped early: what is finished is exact, and it goes on from there."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from test_native import BACKEND, fresh, proved

from hqp import Hierarchy, InvalidInput, Settings, Solver, Status
from hqp.problems import hierarchies


@cache
def hard() -> list[tuple[str, Hierarchy]]:
    """Hierarchies which no guess solves."""
    made = [
        (f"{name} {k}", h)
        for name in ("vertex", "one point", "single point", "weights")
        for k, h in enumerate(hierarchies(name, 60))
    ]
    return [(name, h) for name, h in made if fresh(h).counts.iterations > 0]


@pytest.mark.parametrize("iterations", [1, 2, 3, 5, 8])
def test_what_a_small_budget_leaves_is_exact_above_the_level_where_it_stopped(iterations: int) -> None:
    cases, stopped, below = hard(), 0, 0
    assert len(cases) >= 20
    for name, h in cases:
        solution = Solver(BACKEND, Settings(iterations=iterations)).solve(h)
        if solution.counts.iterations < iterations:
            assert proved(solution), name
            continue
        if solution.ok:
            assert solution.certify().ok, name
            continue
        assert solution.status is Status.SUBOPTIMAL, name
        assert solution.counts.iterations == iterations
        assert f"after {iterations} iterations; the levels above are exact" in solution.message
        assert np.isfinite(solution.x).all()
        assert solution.level is not None
        certificate = solution.certify()
        assert all(level.ok for level in certificate.levels[: solution.level]), f"{name}\n{certificate}"
        stopped += 1
        below += solution.level > 0

        # What can still be gained, and how far away that is.
        k = solution.level
        nearest = fresh(Hierarchy(h.levels[: k + 1], n=h.n), solution.x)
        assert proved(nearest), name
        best = nearest.certify().levels[k].residual_norm if k < len(h.levels) else np.linalg.norm(nearest.x)
        if np.linalg.norm(nearest.x - solution.x) <= certificate.radius:
            gained = certificate.levels[k].residual_norm - best
            assert gained <= solution.gap + 1e-9 * (1.0 + best), name
    assert stopped >= 15
    if iterations > 1:  # the first one mostly goes into level 0
        assert below >= 1


def test_a_solver_goes_on_after_its_budget_ran_out() -> None:
    """The active rows where it stopped are the next guess; sooner or later they are right."""
    for name, h in hard():
        solver = Solver(BACKEND, Settings(iterations=3))
        for _ in range(4):
            solution = solver.solve(h)
            assert np.isfinite(solution.x).all()
            assert solution.status in (Status.OPTIMAL, Status.SUBOPTIMAL), name
            assert not solution.ok or solution.certify().ok, name


def test_a_deadline_that_has_passed_leaves_what_is_finished_exact() -> None:
    stopped = 0
    for name, h in hard():
        solution = Solver(BACKEND, Settings(time_limit=1e-9)).solve(h)
        if solution.ok:
            assert solution.certify().ok, name
            continue
        assert solution.status is Status.SUBOPTIMAL, name
        assert np.isfinite(solution.x).all()
        assert all(level.ok for level in solution.certify().levels[: solution.level]), name
        assert Solver(BACKEND, Settings(time_limit=60.0)).solve(h).status is not Status.SUBOPTIMAL
        stopped += 1
    assert stopped >= 10


@pytest.mark.parametrize("wrong", [0.0, -1.0, np.nan, "soon"])
def test_a_time_limit_is_positive(wrong: object) -> None:
    with pytest.raises(InvalidInput, match="settings: time_limit"):
        Settings(time_limit=wrong)  # type: ignore[arg-type]
