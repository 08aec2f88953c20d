"""Robots of Pinocchio: the same tasks as on a planar arm, configurations on a manifold, files, and states that last."""

from __future__ import annotations

import copy
import logging
import pickle

import numpy as np
import pinocchio as pin
import pytest
from plain import from_states

import hqp
from tasks import (
    AtLeast,
    BoxLimit,
    CenterOfMassTask,
    Controller,
    FrameVelocityLimit,
    JointAccelerationLimit,
    JointLimits,
    JointPositionLimit,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PlaneTask,
    PoseTask,
    PositionTask,
    PostureTask,
    load_robot,
    simulate,
)

LENGTHS = (0.5, 0.4, 0.3)
LOWER, UPPER, V_MAX = (-2.0, -2.5, -2.2), (2.0, 2.5, 2.2), (1.0, 1.5, 2.0)


def joint(number, kind="revolute", extra=""):
    limits = f'<limit lower="{LOWER[number]}" upper="{UPPER[number]}" velocity="{V_MAX[number]}" effort="9"/>'
    at = LENGTHS[number - 1] if number else 0.0
    return (
        f'<joint name="joint{number}" type="{kind}"><parent link="link{number}"/><child link="link{number + 1}"/>'
        f'<origin xyz="{at} 0 0"/><axis xyz="0 0 1"/>{limits if kind != "continuous" else ""}{extra}</joint>'
    )


def link(number):
    inertia = '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>'
    mass = f'<origin xyz="0.2 0 0.1"/><mass value="{number + 1}"/>'
    return f'<link name="link{number}"><inertial>{mass}{inertia}</inertial></link>'


def urdf(folder, *joints, links=4):
    """A planar arm in the x-y plane: its first frame stands, the tip is at the end of its last link."""
    at = f'<parent link="link3"/><child link="tip"/><origin xyz="{LENGTHS[2]} 0 0"/>'
    tip = f'<joint name="end" type="fixed">{at}</joint>'
    parts = [*map(link, range(links)), *joints, '<link name="tip"/>', tip]
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="three links">{"".join(parts)}</robot>')
    return path


@pytest.fixture
def arm(tmp_path):
    return load_robot(urdf(tmp_path, *map(joint, range(3))), tip="tip")


