"""What goes to a motor is finite, within limits, and meant: states, targets, gains and changes that are not."""

from __future__ import annotations

import logging

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from urdf_files import chain, write

from hqp import InvalidInput, Status
from tasks import (
    AtLeast,
    AxisTask,
    BoxLimit,
    Controller,
    Damping,
    DistanceLimit,
    JointAccelerationLimit,
    JointLimits,
    JointPositionLimit,
    JointVelocityLimit,
    LookAtTask,
    OrientationTask,
    PlanarArm,
    PlaneLimit,
    PoseSetpoint,
    PoseTask,
    PositionTask,
    PostureTask,
    RotationSetpoint,
    Setpoint,
    Sphere,
    Turn,
    from_xyzw,
    load_robot,
    planar_links,
    simulate,
    solve_ik,
)
from tasks.base.rotations import exp, from_quaternion, log

pytestmark = pytest.mark.usefixtures("nothing_told")


def told(caplog):
    return [record.getMessage() for record in caplog.records if record.name == "hqp"]


# Configurations off their manifold.


def wheels(tmp_path):
    return load_robot(write(tmp_path, *chain({"kind": "continuous"}, {}), links=3), tip="link2", velocity_limit=2.0)


@pytest.mark.parametrize("off", [0.0, 0.97, 1.03, 1.0 + 1e-5, 1e10])
@pytest.mark.parametrize("name", ["g1", "wheels", "planar"])
def test_a_configuration_off_its_manifold_moves_nothing_and_is_refused(tmp_path, name, off):
    robot = {
        "g1": lambda: load_robot("g1"),
        "wheels": lambda: wheels(tmp_path),
        "planar": lambda: load_robot(write(tmp_path, *chain({}, {}), links=3), base="planar", tip="link2"),
    }[name]()
    first, count = {"g1": (3, 4), "wheels": (0, 2), "planar": (2, 2)}[name]
    frame = robot.tip or "left_rubber_hand"
    q, rest = np.array(robot.home), np.zeros(robot.nv)
    q[first : first + count] *= off
    stack = JointLimits() >> PositionTask([0.3, 0.2, 0.5], frame=frame, gain=2.0)
    for order, options in ("velocity", {}), ("acceleration", {}):
        robot.acceleration_limit = np.full(robot.nv, 20.0)
        step = Controller(robot, stack, order=order, dt=0.01, **options)(q, rest)
        assert step.solution.status is Status.INVALID
        assert not step.solution.x.any()
        assert "has norm" in step.solution.message
        assert "must be 1" in step.solution.message
    for refused in (
        lambda: robot.at(q, rest),
        lambda: solve_ik(robot, stack, q),
        lambda: simulate(Controller(robot, stack, dt=0.01, damping=None), q, duration=0.1),
    ):
        with pytest.raises(InvalidInput, match=r"has norm .*; it must be 1"):
            refused()


@given(seed=st.integers(0, 10_000), size=st.floats(-9e-7, 9e-7))
@settings(max_examples=25)
def test_round_off_of_a_quaternion_is_taken_off(seed, size):
    robot = _G1
    rng = np.random.default_rng(seed)
    q, rest = robot.random(rng), np.zeros(robot.nv)
    near = np.array(q)
    near[3:7] *= 1.0 + size
    here, there = robot.at(q, rest), robot.at(near, rest)
    assert np.linalg.norm(there.q[3:7]) == pytest.approx(1.0, abs=1e-12)
    for frame in "left_rubber_hand", "right_ankle_roll_link":
        np.testing.assert_allclose(there.frame(frame).position, here.frame(frame).position, atol=1e-12)


_G1 = load_robot("g1")


