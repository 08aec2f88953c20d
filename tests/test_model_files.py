"""A robot is what its file describes, or it is refused: names, ties, ranges, and what is no model file."""

from __future__ import annotations

import logging
import pickle
import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest
from urdf_files import chain, joint, write

from hqp import InvalidInput
from tasks import (
    CenterOfMassTask,
    Controller,
    JointLimits,
    JointPositionLimit,
    PinocchioRobot,
    PoseTask,
    PositionTask,
    PostureTask,
    SelfCollisionLimit,
    available_robots,
    load_robot,
    simulate,
    solve_ik,
)
from tasks.robots import ranges


@pytest.fixture(autouse=True)
def nothing_told(monkeypatch):
    monkeypatch.setattr(ranges, "_TOLD", set())


# Joints that follow others.

TIES = {
    "plain": ([{}, {}, {"mimic": ("joint1", -0.5, 0.2)}], {"joint2": ("joint1", -0.5, 0.2)}),
    "a slide follows a hinge": (
        [{}, {}, {"kind": "prismatic", "mimic": ("joint0", 0.1, 0.05)}],
        {"joint2": ("joint0", 0.1, 0.05)},
    ),
    "the leader comes later": ([{"mimic": ("joint2", 0.5, 0.1)}, {}, {}], {"joint0": ("joint2", 0.5, 0.1)}),
    "a chain": (
        [{}, {"mimic": ("joint0", 0.5, 0.1)}, {"mimic": ("joint1", -2.0, 0.3)}],
        {"joint1": ("joint0", 0.5, 0.1), "joint2": ("joint0", -1.0, 0.1)},
    ),
    "two followers, one before": (
        [{"mimic": ("joint1", -1.0, 0.0)}, {}, {"mimic": ("joint1", 0.25, -0.1)}],
        {"joint0": ("joint1", -1.0, 0.0), "joint2": ("joint1", 0.25, -0.1)},
    ),
    "a leader that is fixed": ([{}, {"kind": "fixed"}, {"mimic": ("joint1", 2.0, 0.3)}], {"joint2": (None, 0.0, 0.3)}),
    "a factor of zero": ([{}, {}, {"mimic": ("joint1", 0.0, 0.3)}], {"joint2": (None, 0.0, 0.3)}),
    "both without end": (
        [{}, {"kind": "continuous"}, {"kind": "continuous", "mimic": ("joint1", -0.5, 0.1)}],
        {"joint2": ("joint1", -0.5, 0.1)},
    ),
    "a range follows what has no end": (
        [{}, {"kind": "continuous"}, {"mimic": ("joint1", 0.25, 0.1)}],
        {"joint2": ("joint1", 0.25, 0.1)},
    ),
}


def tied(tmp_path, name, **options):
    parts, ties = TIES[name]
    path = write(tmp_path, *chain(*parts), links=4)
    return load_robot(path, tip="link3", **options), load_robot(path, tip="link3", mimic="free"), ties


def unfolded(follows, free, ties, q):
    """The joints of a robot with ties, each on its own, by the words of the file."""
    known = {name: float(value) for name, value, _, _ in follows.describe(q)}
    for _ in range(3):  # a leader may be known by its follower
        for follower, (leader, factor, offset) in ties.items():
            if leader is None:
                known[follower] = offset
            elif leader in known:
                known[follower] = factor * known[leader] + offset
            elif follower in known:
                known[leader] = (known[follower] - offset) / factor
    whole = pin.neutral(free.model)
    for name, value in known.items():
        own = free.model.joints[free.model.getJointId(name)]
        whole[own.idx_q : own.idx_q + own.nq] = value if own.nq == 1 else [np.cos(value), np.sin(value)]
    return known, whole


