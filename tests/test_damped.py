"""Damping where it is asked for: the closed forms, and what no damping may change."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.linalg import pinv, solve

import hqp
from hqp import (
    DampingRule,
    ErrorDamping,
    FixedDamping,
    Hierarchy,
    InvalidInput,
    Level,
    ManipulabilityDamping,
    NumericalFiltering,
    Settings,
    SingularValueDamping,
    Solver,
    Status,
    Unsupported,
)
from hqp.backends.base import Answer
from hqp.problems import hierarchies, random_hierarchy

seeds = st.integers(0, 2**32 - 1)
factors = st.sampled_from([0.01, 0.1, 1.0, 10.0])
backends = pytest.mark.parametrize("backend", ["native", "cascade:proxsuite", "pseudoinverse"])
RULES = [
    FixedDamping(0.3),
    ManipulabilityDamping(0.5, 2.0),
    SingularValueDamping(0.5, 1.0),
    NumericalFiltering(0.2, 0.7),
    NumericalFiltering(0.2, 0.7, 1.0),
    ErrorDamping(2.0),
    ErrorDamping(2.0, 0.3),
]


class Tasks:
    """Three equality levels on eight unknowns, J1 > J2 > J3, and a reference."""

    def __init__(self, seed: int, weighted: bool = False) -> None:
        rng = np.random.default_rng(seed)
        self.J = [rng.standard_normal((m, 8)) for m in (2, 3, 2)]
        self.r = [rng.standard_normal(m) for m in (2, 3, 2)]
        self.x_ref = rng.standard_normal(8)
        weights = [10.0 ** rng.uniform(-1, 1, m) if weighted else None for m in (2, 3, 2)]
        names = "first", "second", "third"
        self.hierarchy = Hierarchy(
            [Level.equality(*level[:2], weights=level[2], name=level[3])
             for level in zip(self.J, self.r, weights, names, strict=True)]
        )  # fmt: skip
        if weighted:
            self.J = [w[:, None] * J for w, J in zip(weights, self.J, strict=True)]
            self.r = [w * r for w, r in zip(weights, self.r, strict=True)]

    def second_damped(self, metric) -> np.ndarray:
        """The closed form, with `metric(J2_hat)` for what is added to ``J2_hat J2_hat^T``."""
        (J1, J2, J3), (r1, r2, r3) = self.J, self.r
        N1 = np.eye(8) - pinv(J1) @ J1
        J2_hat = J2 @ N1
        x = pinv(J1) @ r1 + N1 @ self.x_ref
        x += J2_hat.T @ solve(J2_hat @ J2_hat.T + metric(J2_hat), r2 - J2 @ x)
        both = np.vstack([J1, J2])
        N = np.eye(8) - pinv(both) @ both
        x = pinv(both) @ both @ x + N @ self.x_ref  # what is frozen, and what is left
        return x + pinv(J3 @ N) @ (r3 - J3 @ x)


def weakest(J: np.ndarray) -> tuple[np.ndarray, float]:
    left, singular, _ = np.linalg.svd(J)
    return left[:, -1], singular[-1]


def close(a: np.ndarray, b: np.ndarray, tolerance: float = 1e-8) -> None:
    np.testing.assert_allclose(a, b, rtol=tolerance, atol=tolerance * (1 + np.abs(b).max(initial=0.0)))


@backends
@given(seed=seeds, factor=factors, weighted=st.booleans())
@settings(max_examples=20)
def test_a_damped_second_level_is_the_closed_form_and_the_third_is_still_met(backend, seed, factor, weighted):
    tasks = Tasks(seed, weighted)
    solution = hqp.solve(tasks.hierarchy, damping={"second": factor}, backend=backend, x_ref=tasks.x_ref)
    close(solution.x, tasks.second_damped(lambda J: factor**2 * np.eye(3)))
    assert [level.rank for level in solution.levels] == [2, 3, 2]
    assert solution.levels[0].residual_norm < 1e-9
    assert solution.levels[2].residual_norm < 1e-9
    assert solution.certify().ok
    assert not hqp.certify(
        solution.hierarchy, solution.x, solution.x_ref
    ).ok  # the strict hierarchy is another question


@backends
@given(seed=seeds)
@settings(max_examples=20)
def test_damping_by_rule_is_the_closed_form(backend, seed):
    tasks = Tasks(seed)

    def by_manipulability(J):
        w = np.sqrt(np.linalg.det(J @ J.T))
        return (5.0 * max(1 - w / 8.0, 0.0)) ** 2 * np.eye(3)

    def by_singular_value(J):
        return 0.5**2 * max(1 - (weakest(J)[1] / 2.0) ** 2, 0.0) * np.eye(3)

    for rule, metric in (
        (ManipulabilityDamping(5.0, 8.0), by_manipulability),
        (SingularValueDamping(0.5, 2.0), by_singular_value),
    ):
        solution = hqp.solve(tasks.hierarchy, damping={1: rule}, backend=backend, x_ref=tasks.x_ref)
        close(solution.x, tasks.second_damped(metric))
        assert solution.certify().ok


@backends
@given(seed=seeds, factor=factors, extra=factors, weighted=st.booleans())
@settings(max_examples=20)
def test_numerical_filtering_is_the_closed_form(backend, seed, factor, extra, weighted):
    tasks = Tasks(seed, weighted)
    rule = NumericalFiltering(factor, extra)
    solution = hqp.solve(tasks.hierarchy, damping={1: rule}, backend=backend, x_ref=tasks.x_ref)

    def metric(J):
        u = weakest(J)[0]
        return factor**2 * np.eye(3) + extra**2 * np.outer(u, u)

    close(solution.x, tasks.second_damped(metric))
    assert solution.certify().ok


@backends
@given(seed=seeds, bound=factors, least=st.sampled_from([0.0, 0.2]), weighted=st.booleans())
@settings(max_examples=20)
def test_damping_by_the_error_is_the_closed_form_of_levenberg_and_marquardt(backend, seed, bound, least, weighted):
    tasks = Tasks(seed, weighted)
    (J1, J2, _), (r1, r2, _) = tasks.J, tasks.r
    above = tasks.x_ref + pinv(J1) @ (r1 - J1 @ tasks.x_ref)
    damping = np.hypot(least, np.linalg.norm(r2 - J2 @ above) / (2 * bound))
    rule = ErrorDamping(bound, least)
    solution = hqp.solve(tasks.hierarchy, damping={1: rule}, backend=backend, x_ref=tasks.x_ref)
    assert solution.relaxed[0].damping == pytest.approx(damping)
    close(solution.x, tasks.second_damped(lambda J: damping**2 * np.eye(3)))
    assert solution.certify().ok
    (r,) = tasks.r[:1]
    alone = hqp.solve(Hierarchy(tasks.hierarchy.levels[:1]), damping={0: rule}, backend=backend)
    damping = np.hypot(least, np.linalg.norm(r) / (2 * bound))
    close(alone.x, J1.T @ solve(J1 @ J1.T + damping**2 * np.eye(2), r))


@given(seed=seeds)
def test_damping_by_the_error_counts_from_where_damped_and_limited_levels_leave_off(seed):
    tasks = Tasks(seed)
    limits = Level.bounds(np.full(8, -0.3), np.full(8, 0.3))
    levels = [limits, *tasks.hierarchy.levels]
    solution = hqp.solve(Hierarchy(levels), damping={1: 0.5, 2: ErrorDamping(2.0), 3: ErrorDamping(3.0)})
    for k, bound in (2, 2.0), (3, 3.0):
        above = hqp.solve(Hierarchy(levels[:k]), damping={1: 0.5, 2: ErrorDamping(2.0)} if k > 2 else {1: 0.5}).x
        lacking = np.linalg.norm(levels[k].A @ above - levels[k].lower)
        assert solution.dampings[k] == pytest.approx(lacking / (2 * bound), rel=1e-6)
    assert solution.certify().ok


@given(seed=seeds, size=st.floats(-16, 1), spread=st.floats(-16, 0), bound=factors)
def test_as_error_and_singular_value_go_to_zero_together_x_does_not_blow_up(seed, size, spread, bound):
    rng = np.random.default_rng(seed)
    left, right = (np.linalg.qr(rng.standard_normal((n, 2)))[0] for n in (2, 5))
    r = 10.0**size * rng.standard_normal(2)
    level = Level.equality(left * [1.0, 10.0**spread] @ right.T, r)
    solution = hqp.solve(Hierarchy([level]), damping={0: ErrorDamping(bound)})
    assert solution.ok
    assert np.linalg.norm(solution.x) <= bound * (1 + 1e-6)


@given(seed=seeds)
def test_where_next_to_nothing_is_lacking_damping_by_the_error_costs_next_to_nothing(seed):
    """The damping falls with the error, and what it costs with the cube."""
    tasks = Tasks(seed)
    (J, _, _), (r, _, _) = tasks.J, tasks.r
    for size in 1.0, 1e-2, 1e-4, 0.0:
        relaxed = hqp.solve(Hierarchy([Level.equality(J, size * r)]), damping={0: ErrorDamping(1.0)}).relaxed[0]
        strongest = 1.0 / np.linalg.svd(J)[1][-1]
        assert relaxed.damping == pytest.approx(0.5 * size * np.linalg.norm(r))
        assert relaxed.excess <= relaxed.damping**2 * strongest**2 * size * np.linalg.norm(r) + 1e-12


def test_a_rule_may_look_and_grow():
    class Weak(SingularValueDamping):
        grows = True

        def growth(self, singular):
            return 1.0 if singular[-1] < self.threshold else 0.0

    h = Hierarchy([Level.equality([[1.0, 0.0], [0.0, 0.1]], [3.0, 4.0])])
    for threshold, damping in (0.2, np.sqrt(0.03 * 0.75 + 25.0)), (0.05, 0.0):
        rule = Weak(np.sqrt(0.03), threshold)
        assert hqp.solve(h, damping={0: rule}).dampings[0] == pytest.approx(damping)


@given(seed=seeds)
@settings(max_examples=20)
def test_two_damped_levels_are_damped_one_after_the_other(seed):
    tasks = Tasks(seed)
    J1, J2 = tasks.J[:2]
    x = J1.T @ solve(J1 @ J1.T + 0.04 * np.eye(2), tasks.r[0])
    N1 = np.eye(8) - pinv(J1) @ J1
    J2_hat = J2 @ N1
    x = x + J2_hat.T @ solve(J2_hat @ J2_hat.T + 0.09 * np.eye(3), tasks.r[1] - J2 @ x)
    two = Hierarchy(tasks.hierarchy.levels[:2])
    solution = hqp.solve(two, damping={"second": 0.3, 0: FixedDamping(0.2)})
    close(solution.x, x)
    assert [relaxation.name for relaxation in solution.relaxed] == ["first", "second"]


@given(seed=seeds, rule=st.sampled_from(RULES), rows=st.sampled_from([1, 2, 3]), noise=st.sampled_from([0.0, 1e-7]))
def test_below_a_damped_singular_level_x_stays_bounded(seed, rule, rows, noise):
    rng = np.random.default_rng(seed)
    J = rng.standard_normal((rows, 1)) @ rng.standard_normal((1, 6)) + noise * rng.standard_normal((rows, 6))
    below = Level.equality(rng.standard_normal((1, 6)), [1.0])
    task = Level.equality(J, rng.standard_normal(rows))
    solution = hqp.solve(Hierarchy([task]), damping={0: rule})
    assert solution.ok
    if rows > 1:
        assert np.linalg.norm(solution.x) <= 0.5 / 0.2 * np.linalg.norm(task.lower)  # s / (s^2 + l^2) <= 1 / 2l
    assert hqp.solve(Hierarchy([task, below]), damping={0: rule}).levels[1].residual_norm < 1e-6


@given(seed=seeds)
def test_without_damping_the_answer_is_the_strict_one(seed):
    h = random_hierarchy(np.random.default_rng(seed))
    k = seed % len(h.levels)
    strict = hqp.solve(h)
    close(hqp.solve(h, damping={}).x, strict.x)
    nowhere = hqp.solve(h, damping={k: SingularValueDamping(1.0, 1e-14)})
    if nowhere.dampings[k] == 0.0:
        close(nowhere.x, strict.x)


@backends
@given(seed=seeds)
@settings(max_examples=10)
def test_as_damping_goes_to_zero_the_answer_goes_to_the_strict_one(backend, seed):
    tasks = Tasks(seed)
    strict = hqp.solve(tasks.hierarchy, x_ref=tasks.x_ref).x
    xs = [
        hqp.solve(tasks.hierarchy, damping={0: factor, 1: factor}, backend=backend, x_ref=tasks.x_ref).x
        for factor in (1e-2, 1e-3, 1e-5)
    ]
    far, near, there = (np.linalg.norm(x - strict) for x in xs)
    assert near <= 0.02 * far + 1e-9  # it falls with the square of the damping
    assert there <= 1e-4 * far + 1e-7


@pytest.mark.parametrize("backend", ["native", "cascade:proxsuite"])
@given(seed=seeds, factor=factors)
@settings(max_examples=40)
def test_whatever_is_above_a_damped_level_stays_as_it_is(backend, seed, factor):
    h = random_hierarchy(np.random.default_rng(seed))
    k = seed % len(h.levels)
    strict, solution = hqp.solve(h), hqp.solve(h, damping={k: factor}, backend=backend)
    assert solution.ok
    for wanted, got in zip(strict.levels[:k], solution.levels[:k], strict=True):
        assert got.residual_norm == pytest.approx(wanted.residual_norm, rel=1e-7, abs=1e-7)
    assert solution.certify().ok
    relaxation = solution.relaxed[0]
    assert relaxation.damping == factor
    assert relaxation.strict_norm == pytest.approx(strict.levels[k].residual_norm, rel=1e-7, abs=1e-7)
    assert relaxation.excess >= -1e-7


@given(seed=seeds, factor=factors)
def test_a_lower_level_does_not_change_what_a_damped_level_reached(seed, factor):
    h = random_hierarchy(np.random.default_rng(seed))
    k = seed % len(h.levels)
    alone = hqp.solve(Hierarchy(h.levels[: k + 1], n=h.n), damping={k: factor})
    whole = hqp.solve(h, damping={k: factor})
    assert whole.relaxed[0].residual_norm == pytest.approx(alone.relaxed[0].residual_norm, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("rule", RULES)
@given(seed=seeds)
@settings(max_examples=20)
def test_bounds_above_are_respected_and_what_they_take_counts_as_lost(rule, seed):
    tasks = Tasks(seed)
    limits = Level.bounds(np.full(8, -0.3), np.full(8, 0.3), name="limits")
    h = Hierarchy([limits, *tasks.hierarchy.levels])
    solution = hqp.solve(h, damping={"second": rule})
    assert solution.ok
    assert solution.certify().ok
    assert np.abs(solution.x).max() <= 0.3 + 1e-9
    if rule.looks:  # the limits that are active where the first level leaves off
        x = hqp.solve(Hierarchy(h.levels[:2])).x
        held = np.vstack([np.eye(8)[np.abs(x) >= 0.3 - 1e-8], tasks.J[0]])
        J = tasks.J[1] @ (np.eye(8) - pinv(held) @ held)
        assert solution.dampings[2] == pytest.approx(rule.damping(np.linalg.svd(J)[1]), abs=1e-6)


@given(seed=seeds)
@settings(max_examples=20)
def test_a_warm_solver_gives_the_same_answers(seed):
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)
    damping = {k: SingularValueDamping(0.5, 1.0) for k in range(0, len(h.levels), 2)}
    solver = Solver(damping=damping)
    for _ in range(3):
        close(solver.solve(h).x, hqp.solve(h, damping=damping).x, 1e-6)
        shift = 0.05 * rng.standard_normal(h.m)
        h.lower += shift
        h.upper += shift


def test_the_hierarchy_itself_is_not_touched():
    h = Tasks(0).hierarchy
    before = h.numbers.copy()
    solution = hqp.solve(h, damping={0: 1.0, 1: 1.0})
    np.testing.assert_array_equal(h.numbers, before)
    np.testing.assert_array_equal(solution.hierarchy.numbers, before)
    assert [len(stage.hierarchy.levels) for stage in solution.stages] == [1, 2, 3]


def test_satisfied_inequalities_of_a_damped_level_stay_inequalities():
    task = Level([[1.0, 0.0], [0.0, 1.0]], [1.0, -1.0], [np.inf, 1.0], name="task")  # x0 >= 1, |x1| <= 1
    below = Level.equality(np.eye(2), [5.0, 0.5])
    solution = hqp.solve(Hierarchy([task, below]), damping={"task": 1.0})
    np.testing.assert_allclose(solution.x, [0.5, 0.5], atol=1e-9)  # x0 is halfway, and stays there; x1 is free to go


def test_where_strictness_was_relaxed_and_by_how_much():
    h = Hierarchy([Level.equality([[2.0, 0.0]], [4.0], name="reach"), Level.equality([[0.0, 1.0]], [1.0])])
    solution = hqp.solve(h, damping={"reach": 1.0, 1: SingularValueDamping(1.0, 0.5)})
    reach, rest = solution.relaxed
    np.testing.assert_allclose(solution.x, [1.6, 1.0], atol=1e-12)  # 2 * 4 / (4 + 1)
    assert (reach.level, reach.name, reach.damping) == (0, "reach", 1.0)
    assert reach.residual_norm == pytest.approx(0.8)
    assert reach.excess == pytest.approx(0.8)
    assert reach.strict_norm == pytest.approx(0.0, abs=1e-12)
    assert (rest.damping, rest.excess) == (0.0, 0.0)
    assert "2 stages, x = [1.6 1. ]" in repr(solution)
    assert f"Relaxation(level=0, name='reach', damping=1.0, residual_norm={reach.residual_norm!r}" in repr(solution)
    told = str(solution.certify()).splitlines()
    assert told[0] == "certified, on the rows that were given: strict: level 1; softened as declared: level 0 (reach)"
    assert told[1].startswith("stage 0: certified")
    assert solution.certify().failed is None


def test_a_rule_of_your_own():
    class Half(DampingRule):
        def damping(self, singular):
            return singular[0] / 2

    assert hqp.solve(Tasks(1).hierarchy, damping={0: Half()}).dampings[0] > 0


@pytest.mark.parametrize("rule", [ManipulabilityDamping(1.0, 2.0), SingularValueDamping(1.0, 2.0)])
def test_rules_fade_from_the_singular_posture_to_the_threshold(rule):
    assert rule.damping(np.array([3.0, 0.0])) == 1.0
    assert 0.0 < rule.damping(np.array([1.0, 1.0])) < 1.0
    assert rule.damping(np.array([2.0, 2.0])) == 0.0
    assert rule.damping(np.zeros(0)) == 0.0  # no row, no singularity


@pytest.mark.parametrize(("failing", "stages", "where"), [(0, 1, "0 to 1"), (1, 2, "0 to 2"), (2, 3, None)])
def test_the_status_of_a_stage_that_fails_is_that_of_the_whole(monkeypatch, failing, stages, where):
    """And nothing is solved after it."""
    h, calls = Hierarchy([*Tasks(0).hierarchy.levels, Level.equality(np.eye(8), np.zeros(8))]), []

    def backend(given, x_ref):
        calls.append(given)
        if len(calls) == failing + 1:
            return Answer(np.ones(8), Status.STALLED, "round-off", level=1)
        return Answer(np.zeros(8))

    monkeypatch.setattr("hqp.backends.cascade.Cascade.solve", lambda self, given, x_ref: backend(given, x_ref))
    solution = hqp.solve(h, damping={1: 0.1, "third": 0.1}, backend="cascade:proxsuite")
    assert (solution.status, solution.level, solution.ok) == (Status.STALLED, 1, False)
    assert solution.message == (f"in the stage of levels {where}: round-off" if where else "round-off")
    assert len(solution.stages) == len(calls) == stages
    assert [relaxation.level for relaxation in solution.relaxed] == [1, 2][:stages]
    np.testing.assert_array_equal(solution.x, np.ones(8))


def test_a_spent_budget_is_told():
    for h in hierarchies("vertex", 25):
        solution = hqp.solve(h, damping={0: 1e-3}, settings=Settings(iterations=1))
        if not solution.ok:
            break
    assert solution.status is Status.SUBOPTIMAL
    assert "after 1 iterations" in solution.message


def test_numbers_that_mean_nothing_are_a_status_in_a_loop_and_refused_in_one_shot():
    h = Tasks(0).hierarchy
    solver = Solver(damping={1: SingularValueDamping(1.0, 1.0)})
    assert solver.solve(h, np.full(8, np.nan)).status is Status.INVALID
    h.levels[1].lower[2] = np.nan
    solution = solver.solve(h)
    assert (solution.status, solution.relaxed, solution.levels) == (Status.INVALID, (), ())
    with pytest.raises(InvalidInput, match=r"level 1 \('second'\), row 2: lower = nan"):
        hqp.solve(h, damping={1: 1.0})


def test_a_backend_that_takes_no_inequalities_says_so():
    limits = Level.bounds([-1.0, -1.0], [1.0, 1.0])
    with pytest.raises(Unsupported, match="level 0, row 0 is an inequality"):
        hqp.solve(Hierarchy([limits]), damping={0: 1.0}, backend="pseudoinverse")


@pytest.mark.parametrize(
    ("damping", "message"),
    [
        ({3: 1.0}, r"3 is no level of the hierarchy, which has level 0 \('hand'\), level 1, level 2 \('twin'\)"),
        ({-1: 1.0}, "-1 is no level"),
        ({"foot": 1.0}, "'foot' is no level"),
        ({"": 1.0}, "'' is no level"),
        ({"twin": 1.0}, "'twin' names 2 of its levels"),
        ({"hand": 1.0, 0: 1.0}, r"level 0 \('hand'\) is given twice"),
        ({True: 1.0}, "True must be the index or the name of a level"),
        ({0: "much"}, "damping of 0: neither a rule nor a number for one"),
        ({0: -1.0}, "damping of 0: .*must be positive"),
        ([0.1], "must map levels to rules"),
        ({1: NumericalFiltering(0.1, 0.1)}, "level 1, row 1 is an inequality .*equality rows only"),
    ],
)
def test_refusals(damping, message):
    rows = np.eye(2)
    h = Hierarchy([
        Level.equality(rows, [1.0, 2.0], name="hand"),
        Level(rows, [0.0, 1.0], [0.0, 2.0]),
        Level.equality(rows, [1.0, 2.0], name="twin"),
        Level.equality(rows, [1.0, 2.0], name="twin"),
    ][: 4 if "twin" in damping else 3])  # fmt: skip
    with pytest.raises(InvalidInput, match=message):
        hqp.solve(h, damping=damping)


@pytest.mark.parametrize("wrong", [0.0, -1.0, np.nan, np.inf, 1e31, "1", True])
def test_rules_refuse_what_is_no_positive_number(wrong):
    for make in (
        lambda: FixedDamping(wrong),
        lambda: ManipulabilityDamping(wrong, 1.0),
        lambda: SingularValueDamping(wrong, 1.0),
        lambda: NumericalFiltering(1.0, wrong),
        lambda: ErrorDamping(wrong),
    ):
        with pytest.raises(InvalidInput, match=r"(Damping|Filtering): (factor|largest|extra|bound)"):
            make()


@pytest.mark.parametrize("wrong", [-1.0, np.nan, np.inf, "1", False, [0.0]])
def test_a_least_damping_may_be_zero_and_nothing_else_that_is_not_positive(wrong):
    assert ErrorDamping(1.0) == ErrorDamping(1.0, 0) == ErrorDamping(bound=1.0, least=0.0)
    with pytest.raises(InvalidInput, match="ErrorDamping: least"):
        ErrorDamping(1.0, wrong)