def test_numbers_from_a_broken_sensor_move_nothing_at_any_order():
    robot = load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=20.0)
    for order in "velocity", "acceleration", "torque":
        controller = Controller(
            robot, JointLimits() >> PositionTask([0.4, 0.2, 0.4], gain=2.0), order=order, dt=0.01, damping=None
        )
        for value in np.nan, np.inf, -np.inf, 1e300:
            for where in "q", "v":
                q, v = np.array(robot.home), np.zeros(7)
                (q if where == "q" else v)[2] = value
                step = controller(q, v)
                command = {"velocity": step.v, "acceleration": step.a, "torque": step.tau}[order]
                assert np.isfinite(command).all()
                if not np.isfinite(value):
                    assert step.solution.status is Status.INVALID
                    assert not command.any()
        assert controller(robot.home, np.zeros(7)).ok


def test_torques_of_a_floating_base_are_refused_however_they_are_asked_for():
    stack = JointLimits() + JointAccelerationLimit(9.0) >> PostureTask(_G1.home, gain=1.0)
    for options in {"order": "torque"}, {"order": "acceleration", "torque": True}:
        with pytest.raises(InvalidInput, match="has a floating base, which no joint torque drives"):
            Controller(_G1, stack, dt=0.01, **options)


# Rotations and transforms.

NO_ROTATIONS = {
    "a vector": [0.1, 0.2, 0.3],
    "a number": 0.5,
    "a reflection": np.diag([1.0, 1.0, -1.0]),
    "too long": 1.1 * np.eye(3),
    "off by 1e-5": np.eye(3) + 1e-5 * np.ones((3, 3)),
    "not finite": np.full((3, 3), np.nan),
    "four by four, no transform": np.ones((4, 4)),
    "words": "R",
}


@pytest.mark.parametrize("name", NO_ROTATIONS)
def test_what_is_no_rotation_is_refused_everywhere(name):
    R = NO_ROTATIONS[name]
    takes = {
        "setpoint": lambda: RotationSetpoint(R),
        "move": lambda: RotationSetpoint(np.eye(3)).move(R),
        "turn": lambda: Turn(np.eye(3), R, 1.0),
        "pose": lambda: PoseTask([0, 0, 0], R, gain=1.0),
        "function": lambda: PoseTask([0, 0, 0], lambda t: (R, np.zeros(3), np.zeros(3)), gain=1.0),
        "orientation": lambda: OrientationTask(R, gain=1.0),
    }
    for where, take in takes.items():
        if (where, name) in {("orientation", "a number"), ("pose", "a number")}:
            continue  # an angle about z
        with pytest.raises(InvalidInput):
            take()


def test_a_rotation_that_is_off_by_round_off_is_cleaned():
    rng = np.random.default_rng(0)
    for _ in range(20):
        R = exp(rng.standard_normal(3))
        setpoint = RotationSetpoint(np.eye(3))
        setpoint.move(R + 3e-7 * rng.uniform(-1, 1, (3, 3)))
        found = setpoint(0.0)[0]
        assert np.abs(found.T @ found - np.eye(3)).max() < 1e-12
        assert np.linalg.norm(log(found @ R.T)) < 2e-6


def test_a_function_that_stops_being_a_rotation_ends_in_invalid_ticks():
    robot = load_robot("ur5")

    def drifting(t):
        return (1.0 + 0.1 * t) * np.eye(3), np.zeros(3), np.zeros(3)

    controller = Controller(robot, JointLimits() >> OrientationTask(drifting, gain=1.0), dt=0.01, damping=None)
    assert controller(robot.home, np.zeros(6), 0.0).ok
    step = controller(robot.home, np.zeros(6), 1.0)
    assert step.solution.status is Status.INVALID
    assert not step.v.any()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (([1.0],), r"setpoint has shape \(1,\); it must be \(3,\)"),
        ((0.5,), r"setpoint has shape \(1,\); it must be \(3,\)"),
        ((np.zeros((3, 1)),), r"setpoint has shape \(3, 1\)"),
        (("here",), "setpoint is not an array of real numbers"),
        ((np.zeros(3), [1.0]), r"setpoint: velocity has shape \(1,\)"),
        ((np.zeros(3), np.zeros(3), 1.0), r"setpoint: acceleration has shape \(1,\)"),
        ((np.zeros(3), None, np.zeros(3)), "an acceleration is given without a velocity"),
    ],
)
def test_setpoints_take_the_shape_they_began_with(arguments, said):
    setpoint = Setpoint([0.1, 0.2, 0.3])
    with pytest.raises(InvalidInput, match=said):
        setpoint.move(*arguments)
    np.testing.assert_array_equal(setpoint(0.0)[0], [0.1, 0.2, 0.3])
    one = Setpoint(0.5)
    one.move(0.7)
    assert one(0.0)[0] == [0.7]