@pytest.mark.parametrize("name", TIES)
def test_followers_are_where_the_file_says(tmp_path, name):
    follows, free, ties = tied(tmp_path, name, mimic="follow")
    rng = np.random.default_rng(3)
    for _ in range(5):
        q = follows.random(rng)
        _, whole = unfolded(follows, free, ties, q)
        here, there = follows.at(q, np.zeros(follows.nv)), free.at(whole, np.zeros(free.nv))
        for frame in "link1", "link2", "link3":
            np.testing.assert_allclose(here.frame(frame).position, there.frame(frame).position, atol=1e-12)
            np.testing.assert_allclose(here.frame(frame).rotation, there.frame(frame).rotation, atol=1e-12)
        assert here.center_of_mass.position == pytest.approx(there.center_of_mass.position, abs=1e-12)


@pytest.mark.parametrize("mimic", ["follow", "lock"])
@pytest.mark.parametrize("name", TIES)
def test_neither_leader_nor_follower_leaves_its_range(tmp_path, name, mimic):
    robot, free, ties = tied(tmp_path, name, mimic=mimic)
    if mimic == "lock":
        assert not set(ties) & set(robot.joint_names)
    for way in 1.0, -1.0:
        goal = PostureTask(robot.integrate(robot.neutral, np.full(robot.nv, 9.0 * way)), gain=2.0)
        record = simulate(Controller(robot, JointLimits() >> goal, dt=0.02), robot.home, duration=3.0, certify=50)
        assert record.stopped is None
        assert record.certified_share == 1.0
        found = [*record.q[::10], record.q[-1], solve_ik(robot, goal, restarts=False, iterations=60).q]
        speeds = np.abs(record.v).max(axis=0)
        for q in found:
            if mimic == "follow":
                known, _ = unfolded(robot, free, ties, q)
                for joint_name, value in known.items():
                    low, high = free.position_limit[:, free.joint_names.index(joint_name)]
                    assert low - 1e-9 <= value <= high + 1e-9, joint_name
        for follower, (leader, factor, _) in ties.items():
            for one, other, share in (leader, follower, abs(factor)), (follower, leader, 1.0 / (abs(factor) or 1.0)):
                if one in robot.joint_names and other in free.joint_names:
                    own = speeds[robot.joint_names.index(one)] * share
                    assert own <= free.velocity_limit[free.joint_names.index(other)] + 1e-9


@pytest.mark.parametrize("name", TIES)
def test_held_followers_stand_where_their_leader_does(tmp_path, name):
    held, free, ties = tied(tmp_path, name, mimic="lock")
    q = held.configuration({name: 0.1 for name in held.joint_names if name in ("joint0",)} if len(ties) < 2 else {})
    _, whole = unfolded(held, free, {}, q)
    neutral = {name: 0.0 for name in free.joint_names if name not in held.joint_names}
    for follower, (leader, factor, offset) in ties.items():
        rest = next((value for joint_name, value, *_ in held.describe(held.neutral) if joint_name == leader), 0.0)
        neutral[follower] = offset if leader is None else factor * rest + offset
    for joint_name, value in neutral.items():
        own = free.model.joints[free.model.getJointId(joint_name)]
        whole[own.idx_q : own.idx_q + own.nq] = value if own.nq == 1 else [np.cos(value), np.sin(value)]
    here, there = (robot.at(x, np.zeros(robot.nv)).frame() for robot, x in ((held, q), (free, whole)))
    np.testing.assert_allclose(here.position, there.position, atol=1e-12)


@pytest.mark.parametrize("name", TIES)
def test_compiled_rows_know_followers(tmp_path, name):
    """The rows that a kernel writes from Pinocchio's columns are those that Python writes from frames."""
    robot, *_ = tied(tmp_path, name, mimic="follow")
    rng = np.random.default_rng(5)
    stack = (
        JointLimits()
        >> PoseTask([0.1, 0.2, 0.3], np.eye(3), gain=2.0)
        >> CenterOfMassTask([0.0, 0.1, 0.2], gain=1.0)
        >> PositionTask([0.1, 0.2, 0.3], frame="link2", gain=2.0)
    )
    fast, slow = (stack.build(robot, "velocity", 0.01, compiled=compiled) for compiled in (True, False))
    assert fast.compiled
    for _ in range(4):
        state = robot.at(robot.random(rng), rng.uniform(-1.0, 1.0, robot.nv))
        for rows in fast, slow:
            rows.fill(state, 0.0)
        np.testing.assert_allclose(fast.hierarchy.dense(), slow.hierarchy.dense(), atol=1e-12)
        np.testing.assert_allclose(fast.hierarchy.lower, slow.hierarchy.lower, atol=1e-12)


