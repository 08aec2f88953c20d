"""Damping by curvature in a controller: a function of its arguments, calm at the edge of reach, and within limits."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from functools import cache

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import (
    AtLeast,
    BoxLimit,
    Controller,
    Damped,
    JointLimits,
    JointPositionLimit,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
    Task,
    load_robot,
    simulate,
)
from tasks.control.calm import GENTLE

DT = 0.005


@cache
def panda():
    return load_robot("panda", lock=["panda_finger_joint1"])


def arm():
    return PlanarArm([0.5, 0.5, 0.5], position_limit=(-2.6, 2.6), velocity_limit=3.0)


def planar(target, gain=10.0, **options):
    robot = arm()
    if options.get("order") == "acceleration":
        robot.acceleration_limit = np.full(3, 30.0)
    tip, turn = PositionTask(target, gain=gain), OrientationTask(0.5, gain=gain)
    return Controller(robot, JointLimits() >> tip >> turn >> PostureTask([0.2] * 3, gain=1.0), dt=DT, **options)


def jerk(record):
    return float(np.sqrt(np.mean((np.diff(record.v, n=2, axis=0) / DT**2) ** 2)))


def out_and_back(t):
    """Beyond the reach of 1.5 m, with its velocity."""
    place, speed = 1.4 - 0.35 * np.cos(2.0 * t), 0.7 * np.sin(2.0 * t)
    return np.array([place, 0.3]), np.array([speed, 0.0]), np.array([1.4 * np.cos(2.0 * t), 0.0])


def states(count=12):
    rng = np.random.default_rng(3)
    return [(rng.uniform(-0.6, 0.6, 3), rng.uniform(-1.0, 1.0, 3)) for _ in range(count)]


def test_what_is_remembered_changes_no_answer() -> None:
    warm, cold = planar([1.45, 0.4]), [planar([1.45, 0.4])(q, v).v for q, v in states()]
    for _ in range(2):
        for (q, v), expected in zip(states(), cold, strict=True):
            np.testing.assert_allclose(warm(q, v).v, expected, atol=1e-9)
    for other in copy.deepcopy(warm), pickle.loads(pickle.dumps(warm)):
        assert repr(other) == repr(warm)
        for (q, v), expected in zip(states(), cold, strict=True):
            np.testing.assert_allclose(other(q, v).v, expected, atol=1e-9)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_copy_keeps_its_damping(order: str) -> None:
    for damping in "curvature", None:
        controller = planar([1.45, 0.4], order=order, damping=damping)
        twin = pickle.loads(pickle.dumps(controller))
        assert ("damping=None" in repr(controller)) == (damping is None)
        q, v = states()[0]
        mine, theirs = controller(q, v), twin(q, v)
        np.testing.assert_allclose(theirs.v if order == "velocity" else theirs.a, mine.v if mine.a is None else mine.a)


def test_live_changes_are_those_of_a_fresh_controller() -> None:
    live = planar([1.45, 0.4])
    live(*states()[0])
    tip = live.stack.levels[1][0]
    tip.gain = 25.0
    tip.weight = 2.0
    live.stack.levels[2][0].gain = 4.0
    for q, v in states():
        fresh = planar([1.45, 0.4])
        fresh.stack.levels[1][0].gain, fresh.stack.levels[1][0].weight = 25.0, 2.0
        fresh.stack.levels[2][0].gain = 4.0
        np.testing.assert_allclose(live(q, v).v, fresh(q, v).v, atol=1e-9)


def test_a_change_of_stacks_blends_what_both_ask_for() -> None:
    controller = planar([1.45, 0.4])
    old, new = controller.stack, JointLimits() >> PositionTask([1.6, -0.4], gain=5.0)
    (q, v), _ = states()[:2]
    before = controller(q, v, 0.0).v
    controller.change(new, duration=1.0)
    np.testing.assert_allclose(controller(q, v, 0.0).v, before, atol=1e-9)
    half = controller(q, v, 0.5)
    after = Controller(controller.robot, new, dt=DT)(q, v, 0.5).v
    np.testing.assert_allclose(half.v, half.share * after + (1.0 - half.share) * before, atol=1e-9)
    controller.change(old, duration=0.0)
    np.testing.assert_allclose(controller(q, v, 0.0).v, before, atol=1e-9)


def test_unknown_velocities() -> None:
    controller, (q, v) = planar([1.45, 0.4]), states()[4]
    unknown = controller(q)
    assert unknown.ok
    np.testing.assert_allclose(unknown.v, controller(q, None, 0.0).v, atol=1e-9)
    assert (unknown.state.v == 0.0).all()
    assert np.abs(unknown.v - controller(q, v).v).max() > 1e-3  # which leans
    for order in "acceleration", "torque":
        with pytest.raises(InvalidInput, match=f"v = None, but order = '{order}' needs the joint velocities"):
            Controller(panda(), PostureTask(panda().home, gain=1.0), order=order, dt=DT)(panda().home)


def test_a_planar_arm_at_its_edge_is_calm() -> None:
    default, strict = (
        simulate(planar(out_and_back, damping=damping), [0.3, 0.5, 0.4], duration=3.0)
        for damping in ("curvature", None)
    )
    assert default.certified_share == 1.0
    assert jerk(default) < 0.04 * jerk(strict)
    assert np.linalg.norm(default.errors["position"][-100:]) < 1.2 * np.linalg.norm(strict.errors["position"][-100:])


def test_a_panda_at_its_edge_is_calm() -> None:
    robot = panda()
    hand = robot.at(robot.home, np.zeros(7)).frame()

    def target(t):
        away = np.array([1.0, 0.0, 0.0])
        return hand.position + 0.25 * (1.0 - np.cos(3.0 * t)) * away, 0.75 * np.sin(3.0 * t) * away, np.zeros(3)

    jerks = {}
    for damping in "curvature", None:
        reach = PositionTask(target, gain=20.0) >> OrientationTask(hand.rotation, gain=20.0)
        stack = JointLimits() >> reach >> PostureTask(robot.home, gain=1.0)
        record = simulate(Controller(robot, stack, dt=DT, damping=damping), robot.home, duration=2.0)
        assert record.certified_share == 1.0
        jerks[damping] = jerk(record)
    assert jerks["curvature"] < 0.01 * jerks[None]


def test_in_reach_it_is_the_strict_one() -> None:
    def circle(t):
        way, speed = np.array([np.cos(t) - 1.0, np.sin(t)]), np.array([-np.sin(t), np.cos(t)])
        return place + 0.1 * way, 0.1 * speed, np.zeros(2)

    robot, runs, start = PlanarArm([0.5, 0.5, 0.5], velocity_limit=3.0), [], np.array([-0.7, 1.3, 0.9])
    place = robot.at(start, np.zeros(3)).pose[:2]
    for damping in "curvature", None:
        stack = JointLimits() >> PositionTask(circle, gain=10.0) >> PostureTask(start, gain=1.0)
        runs.append(simulate(Controller(robot, stack, dt=DT, damping=damping), start, duration=2.0))
    np.testing.assert_allclose(runs[0].q, runs[1].q, atol=1e-4)


@pytest.mark.parametrize("kind", ["four joints", "contradictory", "dependent", "wide"])
def test_a_level_with_fewer_directions_than_rows_keeps_what_it_reached(kind: str) -> None:
    """Rows that round-off makes independent: what a level hands over are its directions, and the posture has the rest.

    Three rows of orientation in the one direction that a position leaves to four joints; two positions of one frame;
    rows that are there twice; and six rows in four directions.
    """
    held = ["panda_joint3", "panda_joint5", "panda_joint7"] if kind == "four joints" else []
    robot, rng = load_robot("panda", lock=["panda_finger_joint1", *held]), np.random.default_rng(0)
    for _ in range(25):
        q, one, other = (rng.uniform(*robot.position_limit) for _ in range(3))
        here, there = robot.at(one).frame(), robot.at(other).frame()
        place, turn = PositionTask(here.position, gain=3.0), OrientationTask(here.rotation, gain=3.0)
        second = PositionTask(there.position, gain=3.0, name="second")
        if kind == "contradictory":
            place = place + second
        elif kind == "dependent":
            place = place + second + OrientationTask(there.rotation, gain=2.0, name="turned") + turn
            turn = OrientationTask(here.rotation, gain=3.0, name="below")
        elif kind == "wide":
            turn = turn + second
        stack = JointLimits() >> place >> turn >> PostureTask(robot.home, gain=1.0)
        step = Controller(robot, stack, dt=0.01)(q, rng.uniform(-0.5, 0.5, robot.nv))
        assert step.solution.certify().ok


def test_accelerations_brake_towards_the_rate_of_the_task() -> None:
    controller = planar([1.9, 0.2], order="acceleration")
    step = controller([0.01, 0.02, 0.01], [0.5, -0.2, 0.3])
    assert step.solution.certify().ok
    assert step.relaxed
    for level in step.relaxed[:1]:
        np.testing.assert_allclose(level.aim, -2.0 * 10.0 * np.array([0.5, -0.2, 0.3]))


def test_importing_the_packages_loads_none_of_it() -> None:
    code = "import sys, hqp, tasks; tasks.Controller; assert 'hqp.solver.curved' not in sys.modules"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True).returncode == 0


def test_rules_of_its_own_hold() -> None:
    robot = PlanarArm([0.5, 0.5, 0.5], velocity_limit=3.0)
    stack = JointLimits() >> Damped(PositionTask([1.7, 0.0], gain=5.0), 0.2) >> OrientationTask(0.4, gain=5.0)
    default, off = (Controller(robot, stack, dt=DT, damping=d)([0.1, 0.1, 0.1]) for d in ("curvature", None))
    assert (default.v == off.v).all()
    assert [level.level for level in default.relaxed] == [1]


def test_rows_above_plain_bounds_stay_what_they_are() -> None:
    robot = arm()
    guard = BoxLimit([-2.0, -2.0], [1.1, 0.5], gain=20.0)
    stack = guard >> JointLimits() >> PositionTask([1.7, 0.4], gain=10.0) >> PostureTask([0.2] * 3, gain=1.0)
    step = Controller(robot, stack, dt=DT)([0.1, 0.2, 0.1], [0.3, 0.2, 0.1])
    assert step.relaxed
    for stage in step.solution.stages:
        for own, given in zip(stage.hierarchy.levels[:1], step.solution.hierarchy.levels, strict=False):
            np.testing.assert_array_equal(own.A, given.A)
    assert step.solution.levels[0].residual_norm <= 1e-9


def led_to_its_end(damping: str | None, robot: PlanarArm | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of an arm whose first joint is led past the end of its range, fast."""
    robot = PlanarArm([0.5, 0.5, 0.5], position_limit=(-0.4, 0.4), velocity_limit=3.0) if robot is None else robot
    stack = JointLimits() >> PositionTask([0.8, 0.9], gain=10.0) >> PostureTask([0.0] * 3, gain=1.0)
    controller = Controller(robot, stack, dt=DT, damping=damping)
    q, v, places, speeds = np.array([-0.3, 0.2, 0.1]), np.zeros(3), [], []
    for _ in range(120):
        step = controller(q, v)
        q, v = q + DT * step.v, step.v
        places.append(q)
        speeds.append(v)
    return np.array(places), np.array(speeds)