def test_poses_as_transforms():
    """A 4 x 4 matrix, an SE3 of Pinocchio, and position and rotation apart are one task."""
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    R, p = exp([0.3, -2.0, 0.4]), np.array([0.4, 0.1, 0.5])
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, p
    here = robot.home, np.zeros(7)
    goal = PoseSetpoint(np.eye(4))
    goal.move(pin.SE3(R, p))
    expected = Controller(robot, PoseTask(p, R, gain=2.0), dt=0.01, damping=None)(*here).v
    for task in PoseTask(T, gain=2.0), PoseTask(pin.SE3(R, p), gain=2.0), PoseTask(goal, gain=2.0):
        np.testing.assert_allclose(Controller(robot, task, dt=0.01, damping=None)(*here).v, expected, atol=1e-9)
    goal.move(T, velocity=[0.1, 0.0, 0.0, 0.0, 0.0, 0.2])
    moving = Controller(robot, PoseTask(goal, gain=2.0), dt=0.01, damping=None)(*here).v
    assert np.abs(moving - expected).max() > 0.01
    x, y, z, w = pin.Quaternion(R).coeffs()
    np.testing.assert_allclose(from_xyzw([x, y, z, w]), R, atol=1e-12)


def test_what_is_no_transform_is_refused():
    reflected, leaning = np.diag([1.0, 1.0, -1.0, 1.0]), np.eye(4)
    leaning[3, 0] = 0.1
    for T, said in (
        (np.eye(3), r"has shape \(3, 3\); a transform is a matrix of shape \(4, 4\)"),
        ([0.1, 0.2, 0.3], r"has shape \(3,\)"),
        (reflected, "is a reflection"),
        (leaning, "has the last row"),
        (np.full((4, 4), np.nan), "must be finite"),
    ):
        for take in (
            lambda T=T: PoseTask(T, gain=1.0),
            lambda T=T: PoseSetpoint(T),
            lambda T=T: PoseSetpoint(np.eye(4)).move(T),
        ):
            with pytest.raises(InvalidInput, match=said):
                take()
    with pytest.raises(InvalidInput, match="a rotation is given beside a PoseSetpoint"):
        PoseTask(PoseSetpoint(np.eye(4)), np.eye(3), gain=1.0)
    for quaternion in [0, 0, 0.7, 0.7], [0, 0, 0, 0], [0, 0, 1], [np.nan, 0, 0, 1]:
        with pytest.raises(InvalidInput, match="quaternion"):
            from_xyzw(quaternion)
    np.testing.assert_allclose(from_quaternion(0, 0, 2, 0), np.diag([-1, -1, 1]), atol=1e-12)


@pytest.mark.parametrize("relative_to", [None, "torso_link"])
def test_holding_a_frame_where_it_is(relative_to):
    rest = np.zeros(_G1.nv)
    q = _G1.random(np.random.default_rng(3))
    hold = PoseTask.hold(_G1.at(q, rest), frame="left_rubber_hand", relative_to=relative_to, gain=5.0, name="hand")
    assert np.abs(hold.error(_G1.at(q, rest), 0.0)).max() < 1e-12
    assert hold.name == "hand"
    with pytest.raises(InvalidInput, match="a planar arm has no pose in space"):
        PoseTask.hold(PlanarArm([0.5]).at([0.1], [0.0]), gain=1.0)


# Gains.


class Unchecked(PostureTask):
    """With whatever gain."""

    def check_gain(self, order, dt):
        pass