def test_a_joint_of_a_tie_that_is_locked_takes_the_others_with_it(tmp_path):
    path = write(tmp_path, *chain(*TIES["plain"][0]), links=4)
    free = load_robot(path, tip="link3", mimic="free")
    for lock in {"joint1": 0.4}, {"joint2": 0.0}, {"joint1": 0.4, "joint2": 0.0}:
        robot = load_robot(path, tip="link3", mimic="follow", lock=lock)
        assert robot.joint_names == ("joint0",)
        place = free.at([0.3, 0.4, 0.0], np.zeros(3)).frame().position
        np.testing.assert_allclose(robot.at([0.3], [0.0]).frame().position, place, atol=1e-12)
    with pytest.raises(InvalidInput, match=r"lock holds 'joint2' at 0\.5; as it follows 'joint1', it must be 0"):
        load_robot(path, mimic="follow", lock={"joint1": 0.4, "joint2": 0.5})


REFUSED_TIES = {
    "missing": ([{}, {"mimic": ("nobody", 1.0, 0.0)}], "'joint1' follows 'nobody', and 'nobody' is no joint"),
    "itself": ([{}, {"mimic": ("joint1", 1.0, 0.0)}], "'joint1' follows itself"),
    "in a circle": (
        [{"mimic": ("joint1", 1.0, 0.0)}, {"mimic": ("joint0", 1.0, 0.0)}],
        "follows itself, by 'joint0' and 'joint1'",
    ),
    "no range left": (
        [{}, {"mimic": ("joint0", 1.0, 5.0)}],
        "'joint1' follows 'joint0', and the ranges of both leave it no",
    ),
    "no number": ([{}, {"mimic": ("joint0", "x", 0.0)}], "mimic of joint 'joint1': multiplier = 'x' must be a finite"),
    "a base": (
        [{"kind": "floating"}, {"mimic": ("joint0", 1.0, 0.0)}],
        "'joint1' follows 'joint0'; 'joint0' must have one position",
    ),
}


@pytest.mark.parametrize("name", REFUSED_TIES)
def test_ties_that_mean_nothing(tmp_path, name):
    parts, said = REFUSED_TIES[name]
    path = write(tmp_path, *chain(*parts), links=3)
    for mimic in "lock", "follow":
        with pytest.raises(InvalidInput, match=said):
            load_robot(path, mimic=mimic)
    if name == "missing":
        assert load_robot(path, lock={"joint1": 0.2}).joint_names == ("joint0",)
    if name not in ("no number", "itself"):
        assert load_robot(path, mimic="free").nv >= 2


# Names.


def shared(tmp_path):
    """A joint, and the link that it moves, of one name; and one that follows it."""
    return write(
        tmp_path,
        joint("gripper", "base", "gripper", at="1 0 0"),
        joint("finger", "gripper", "tip", at="0.5 0 0", mimic=("gripper", 0.5, 0.1)),
        joint("tip", "tip", "end", kind="fixed", at="0 2 0"),
        links=("base", "gripper", "tip", "end"),
    )


def test_a_plain_name_means_the_link_and_the_joint_is_asked_for_by_kind(tmp_path):
    robot = load_robot(shared(tmp_path), mimic="free")
    state = robot.at([0.2, 0.3], [0.0, 0.0])
    link, end = state.frame("tip"), state.frame("end")
    assert state.frame("body:tip").position == pytest.approx(link.position)
    assert state.frame("joint:tip").position == pytest.approx(end.position)  # a fixed joint, where its child is
    assert np.linalg.norm(end.position - link.position) == pytest.approx(2.0)
    assert state.frame("joint:gripper").position == pytest.approx(state.frame("gripper").position)
    task = PositionTask([0.0, 0.0, 0.0], frame="joint:tip", gain=1.0)
    assert Controller(robot, task, dt=0.01)([0.2, 0.3], [0.0, 0.0]).ok
    with pytest.raises(InvalidInput, match=r"'joint:grip' is no frame of .*did you mean"):
        state.frame("joint:grip")


