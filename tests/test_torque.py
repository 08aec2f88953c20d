"""Torque order: the motion of the acceleration order, its torques by the motion equation, and limits on them."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from hqp import InvalidInput, Label, Side
from tasks import (
    Circle,
    Controller,
    JointAccelerationLimit,
    JointLimits,
    JointPositionLimit,
    JointTorqueLimit,
    OrientationTask,
    PinocchioRobot,
    PlanarArm,
    PositionTask,
    PostureTask,
    load_robot,
    simulate,
)

ARM = PlanarArm([0.5, 0.4, 0.3], masses=[3.0, 2.0, 1.0], torque_limit=[40.0, 16.0, 5.0])
START = np.array([0.3, 0.8, -0.4])


@cache
def panda(**limits):
    return load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=30.0, **limits)


@cache
def armed():
    """A Panda whose motors have rotors."""
    model = panda().model.copy()
    model.armature = np.linspace(0.1, 0.7, 7)
    return PinocchioRobot(model)


def circle():
    return PositionTask(Circle([0.55, 0.35], 0.25, duration=1.0), gain=15.0) >> OrientationTask(1.0, gain=15.0)


@pytest.mark.parametrize("robot", [lambda: ARM, panda, armed], ids=["planar", "panda", "armature"])
def test_torques_are_mass_times_acceleration_and_bias(robot):
    """With leading axes, and one by one; M symmetric and positive."""
    robot, rng = robot(), np.random.default_rng(0)
    q, v, a = rng.uniform(-1.5, 1.5, (3, 2, 4, robot.nv))
    M, bias = robot.mass_matrix(q), robot.bias(q, v)
    assert (M.shape, bias.shape) == ((2, 4, robot.nv, robot.nv), (2, 4, robot.nv))
    np.testing.assert_allclose(M, M.swapaxes(-1, -2), rtol=1e-12, atol=1e-12)
    assert np.linalg.eigvalsh(M).min() > 0.0
    tau = (M @ a[..., None])[..., 0] + bias
    np.testing.assert_allclose(tau, robot.inverse_dynamics(q, v, a), rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(M[1, 2], robot.mass_matrix(q[1, 2]), rtol=1e-12)
    np.testing.assert_allclose(bias[1, 2], robot.bias(q[1, 2], v[1, 2]), rtol=1e-12, atol=1e-12)


def test_dynamics_do_not_disturb_a_state():
    robot = panda()
    state = robot.at(robot.home, np.ones(7))
    expected = robot.at(robot.home, np.ones(7)).frame("panda_link5").linear.copy()
    robot.mass_matrix(np.ones(7)), robot.bias(np.ones(7), np.ones(7))
    np.testing.assert_array_equal(state.frame("panda_link5").linear, expected)


def test_a_robot_has_the_torque_limits_of_its_model():
    np.testing.assert_array_equal(panda().torque_limit, [87.0] * 4 + [12.0] * 3)
    np.testing.assert_array_equal(panda(torque_limit=5.0).torque_limit, [5.0] * 7)
    assert np.isinf(load_robot("g1").torque_limit[:6]).all()  # what a model cannot have it calls huge
    model = panda().model.copy()
    model.effortLimit = np.zeros(7)
    assert PinocchioRobot(model).torque_limit is None
    assert PlanarArm([1, 1]).torque_limit is None


def test_the_same_motion_at_torque_and_at_acceleration_order():
    """With limits wide enough the torques make the motion of the accelerations, and are told by every step."""
    records = [
        simulate(Controller(ARM, stack, order=order, dt=0.01, damping=None), START, duration=1.5)
        for order, stack in (("acceleration", circle()), ("torque", JointTorqueLimit(1e3) >> circle()))
    ]
    np.testing.assert_allclose(records[0].q, records[1].q, atol=1e-9)
    np.testing.assert_allclose(records[0].tau, records[1].tau, atol=1e-6)
    assert not records[1].active["torque"].any()
    step = Controller(ARM, circle(), order="torque", damping=None)(START, np.ones(3))
    assert (step.order, step.v) == ("torque", None)
    np.testing.assert_allclose(step.tau, ARM.mass_matrix(START) @ step.a + ARM.bias(START, np.ones(3)), atol=1e-9)


@pytest.mark.parametrize("order", ["acceleration", "torque"])
def test_no_torque_exceeds_its_limit(order):
    record = simulate(
        Controller(ARM, JointTorqueLimit() >> circle(), order=order, dt=0.01, damping=None), START, duration=2.0
    )
    assert record.stopped is None
    assert record.certified == record.checked
    np.testing.assert_allclose(record.tau, ARM.inverse_dynamics(record.q[:-1], record.v[:-1], record.a), atol=1e-9)
    excess = np.abs(record.tau) - ARM.torque_limit
    assert excess.max() <= 1e-9
    sides = record.active["torque"]
    assert 0.05 < (sides != 0).any(axis=1).mean() < 0.95
    np.testing.assert_array_equal(sides == Side.UPPER, record.tau >= ARM.torque_limit * (1.0 - 1e-8))


def test_a_spatial_arm_keeps_its_torques():
    robot = panda(torque_limit=(25.0,) * 4 + (3.0,) * 3)
    hand = robot.at(robot.home, np.zeros(7)).frame()
    reach = PositionTask(np.add(hand.position, [0.1, 0.4, -0.2]), gain=20.0) >> OrientationTask(
        hand.rotation, gain=20.0
    )
    stack = JointTorqueLimit() >> JointLimits() >> reach >> PostureTask(robot.home, gain=2.0)
    record = simulate(
        Controller(robot, stack, order="torque", dt=4e-3, damping=None), robot.home, duration=0.8, certify=10
    )
    assert record.certified == record.checked
    assert (np.abs(record.tau) - robot.torque_limit).max() <= 1e-9
    assert record.active["torque"].any()
    assert (robot.position_limit[0] <= record.q).all()
    assert (record.q <= robot.position_limit[1]).all()


def test_the_higher_level_is_the_harder_limit():
    """A joint too fast for its motors to stop inside its range: what stands first is kept, the other pays."""
    arm = PlanarArm([1.0], masses=[3.0])  # inertia 1 kg m^2
    motor, ranges = JointTorqueLimit(2.0), JointLimits(JointPositionLimit(-1.0, 1.0), JointAccelerationLimit(50.0))

    def run(stack):
        controller = Controller(arm, stack >> PostureTask([0.0], gain=5.0), order="torque", dt=0.01, damping=None)
        return simulate(controller, [0.8], [2.0], duration=1.0)

    physical, planned = run(motor >> ranges), run(ranges >> motor)
    assert np.abs(physical.tau).max() <= 2.0 + 1e-9 < np.abs(planned.tau).max()
    assert planned.q.max() <= 1.0 + 1e-9 < physical.q.max()
    step = Controller(arm, motor >> ranges >> PostureTask([0.0], gain=5.0), order="torque", dt=0.01, damping=None)(
        [0.95], [2.0]
    )
    assert "joint limits short by 23 rad/s^2: joint 0 torque limit (lower)" in str(step.solution.explain())


def test_explanations_name_joint_and_unit():
    assert JointTorqueLimit().labels(panda(), "acceleration")[1] == Label("torque limit", "panda_joint2", "N m")
    assert JointTorqueLimit(name="motors").labels(panda(), "acceleration")[0].part == "motors"
    sliding = SimpleNamespace(nv=1, joint_names=("lift",), joint_units=("m",))
    assert JointTorqueLimit(3.0).labels(sliding, "acceleration")[0].unit == "N"
    robot = panda()
    stack = JointTorqueLimit() >> PositionTask([0.3, 0.0, 1.5], gain=10.0)
    text = str(Controller(robot, stack, order="torque", damping=None)(robot.home, np.zeros(7)).solution.explain())
    assert "panda_joint4 torque limit (upper)" in text


def test_it_reads_like_its_declaration():
    assert repr(JointTorqueLimit()) == "JointTorqueLimit()"
    assert repr(JointTorqueLimit([1, 2])) == "JointTorqueLimit([1.0, 2.0])"
    controller = Controller(ARM, JointTorqueLimit() >> circle(), order="torque")
    assert "order='torque', backend" in repr(controller)


def test_numbers_never_raise():
    controller = Controller(ARM, JointTorqueLimit() >> circle(), order="torque", damping=None)
    assert not controller([np.nan, 0, 0], [0, 0, 0]).ok
    assert controller(START, [0, 0, 0]).ok


FOREIGN = SimpleNamespace(nq=3, nv=3, at=ARM.at)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (
            lambda: Controller(ARM, JointTorqueLimit(), damping=None),
            r"JointTorqueLimit 'torque': velocities tell no torques; .* must",
        ),
        (
            lambda: Controller(load_robot("g1"), JointTorqueLimit(), order="acceleration", damping=None),
            "'torque': .* floating base",
        ),
        (
            lambda: Controller(load_robot("g1"), JointLimits(), order="torque", damping=None),
            "order = 'torque': .* floating base",
        ),
        (
            lambda: Controller(FOREIGN, JointTorqueLimit(1.0), order="acceleration", damping=None),
            r"has no mass_matrix\(q\)",
        ),
        (
            lambda: Controller(FOREIGN, circle(), order="torque", damping=None),
            r"order = 'torque', but .* has no inverse_dynamics",
        ),
        (
            lambda: Controller(PlanarArm([1]), JointTorqueLimit(), order="torque", damping=None),
            r"no torque limit .* give one in N m",
        ),
        (
            lambda: Controller(ARM, JointTorqueLimit([1.0, 2.0]), order="torque", damping=None),
            r"limit has shape \(2,\)",
        ),
        (lambda: JointTorqueLimit(-1.0), r"JointTorqueLimit 'torque': limit = -1.0 N m must not be negative"),
        (lambda: JointTorqueLimit(1.0, name=3), "name of a JointTorqueLimit = 3 is a int"),
        (lambda: PlanarArm([1], torque_limit=-1.0), "torque limit = -1.0 N m must not be negative"),
        (lambda: panda(torque_limit=(1.0, 2.0)), r"torque limit has shape \(2,\)"),
    ],
)
def test_refuses_what_has_no_torques(make, named):
    with pytest.raises(InvalidInput, match=named):
        make()


def test_gravity_is_part_of_the_bias():
    robot = panda()
    gravity = pin.computeGeneralizedGravity(robot.model, robot.model.createData(), robot.home)
    np.testing.assert_allclose(robot.bias(robot.home, np.zeros(7)), gravity, atol=1e-12)


@pytest.mark.parametrize("given", ["the robot", "the limit"])
def test_a_joint_without_a_motor_has_no_torque(given):
    largest = [0.0, 20.0]
    arm = PlanarArm([1.0, 1.0], masses=[1.0, 1.0], velocity_limit=20.0)
    if given == "the robot":
        arm.torque_limit = largest
    limit = JointTorqueLimit(None if given == "the robot" else largest)
    controller = Controller(arm, limit >> PostureTask([0.5, 0.3], gain=3.0), order="torque", dt=0.005)
    q, v = np.array([0.3, 0.2]), np.zeros(2)
    for _ in range(20):
        step = controller(q, v)
        assert abs(step.tau[0]) < 1e-10
        assert step.solution.certify().ok
        q, v = q + 0.005 * v, v + 0.005 * step.a