@pytest.mark.parametrize(("order", "zeta"), [("velocity", 1.0), *(("acceleration", z) for z in (0.2, 0.5, 1.0, 3.0))])
def test_a_gain_that_is_taken_brings_the_error_down_and_one_that_is_refused_would_not(order, zeta):
    arm, dt = PlanarArm([0.5, 0.4]), 0.01
    most = (2.0 if order == "velocity" else min(1.0 / zeta, 4.0 * zeta)) / dt

    def posture(gain):
        return PostureTask([0.5, -0.3], gain=gain, damping_ratio=zeta)

    with pytest.raises(InvalidInput, match="makes the error grow from tick to tick"):
        Controller(arm, posture(1.01 * most), order=order, dt=dt, damping=None)
    record = simulate(
        Controller(arm, posture(0.97 * most), order=order, dt=dt, damping=None), [0.4, -0.2], duration=9.0, certify=0
    )
    assert np.abs(record.q[-1] - [0.5, -0.3]).max() < 0.05 * np.abs(record.q - [0.5, -0.3]).max()
    wild = Unchecked([0.5, -0.3], gain=1.03 * most, damping_ratio=zeta)  # and what is refused does grow
    controller = Controller(arm, wild, order=order, dt=dt, damping=None)
    grown = simulate(controller, [0.4, -0.2], duration=4.0, certify=0)
    assert grown.stopped is not None or np.abs(grown.q[-1] - [0.5, -0.3]).max() > 0.1


def test_a_gain_beyond_one_tick_is_told_once(caplog):
    robot = load_robot("ur5")
    with caplog.at_level(logging.WARNING, logger="hqp"):
        for _ in range(3):
            Controller(robot, JointLimits() >> PositionTask([0.4, 0.2, 0.4], gain=150.0), dt=0.01, damping=None)
    assert told(caplog) == [
        "PositionTask 'position': gain = 150 1/s passes the target in every tick of 0.01 s and comes back; above 100 it"
        " is not reached sooner"
    ]
    with pytest.raises(InvalidInput, match="gain = 210 1/s makes the error grow"):
        Controller(robot, PositionTask([0.4, 0.2, 0.4], gain=[1.0, 210.0, 1.0]), dt=0.01, damping=None)


def test_where_nothing_limits_the_speed_it_is_told_once(caplog):
    free, limited = PlanarArm([0.5, 0.4]), PlanarArm([0.5, 0.4], velocity_limit=2.0)
    task = PositionTask([0.5, 0.2], gain=1.0)
    with caplog.at_level(logging.WARNING, logger="hqp"):
        for robot, stack in ((limited, task), (free, JointVelocityLimit(1.0) >> task)):
            Controller(robot, stack, dt=0.01, damping=None)
        assert not told(caplog)
        for _ in range(2):
            Controller(free, task, dt=0.01, damping=None)
    assert len(told(caplog)) == 1
    assert "nothing limits the speed of PlanarArm([0.5, 0.4])" in caplog.text
    assert "add JointVelocityLimit(2.0)" in caplog.text


# Zeros that mean something.


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_joint_without_speed_is_held(order):
    for robot in (
        PlanarArm([0.5, 0.4, 0.3], velocity_limit=[1.0, 0.0, 1.0], acceleration_limit=20.0, position_limit=(-2.0, 2.0)),
        PlanarArm([0.5, 0.4, 0.3], velocity_limit=1.0, acceleration_limit=20.0, position_limit=(-2.0, 2.0)),
    ):
        own = JointLimits(JointPositionLimit(), JointVelocityLimit([1.0, 0.0, 1.0]), JointAccelerationLimit())
        stack = (JointLimits() if robot.velocity_limit[1] == 0.0 else own) >> PositionTask([0.2, 0.6], gain=2.0)
        record = simulate(
            Controller(robot, stack, order=order, dt=0.01, damping=None), [0.4, 0.9, 0.6], duration=1.0, certify=20
        )
        assert record.certified_share == 1.0
        np.testing.assert_allclose(record.q[:, 1], 0.9, atol=1e-9)
        assert np.abs(record.q[-1] - record.q[0]).max() > 0.05
    panda = load_robot("panda", lock=["panda_finger_joint1"], velocity_limit={"panda_joint2": 0.0})
    step = Controller(panda, JointLimits() >> PositionTask([0.5, 0.3, 0.3], gain=2.0), dt=0.01, damping=None)(
        panda.home, np.zeros(7)
    )
    assert step.v[1] == pytest.approx(0.0, abs=1e-12)
    assert np.abs(step.v).max() > 0.1