def test_joints_come_to_rest_at_the_ends_of_their_ranges_not_within_a_tick() -> None:
    """By default; a strict stack does what it is told."""
    (strict, fast), (gentle, slow) = led_to_its_end(None), led_to_its_end("curvature")
    for places in strict, gentle:
        assert np.abs(places).max() <= 0.4 + 1e-9
        np.testing.assert_allclose(np.abs(places[-1]).max(), 0.4, atol=1e-9)
    hardest = [-np.diff(np.abs(speeds), axis=0).min() / DT for speeds in (fast, slow)]
    assert hardest[0] > 100.0
    assert hardest[1] <= GENTLE * (1.0 + 1e-6)


def test_a_limit_of_the_robot_counts_for_its_ends_and_goes_again() -> None:
    robot = PlanarArm([0.5, 0.5, 0.5], position_limit=(-2.0, 2.0), velocity_limit=3.0)
    near = np.array([1.9, 0.3, 0.1])
    ends = JointPositionLimit()
    controller = Controller(robot, ends >> PositionTask([-0.8, 0.9], gain=10.0), dt=DT)
    most = []
    for limit in None, 20.0, None:
        robot.acceleration_limit = None if limit is None else np.full(3, limit)
        controller(near)
        most.append(controller.bounds(ends)[1][0])
    assert most[0] == most[2] == pytest.approx(np.sqrt(2.0 * GENTLE * 0.1), rel=0.1)
    assert most[1] == pytest.approx(np.sqrt(2.0 * 20.0 * 0.1), rel=0.1)