@pytest.mark.parametrize("mimic", ["lock", "follow", "free"])
def test_holding_and_tying_joints_that_share_their_names_with_links(tmp_path, mimic):
    robot = load_robot(shared(tmp_path), mimic=mimic)
    assert robot.joint_names == (("gripper", "finger") if mimic == "free" else ("gripper",))
    held = load_robot(shared(tmp_path), mimic="free", lock={"gripper": 0.2})
    assert held.joint_names == ("finger",)
    place = load_robot(shared(tmp_path), mimic="free").at([0.2, 0.3], [0.0, 0.0]).frame("end").position
    np.testing.assert_allclose(held.at([0.3], [0.0]).frame("end").position, place, atol=1e-12)


# Ranges.


def test_ranges_from_zero_to_zero_are_taken_to_be_none_and_told_once(tmp_path, caplog):
    path = write(tmp_path, *chain({"lower": 0, "upper": 0}, {}, {"lower": 0, "upper": 0, "kind": "prismatic"}), links=4)
    with caplog.at_level(logging.WARNING, logger="hqp"):
        robots = [load_robot(path) for _ in range(3)]
        told = [record.getMessage() for record in caplog.records]
    assert told == [f"robot {str(path)!r}: joints whose range is from 0 to 0 are taken to have none: joint0, joint2"]
    np.testing.assert_array_equal(robots[0].position_limit, [[-np.inf, -1, -np.inf], [np.inf, 1, np.inf]])
    wrapped = PinocchioRobot(pin.buildModelFromUrdf(str(path)))
    np.testing.assert_array_equal(wrapped.position_limit, robots[0].position_limit)
    assert wrapped.model.lowerPositionLimit[0] == 0.0, "the model of a user is left as it is"


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_joint_with_equal_ends_is_held_there(tmp_path, order):
    path = write(tmp_path, *chain({"lower": 0.4, "upper": 0.4}, {}, {}), links=4)
    robot = load_robot(path, tip="link3", acceleration_limit=20.0)
    goal = PositionTask([9.0, 9.0, 9.0], gain=1.0)
    record = simulate(Controller(robot, JointLimits() >> goal, order=order, dt=0.01), robot.home, duration=0.5)
    assert record.certified_share == 1.0
    np.testing.assert_allclose(record.q[:, 0], 0.4, atol=1e-9)
    assert np.abs(record.q[-1, 1:]).max() > 0.1
    assert solve_ik(robot, goal, restarts=False).q[0] == pytest.approx(0.4, abs=1e-9)
    same = load_robot(path, position_limit={"joint1": (0.2, 0.2), "joint2": (0, 0)})
    np.testing.assert_array_equal(same.position_limit, [[0.4, 0.2, 0.0]] * 2)
    assert Controller(same, JointLimits() >> PostureTask([1, 1, 1.0], gain=1.0), dt=0.01)(same.home, np.zeros(3)).ok


def test_a_dict_changes_the_joints_that_it_names(tmp_path):
    path = write(tmp_path, *chain({}, {}, {"kind": "prismatic"}), links=4)
    robot = load_robot(
        path,
        position_limit={"joint1": (-0.2, np.inf)},
        velocity_limit={"joint2": 0.5},
        acceleration_limit={"joint0": 7.0},
        torque_limit={"joint1": 4.0},
    )
    np.testing.assert_array_equal(robot.position_limit, [[-1.0, -0.2, -1.0], [1.0, np.inf, 1.0]])
    np.testing.assert_array_equal(robot.velocity_limit, [3.0, 3.0, 0.5])
    np.testing.assert_array_equal(robot.acceleration_limit, [7.0, np.inf, np.inf])
    np.testing.assert_array_equal(robot.torque_limit, [9.0, 4.0, 9.0])
    for options, said in (
        ({"position_limit": {"joint9": (0, 1)}}, "position limit of joint 'joint9' is no joint of the robot; did you"),
        ({"position_limit": {"joint1": (1, 0)}}, "position limit of 'joint1': joint 'joint1' from 1 to 0 rad; the low"),
        ({"position_limit": {"joint1": 3}}, "position limit of 'joint1' = 3 must be a pair"),
        ({"position_limit": {"joint1": (np.nan, 1)}}, "'joint1' from nan to 1 rad"),
        ({"velocity_limit": {"joint2": -1}}, "velocity limit of 'joint2' = -1.0 m/s must be positive"),
        ({"acceleration_limit": {"joint0": np.inf}}, "acceleration limit of 'joint0' = inf rad/s.2 must be positive"),
        ({"torque_limit": {"joint2": 0}}, "torque limit of 'joint2' = 0.0 N must be positive"),
    ):
        with pytest.raises(InvalidInput, match=said):
            load_robot(path, **options)