def test_rows_without_weight_ask_for_nothing():
    """A weight of 0 is the task without that row; on robots whose rows are compiled as on others."""
    panda, arm = load_robot("panda", lock=["panda_finger_joint1"]), PlanarArm([0.5, 0.4, 0.3], velocity_limit=3.0)
    for robot, q, some, masked in (
        (
            panda,
            panda.home,
            PositionTask([0.5, 0.3, 0.3], gain=2.0, weight=[1.0, 0.0, 1.0]),
            PositionTask([0.5, 0.3], mask="xz", gain=2.0),
        ),
        (
            arm,
            np.array([0.4, 0.9, 0.6]),
            PositionTask([0.5, 0.3], gain=2.0, weight=[1.0, 0.0]),
            PositionTask([0.5], mask="x", gain=2.0),
        ),
    ):
        if robot is panda:
            masked = PositionTask([0.5, 0.3], mask="xz", gain=2.0)
            some = PositionTask([0.5, 9.0, 0.3], gain=2.0, weight=[1.0, 0.0, 1.0])
        rest = np.zeros(robot.nv)
        found, expected = (
            Controller(robot, JointLimits() >> task >> PostureTask(q + 0.1, gain=1.0), dt=0.01, damping=None)(q, rest)
            for task in (some, masked)
        )
        np.testing.assert_allclose(found.v, expected.v, atol=1e-8)
        assert found.solution.certify().ok
        nothing = Controller(
            robot, JointLimits() >> PositionTask([0.5] * some.rows, gain=2.0, weight=0.0), dt=0.01, damping=None
        )
        assert not nothing(q, rest).v.any()
    some = Controller(arm, PositionTask([2.0, 2.0], gain=2.0) + Damping([0.5, 0.0, 0.5]), dt=0.01, damping=None)
    assert some([0.4, 0.9, 0.6], np.zeros(3)).solution.certify().ok
    with pytest.raises(InvalidInput, match="must not be negative"):
        Damping([0.5, -0.1, 0.5])


# Frames that are asked for in vain.


@pytest.mark.parametrize("make", [AxisTask, LookAtTask])
def test_half_a_turn_is_left_the_way_that_the_joints_turn(tmp_path, make):
    """Also where they turn one way alone, whichever of the rows that is."""
    for axis in "1 0 0", "0 1 0", "0.6 0.8 0":
        path = write(tmp_path, *chain({"axis": axis, "rpy": "0 0 0", "at": "0 0 0", "kind": "continuous"}), links=2)
        robot = load_robot(path, tip="link1", velocity_limit=2.0)
        away = [0.0, 0.0, -1.0] if make is AxisTask else [0.0, 0.0, -5.0]
        task = make(away, gain=2.0)
        record = simulate(
            Controller(robot, JointLimits() >> task, dt=0.01, damping=None), robot.neutral, duration=4.0, certify=50
        )
        assert np.abs(record.errors[task.name][-1]).max() < 1e-2
    panda = load_robot("panda", lock=["panda_finger_joint1"])
    down = panda.at(panda.home, np.zeros(7)).frame().rotation[:, 2]
    task = AxisTask(-down, gain=2.0)
    step = Controller(panda, JointLimits() >> task, dt=0.01, damping=None)(panda.home, np.zeros(7))
    assert np.abs(step.v).max() > 0.1


def test_a_frame_relative_to_itself_is_refused():
    panda = load_robot("panda", lock=["panda_finger_joint1"])
    for task in (
        PositionTask([0, 0, 0], relative_to="panda_hand_tcp", gain=1.0),
        PoseTask(np.eye(4), frame="panda_link4", relative_to="panda_link4", gain=1.0),
        AtLeast(PositionTask([0], mask="z", frame="panda_link4", relative_to="panda_link4", gain=1.0)),
    ):
        with pytest.raises(InvalidInput, match="is the frame itself; name another one"):
            Controller(panda, task, dt=0.01, damping=None)


