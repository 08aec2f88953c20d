"""The known answers are right, and everybody finds them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hqp import certify, solve
from hqp.backends import BACKENDS
from hqp.backends.pseudoinverse import joint_form
from hqp.validation import KNOWN, KnownAnswer, check, known
from hqp.validation.backwards import BACKWARDS, backwards

EACH = pytest.mark.parametrize("answer", KNOWN, ids=lambda answer: answer.name)


def test_every_name_is_another() -> None:
    assert len({answer.name for answer in KNOWN}) == len(KNOWN)


@EACH
def test_it_is_the_optimum_by_the_certificate_alone(answer: KnownAnswer) -> None:
    certificate = certify(answer.hierarchy, answer.x, answer.x_ref)
    assert certificate.ok, certificate
    residuals = [level.residual_norm for level in certificate.levels[:-1]]
    assert residuals == pytest.approx(answer.residuals.tolist(), abs=1e-12)


@EACH
def test_its_multipliers_balance_the_level(answer: KnownAnswer) -> None:
    """A_k^T D_k^2 w_k + sum_j A_j^T lambda_kj = 0, an upper bound pushes with a positive one."""
    h = answer.hierarchy
    for k, multipliers in answer.multipliers.items():
        level, rows = h.levels[k], h.dense()
        A = h.matrix(k)
        slack = A @ answer.x - np.clip(A @ answer.x, level.lower, level.upper)
        above = rows[: h.pointers[k]]
        assert A.T @ (level.weights**2 * slack) + above.T @ multipliers == pytest.approx(np.zeros(h.n), abs=1e-12)
        found = certify(h, answer.x, answer.x_ref).levels[k].multipliers
        assert found == pytest.approx(multipliers, abs=1e-12)


@pytest.mark.parametrize("n", [7, 30])
def test_what_is_made_backwards_is_known_to_the_last_digit_and_has_everything_in_it(n: int) -> None:
    """Small integers and powers of two: nothing is rounded, so that x is the optimum exactly."""
    (answer,) = [answer for answer in BACKWARDS if answer.hierarchy.n == n]
    h = answer.hierarchy
    scaled = [64.0 * array[np.isfinite(array)] for array in (h.A, h.lower, h.upper, h.weights, answer.x, answer.x_ref)]
    assert all((array == np.round(array)).all() and np.abs(array).max() < 2**20 for array in scaled)
    for level in h.levels:
        assert (level.lower < level.upper).any()
        assert np.ptp(level.weights) > 0.0
    assert (answer.residuals[1:] > 0.0).all()
    assert np.abs(solve(h).x - answer.x).max() > 1e-3  # x_ref has a say
    assert answer.multipliers


def test_a_seed_gives_one_hierarchy_and_another_another() -> None:
    one, same, other = (backwards(7, (4, 1, 0), seed=seed) for seed in (3, 3, 4))
    assert (one.hierarchy.A == same.hierarchy.A).all()
    assert one.hierarchy.A.shape != other.hierarchy.A.shape or (one.hierarchy.A != other.hierarchy.A).any()


@pytest.mark.parametrize("seed", range(8))
def test_whatever_the_seed_it_is_certified_and_found(seed: int) -> None:
    answer = backwards(15, (5, 3, 2, 1), seed=seed)
    assert certify(answer.hierarchy, answer.x, answer.x_ref).ok
    assert solve(answer.hierarchy, x_ref=answer.x_ref).x == pytest.approx(answer.x, abs=1e-9)


def test_the_multipliers_of_the_harmonic_levels_have_the_sign_of_escande() -> None:
    answer = next(answer for answer in KNOWN if answer.name == "harmonic, n = 5")
    w = 1 / 2 + 1 / 3 + 1 / 4 + 1 / 5
    assert solve(answer.hierarchy).levels[5].multipliers == pytest.approx([-w, -w / 2, -w / 3, -w / 4, -w / 5])


@EACH
def test_unique_means_that_x_ref_moves_nothing(answer: KnownAnswer) -> None:
    elsewhere = answer.x + np.arange(1.0, answer.hierarchy.n + 1) ** 2
    moved = float(np.abs(solve(answer.hierarchy, x_ref=elsewhere).x - answer.x).max())
    assert (moved < 1e-12) == answer.unique


def test_every_backend_finds_them(general_backend: str) -> None:
    findings = check(general_backend)
    assert [found.name for found in findings] == [answer.name for answer in KNOWN]
    for found in findings:
        assert found.hit, found
        assert found.certified, found
        assert max(found.x, found.residual) < 1e-10


@pytest.mark.parametrize(("backend", "least"), [("pseudoinverse", 8), ("pseudoinverse:joint", 1)])
def test_the_closed_forms_find_what_they_take(backend: str, least: int) -> None:
    findings = check(backend)
    assert least <= len(findings) < len(KNOWN)
    assert all(found.hit and found.certified for found in findings)


def test_eq_48_solves_the_hierarchy_that_is_said_to_be_its_own() -> None:
    (answer,) = [answer for answer in KNOWN if answer.stack is not None]
    assert answer.stack is not None
    own = joint_form(answer.stack)
    assert solve(own).x == pytest.approx(answer.x)
    assert own.levels[1].lower == pytest.approx(answer.hierarchy.levels[1].lower)


def test_a_miss_is_a_miss(monkeypatch: pytest.MonkeyPatch) -> None:
    first = replace(KNOWN[0], x=KNOWN[0].x * (1 + 1e-5))
    monkeypatch.setattr(known, "KNOWN", (first,))
    exact, rough = check("native")[0], check("cascade:osqp")[0]
    assert not exact.hit
    assert not exact.ok
    assert rough.ok  # first-order: 1e-3


def test_who_promises_nothing_may_miss() -> None:
    if not BACKENDS["daqp"].installed:
        pytest.skip("daqp is not installed")
    findings = check("daqp")
    assert any(not found.hit for found in findings)
    assert all(found.ok for found in findings)
    assert all(found.certified == found.hit for found in findings)