def test_positions_outside_a_range_are_refused(tmp_path):
    path = write(tmp_path, *chain({}, {"kind": "continuous"}, {"kind": "prismatic"}), links=4)
    robot = load_robot(path)
    assert robot.configuration({"joint1": np.pi / 2}) == pytest.approx([0.0, 0.0, 1.0, 0.0])
    assert load_robot(path, lock={"joint1": np.pi / 2}).nq == 2
    for refused in (
        lambda: robot.configuration({"joint0": 1.5}),
        lambda: load_robot(path, lock={"joint0": 1.5}),
        lambda: load_robot(path, lock={"joint2": -1.1}),
    ):
        with pytest.raises(InvalidInput, match=r"outside its range, -1 \.\. 1"):
            refused()
    assert load_robot(path, position_limit={"joint0": (-2, 2)}).configuration({"joint0": 1.5})[0] == 1.5


@pytest.mark.parametrize("kind", ["continuous", "planar", "floating"])
def test_a_range_without_a_position_is_refused_everywhere(tmp_path, kind):
    path = write(tmp_path, *chain({}, {"kind": kind}, {}), links=4)
    robot = load_robot(path)
    own = [name for name in robot.joint_names if name.startswith("joint1")]
    low, high = np.full(robot.nv, -0.5), np.full(robot.nv, 0.5)
    said = "position"
    for refused in (
        lambda: load_robot(path, position_limit={own[0]: (-0.5, 0.5)}),
        lambda: load_robot(path, position_limit=(low, high)),
        lambda: Controller(robot, JointPositionLimit(low, high), dt=0.01),
        lambda: solve_ik(robot, JointPositionLimit(low, high) >> PositionTask([1, 1, 1.0], frame="link3", gain=1.0)),
    ):
        with pytest.raises(InvalidInput, match=said):
            refused()
    scalar = load_robot(path, position_limit=(-0.5, 0.5))  # all joints that have one
    others = [robot.joint_names.index(name) for name in ("joint0", "joint2")]
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(scalar.position_limit[0])), others)


# Bases.


def test_bases(tmp_path):
    path = write(tmp_path, *chain({}, {}), links=3)
    sizes = {None: (2, 2, 0), "fixed": (2, 2, 0), "planar": (6, 5, 3), "floating": (9, 8, 6)}
    for base, expected in sizes.items():
        robot = load_robot(path, base=base)
        assert (robot.nq, robot.nv, robot.base) == expected
    assert load_robot(path, base="planar").joint_units == ("m", "m", "rad", "rad", "rad")
    assert load_robot("g1", base="fixed").base == 0
    with pytest.warns(DeprecationWarning, match="floating_base is now base='floating'"):
        assert load_robot(path, floating_base=True).base == 6
    with (
        pytest.warns(DeprecationWarning, match="floating_base"),
        pytest.raises(InvalidInput, match="floating_base = True, but base = 'fixed'"),
    ):
        load_robot(path, floating_base=True, base="fixed")
    with pytest.raises(InvalidInput, match="has a planar base, which no joint torque drives"):
        Controller(load_robot(path, base="planar", acceleration_limit=9.0), JointLimits(), order="torque", dt=0.01)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_planar_base_drives_and_keeps_its_limits(tmp_path, order):
    path = write(tmp_path, *chain({}, {}), links=3)
    robot = load_robot(path, base="planar", tip="link2", velocity_limit=1.5, acceleration_limit=10.0)
    stack = JointLimits() >> PositionTask([2.0, -1.0, 0.45], gain=2.0) >> PostureTask(robot.home, gain=1.0)
    record = simulate(Controller(robot, stack, order=order, dt=0.01), robot.home, duration=6.0, certify=50)
    assert record.certified_share == 1.0
    np.testing.assert_allclose(np.hypot(record.q[:, 2], record.q[:, 3]), 1.0, atol=1e-12)
    assert np.abs(record.v).max() <= 1.5 + 1e-9
    assert np.abs(record.q[:, 4:]).max() <= 1.0 + 1e-9
    tip = record.pose[-1]
    assert np.linalg.norm(tip[:2] - [2.0, -1.0]) < 0.01
    found = solve_ik(robot, PositionTask([0.3, 0.4, tip[2]], gain=1.0) >> PostureTask(robot.home, gain=1.0))
    assert found.reached