class Modelled:
    """A robot of one's own that has a model, of its own kind: one wheel on a rail."""

    nq = nv = 2
    model, position_limit, velocity_limit, acceleration_limit = "a drawing", None, np.full(2, 3.0), None

    def __init__(self):
        self._arm = PlanarArm([0.5, 0.4])

    def at(self, q, v):
        return self._arm.at(q, v)


def test_a_robot_of_ones_own_may_have_a_model():
    robot = Modelled()
    stack = JointVelocityLimit() >> PositionTask([0.5, 0.3], gain=2.0)
    expected = Controller(robot._arm, JointVelocityLimit(3.0) >> stack.levels[1][0], dt=0.01, damping=None)(
        [0.4, 0.9], [0.0, 0.0]
    ).v
    np.testing.assert_allclose(
        Controller(robot, stack, dt=0.01, damping=None)([0.4, 0.9], [0.0, 0.0]).v, expected, atol=1e-12
    )


# Changes.


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_limits_of_the_new_stack_hold_from_the_first_tick_of_a_change(order):
    """An old stack without an acceleration limit, gone over to one with: no command passes it, at any tick."""
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    reach, turn = PositionTask([0.5, -0.4, 0.3], gain=9.0), PositionTask([0.4, 0.4, 0.5], gain=9.0)
    old = JointLimits(JointVelocityLimit()) >> reach
    box = BoxLimit([-1.0, -1.0, 0.0], [1.0, 1.0, 1.0], gain=5.0)
    new = JointLimits(JointVelocityLimit(1.0), JointAccelerationLimit(20.0)) >> box >> turn
    controller = Controller(robot, old, order=order, dt=0.01, damping=None)
    q, v = robot.home, np.zeros(7)
    for k in range(60):
        if k == 10:
            controller.change(new, duration=0.3)
        step = controller(q, v, 0.01 * k)
        a = step.a if order == "acceleration" else (step.v - v) / 0.01
        if k >= 10:
            assert np.abs(a).max() <= 20.0 + 1e-6
        v = step.v if order == "velocity" else v + 0.01 * a
        q = robot.integrate(q, 0.01 * v)
    assert step.share == 1.0
    assert np.abs(v).max() <= 1.0 + 1e-6


def test_a_change_of_no_duration_is_made_at_once():
    robot = load_robot("ur5")
    first, second = PositionTask([0.4, 0.2, 0.4], gain=2.0), PositionTask([0.4, -0.2, 0.4], gain=2.0)
    controller = Controller(robot, JointLimits() >> first, dt=0.01, damping=None)
    rest = np.zeros(6)
    controller(robot.home, rest)
    controller.change(JointLimits() >> second, duration=0.0)
    step = controller(robot.home, rest, 0.01)
    assert step.share == 1.0
    expected = Controller(robot, JointLimits() >> second, dt=0.01, damping=None)(robot.home, rest).v
    np.testing.assert_allclose(step.v, expected, atol=1e-9)


# Bounds of frames, where joints brake by an acceleration limit.

ARM = PlanarArm([0.5, 0.4, 0.3], position_limit=(-2.6, 2.6))
START = np.array([0.4, 0.9, 0.6])
CENTRE = ARM.at(START, np.zeros(3)).frame().position[:2]


def bounds(gain):
    """Parts that bound the tip or the links, and by how much a configuration is beyond each [m]."""
    low, high = CENTRE - 0.15, CENTRE + 0.15
    ball = DistanceLimit(planar_links(ARM, 0.03), [Sphere([-0.1, 0.75, 0.0], 0.1)], margin=0.02, gain=gain)

    def tip(q):
        return ARM.at(q, np.zeros(3)).frame().position[:2]

    return {
        "box": (BoxLimit(low, high, gain=gain), lambda q: np.maximum(low - tip(q), tip(q) - high)),
        "plane": (PlaneLimit([1, 0, 0], CENTRE[0] - 0.1, gain=gain), lambda q: CENTRE[:1] - 0.1 - tip(q)[:1]),
        "height": (
            AtLeast(PositionTask([CENTRE[1] - 0.1], mask="y", gain=gain)),
            lambda q: CENTRE[1:] - 0.1 - tip(q)[1:],
        ),
        "distance": (ball, lambda q: 0.02 - ball.distances(ARM, ARM.at(q, np.zeros(3)))),
    }