PLANAR = PlanarArm(LENGTHS, position_limit=(LOWER, UPPER), velocity_limit=V_MAX)
Q = np.array([0.4, 0.9, 0.6])
STACKS = {
    "position, orientation": lambda: PositionTask([0.3, 0.6], gain=3.0) >> OrientationTask(2.4, gain=3.0),
    "orientation, position": lambda: OrientationTask(2.9, gain=2.0) >> PositionTask([0.1, 0.7], gain=3.0),
    "posture": lambda: PostureTask([0.2, -0.4, 1.0], gain=2.0),
    "some joints": lambda: PostureTask([1.0, -1.0], joints=[2, 0], gain=2.0) >> PositionTask([0.4, 0.1], gain=2.0),
    "limits": lambda: JointLimits() + JointAccelerationLimit(15.0) >> PositionTask([-1.5, 0.3], gain=8.0),
    "at least": lambda: AtLeast(PositionTask([0.1], mask="y", gain=4.0)) >> PositionTask([0.8, -0.5], gain=3.0),
    "box": lambda: BoxLimit([0.1, 0.0], [0.6, 0.9], gain=5.0) >> PositionTask([1.0, 1.0], gain=3.0),
    "plane and speed": lambda: (
        FrameVelocityLimit(0.2, mask="xy")
        >> PlaneTask([1, 1, 0], 0.5, gain=2.0) + PositionTask([0.3], mask="y", gain=1.0)
    ),
}


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("stack", STACKS)
def test_one_protocol(arm, stack, order):
    """The very same task objects bring a planar arm and a robot of Pinocchio to the same motion."""
    tasks = STACKS[stack]()
    planar, spatial = (
        simulate(Controller(robot, tasks, order=order, dt=0.01, damping=None), Q, duration=0.8, certify=0)
        for robot in (PLANAR, arm)
    )
    assert planar.stopped is None
    assert spatial.stopped is None
    np.testing.assert_allclose(spatial.q, planar.q, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(spatial.v, planar.v, rtol=0.0, atol=1e-9)
    for name, error in planar.errors.items():
        np.testing.assert_allclose(spatial.errors[name], error, atol=1e-9)
    assert np.abs(planar.q[-1] - Q).max() > 0.05


def test_limits_of_the_model(arm):
    np.testing.assert_array_equal(arm.position_limit, [LOWER, UPPER])
    np.testing.assert_array_equal(arm.velocity_limit, V_MAX)
    assert arm.acceleration_limit is None
    assert arm.joint_names == ("joint0", "joint1", "joint2")


def test_limits_given_stand_for_those_of_the_model(tmp_path):
    path = urdf(tmp_path, *map(joint, range(3)))
    arm = load_robot(path, position_limit=(-1, [1, 2, 3]), velocity_limit=4.0, acceleration_limit=[1, 2, 3])
    np.testing.assert_array_equal(arm.position_limit, [[-1, -1, -1], [1, 2, 3]])
    np.testing.assert_array_equal(arm.velocity_limit, [4, 4, 4])
    np.testing.assert_array_equal(arm.acceleration_limit, [1, 2, 3])
    assert arm.tip is None


def test_a_model_without_limits_has_none(tmp_path):
    robot = load_robot(urdf(tmp_path, *(joint(i, "continuous") for i in range(3))), tip="tip")
    assert (robot.nq, robot.nv) == (6, 3)  # each a point on a circle
    assert robot.position_limit is None
    assert robot.velocity_limit is None
    tasks = JointVelocityLimit(1.0) >> PositionTask([0.2, 0.6], gain=2.0)
    record = simulate(
        Controller(robot, tasks, dt=0.01, damping=None), robot.integrate(robot.neutral, Q), duration=0.5, certify=10
    )
    planar = simulate(Controller(PlanarArm(LENGTHS), tasks, dt=0.01, damping=None), Q, duration=0.5, certify=0)
    np.testing.assert_allclose(record.v, planar.v, atol=1e-9)
    np.testing.assert_allclose(np.hypot(record.q[:, ::2], record.q[:, 1::2]), 1.0, atol=1e-12)


def test_a_range_means_nothing_to_a_joint_without_end(tmp_path):
    robot = load_robot(urdf(tmp_path, joint(0, "continuous"), joint(1), joint(2)), tip="tip")
    limit = JointPositionLimit(0.5, 1.0)
    np.testing.assert_array_equal(limit.range(robot), [[-np.inf, 0.5, 0.5], [np.inf, 1.0, 1.0]])
    step = Controller(robot, limit, dt=0.01, damping=None)(robot.neutral, np.zeros(3))
    np.testing.assert_allclose(step.v, [0.0, 0.5, 0.5], atol=1e-12)  # the two that are outside come back


def test_an_mjcf_file(tmp_path):
    bodies = "".join(
        f'<body name="link{i + 1}" pos="{LENGTHS[i - 1] if i else 0} 0 0">'
        f'<joint name="joint{i}" type="hinge" axis="0 0 1" limited="true" range="{LOWER[i]} {UPPER[i]}"/>'
        f'<geom type="capsule" size="0.05" fromto="0 0 0 {LENGTHS[i]} 0 0"/>'
        for i in range(3)
    )
    tip = f'<body name="tip" pos="{LENGTHS[2]} 0 0"><geom size="0.01"/></body>'
    path = tmp_path / "arm.xml"
    path.write_text(f'<mujoco><compiler angle="radian"/><worldbody>{bodies}{tip}{"</body>" * 3}</worldbody></mujoco>')
    robot = load_robot(path, tip="tip")
    assert (robot.nq, robot.nv, robot.base) == (3, 3, 0)
    np.testing.assert_allclose(robot.position_limit, [LOWER, UPPER])
    np.testing.assert_allclose(robot.at(Q, np.zeros(3)).pose[:2], PlanarArm(LENGTHS).pose(Q)[:2], atol=1e-12)
    assert Controller(robot, JointPositionLimit() >> PositionTask([0.5, 0.5], gain=1.0), dt=0.01, damping=None)(
        Q, np.zeros(3)
    ).ok


def test_a_file_on_a_floating_base(tmp_path):
    robot = load_robot(urdf(tmp_path, *map(joint, range(3))), tip="tip", base="floating")
    assert (robot.nq, robot.nv, robot.base) == (10, 9, 6)
    assert robot.joint_names[5:7] == ("root_joint[5]", "joint0")
    np.testing.assert_array_equal(robot.position_limit[:, :6], [[-np.inf] * 6, [np.inf] * 6])
    goal = PoseTask([1.0, 2.0, 3.0], np.diag([1.0, -1.0, -1.0]), gain=3.0)
    record = simulate(
        Controller(robot, JointLimits() >> goal, dt=0.01, damping=None), robot.home, duration=4.0, certify=50
    )
    assert record.certified_share == 1.0
    np.testing.assert_allclose(record.pose[-1], [1, 2, 3, np.pi, 0, 0], atol=1e-4)


def test_a_quaternion_stays_one():
    robot = load_robot("g1")
    hand = PoseTask([0.4, -0.3, 1.0], np.eye(3), frame="right_rubber_hand", gain=3.0)
    feet = [
        PoseTask(seen.position, seen.rotation, frame=foot, gain=5.0, name=foot)
        for foot in ("left_ankle_roll_link", "right_ankle_roll_link")
        for seen in [robot.at(robot.home, np.zeros(robot.nv)).frame(foot)]
    ]
    stack = (
        JointLimits() >> feet[0] + feet[1] >> CenterOfMassTask([0, 0], mask="xy", relative_to=feet[0].frame, gain=1.0)
    )
    record = simulate(Controller(robot, stack >> hand, dt=0.01, damping=None), robot.home, duration=1.5, certify=25)
    assert record.stopped is None
    assert record.certified_share == 1.0
    np.testing.assert_allclose(np.linalg.norm(record.q[:, 3:7], axis=1), 1.0, atol=1e-12)
    assert np.abs(record.errors[feet[0].frame][-1]).max() < 1e-3
    assert np.abs(record.q[-1, :7] - record.q[0, :7]).max() > 0.01  # and the base did move


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_wheels_turn_on_and_on(order):
    robot = load_robot("tiago")
    wheels = np.array([i for i, name in enumerate(robot.joint_names) if name.startswith("wheel")])
    turning = np.zeros(robot.nv)
    turning[wheels] = [3.0, -2.0]

    class Roll(PostureTask):  # a speed, not a position
        def error(self, state, t):
            return np.zeros(robot.nv)

        def rates(self, state, t):
            return turning, 0.0

    record = simulate(
        Controller(
            robot,
            JointLimits(JointVelocityLimit()) >> Roll(robot.neutral, gain=5.0),
            order=order,
            dt=0.02,
            damping=None,
        ),
        robot.neutral,
        duration=4.0,
        certify=0,
    )
    steps = np.array([robot.difference(a, b) for a, b in zip(record.q, record.q[1:], strict=False)])
    mean = record.v[1:] if order == "velocity" else 0.5 * (record.v[1:] + record.v[:-1])
    np.testing.assert_allclose(steps, 0.02 * mean, atol=1e-9)  # no jump where the angle passes half a turn
    assert np.abs(steps[:, wheels].sum(axis=0)).min() > 2 * np.pi * 1.05
    assert np.isfinite(record.q).all()


# Joints that mimic others.


def tied(folder):
    extra = '<mimic joint="joint1" multiplier="-0.5" offset="0.2"/>'
    return urdf(folder, joint(0), joint(1), joint(2, extra=extra))


@pytest.mark.parametrize(("mimic", "size"), [("lock", 2), ("follow", 2), ("free", 3)])
def test_sizes_of_mimic(tmp_path, mimic, size):
    robot = load_robot(tied(tmp_path), tip="tip", mimic=mimic)
    assert (robot.nq, robot.nv, len(robot.joint_names), len(robot.velocity_limit)) == (size,) * 4
    assert robot.position_limit.shape == (2, size)
    assert Controller(robot, JointLimits() >> PositionTask([0.5, 0.5], gain=1.0), dt=0.01, damping=None)(
        Q[:size], np.zeros(size)
    ).ok


def derivatives(robot, q, v, frame, h=1e-6):
    """Linear and angular velocity and acceleration of a frame, and of the weight, at a = 0, by placements alone."""
    places = []
    for s in (-1, 0, 1):
        data = robot.model.createData()
        there = robot.integrate(q, s * 1e-4 * v), robot.integrate(q, s * h * v)
        com = [pin.centerOfMass(robot.model, data, x).copy() for x in there]
        pin.framesForwardKinematics(robot.model, data, there[0])
        coarse = data.oMf[robot.model.getFrameId(frame)].copy()
        pin.framesForwardKinematics(robot.model, data, there[1])
        places.append((data.oMf[robot.model.getFrameId(frame)].copy(), coarse, com))
    (a, A, ca), (_, M, cm), (b, B, cb) = places
    return (
        (b.translation - a.translation) / (2 * h),
        pin.log3(b.rotation @ a.rotation.T) / (2 * h),
        (B.translation - 2 * M.translation + A.translation) / 1e-8,
        (cb[1] - ca[1]) / (2 * h),
        (cb[0] - 2 * cm[0] + ca[0]) / 1e-8,
    )


@pytest.mark.parametrize("name", ["three links", "panda", "baxter"])
def test_joints_that_follow_are_in_the_jacobians(tmp_path, name):
    robot = load_robot(tied(tmp_path) if name == "three links" else name, mimic="follow")
    rng = np.random.default_rng(5)
    if name == "three links":
        place = robot.at([0.3, 0.8], [0.0, 0.0]).frame("tip").position
        np.testing.assert_allclose(place[:2], PlanarArm(LENGTHS).pose([0.3, 0.8, 0.2 - 0.4])[:2], atol=1e-12)
    for frame in robot.frame_names[1::3]:
        q, v = robot.random(rng), rng.uniform(-1.0, 1.0, robot.nv)
        state = robot.at(q, v)
        seen, weight = state.frame(frame), state.center_of_mass
        found = (seen.linear @ v, seen.angular @ v, seen.linear_drift, weight.linear @ v, weight.linear_drift)
        for mine, expected, tolerance in zip(
            found, derivatives(robot, q, v, frame), (1e-8, 1e-8, 1e-6, 1e-8, 1e-6), strict=True
        ):
            np.testing.assert_allclose(mine, expected, atol=tolerance, err_msg=frame)


def test_locked_joints_are_told_once(tmp_path, caplog, nothing_told):
    path = tied(tmp_path)
    with caplog.at_level(logging.WARNING, logger="hqp"):
        for _ in range(3):
            load_robot(path)
        assert [record.getMessage() for record in caplog.records] == [
            f"robot {str(path)!r}: joints that follow others are held: joint2"
        ]
        caplog.clear()
        load_robot(path, mimic="follow")
        load_robot(path, mimic="free")
    assert not caplog.records


def test_held_joints(tmp_path):
    path = urdf(tmp_path, *map(joint, range(3)))
    held = load_robot(path, lock={"joint1": 0.7}, tip="tip")
    assert held.joint_names == ("joint0", "joint2")
    np.testing.assert_allclose(
        held.at([0.2, 0.3], [0, 0]).pose[:2], PlanarArm(LENGTHS).pose([0.2, 0.7, 0.3])[:2], atol=1e-12
    )
    np.testing.assert_array_equal(held.velocity_limit, [V_MAX[0], V_MAX[2]])
    follows = load_robot(tied(tmp_path), mimic="free", lock=["joint2"])
    assert follows.joint_names == ("joint0", "joint1")


# Copies and states.

STACK = (
    JointLimits() >> PositionTask([0.4, 0.2, 0.5], gain=2.0) >> OrientationTask(np.diag([1.0, -1.0, -1.0]), gain=2.0)
)


def panda(**options):
    return load_robot("panda", lock=["panda_finger_joint1"], **options)


@pytest.mark.parametrize("copied", [lambda r: pickle.loads(pickle.dumps(r)), copy.copy, copy.deepcopy])
def test_copies_of_a_robot_move_alike(copied):
    robot = panda(acceleration_limit=15.0)
    q, v = robot.home, np.linspace(-0.3, 0.3, 7)
    state = robot.at(q, v)
    state.frame()  # with kinematics in its data
    other = copied(robot)
    assert other.data is not robot.data
    assert (other.name, other.tip, other.joint_names) == (robot.name, robot.tip, robot.joint_names)
    np.testing.assert_array_equal(other.home, robot.home)
    for order in ("velocity", "acceleration"):
        mine, theirs = (
            Controller(r, STACK, order=order, dt=0.01, damping=None)(q, v).solution.x for r in (robot, other)
        )
        np.testing.assert_array_equal(mine, theirs)


def numbers_of(state):
    seen = state.frame()
    weight = state.center_of_mass
    parts = [seen.position, seen.rotation, seen.linear, seen.angular, seen.linear_drift, seen.angular_drift]
    return np.concatenate([np.ravel(part) for part in [*parts, weight.position, weight.linear, weight.linear_drift]])


def test_a_state_answers_for_its_own_instant():
    """In whatever order states of one robot are asked, and whatever happens to the arrays they were made of."""
    robot, rng = panda(), np.random.default_rng(2)
    q, v = [robot.random(rng) for _ in range(6)], rng.uniform(-1, 1, (6, 7))
    expected = [numbers_of(panda().at(*pair)) for pair in zip(q, v, strict=True)]
    asks = [
        lambda state: state.frame().position,
        lambda state: state.frame("panda_link4").linear,
        lambda state: state.frame("panda_link4").linear_drift,
        lambda state: state.center_of_mass,
        lambda state: robot.inverse_dynamics(state.q, state.v, state.v),
    ]
    for _ in range(20):
        states = [robot.at(*pair) for pair in zip(q, v, strict=True)]
        for _ in range(30):
            asks[rng.integers(len(asks))](states[rng.integers(6)])
        for k in rng.permutation(6):
            np.testing.assert_array_equal(numbers_of(states[k]), expected[k])
    mine_q, mine_v = np.array(q[0]), np.array(v[0])
    state = robot.at(mine_q, mine_v)
    mine_q += 1.0
    mine_v += 1.0
    np.testing.assert_array_equal(numbers_of(state), expected[0])


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_two_controllers_may_share_a_robot(order):
    one = panda(acceleration_limit=15.0)
    stacks = (
        JointLimits() >> PositionTask([0.4, 0.2, 0.5], gain=2.0),
        JointLimits() >> CenterOfMassTask([0.1, 0.0], mask="xy", gain=1.0) >> PositionTask([0.6], mask="z", gain=2.0),
    )
    shared = [Controller(one, stack, order=order, dt=0.01, damping=None) for stack in stacks]
    own = [Controller(panda(acceleration_limit=15.0), stack, order=order, dt=0.01, damping=None) for stack in stacks]
    states = [[one.home, np.zeros(7)], [one.home + 0.1, np.zeros(7)]]
    for _ in range(30):
        for k, (q, v) in enumerate(states):
            x = shared[k](q, v).solution.x
            np.testing.assert_array_equal(x, own[k](q, v).solution.x)
            step = 0.01 * x if order == "velocity" else 0.01 * v + 0.5e-4 * x
            states[k] = [q + step, x if order == "velocity" else v + 0.01 * x]


@pytest.mark.parametrize("loops", [True, False])
def test_what_only_round_off_moves_is_left_alone(loops):
    """A robot that moves in a plane, asked to leave it: no joint is driven by the 1e-17 that a Jacobian has there."""
    robot = load_robot("borinot_flying_arm_2", base="planar", velocity_limit=2.0)
    frame, rest = robot.frame_names[-1], np.zeros(robot.nv)
    place = robot.at(robot.home, rest).frame(frame).position
    goal = PositionTask(place + np.array([0.01, 0.01, 0.02]), frame=frame, gain=1.0)
    stack = JointLimits() >> goal >> PostureTask(robot.home, gain=1.0)
    rows = stack.build(robot if loops else from_states(robot), "velocity", 0.01)
    solution = hqp.solve(rows.fill(robot.at(robot.home, rest), 0.0))
    assert solution.certify().ok
    assert np.abs(solution.x).max() < 0.1
