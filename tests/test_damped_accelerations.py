"""Damping at acceleration and torque order: towards -2 zeta K v, by the fastest task of the level."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import hqp
from hqp import ErrorDamping, SingularValueDamping
from tasks import (
    AtMost,
    Controller,
    Damped,
    Damping,
    JointAccelerationLimit,
    JointLimits,
    JointMotion,
    JointVelocityLimit,
    ManipulabilityTask,
    MinimumMotionTask,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
    Task,
    load_robot,
)

ARM = PlanarArm([0.5, 0.4, 0.3])
Q, V = np.array([0.3, 0.7, -0.4]), np.array([0.6, -0.5, 1.2])
DT = 5e-3


class Scaled(Task):
    """s times one joint."""

    rows = 1

    def __init__(self, s: float, **options) -> None:
        self._s = s
        super().__init__(**options)

    def error(self, state, t):
        return -self._s * state.q[:1]

    def jacobian(self, state):
        return np.full((1, 1), self._s)


def tip(**options) -> PositionTask:
    return PositionTask([0.9, 0.6], **{"gain": 4.0, **options})


def both(level, damping=0.2):
    """One level, damped by a rule and by the part beside it."""
    return Damped(level(), damping), level() + Damping(damping)


@given(
    s=st.floats(0.01, 3.0),
    damping=st.floats(0.0, 2.0),
    K=st.floats(0.5, 20.0),
    zeta=st.floats(0.5, 2.0),
    part=st.booleans(),
)
@settings(max_examples=25)
def test_a_joint_alone_is_damped_by_no_less_than_its_task(s, damping, K, zeta, part):
    """a = s K^2 e / (s^2 + lambda^2) - 2 zeta K v: critically damped at lambda = 0, overdamped elsewhere."""
    task = Scaled(s, gain=K, damping_ratio=zeta)
    stack = task if damping < 1e-3 else task + Damping(damping) if part else Damped(task, damping)
    controller = Controller(PlanarArm([1.0]), stack, order="acceleration")
    if damping < 1e-3:
        damping = 0.0
    for q, v in (1.0, 0.0), (-0.3, 2.0), (0.0, 1.0):
        a = controller([q], [v]).a[0]
        assert a == pytest.approx(-(s**2) * K**2 * q / (s**2 + damping**2) - 2 * zeta * K * v, rel=1e-9, abs=1e-9)
    if zeta < 1.0:
        return
    q, v, dt = 1.0, 0.0, 0.05 / (zeta * K)
    for _ in range(300):
        a = controller([q], [v]).a[0]
        q, v = q + dt * v + 0.5 * dt**2 * a, v + dt * a
        assert q >= -1e-12  # from rest it never passes its target,
        assert v <= 1e-12  # nor turns back


@pytest.mark.parametrize("top", [False, True], ids=["free", "limits"])
def test_the_part_and_the_rule_ask_for_the_same(top):
    found = []
    for level in both(tip):
        stack = JointLimits(JointVelocityLimit(1.0)) >> level if top else level
        step = Controller(ARM, stack, order="acceleration", dt=DT)(Q, V)
        assert step.solution.certify().ok
        found.append(step.a)
    np.testing.assert_allclose(*found, atol=1e-9)
    controller = Controller(ARM, Damped(tip(), 0.2), order="acceleration")
    step = controller(Q, V)
    np.testing.assert_array_equal(controller.aims[0], -8.0 * V)
    np.testing.assert_array_equal(step.relaxed[0].aim, -8.0 * V)
    J = ARM.jacobian(Q)[:2]
    e, drift = np.array([0.9, 0.6]) - ARM.pose(Q)[:2], (ARM.jacobian_dot(Q, V) @ V)[:2]
    wanted = J.T @ np.linalg.solve(J @ J.T + 0.04 * np.eye(2), 16.0 * e - drift) - 8.0 * V
    np.testing.assert_allclose(step.a, wanted, atol=1e-9)


@pytest.mark.parametrize("rule", [0.1, ErrorDamping(2.0), SingularValueDamping(0.1, 0.5)], ids=str)
@pytest.mark.parametrize("backend", ["native", "cascade:proxsuite", "pseudoinverse"])
def test_every_backend_and_both_orders_give_the_same(rule, backend):
    stack = Damped(tip(), rule) >> Damped(OrientationTask(0.4, gain=9.0), rule)
    step = Controller(ARM, stack, order="acceleration", backend=backend)(Q, V)
    assert step.solution.certify().ok
    expected = Controller(ARM, stack, order="torque")(Q, V)
    np.testing.assert_allclose(step.a, expected.a, atol=1e-8)
    np.testing.assert_allclose(expected.tau, ARM.inverse_dynamics(Q, V, expected.a), atol=1e-12)
    assert {k: -aim[0] / V[0] for k, aim in step.solution.aims.items()} == pytest.approx({0: 8.0, 1: 18.0})


def test_the_fastest_of_a_level_counts_and_what_has_no_task_does_not_brake():
    turn = OrientationTask(0.4, gain=[9.0], damping_ratio=0.5)
    posture = PostureTask([0.1, 0.2, 0.3], gain=[1.0, 6.0, 2.0])
    rates = [
        (tip(), 4.0),
        (tip() + turn, 4.5),
        (tip() + posture, 6.0),
        (AtMost(tip()) + tip(gain=1.0), 4.0),
        (JointMotion(turn), 4.5),
        (MinimumMotionTask(gain=3.0), 1.5),
        (ManipulabilityTask(tip(gain=1.0), gain=2.0), 2.0),
    ]
    for level, rate in rates:
        for stack in Damped(level, 0.1), level + Damping(0.1):
            controller = Controller(ARM, stack, order="acceleration", dt=DT)
            controller(Q, V)
            (*_, last) = stack
            aim = controller.aims[0] if controller.aims else controller.bounds(last)[0]
            np.testing.assert_allclose(aim, -2.0 * rate * V, atol=1e-12)
    alone = Damping(0.1)
    controller = Controller(ARM, tip() >> alone, order="acceleration")
    controller(Q, V)
    for bound in controller.bounds(alone):
        np.testing.assert_array_equal(bound, np.zeros(3))


@pytest.mark.parametrize("stack", both(tip), ids=["rule", "part"])
def test_at_velocity_order_nothing_is_aimed_at(stack):
    controller = Controller(ARM, stack, order="velocity")
    moving, still = controller(Q, V), controller(Q, np.zeros(3))
    assert controller.aims == {}
    np.testing.assert_array_equal(moving.v, still.v)
    np.testing.assert_array_equal(controller(Q, np.full(3, np.nan)).v, still.v)


def test_gains_that_change_at_work_and_copies_give_what_a_fresh_controller_gives():
    for make in Damped, lambda level, damping: level + Damping(damping):
        task = tip()
        stack = make(task + PostureTask([0.1, 0.2, 0.3], gain=2.0, weight=0.1), 0.2)
        controller = Controller(ARM, stack, order="acceleration", dt=DT)
        controller(Q, V)
        task.gain, task.damping_ratio = 7.0, 1.2
        other = tip(gain=7.0, damping_ratio=1.2) + PostureTask([0.1, 0.2, 0.3], gain=2.0, weight=0.1)
        expected = Controller(ARM, make(other, 0.2), order="acceleration", dt=DT)(Q, V).a
        for one in controller, copy.deepcopy(controller), pickle.loads(pickle.dumps(controller)):
            np.testing.assert_allclose(one(Q, V).a, expected, atol=1e-12)
        with pytest.raises(hqp.InvalidInput):
            task.gain = 1e4
        np.testing.assert_allclose(controller(Q, V).a, expected, atol=1e-12)


def test_a_change_begins_with_the_old_aims():
    old, new = Damped(tip(), 0.2), PostureTask([0.1, 0.2, 0.3], gain=2.0)
    controller = Controller(ARM, old, order="acceleration", dt=DT)
    expected = controller(Q, V).a
    controller.change(new, duration=1.0)
    np.testing.assert_allclose(controller(Q, V).a, expected, atol=1e-12)
    controller.change(Damped(tip(gain=8.0), 0.2), duration=0.0)
    controller(Q, V)
    np.testing.assert_array_equal(controller.aims[0], -16.0 * V)


def test_numbers_that_mean_nothing_are_a_status():
    controller = Controller(ARM, Damped(tip(), 0.1), order="acceleration")
    assert controller(Q, [np.nan, 0.0, 0.0]).solution.status is hqp.Status.INVALID
    assert controller(Q, [1e300, 0.0, 0.0]).solution.status is hqp.Status.INVALID
    assert controller(Q, V).ok


@pytest.mark.parametrize("order", ["acceleration", "torque"])
@pytest.mark.parametrize("seed", range(6))
def test_by_default_an_arm_far_out_of_reach_comes_to_rest(seed: int, order: str) -> None:
    """Its last level leaves it bends that hardly move the tip at first order: nothing keeps them, and nothing is to."""
    rng, angle = np.random.default_rng(seed), 0.5 * (seed - 2.5)
    arm = PlanarArm([0.5, 0.4, 0.3, 0.2], velocity_limit=3.0, acceleration_limit=30.0)
    far = PositionTask([2.8 * np.cos(angle), 2.8 * np.sin(angle)], gain=5.0)
    stack = JointVelocityLimit() + JointAccelerationLimit() >> far >> OrientationTask(rng.normal(), gain=5.0)
    controller, q, v, fastest = Controller(arm, stack, order=order, dt=DT), rng.uniform(-1.0, 1.0, 4), np.zeros(4), 0.0
    for k in range(1600):
        a = controller(q, v).a
        q, v = q + DT * v + 0.5 * DT**2 * a, v + DT * a
        fastest = max(fastest, np.abs(v).max()) if k >= 1200 else 0.0
    assert fastest < 0.1


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("name", ["ur5", "ur10"])
def test_by_default_a_posture_does_not_swing_an_arm_out_of_reach(name: str, seed: int) -> None:
    """It is slow, and soft rows above, which turn and stiffen with the joints, are a spring to what it leaves alone."""
    rng, robot = np.random.default_rng(seed), load_robot(name, acceleration_limit=50.0)
    way = rng.normal(size=3) * [1.0, 1.0, 0.5]
    gain, to = rng.uniform(10.0, 20.0), Rotation.from_quat(rng.normal(size=4)).as_matrix()
    far = PositionTask(rng.uniform(1.2, 3.0) * way / np.linalg.norm(way), gain=gain)
    stack = JointLimits() >> far >> OrientationTask(to, gain=gain) >> PostureTask(robot.home, gain=2.0)
    controller, q, v, fastest = Controller(robot, stack, order="acceleration", dt=DT), robot.home, np.zeros(6), 0.0
    for k in range(2400):
        a = controller(q, v).a
        q, v = robot.integrate(q, DT * v + 0.5 * DT**2 * a), v + DT * a
        fastest = max(fastest, np.abs(v).max()) if k >= 2000 else 0.0
    assert fastest < 0.03
