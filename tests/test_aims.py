"""What a damped level is damped towards: its aim stands for x_ref in all that belongs to the level."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.linalg import norm, pinv
from test_damped_native import Fixed, agree, in_stages, pair, seeds

import hqp
from hqp import ErrorDamping, FixedDamping, Hierarchy, InvalidInput, Level, NumericalFiltering, Solver, Status
from hqp.problems import random_hierarchy

backends = pytest.mark.parametrize("backend", ["native", "cascade:proxsuite", "pseudoinverse"])


def some_aims(rng: np.random.Generator, damped, n: int) -> dict[int, np.ndarray]:
    """Of most damped levels, of all sizes; often the same for several."""
    same = rng.standard_normal(n)
    return {
        k: same if rng.random() < 0.3 else 10.0 ** rng.uniform(-2, 1) * rng.standard_normal(n)
        for k in damped
        if rng.random() < 0.8
    }


@backends
@given(seed=seeds, factor=st.sampled_from([0.01, 0.3, 10.0]), filtered=st.booleans())
@settings(max_examples=15)
def test_the_closed_form(backend, seed, factor, filtered):
    """Below the level nothing is left of its aim: what it does not hold is next to x_ref."""
    rng = np.random.default_rng(seed)
    J1, J2, J3 = (rng.standard_normal((m, 8)) for m in (2, 3, 2))
    r1, r2, r3 = (rng.standard_normal(m) for m in (2, 3, 2))
    aim, x_ref = rng.standard_normal((2, 8))
    h = Hierarchy([Level.equality(J1, r1), Level.equality(J2, r2, name="second"), Level.equality(J3, r3)])
    rule = NumericalFiltering(factor, 0.7) if filtered else FixedDamping(factor)
    solution = hqp.solve(h, damping={1: rule}, aims={"second": aim}, x_ref=x_ref, backend=backend)

    N1 = np.eye(8) - pinv(J1) @ J1
    J_hat = J2 @ N1
    u = np.linalg.svd(J_hat)[0][:, -1]
    metric = factor**2 * np.eye(3) + (0.7**2 * np.outer(u, u) if filtered else 0.0)
    x = pinv(J1) @ r1 + N1 @ aim
    x += J_hat.T @ np.linalg.solve(J_hat @ J_hat.T + metric, r2 - J2 @ x)
    both = np.vstack([J1, J2])
    N = np.eye(8) - pinv(both) @ both
    x = pinv(both) @ both @ x + N @ x_ref
    x += pinv(J3 @ N) @ (r3 - J3 @ x)
    np.testing.assert_allclose(solution.x, x, atol=1e-8 * (1.0 + norm(x)))
    assert solution.certify().ok
    np.testing.assert_array_equal(solution.relaxed[0].aim, aim)
    np.testing.assert_array_equal(solution.aims[1], aim)


@given(seed=seeds)
@settings(max_examples=50)
def test_all_at_once_is_stage_by_stage_and_every_stage_is_proved(seed):
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)
    known, own = pair(rng, len(h.levels))
    solver = Solver(damping=known)
    for warm in False, True, True:
        x_ref, aims = rng.standard_normal(h.n), some_aims(rng, known, h.n)
        solution, expected = solver.solve(h, x_ref, aims), hqp.solve(h, damping=own, x_ref=x_ref, aims=aims)
        assert solution.ok
        assert solution.certify().ok, f"warm: {warm}"
        agree(solution, expected, 1e-8)
    assert not in_stages(solver)


@pytest.mark.sweep
def test_many_more():
    for seed in range(2000):
        rng = np.random.default_rng(seed)
        h = random_hierarchy(rng)
        known, own = pair(rng, len(h.levels))
        aims = some_aims(rng, known, h.n)
        solution = hqp.solve(h, damping=known, aims=aims)
        assert solution.certify().ok, seed
        agree(solution, hqp.solve(h, damping=own, aims=aims), 1e-8)


@pytest.mark.parametrize("backend", ["cascade:proxsuite", "cascade:osqp"])
def test_other_backends_give_the_same(backend):
    for seed in range(8):
        rng = np.random.default_rng(seed)
        h = random_hierarchy(rng)
        known, _ = pair(rng, len(h.levels))
        aims = some_aims(rng, known, h.n)
        solution = hqp.solve(h, damping=known, aims=aims, backend=backend)
        assert solution.certify().ok
        agree(solution, hqp.solve(h, damping=known, aims=aims), 1e-6)


@given(seed=seeds)
@settings(max_examples=30)
def test_an_aim_that_is_x_ref_changes_no_bit_and_aims_are_forgotten(seed):
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)
    x_ref = rng.standard_normal(h.n)
    known, _ = pair(rng, len(h.levels))
    solver, plain = Solver(damping=known), Solver(damping=known)
    for reference in None, x_ref, x_ref:
        aim = np.zeros(h.n) if reference is None else reference
        with_aims = solver.solve(h, reference, dict.fromkeys(known, aim))
        without = plain.solve(h, reference)
        np.testing.assert_array_equal(with_aims.x, without.x)
        for mine, theirs in zip(with_aims.stages, without.stages, strict=True):
            np.testing.assert_array_equal(mine.x, theirs.x)
    expected = solver.solve(h, x_ref).x  # warm from the same
    solver.solve(h, x_ref, some_aims(rng, known, h.n))
    np.testing.assert_allclose(solver.solve(h, x_ref).x, expected, atol=1e-9 * (1.0 + norm(expected)))


@given(seed=seeds, rule=st.builds(FixedDamping, st.floats(0.01, 1.0)) | st.builds(ErrorDamping, st.floats(0.01, 10.0)))
@settings(max_examples=40)
def test_what_the_level_adds_is_bounded_from_the_point_next_to_its_aim(seed, rule):
    """Also among inequalities: ||x - x_a|| <= b, where x_a is the answer of the levels above that is nearest to it."""
    rng = np.random.default_rng(seed)
    bounds = Level.bounds(*np.sort(rng.standard_normal((2, 5)), axis=0))
    weak = np.linalg.qr(rng.standard_normal((3, 3)))[0] * [1.0, 1.0, 1e-3] @ rng.standard_normal((3, 5))
    first = Level.equality(rng.standard_normal((1, 5)), rng.standard_normal(1))
    level = Level.equality(weak, rng.standard_normal(3))
    aims = {1: rng.standard_normal(5), 2: 3.0 * rng.standard_normal(5)}
    solution = hqp.solve(Hierarchy([bounds, first, level]), damping={1: 0.1, 2: rule}, aims=aims)
    assert solution.certify().ok
    reached = Level.equality(first.A, first.A @ solution.x)
    x_above = hqp.solve(Hierarchy([bounds, reached]), x_ref=aims[2]).x
    most = rule.largest_change(3, np.inf, norm(weak @ x_above - level.lower))
    assert norm(solution.x - x_above) <= most * (1 + 1e-9) + 1e-8


def test_stages_survive_a_copy_and_what_the_aims_become_later():
    h = Hierarchy([Level.equality([[1.0, 1.0]], [1.0], name="sum")])
    aim = np.array([3.0, -1.0])
    solution = Solver(damping={0: 1.0}).solve(h, aims={0: aim})
    aim[:] = 0.0
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(solution)).aims[0], [3.0, -1.0])
    np.testing.assert_array_equal(solution.relaxed[0].aim, [3.0, -1.0])
    np.testing.assert_allclose(solution.x, np.array([3.0, -1.0]) - 1.0 / 3.0, atol=1e-12)
    assert solution.explain().levels[0].name == "sum"


@pytest.mark.parametrize("rule", [FixedDamping(0.1), Fixed(0.1)], ids=["at once", "in stages"])
def test_what_is_no_aim_is_refused(rule):
    h = Hierarchy([Level.equality(np.eye(2), [1.0, 2.0], name="a"), Level.equality([[1.0, 1.0]], [0.0], name="b")])
    solver = Solver(damping={"a": rule})
    good = solver.solve(h, aims={"a": [1, 0]}).x
    for aims, message in (
        ({1: [0.0, 0.0]}, r"aims: level 1 \('b'\) is not damped, and takes no aim"),
        ({"c": [0.0, 0.0]}, "aims: 'c' is no level of the hierarchy"),
        ({"a": [0.0]}, r"aim of 'a' has shape \(1,\); it must be \(2,\)"),
        ({"a": "here"}, "aim of 'a' is not an array of real numbers"),
        ([0.0, 0.0], "must map damped levels to arrays"),
    ):
        with pytest.raises(InvalidInput, match=message):
            solver.solve(h, aims=aims)
    with pytest.raises(InvalidInput, match="is not damped"):
        Solver().solve(h, aims={0: [0.0, 0.0]})
    assert Solver().solve(h, aims={}).ok
    for wrong in np.nan, np.inf, 1e31:
        told = solver.solve(h, aims={"a": [0.0, wrong]})
        assert told.status is Status.INVALID
        assert "aim of level 0 ('a')" in told.message
        assert told.relaxed == ()
        with pytest.raises(InvalidInput, match="must be finite"):
            hqp.solve(h, damping={0: rule}, aims={0: [0.0, wrong]})
    np.testing.assert_array_equal(solver.solve(h, aims={0: [1.0, 0.0]}).x, good)
