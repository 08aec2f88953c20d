"""Random hierarchies: what is in them, and how answers to them are judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mutants import MUTATIONS, mutate

from hqp import Solver, Status
from hqp.certificate import Certificate
from hqp.solution import Solution
from hqp.validation import SIZES, Judgement, hierarchies, judge, summed
from hqp.validation.conditioning import stream
from hqp.validation.hierarchies import beaten, crowded


@pytest.mark.parametrize("size", SIZES)
def test_all_that_a_solver_could_forget_is_at_every_level(size: tuple[int, int]) -> None:
    n, levels = size
    made = [crowded(n, levels, np.random.default_rng(seed)) for seed in range(20)]
    for h in made:
        assert h.n == n
        assert len(h.levels) == levels
    for k in range(1, levels):
        own = [h.levels[k] for h in made]
        assert any(((level.lower < level.upper) & np.isfinite(level.lower)).any() for level in own)
        assert any(((level.lower < level.upper) & np.isfinite(level.upper)).any() for level in own)
        assert any((level.lower == level.upper).any() for level in own)
        assert all(np.ptp(level.weights) > 0.0 for level in own)
        solved = [Solver().solve(h).levels[k].residual_norm for h in made]
        assert max(solved) > 1e-2, "no conflict"


def test_all_backends_are_right(general_backend: str) -> None:
    for size in SIZES:
        (found,) = judge([general_backend], size, 3, seed=0)
        assert (found.backend, found.count, found.refuted, found.failures) == (general_backend, 3, 0, 0)
        assert found.certified == 3
        assert found.ok


def test_hierarchies_are_the_same_whoever_asks_for_how_many() -> None:
    whole = judge(["native"], (7, 4), 4, seed=3)
    parts = [judge(["native"], (7, 4), 2, seed=3, first=first)[0] for first in (0, 2)]
    timeless = [replace(found, seconds=0.0) for found in (*whole, *summed(parts))]
    assert timeless[0] == timeless[1]


def test_closed_forms_are_not_asked() -> None:
    assert judge(["pseudoinverse", "pseudoinverse:joint"], (3, 2), 1, seed=0) == []


def test_a_pair_tells_without_the_certificate(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whichever level a wrong solver gives up for another, a right one attains less at the first that differs."""
    monkeypatch.setattr(hierarchies, "_refuted", lambda answer, certificate: False)
    for name in (
        "ignores inequalities below the top",
        "drops the second level",
        "ignores x_ref",
        "ignores lower bounds",
    ):
        with monkeypatch.context() as inside:
            mutate(inside, "cascade:proxsuite", next(mutation for mutation in MUTATIONS if mutation.name == name))
            right, wrong = judge(["native", "cascade:proxsuite"], (15, 6), 4, seed=0)
        assert right.ok, name
        assert wrong.beaten > 0, name
        assert wrong.by == ("native",)
        assert not wrong.ok


def test_who_is_better_at_a_lower_level_for_a_worse_higher_one_is_beaten() -> None:
    rng = stream(0, "pair")
    hierarchy, x_ref = crowded(7, 4, rng), rng.standard_normal(7)
    right = Solver().solve(hierarchy, x_ref)
    tempted = replace(right, x=x_ref.copy(), backend="cascade:proxsuite")  # nothing is left of the last level
    assert beaten({"native": right, "cascade:proxsuite": tempted}) == {"cascade:proxsuite": ("native",)}
    assert beaten({"native": right, "cascade:proxsuite": replace(right, backend="cascade:proxsuite")}) == {}


def test_who_promises_nothing_judges_nobody() -> None:
    rng = stream(0, "pair")
    hierarchy, x_ref = crowded(7, 4, rng), rng.standard_normal(7)
    right = Solver().solve(hierarchy, x_ref)
    assert beaten({"native": replace(right, x=x_ref.copy()), "daqp": replace(right, backend="daqp")}) == {}


def test_giving_up_is_honest_if_rare_and_the_levels_above_are_right(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = Solver.solve

    def gives_up(self: Solver, hierarchy, x_ref=None) -> Solution:
        return replace(seen(self, hierarchy, x_ref), status=Status.FAILED, level=1)

    monkeypatch.setattr(Solver, "solve", gives_up)
    (found,) = judge(["native"], (7, 4), 2, seed=0)
    assert (found.refuted, found.failures) == (0, 2)
    assert not found.ok
    assert Judgement("native", 7, 4, count=200, certified=198, failures=2).ok
    assert not Judgement("native", 7, 4, count=200, certified=199, refuted=1).ok


def test_a_first_order_backend_is_judged_by_what_it_claims() -> None:
    rng = stream(0, "pair")
    hierarchy, x_ref = crowded(3, 2, rng), rng.standard_normal(3)
    right = Solver().solve(hierarchy, x_ref)
    near = replace(right, x=right.x + 1e-5)
    judged: list[Certificate] = [hierarchies._best(replace(near, backend=name)) for name in ("native", "cascade:osqp")]
    assert [certificate.ok for certificate in judged] == [False, True]
