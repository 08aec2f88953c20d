"""Damped levels of a stack: what they are, that they leave the levels below their freedom, and what bounds them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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
    SingularValueDamping,
    Status,
    solve,
)
from tasks import (
    Controller,
    Damped,
    Damping,
    JointLimits,
    JointVelocityLimit,
    Line,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
    Stack,
    load_robot,
    quintic,
    simulate,
)

ARM = PlanarArm([0.5, 0.5, 0.5])
STRETCHED, STILL = np.array([0.3, 0.02, 0.01]), np.zeros(3)
RULES = [
    FixedDamping(0.1),
    ManipulabilityDamping(0.1, 0.2),
    SingularValueDamping(0.1, 0.3),
    NumericalFiltering(0.05, 0.2),
    ErrorDamping(2.0),
    ErrorDamping(2.0, 0.05),
]
seeds = st.integers(0, 2**32 - 1)
rules = st.sampled_from(RULES)


def tip(goal: object = (1.8, 0.3)) -> PositionTask:
    """By default out of reach."""
    return PositionTask(goal, gain=5.0, name="tip")


def posture() -> PostureTask:
    return PostureTask([0.5, 0.5, 0.5], gain=1.0)


def limits() -> JointLimits:
    return JointLimits(JointVelocityLimit(2.0))


def test_a_damped_level_is_one_level_of_a_stack():
    above, below = tip(), posture()
    stack = limits() >> Damped(above, 0.1) >> below
    assert isinstance(stack, Stack)
    assert [len(level) for level in stack.levels] == [1, 1, 1]
    assert stack.damping == (None, FixedDamping(0.1), None)
    assert stack.levels[1] == (above,)
    assert repr(Damped(above, 0.1) >> below) == (
        "Damped(PositionTask([1.8, 0.3], gain=5, name='tip'), FixedDamping(factor=0.1))"
        " >> PostureTask([0.5, 0.5, 0.5], gain=1)"
    )
    assert Damped(above, 0.1) == Damped(above, 0.1) != Damped(above, 0.2)
    assert Damped(above, 0.1) != Stack(above)
    assert Damped(above + below, RULES[2]).levels == ((above, below),)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Damped(tip() >> posture(), 0.1), "takes one level, but .* has 2"),
        (lambda: Damped(Damped(tip(), 0.1), 0.1), "is damped already"),
        (lambda: Damped(tip(), "much"), "rule: neither a rule nor a number"),
        (lambda: Damped(tip(), 0.0), "must be positive"),
        (lambda: Damped("tip", 0.1), "is a str"),
        (lambda: Damped(tip(), 0.1) + posture(), r"damped as a whole.*Damped\(a \+ b, rule\)"),
        (lambda: posture() + Damped(tip(), 0.1), "damped as a whole"),
    ],
)
def test_refusals(make, message):
    with pytest.raises(InvalidInput, match=message):
        make()


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: type(rule).__name__)
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("top", [False, True], ids=["free", "limits"])
def test_the_controller_solves_what_is_declared(rule, order, top):
    stack = Damped(tip(), rule) >> posture()
    stack = limits() >> stack if top else stack
    controller = Controller(ARM, stack, order=order, dt=5e-3)
    for q in STRETCHED, STRETCHED + 0.4, STRETCHED:
        step = controller(q, STILL)
        expected = hqp.solve(controller.hierarchy, damping={int(top): rule})
        np.testing.assert_allclose(step.solution.x, expected.x, atol=1e-8)
        assert step.ok
        assert step.solution.certify().ok
        (told,) = step.relaxed
        level = controller.hierarchy.levels[int(top)]
        assert (told.name, told.damping) == ("tip", expected.dampings[int(top)])
        assert told.residual_norm == pytest.approx(np.linalg.norm(level.A @ step.solution.x - level.lower))
        assert told.excess >= -1e-9


@pytest.mark.parametrize("name", ["ur5", "panda"])
def test_spatial_robots_have_their_rows_written_as_always(name):
    robot = load_robot(name)
    frame = robot.at(robot.home, np.zeros(robot.nv)).frame()
    position = PositionTask(np.add(frame.position, 0.05), gain=5.0)
    orientation = OrientationTask(frame.rotation, gain=5.0)
    stack = JointLimits() >> position >> Damped(orientation, 0.1) >> PostureTask(robot.home, gain=1.0)
    controller = Controller(robot, stack, dt=5e-3)
    assert controller._rows.compiled
    step = controller(robot.home, np.zeros(robot.nv))
    np.testing.assert_allclose(step.v, hqp.solve(controller.hierarchy, damping={2: 0.1}).x, atol=1e-9)
    record = simulate(controller, robot.home, duration=0.5, certify=25)
    assert record.certified == record.checked == 4
    assert record.ranks[0].tolist() == [0, 3, 3, robot.nv - 6]  # the posture has what is left


def test_without_a_damped_level_nothing_changes():
    controller = Controller(ARM, tip() >> posture(), damping=None)
    assert type(controller._now.solver) is hqp.Solver
    step = controller(STRETCHED, STILL)
    assert type(step.solution) is hqp.Solution
    assert step.relaxed == ()


def test_a_damped_lowest_level_is_the_part_beside_it_in_one_solve():
    for order in "velocity", "acceleration":
        one = Controller(ARM, limits() >> Damped(tip(), 0.1), order=order, dt=5e-3)(STRETCHED, STILL).solution
        other = Controller(ARM, limits() >> tip() + Damping(0.1), order=order, dt=5e-3)(STRETCHED, STILL).solution
        np.testing.assert_allclose(one.x, other.x, atol=1e-9)
        assert (len(one.stages), one.ok, one.certify().ok) == (1, True, True)
        assert one.counts == one.stages[0].counts
        assert (one.backend, one.gap) == ("native", 0.0)


def test_levels_below_keep_their_freedom():
    """Beside the damped level, rows of damping would take it."""
    turn = OrientationTask(0.9, gain=1.0)
    q = np.array([0.4, 0.5, 0.6])
    step = Controller(ARM, Damped(tip((1.0, 1.0)), 0.1) >> turn)(q, STILL)
    assert step.solution.levels[1].residual_norm < 1e-9
    assert [level.rank for level in step.solution.levels] == [2, 1]


def test_the_damping_is_among_what_holds_the_level_back():
    step = Controller(ARM, limits() >> Damped(tip(), 0.1) >> posture(), dt=5e-3)(STRETCHED, STILL)
    held, short, below = map(str, step.solution.explain().levels)
    assert held.startswith("joint limits met")
    assert short.startswith("tip short by 1.5 m/s: damped, lambda = 0.1")
    assert below.endswith(": tip")


def test_numbers_that_mean_nothing_are_a_status():
    controller = Controller(ARM, Damped(tip(), 0.1) >> posture())
    solution = controller(STRETCHED, STILL, np.nan).solution
    assert (solution.status, solution.message) == (Status.INVALID, "t = nan s must be finite")
    assert controller([np.nan, 0.0, 0.0], STILL).solution.status is Status.INVALID
    assert str(solution.explain()) == "t = nan s must be finite"
    assert controller(STRETCHED, STILL).ok


@given(rule=rules, seed=seeds)
def test_no_singular_values_give_more_than_the_largest_gain(rule: DampingRule, seed):
    rng = np.random.default_rng(seed)
    values = np.sort(10.0 ** rng.uniform(-6, 0.5, rng.integers(1, 5)))[::-1]
    lacking = 10.0 ** rng.uniform(-6, 2)
    factor = np.hypot(rule.damping(values), rule.growth(values) * lacking)
    gain = (values / (values**2 + factor**2)).max()
    assert gain <= rule.largest_gain(len(values), values[0]) * (1 + 1e-12)
    assert gain * lacking <= rule.largest_change(len(values), values[0], lacking) * (1 + 1e-12)
    assert rule.largest_change(len(values), values[0], 0.0) == 0.0


def test_the_largest_gain_of_a_fixed_damping_is_reached():
    assert FixedDamping(0.1).largest_gain(1, 1.0) == pytest.approx(0.1 / (0.1**2 + 0.1**2))


def test_the_bound_of_damping_by_the_error_is_reached_and_never_passed():
    for lacking in 1e-3, 1.0, 1e3:
        weakest = Hierarchy([Level.equality([[lacking / 4.0, 0.0]], [lacking])])  # sigma = lambda
        assert hqp.solve(weakest, damping={0: ErrorDamping(2.0)}).x == pytest.approx([2.0, 0.0])
        assert ErrorDamping(2.0).largest_change(1, 1.0, lacking) == pytest.approx(2.0)
        assert ErrorDamping(2.0, 0.1).largest_change(1, 1.0, lacking) < min(2.0, lacking / 0.2)


@given(rule=rules, seed=seeds, spread=st.floats(-8, 0))
@settings(max_examples=40)
def test_what_a_damped_level_adds_is_bounded(rule, seed, spread):
    """||x - x_a|| <= g ||r_a||, or b, however close to singular the level is."""
    rng = np.random.default_rng(seed)
    above = Level.equality(rng.standard_normal((2, 6)), rng.standard_normal(2))
    weak = np.linalg.qr(rng.standard_normal((2, 2)))[0] * [1.0, 10.0**spread] @ rng.standard_normal((2, 6))
    level = Level.equality(weak, rng.standard_normal(2))
    x_above = solve(Hierarchy([above])).x
    x = hqp.solve(Hierarchy([above, level]), damping={1: rule}).x
    most = rule.largest_change(2, np.linalg.norm(weak, 2), np.linalg.norm(weak @ x_above - level.lower))
    assert np.linalg.norm(x - x_above) <= most * (1 + 1e-9) + 1e-12


@given(
    seed=seeds,
    spread=st.floats(-8, 0),
    rule=st.builds(FixedDamping, st.floats(0.01, 1.0)) | st.builds(ErrorDamping, st.floats(0.01, 10.0)),
)
@settings(max_examples=60)
def test_a_damping_that_does_not_look_bounds_among_inequalities_too(seed, spread, rule):
    rng = np.random.default_rng(seed)
    bounds = Level.bounds(*np.sort(rng.standard_normal((2, 5)), axis=0))
    above = Level(rng.standard_normal((2, 5)), *np.sort(rng.standard_normal((2, 2)), axis=0))
    weak = np.linalg.qr(rng.standard_normal((3, 3)))[0] * [1.0, 1.0, 10.0**spread] @ rng.standard_normal((3, 5))
    level = Level(weak, *np.sort(rng.standard_normal((2, 3)), axis=0))
    x_above = solve(Hierarchy([bounds, above])).x
    x = hqp.solve(Hierarchy([bounds, above, level]), damping={2: rule}).x
    lacking = np.linalg.norm(weak @ x_above - np.clip(weak @ x_above, level.lower, level.upper))
    assert np.linalg.norm(x - x_above) <= rule.largest_change(3, np.inf, lacking) * (1 + 1e-9) + 1e-9


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: type(rule).__name__)
def test_joint_speeds_through_a_singularity_keep_their_bound_and_the_error_is_told(rule):
    """The arm is stretched to where it cannot reach; what is told is what the tip lacks."""
    start = np.array([0.9, -1.2, -0.5])
    here = ARM.pose(start)[:2]
    task = tip(Line(here, np.add(here, [0.45, 0.15]), 1.0, timing=quintic))
    controller = Controller(ARM, Damped(task, rule), dt=5e-3)
    q = start
    for k in range(300):
        step = controller(q, STILL, 5e-3 * k)
        J, h = controller.hierarchy.levels[0].A.copy(), controller.hierarchy.levels[0].lower.copy()
        most = rule.largest_change(2, np.linalg.norm(J, 2), np.linalg.norm(h))
        assert np.linalg.norm(step.v) <= most * (1 + 1e-9)
        told = step.relaxed[0].residual_norm
        moved = (ARM.pose(q + 1e-6 * step.v) - ARM.pose(q - 1e-6 * step.v))[:2] / 2e-6
        assert told == pytest.approx(np.linalg.norm(moved - h), abs=1e-6)
        q = q + 5e-3 * step.v
    assert np.linalg.svd(ARM.jacobian(q)[:2])[1][-1] < 0.05  # stretched indeed


def test_out_of_reach_joints_do_not_jump_between_their_limits():
    start = np.array([0.9, -1.2, -0.5])
    here = ARM.pose(start)[:2]

    def jump(damped: bool) -> float:
        task = tip(Line(here, np.add(here, [0.45, 0.15]), 1.0, timing=quintic))
        level = Damped(task, 0.2) if damped else task
        record = simulate(
            Controller(ARM, limits() >> level >> posture(), dt=5e-3, damping=None), start, duration=2.0, certify=0
        )
        assert np.abs(record.v).max() <= 2.0 + 1e-9
        return float(np.abs(np.diff(record.v[1:], axis=0)).max())

    assert jump(False) > 1.0
    assert jump(True) < 0.2
