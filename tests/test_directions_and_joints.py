"""Axis, sight, plane, posture, coupling and damping: what their loops write, at all orders and on all joints."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from asking import asked

from hqp import InvalidInput
from tasks import (
    AtLeast,
    AxisTask,
    Controller,
    Damping,
    JointCouplingTask,
    LookAtTask,
    OrientationTask,
    PlanarArm,
    PlaneTask,
    PositionTask,
    PostureTask,
    Reconstructed,
    Stack,
    Within,
    load_robot,
)
from tasks.robots.pinocchio import PinocchioRobot

K, ZETA = 2.3, 0.7
LAW = {"gain": K, "damping_ratio": ZETA}
NOW = 0.3
PANDA = load_robot("panda", lock=["panda_finger_joint1"])
TIAGO = load_robot("tiago")
#: Which velocities of it are those of wheels.
WHEELS = np.flatnonzero(TIAGO.circles(np.arange(TIAGO.nv)) >= 0)


def moving(*start):
    """A target with a velocity and an acceleration."""
    x = np.array(start)
    return lambda t: (x + 0.3 * t + 0.1 * t * t, 0.3 + 0.2 * t + 0.0 * x, 0.2 + 0.0 * x)


MADE = {
    "axis": lambda: AxisTask(moving(0.2, 0.3, -1.0), axis=[0.1, 0.2, 1.0], **LAW),
    "axis, relative": lambda: AxisTask([0.0, 1.0, 0.4], relative_to="panda_link3", **LAW),
    "look at": lambda: LookAtTask(moving(0.8, 0.3, 0.1), axis=[1.0, 0.0, 0.3], **LAW),
    "look at, relative": lambda: LookAtTask([0.5, 0.4, 0.3], relative_to="panda_link3", **LAW),
    "plane": lambda: PlaneTask([0.3, 0.1, 1.0], moving(0.2), **LAW),
    "posture": lambda: PostureTask(moving(*np.linspace(-0.3, 0.4, 7)), **LAW),
    "posture of some": lambda: PostureTask(moving(0.2, -1.0), joints=["panda_joint2", 4], **LAW),
    "coupling": lambda: JointCouplingTask({"panda_joint2": 2.0, "panda_joint4": -1.0}, moving(0.4), **LAW),
}
made = pytest.mark.parametrize("make", MADE.values(), ids=MADE.keys())


def states(robot, count=5):
    rng = np.random.default_rng(4)
    for _ in range(count):
        yield robot.at(robot.random(rng), rng.uniform(-0.8, 0.8, robot.nv))


@made
def test_rows_are_the_law_of_what_the_task_tells(make):
    task = make()
    told = {}
    for state in states(PANDA):
        e, (rate, change) = task.error(state, NOW), task.rates(state, NOW)
        J, drift = task.jacobian(state, NOW), task.drift(state, NOW)
        told = {
            "velocity": rate + K * e,
            "acceleration": change + 2.0 * ZETA * K * (rate - J @ state.v) + K**2 * e - drift,
            "displacement": e,
        }
        for order, h in told.items():
            rows, right = asked(task, state, NOW, order)
            np.testing.assert_allclose(rows, J, rtol=1e-13, atol=1e-14)
            np.testing.assert_allclose(right, h, rtol=1e-12, atol=1e-12)


@made
def test_loops_write_them_and_an_inequality_asks_for_them_between_its_bounds(make):
    for order, slope in ("velocity", K), ("acceleration", K**2), ("displacement", 1.0):
        inside = Stack(Within(make(), 0.2, below=0.1)).build(PANDA, order)
        assert inside.compiled
        for state in states(PANDA, 2):
            _, h = asked(make(), state, NOW, order)
            filled = inside.fill(state, NOW)
            np.testing.assert_allclose(filled.upper - h, slope * 0.2, rtol=1e-9)
            np.testing.assert_allclose(h - filled.lower, slope * 0.1, rtol=1e-9)


def test_a_plane_is_where_it_is_said():
    """The distance of the tip, and of a frame that another one sees."""
    for state in states(PANDA):
        tip, elbow = state.frame().position, state.frame("panda_link4")
        floor = AtLeast(PlaneTask([0.0, 0.0, 2.0], 0.1, gain=1.0))
        assert floor.task.error(state, 0.0) == pytest.approx(0.1 - tip[2], abs=1e-14)
        seen = PlaneTask([0.0, 1.0, 0.0], 0.0, relative_to="panda_link4", gain=1.0).error(state, 0.0)
        assert seen == pytest.approx(-(elbow.rotation.T @ (tip - elbow.position))[1], abs=1e-13)
    arm = PlanarArm([0.5, 0.4]).at([0.3, 0.4], [0.0, 0.0])
    assert PlaneTask([0.0, 1.0, 0.0], 0.1, gain=1.0).error(arm, 0.0) == pytest.approx(0.1 - arm.frame().position[1])


# Half a turn.


def to_the_back(state, make):
    """A task whose axis points away from where it is to."""
    frame = state.frame()
    z = frame.rotation[:, 2]
    return make(-2.0 * z, gain=1.0) if make is AxisTask else make(frame.position - 0.7 * z, gain=1.0)


@pytest.mark.parametrize("make", [AxisTask, LookAtTask])
def test_half_a_turn_is_taken_the_way_that_the_joints_turn_best(make):
    for state in states(PANDA):
        task = to_the_back(state, make)
        e, J = task.error(state, 0.0), task.jacobian(state)
        ways, sizes, _ = np.linalg.svd(J)
        assert np.linalg.norm(e) == pytest.approx(np.pi, abs=1e-7)
        assert np.linalg.norm(J.T @ e) == pytest.approx(np.pi * sizes[0], rel=1e-9)
        assert abs(ways[:, 0] @ e) == pytest.approx(np.pi, rel=1e-7)
        assert e[np.argmax(np.abs(e))] > 0.0


@pytest.mark.parametrize("make", [AxisTask, LookAtTask])
def test_where_it_points_there_is_nothing_left_to_turn(make):
    state = PANDA.at(PANDA.home, np.zeros(7))
    frame = state.frame()
    z = frame.rotation[:, 2]
    there = make(3.0 * z if make is AxisTask else frame.position + 0.7 * z, gain=1.0)
    np.testing.assert_allclose(there.error(state, 0.0), 0.0, atol=1e-8)
    lost = PANDA.at(np.full(7, np.nan), np.zeros(7))
    assert np.isnan(there.error(lost, 0.0)).all()


def test_a_direction_that_vanishes_on_its_way_is_reported_by_the_solver():
    task = AxisTask(lambda t: (np.array([0.0, 0.0, t - 1.0]), np.array([0.0, 0.0, 1.0]), np.zeros(3)), gain=1.0)
    controller = Controller(PANDA, task, dt=0.01, damping=None)
    assert controller(PANDA.home, np.zeros(7), 0.5).ok
    assert not controller(PANDA.home, np.zeros(7), 1.0).ok


# Joints.


def test_wheels_go_the_short_way_round_by_a_loop():
    assert len(WHEELS) > 1
    rng = np.random.default_rng(2)
    for state in states(TIAGO, 20):
        target = TIAGO.random(rng)
        expected = TIAGO.difference(state.q, target)
        far = np.abs(np.abs(expected) - np.pi) < 1e-3  # where a cosine alone is not exact
        np.testing.assert_allclose(PostureTask(target, gain=1.0).error(state, 0.0)[~far], expected[~far], atol=1e-12)
        some = PostureTask(target, joints=WHEELS[:2].tolist(), gain=1.0)
        assert Stack(some).build(TIAGO, "velocity").compiled
        near = ~far[WHEELS[:2]]
        np.testing.assert_allclose(some.error(state, 0.0)[near], expected[WHEELS[:2]][near], atol=1e-12)
        np.testing.assert_array_equal(some.jacobian(state), np.eye(TIAGO.nv)[WHEELS[:2]])


def test_half_a_turn_of_a_wheel_is_half_a_turn():
    circle = TIAGO.circles(WHEELS)[0]
    for angle in 0.0, 0.7, 3.0, -2.5:
        q, target = np.array(TIAGO.neutral), np.array(TIAGO.neutral)
        q[circle : circle + 2] = np.cos(angle), np.sin(angle)
        target[circle : circle + 2] = np.cos(angle + np.pi), np.sin(angle + np.pi)
        error = PostureTask(target, joints=[int(WHEELS[0])], gain=1.0).error(TIAGO.at(q, np.zeros(TIAGO.nv)), 0.0)
        assert abs(error[0]) == pytest.approx(np.pi, abs=1e-12)


def ball_robot():
    """A ball joint that carries a hinge."""
    model = pin.Model()
    inertia = pin.Inertia(1.0, np.array([0.1, 0.0, 0.2]), np.eye(3))
    for name, joint in ("ball", pin.JointModelSpherical()), ("hinge", pin.JointModelRX()):
        number = model.addJoint(model.njoints - 1, joint, pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.3])), name)
        model.appendBodyToJoint(number, inertia, pin.SE3.Identity())
    return PinocchioRobot(model)


def test_what_has_no_position_of_its_own_is_measured_by_the_robot_and_told():
    robot = ball_robot()
    rng = np.random.default_rng(5)
    target = robot.random(rng)
    rows = Stack(PostureTask(target, gain=K)).build(robot, "velocity")
    ((_, plan),) = rows.plans
    assert not rows.compiled
    assert "no position of their own" in plan.why
    for state in states(robot):
        step = robot.difference(state.q, target)
        np.testing.assert_allclose(rows.fill(state, 0.0).lower, K * step, atol=1e-12)
        np.testing.assert_allclose(PostureTask(target, gain=K).error(state, 0.0), step, atol=1e-12)
    hinge = PostureTask([0.4], joints=["hinge"], gain=K)
    assert Stack(hinge).build(robot, "velocity").compiled


class Round:
    """A robot that has as many positions as velocities, and steps that are no differences."""

    nq = nv = 2
    position_limit = velocity_limit = acceleration_limit = None
    neutral = np.zeros(2)

    def at(self, q, v):
        return SimpleNamespace(q=np.asarray(q), v=np.asarray(v), frame=PlanarArm([0.5, 0.4]).at(q, v).frame, robot=self)

    def integrate(self, q, step):
        return q + step

    def difference(self, start, end):
        return np.remainder(end - start + np.pi, 2.0 * np.pi) - np.pi


def test_a_robot_of_ones_own_tells_the_way_of_its_joints():
    posture = PostureTask([3.0, 0.0], gain=1.0)
    x = Controller(Round(), posture, dt=0.01, damping=None)([-3.0, 0.5], [0.0, 0.0]).v
    np.testing.assert_allclose(x, [6.0 - 2.0 * np.pi, -0.5], atol=1e-12)


def test_beside_other_rows_a_posture_keeps_those_of_the_identity():
    posture, sum_ = PostureTask(PANDA.home + 0.1, gain=K), JointCouplingTask({0: 1.0, 1: 0.5}, 0.2, gain=1.0)
    for part in posture, Within(posture, 0.3), Damping(0.2):
        rows = Stack(part + sum_).build(PANDA, "velocity")
        for state in states(PANDA, 2):
            filled = rows.fill(state, 0.0)
            np.testing.assert_array_equal(filled.dense(), [*np.eye(7), [1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0]])
            assert filled.upper[-1] == pytest.approx(0.2 - state.q[0] - 0.5 * state.q[1])


# Numbers that are live.


def test_both_names_of_a_target_are_one():
    for task, name, other in (
        (AxisTask([0.0, 0.0, 1.0], gain=1.0), "direction", [0.0, 1.0, 0.0]),
        (LookAtTask([0.5, 0.0, 0.1], gain=1.0), "point", [0.1, 0.6, 0.2]),
        (PlaneTask([0.0, 0.0, 1.0], 0.1, gain=1.0), "distance", [0.3]),
    ):
        before = task.error(PANDA.at(PANDA.home, np.zeros(7)), 0.0)
        setattr(task, name, other)
        assert task.target is getattr(task, name)
        fresh = type(task)(*([task.normal] if name == "distance" else []), other, gain=1.0)
        state = PANDA.at(PANDA.home, np.zeros(7))
        np.testing.assert_array_equal(task.error(state, 0.0), fresh.error(state, 0.0))
        assert np.abs(before - task.error(state, 0.0)).max() > 1e-3
    with pytest.raises(InvalidInput, match="has no direction"):
        AxisTask([0.0, 0.0, 1.0], gain=1.0).direction = [0.0, 0.0, 0.0]


def test_a_coupling_takes_other_factors_of_the_same_joints():
    task = JointCouplingTask({"panda_joint2": 1.0, "panda_joint4": -1.0}, gain=1.0)
    controller = Controller(PANDA, task, dt=0.01, damping=None)
    task.factors = {"panda_joint2": 0.0, "panda_joint4": 2.0}
    assert controller(PANDA.home, np.zeros(7)).v[3] == pytest.approx(-PANDA.home[3])
    assert task.factors == {"panda_joint2": 0.0, "panda_joint4": 2.0}
    for refused, why in (
        ({"panda_joint2": 1.0, "panda_joint3": 1.0}, "its joints are part of its structure"),
        ({"panda_joint2": 0.0, "panda_joint4": 0.0}, "one must not be zero"),
    ):
        with pytest.raises(InvalidInput, match=why):
            task.factors = refused
    with pytest.raises(TypeError):
        task.factors["panda_joint2"] = 3.0
    assert task.factors == {"panda_joint2": 0.0, "panda_joint4": 2.0}


def test_a_reconstructed_task_says_that_python_writes_it_and_is_taken_by_steps_too():
    arm = PlanarArm([0.5, 0.5, 0.5])
    tip = PositionTask([2.0, 0.3], gain=2.0)
    slowed = Reconstructed(OrientationTask(-0.5, gain=3.0), 0.8, above=tip)
    state = arm.at(np.array([1.0, -0.3, 0.1]), np.zeros(3))
    by_order = {}
    for order in "velocity", "displacement":
        rows = Stack(slowed).build(arm, order)
        assert "gradient" in rows.plans[0][1].why
        by_order[order] = rows.fill(state, 0.0).lower.copy()
        assert np.isfinite(by_order[order]).all()
    exact = slowed.error(state, 0.0)
    assert by_order["displacement"] != pytest.approx(exact)
    slowed.threshold = 1e-6
    np.testing.assert_array_equal(Stack(slowed).build(arm, "displacement").fill(state, 0.0).lower, exact)