# What is no model, and who says so.

MESH = '<collision><geometry><mesh filename="package://arm/hand.stl"/></geometry></collision>'
XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
FILES = {
    "xacro": (
        "arm.urdf.xacro",
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm/></robot>',
        "xacro arm.ur",
    ),
    "broken": ("arm.urdf", "<robot><link></robot>", "is no valid XML: mismatched tag: line 1"),
    "cut": ("arm.xml", "<mujoco><worldbody>", "MuJoCo cannot read it"),
    "no XML": ("arm.urdf", "hello", "has no XML element; URDF begins with <robot>"),
    "binary": ("arm.urdf", "\0\1\2", "has no XML element"),
    "SDF": ("arm.sdf", "<sdf version='1.6'/>", "is SDF, which is not read; give a URDF or an MJCF"),
    "a part": ("part.xml", "<mujocoinclude/>", "is a part that others include"),
    "no parent": (
        "arm.urdf",
        '<robot name="a"><link name="l"/><joint name="j" type="fixed"/></robot>',
        "is no valid URDF",
    ),
    "two roots": ("arm.urdf", '<robot name="a"><link name="k"/><link name="l"/></robot>', "is no valid URDF: .*root"),
    "no joints": ("arm.urdf", '<robot name="a"><link name="l"/></robot>', "has 0 degrees of freedom"),
}


@pytest.mark.parametrize("name", FILES)
def test_files_that_are_no_robot_are_refused_in_one_line(tmp_path, capfd, name):
    file, text, said = FILES[name]
    path = tmp_path / file
    path.write_text(text)
    with pytest.raises(InvalidInput, match=said) as refusal:
        load_robot(path)
    assert "\n" not in str(refusal.value)
    assert str(path) in str(refusal.value)
    assert capfd.readouterr().err == "", "libraries print nothing by themselves"


@pytest.mark.parametrize(
    ("axis", "kind", "said"),
    [
        ("0 0 0", "revolute", "axis of joint 'joint1' is 0 0 0; it must have a direction"),
        ("1 0 0", "planar", "axis of planar joint 'joint1' is 1 0 0; only 0 0 1 is read"),
        ("0 0 -1", "planar", "only 0 0 1 is read"),
        ("0 nan 0", "prismatic", "is no valid URDF: Malformed axis"),
    ],
)
def test_axes_that_mean_nothing(tmp_path, axis, kind, said):
    path = write(tmp_path, *chain({}, {"axis": axis, "kind": kind}), links=3)
    with pytest.raises(InvalidInput, match=said):
        load_robot(path)


def test_folders_and_text(tmp_path):
    path = write(tmp_path, *chain({}, {}), links=3)
    with pytest.raises(InvalidInput, match=r"is a folder; name a file in it: 'arm\.urdf'"):
        load_robot(tmp_path)
    with pytest.raises(InvalidInput, match="is XML, and no name of a file; write it to one"):
        load_robot(path.read_text())
    with pytest.raises(InvalidInput, match="lock holds all joints; one must be left to move"):
        load_robot(path, lock=["joint0", "joint1"])