def driven(limit, beyond, order, acceleration, dt, seed):
    """How far it is passed, and by how much at most a tick bends [m], while a hand leads to and fro beyond it."""
    rng, hand = np.random.default_rng(seed), Setpoint(CENTRE)
    joints = JointLimits(JointPositionLimit(), JointVelocityLimit(2.5), JointAccelerationLimit(acceleration))
    controller = Controller(ARM, joints >> limit >> PositionTask(hand, gain=10.0), order=order, dt=dt, damping=None)
    q, v, passed, bent = START, np.zeros(3), -np.inf, 0.0
    for k in range(int(2.0 / dt)):
        if k % int(0.5 / dt) == 0:
            hand.move(CENTRE + rng.uniform(-1.2, 1.2, 2))
        step, before = controller(q, v, k * dt), ARM.at(q, v)
        if order == "velocity":
            moved, v = dt * step.v, step.v
        else:
            moved, v = dt * v + 0.5 * dt**2 * step.a, v + dt * step.a
        q = q + moved
        frame, after = before.frame(), ARM.at(q, v).frame()
        bent = max(bent, float(np.linalg.norm(after.position - frame.position - frame.linear @ moved)))
        passed = max(passed, float(beyond(q).max()))
    return passed, bent


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("acceleration", [5.0, 15.0, 50.0])
@pytest.mark.parametrize("name", ["box", "plane", "height", "distance"])
def test_bounds_are_kept_however_hard_the_joints_may_brake(name, acceleration, order):
    """For every gain up to 1/dt: what is passed is what bends in the ticks, which a bound does not see."""
    dt = 0.01
    rate = min(1.0 / (2.5 / acceleration + dt), 1.0 / dt)
    for gain in 5.0, 1.0 / dt:
        limit, beyond = bounds(gain)[name]
        for seed in range(2):
            passed, bent = driven(limit, beyond, order, acceleration, dt, seed)
            assert passed <= 1e-6 + bent / (min(gain, rate) * dt)


def test_a_bound_without_a_speed_to_brake_from_is_told(caplog):
    stack = JointAccelerationLimit(9.0) >> PlaneLimit([1, 0, 0], 0.0, gain=5.0)
    with caplog.at_level(logging.WARNING, logger="hqp"):
        Controller(PlanarArm([0.5, 0.4], velocity_limit=3.0), stack, dt=0.01, damping=None)
    assert "no velocity limit says for how long; it may be passed; add JointVelocityLimit(2.0)" in caplog.text


def test_a_bound_that_moves_is_told_with_what_it_may_cost(caplog):
    joints = JointLimits(JointPositionLimit(), JointVelocityLimit(2.5), JointAccelerationLimit(5.0))
    hand = Setpoint([0.2])
    moving = AtLeast(PositionTask(hand, mask="y", gain=5.0))
    with caplog.at_level(logging.WARNING, logger="hqp"):
        Controller(ARM, joints >> bounds(5.0)["box"][0] >> bounds(5.0)["distance"][0], dt=0.01, damping=None)
        assert not told(caplog)
        for _ in range(2):
            Controller(ARM, joints >> moving, dt=0.01, damping=None)
        ball = Sphere(lambda t: (np.array([t, 1.0]), np.array([1.0, 0.0]), np.zeros(2)), 0.1)
        limit = DistanceLimit(planar_links(ARM, 0.03), [ball], margin=0.02, gain=5.0)
        Controller(ARM, joints >> limit, dt=0.01, damping=None)
    assert [message.split(":")[0] for message in told(caplog)] == [moving.full_name(), limit.full_name()]
    assert all("may be passed by up to 0.255 m" in message for message in told(caplog))