def test_what_is_braked_without_a_limit_is_told() -> None:
    free, limited = PlanarArm([0.5, 0.5]), PlanarArm([0.5, 0.5], acceleration_limit=10.0)
    for robot in free, limited:
        robot.position_limit = [-2.0, 2.0]
    tip = PositionTask([0.5, 0.5], gain=2.0)
    braked = "at ends of ranges 30 rad/s^2"
    assert braked in repr(Controller(free, JointLimits() >> tip, dt=0.01))
    assert braked not in repr(Controller(free, JointLimits() >> tip, dt=0.01, damping=None))
    assert braked not in repr(Controller(free, tip, dt=0.01))
    assert braked not in repr(Controller(limited, JointLimits() >> tip, dt=0.01))


class Reach(Task):
    """How far the tip of a planar arm is from its base; how this bends is not told."""

    rows = 1

    def error(self, state, t):
        return np.array([2.0 - np.linalg.norm(state.pose[:2])])

    def jacobian(self, state):
        place = state.pose[:2]
        return (place / np.linalg.norm(place) @ state.jacobian[:2])[None]


def test_a_task_that_the_default_cannot_damp_is_named() -> None:
    robot = PlanarArm([0.5] * 4, velocity_limit=2.0)
    own, tip = Reach(gain=10.0, name="reach"), PositionTask([1.0, 0.5], gain=10.0)
    low = PostureTask([0.3] * 4, gain=1.0)
    said = "damping without the curvature of Reach 'reach'"
    for stack in own, JointLimits() >> own >> low, tip >> own >> low, own + tip:
        assert said in repr(Controller(robot, stack, dt=DT))
        assert said not in repr(Controller(robot, stack, dt=DT, damping=None))
    for stack in tip >> low, Damped(own, None) >> tip, Damped(own, 0.1) >> tip, tip >> AtLeast(own), low:
        assert "curvature" not in repr(Controller(robot, stack, dt=DT))