def test_the_language_is_told_by_the_file_and_not_by_its_name(tmp_path):
    joints = chain({}, {})
    odd = "<?xml version='1.0'?><!-- a -- b -->\n"
    for name, head in ("arm.URDF", ""), ("arm.xml", ""), ("arm.urdf.xacro", ""), ("arm.urdf", odd):
        robot = load_robot(write(tmp_path, *joints, links=3, name=name, head=head))
        assert robot.joint_names == ("joint0", "joint1")


def test_a_mesh_that_is_not_there_is_said_with_what_to_do(tmp_path, capfd):
    path = write(tmp_path, *chain({}, {}, {}), links=4)
    path.write_text(path.read_text().replace("</link>", f"{MESH}</link>"))
    robot = load_robot(path)  # which needs no mesh
    with pytest.raises(InvalidInput, match=r"hand\.stl.*is sought as a folder NAME beside the file"):
        Controller(robot, SelfCollisionLimit(margin=0.01, gain=1.0), dt=0.01)
    assert capfd.readouterr().err == ""


# Models that are handed over.


def test_a_model_that_moves_nothing_or_has_names_twice_is_refused():
    with pytest.raises(InvalidInput, match="0 degrees of freedom"):
        PinocchioRobot(pin.Model())
    model = pin.Model()
    for _ in range(2):
        model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), "twice")
    with pytest.raises(InvalidInput, match="joint 'twice' is there 2 times"):
        PinocchioRobot(model)
    model = pin.Model()
    model.addJoint(0, pin.JointModelRX(), pin.SE3(np.eye(3), np.array([0.0, np.nan, 0.0])), "nowhere")
    with pytest.raises(InvalidInput, match=r"joint 'nowhere' is placed at .*; the place must be finite"):
        PinocchioRobot(model)


# All robots of the library.


def tick(name):
    robot = load_robot(name)
    frame = robot.tip or robot.frame_names[-1]
    place = robot.at(robot.home, np.zeros(robot.nv)).frame(frame).position
    goal = PositionTask(place + np.array([0.01, 0.01, 0.02]), frame=frame, gain=1.0) >> PostureTask(
        robot.home, gain=1.0
    )
    limited = robot.position_limit is not None or robot.velocity_limit is not None
    step = Controller(robot, JointLimits() >> goal if limited else goal, dt=0.01)(robot.home, np.zeros(robot.nv))
    assert step.solution.certify().ok
    assert pickle.loads(pickle.dumps(robot)).joint_names == robot.joint_names


#: Refused for a reason that is their file's.
BROKEN = {
    "alex_psyonic_hands": "'Left_index_q2' follows 'index_q1', and 'index_q1' is no joint",
    "iris_simple": "0 degrees of freedom",
    "quadrotor_base": "0 degrees of freedom",
}


def test_every_robot_of_the_library_is_read_or_refused_for_a_reason():
    for name in available_robots():
        if name in BROKEN:
            with pytest.raises(InvalidInput, match=BROKEN[name]):
                load_robot(name)
        else:
            tick(name)


@pytest.mark.sweep
@pytest.mark.parametrize("base", [None, "fixed", "planar", "floating"])
@pytest.mark.parametrize("name", available_robots())
def test_no_robot_ends_its_process(name, base):
    """Each in a process of its own: a certified tick or one line of refusal, and never a crash."""
    program = (
        "import sys; sys.path.insert(0, sys.argv[1]); import tasks, hqp, numpy as np\n"
        f"try: robot = tasks.load_robot({name!r}, base={base!r})\n"
        "except hqp.InvalidInput as refusal: sys.exit(print(refusal))\n"
        "frame = robot.frame_names[-1]\n"
        "task = tasks.PositionTask([0.1, 0.2, 0.3], frame=frame, gain=1.0)\n"
        "step = tasks.Controller(robot, task, dt=0.01)(robot.home, np.zeros(robot.nv))\n"
        "robot.at(robot.home, np.zeros(robot.nv)).center_of_mass\n"
    )
    done = subprocess.run([sys.executable, "-c", program, "."], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not [line for line in done.stderr.splitlines() if not line.startswith(("robot ", "hqp: "))]
