"""A robot is what its file describes, or it is refused: names, ranges, bases, and what is no model file."""

from __future__ import annotations

import copy
import logging
import pickle
import re
import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest
from urdf_files import INERTIA, chain, joint, write

from hqp import InvalidInput
from tasks import (
    CenterOfMassTask,
    Controller,
    JointCouplingTask,
    JointLimits,
    JointPositionLimit,
    LinearHolonomicTask,
    MujocoPlant,
    PinocchioRobot,
    PositionTask,
    PostureTask,
    SelfCollisionLimit,
    available_robots,
    load_robot,
    simulate,
    solve_ik,
)

pytestmark = pytest.mark.usefixtures("nothing_told")


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
    assert Controller(robot, task, dt=0.01, damping=None)([0.2, 0.3], [0.0, 0.0]).ok
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
    record = simulate(
        Controller(robot, JointLimits() >> goal, order=order, dt=0.01, damping=None), robot.home, duration=0.5
    )
    assert record.certified_share == 1.0
    np.testing.assert_allclose(record.q[:, 0], 0.4, atol=1e-9)
    assert np.abs(record.q[-1, 1:]).max() > 0.1
    assert solve_ik(robot, goal, restarts=False).q[0] == pytest.approx(0.4, abs=1e-9)
    same = load_robot(path, position_limit={"joint1": (0.2, 0.2), "joint2": (0, 0)})
    np.testing.assert_array_equal(same.position_limit, [[0.4, 0.2, 0.0]] * 2)
    assert Controller(same, JointLimits() >> PostureTask([1, 1, 1.0], gain=1.0), dt=0.01, damping=None)(
        same.home, np.zeros(3)
    ).ok


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
        ({"velocity_limit": {"joint2": -1}}, "velocity limit of 'joint2' = -1.0 m/s must not be negative"),
        ({"acceleration_limit": {"joint0": np.inf}}, "acceleration limit of 'joint0' = inf rad/s.2 must be positive"),
        ({"torque_limit": {"joint2": -1}}, "torque limit of 'joint2' = -1.0 N must not be negative"),
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
        lambda: Controller(robot, JointPositionLimit(low, high), dt=0.01, damping=None),
        lambda: solve_ik(robot, JointPositionLimit(low, high) >> PositionTask([1, 1, 1.0], frame="link3", gain=1.0)),
    ):
        with pytest.raises(InvalidInput, match=said):
            refused()
    scalar = load_robot(path, position_limit=(-0.5, 0.5))  # all joints that have one
    others = [robot.joint_names.index(name) for name in ("joint0", "joint2")]
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(scalar.position_limit[0])), others)


@pytest.mark.parametrize("wrong", [[0.0, 0.0, 0.0, 0.0], [0.1, 2.5, 1.0, 0.2], [0.1, 1.0, 1e-2, 0.2]])
def test_a_posture_that_is_no_configuration_is_refused_by_fresh_and_live_controllers(tmp_path, wrong):
    """An angle in place of a cosine was read as another angle, and zeros as where the joint is."""
    robot = load_robot(write(tmp_path, *chain({}, {"kind": "continuous"}, {}), links=4))
    right = robot.configuration({"joint0": 0.1, "joint1": 2.5})
    said = "the cosine and sine of joint 'joint1', has norm"
    for task in (
        PostureTask(right, gain=1.0),
        PostureTask(right, joints=["joint1"], gain=1.0),
        LinearHolonomicTask([[1.0, 1.0, 0.0]], [0.2], q0=right, gain=1.0),
    ):
        name = "q0" if isinstance(task, LinearHolonomicTask) else "target"
        controller = Controller(robot, task, dt=0.01)
        before = controller(robot.home).v
        assert before[1] != 0.0
        with pytest.raises(InvalidInput, match=f"{name}: .*{said}"):
            setattr(task, name, wrong)
        assert np.array_equal(controller(robot.home).v, before)
        fresh = copy.deepcopy(task)
        setattr(fresh, name, wrong)
        with pytest.raises(InvalidInput, match=f"{name}: .*{said}"):
            Controller(robot, fresh, dt=0.01)
    with pytest.raises(InvalidInput, match=said):
        solve_ik(robot, PostureTask(wrong, gain=1.0))


def test_a_posture_leaves_the_numbers_of_the_base_aside(tmp_path):
    robot = load_robot(write(tmp_path, *chain({}, {}), links=3), base="floating")
    target = np.array([0.0] * 7 + [0.2, 0.3])
    v = Controller(robot, PostureTask(target, gain=1.0), dt=0.01)(robot.home).v
    np.testing.assert_allclose(v, [0.0] * 6 + [0.2, 0.3], atol=1e-12)


def test_home_is_moved_into_limits_by_hand():
    robot = load_robot("panda", lock=["panda_finger_joint1"], position_limit=(-0.5, 0.5))
    assert np.abs(robot.home).max() <= 0.5
    assert load_robot("panda", position_limit={"panda_joint4": (-1.0, -0.5)}).home[3] == -1.0


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
        Controller(
            load_robot(path, base="planar", acceleration_limit=9.0),
            JointLimits(),
            order="torque",
            dt=0.01,
            damping=None,
        )


@pytest.mark.parametrize("own", ["floating", "planar"])
@pytest.mark.parametrize("mounted", [False, True])
def test_the_base_that_is_asked_for_stands_in_place_of_that_of_the_file(tmp_path, own, mounted):
    """Not on it: a robot that was to be mounted flew away, and one that was to float had two bases."""
    names = ("world", "stand", "link0", "link1", "link2")
    below = [joint("mount", "world", "stand", kind="fixed", at="0 0 1")] if mounted else []
    carries = joint("free", "stand" if mounted else "world", "link0", kind=own)
    path = write(tmp_path, *below, carries, *chain({}, {}), links=names if mounted else (names[0], *names[2:]))
    sizes = {None: None, "fixed": (2, 2, 0), "planar": (6, 5, 3), "floating": (9, 8, 6)}
    sizes[None] = sizes[own]
    places = []
    for base, expected in sizes.items():
        robot = load_robot(path, base=base, tip="link2")
        assert (robot.nq, robot.nv, robot.base) == expected, base
        assert robot.joint_names[0] == (
            "free[0]" if base in (None, own) else "joint0" if base == "fixed" else "root_joint[0]"
        )
        assert robot.left_out == ((f"limits of {own} joint 'free'",) if base in (None, own) else ())
        places.append(robot.at(robot.neutral).frame().position)
    np.testing.assert_allclose(places, [places[0]] * 4, atol=1e-12)
    held = load_robot(path, base="fixed", tip="link2")
    record = simulate(
        Controller(held, JointLimits() >> PositionTask([9.0, 9.0, 9.0], gain=1.0), dt=0.01), held.home, duration=0.5
    )
    assert (
        np.linalg.norm(held.at(record.q[-1]).frame("link0").position - held.at(held.home).frame("link0").position)
        == 0.0
    )


def test_a_thing_that_floats_beside_other_joints_is_no_base(tmp_path):
    carried = joint("free", "link0", "link2", kind="floating")
    path = write(tmp_path, joint("joint0", "link0", "link1"), carried, links=3)
    assert "free[0]" in load_robot(path, base="fixed").joint_names
    assert load_robot(path, base="floating").nv == 6 + 1 + 6


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_planar_base_drives_and_keeps_its_limits(tmp_path, order):
    path = write(tmp_path, *chain({}, {}), links=3)
    robot = load_robot(path, base="planar", tip="link2", velocity_limit=1.5, acceleration_limit=10.0)
    stack = JointLimits() >> PositionTask([2.0, -1.0, 0.45], gain=2.0) >> PostureTask(robot.home, gain=1.0)
    record = simulate(
        Controller(robot, stack, order=order, dt=0.01, damping=None), robot.home, duration=6.0, certify=50
    )
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


LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
ONE = (
    '<link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
    f"<axis xyz='0 0 1'/>{LIMIT}</joint>"
)
NAME, WORLD = '"j"', '"universe"'
MASS = '<inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
KILOGRAMS = ONE.replace('<link name="b"/>', f'<link name="b">{MASS.format("5 kg")}</link>')
ISLAND = (
    '<link name="c"/><link name="d"/><joint name="k" type="fixed"><parent link="c"/><child link="d"/></joint>'
    '<joint name="l" type="fixed"><parent link="d"/><child link="c"/></joint>'
)
OPEN = '<robot name="a"'
#: A file, and why it is refused.
IGNORED = {
    "xacro of another name": (
        f'{OPEN} xmlns:xacro="http://wiki.ros.org/xacro">{ONE}<xacro:if/></robot>',
        "by xacro first",
    ),
    "a property": (f'<robot name="${{name}}">{ONE}</robot>', "by xacro first"),
    "an island": (f"{OPEN}>{ONE}{ISLAND}</robot>", "link 'c' is no part of the tree that begins with 'a'"),
    "no number of kilograms": (f"{OPEN}>{KILOGRAMS}</robot>", "is no valid URDF: .*(mass|nertia)"),
    "a capital": (f"{OPEN}>{ONE}<Joint/></robot>", "<Joint> in <robot> is not read; write <joint>"),
    "a group": (
        f"{OPEN}>{ONE}<group><link name='x'><inertial/></link></group></robot>",
        "<link> inside <group> is not read",
    ),
    "two ties": (f"{OPEN}>{ONE.replace(LIMIT, LIMIT + 2 * f'<mimic joint={NAME}/>')}</robot>", "has several"),
    "an attribute": (
        f"{OPEN}>{ONE.replace('lower', 'Lower')}</robot>",
        "'Lower' of <limit> of joint 'j' is not read; write 'lower'",
    ),
    "a joint of the world": (
        f"{OPEN}>{ONE.replace(NAME, WORLD)}</robot>",
        "joint 'universe' has the name of the",
    ),
}


@pytest.mark.parametrize("name", IGNORED)
def test_what_would_be_passed_over_in_silence_is_refused(tmp_path, name):
    text, said = IGNORED[name]
    path = tmp_path / "arm.urdf"
    path.write_text(text)
    with pytest.raises(InvalidInput, match=said):
        load_robot(path)


def test_what_is_left_out_of_a_urdf_is_said(tmp_path, caplog):
    path = write(tmp_path, *chain({}, {"kind": "planar"}), links=3)
    with caplog.at_level(logging.WARNING, logger="hqp"):
        robot = load_robot(path)
    assert robot.left_out == ("limits of planar joint 'joint1'",)
    assert "left out of the robot: limits of planar joint 'joint1'" in caplog.text


@pytest.mark.parametrize("ends", ["lower='-1'", "upper='6.28'", "lower='0' upper='0'"])
@pytest.mark.parametrize("soft", [False, True])
def test_a_range_of_a_joint_that_turns_without_end_is_not_dropped_in_silence(tmp_path, ends, soft):
    path = write(tmp_path, *chain({}, {"kind": "continuous"}, {}), links=4)
    bounds = f"<limit {'' if soft else ends} velocity='3' effort='9'/>"
    if soft:
        ends = ends.replace("er=", "er_limit=").replace("lower", "soft_lower").replace("upper", "soft_upper")
        bounds += f"<safety_controller {ends} k_velocity='1'/>"
    head, tail = path.read_text().split('<joint name="joint1"')
    path.write_text(f'{head}<joint name="joint1"' + re.sub("<limit [^>]*>", bounds, tail, count=1))
    robot = load_robot(path)
    told = "ranges of the continuous joints 'joint1' (a joint of type revolute has one)"
    assert robot.left_out == (() if "'0'" in ends else (told,))
    assert robot.position_limit[:, 1].tolist() == [-np.inf, np.inf]


MISSPELT = {
    "lower=": "lowr=",
    "<axis ": "<axes ",
    "<limit ": "<limits ",
    "<parent ": "<parnet ",
    "<mass ": "<maas ",
    "inertial>": "inertal>",
    "multiplier=": "multipler=",
    "rpy=": "quat_xyzw=",
    "ixx=": "lxx=",
}


@pytest.mark.parametrize("right", MISSPELT)
def test_what_is_misspelt_is_refused_and_not_left_at_its_default(tmp_path, right):
    path = write(tmp_path, *chain({}, {"mimic": ("joint0", 0.5, 0.0)}), links=3)
    path.write_text(path.read_text().replace(right, MISSPELT[right]))
    with pytest.raises(InvalidInput, match=r"is not read; (write|there may be)"):
        load_robot(path)


def test_what_is_not_read_in_a_joint_is_said(tmp_path):
    path = write(tmp_path, *chain({}, {}), links=3)
    path.write_text(path.read_text().replace("<limit ", "<soft/><limit jerk='3' "))
    assert load_robot(path).left_out == (
        "<soft> in joint 'joint0' and 1 more",
        "'jerk' of <limit> in joint 'joint0' and 1 more",
    )


@pytest.mark.parametrize("version", ["1.0", "1.2"])
def test_a_quaternion_turns_a_joint_or_is_refused(tmp_path, version):
    path = write(tmp_path, *chain({"rpy": "0 0 0"}, {"rpy": "0 0 0"}), links=3)
    text = path.read_text().replace('rpy="0 0 0"', 'quat_xyzw="0 0 1 0"', 1)
    path.write_text(text.replace('<robot name="arm">', f'<robot name="arm" version="{version}">'))
    if version == "1.0":
        with pytest.raises(InvalidInput, match="'quat_xyzw' of <origin> of joint 'joint0' is not read"):
            load_robot(path)
    else:
        assert np.allclose(load_robot(path).at(np.zeros(2)).frame("link1").rotation, np.diag([-1.0, -1.0, 1.0]))


def test_largest_speeds_and_efforts_of_zero_are_taken_to_be_none_and_told(tmp_path, caplog):
    path = write(tmp_path, *chain({}, {"speed": 0.0}), links=3)
    path.write_text(path.read_text().replace('effort="9"', 'effort="0.0"', 1))
    with caplog.at_level(logging.WARNING, logger="hqp"):
        robot = load_robot(path)
    assert robot.velocity_limit.tolist() == [3.0, np.inf]
    assert robot.torque_limit.tolist() == [np.inf, 9.0]
    assert "largest speed is 0 are taken to have none: joint1" in caplog.text
    assert "largest effort is 0 are taken to have none: joint0" in caplog.text


@pytest.mark.parametrize("moments", [(10.0, 1.0, 1.0), (-1.0, 1.0, 1.0)])
def test_inertias_that_no_body_has_are_told(tmp_path, caplog, moments):
    path = write(tmp_path, *chain({}, {}), links=3)
    wrong = INERTIA
    for key, value in zip(("ixx", "iyy", "izz"), moments, strict=True):
        wrong = wrong.replace(f'{key}="0.1"', f'{key}="{value}"')
    head, tail = path.read_text().split('<link name="link2">')
    path.write_text(f'{head}<link name="link2">{tail.replace(INERTIA, wrong)}'.replace('"arm"', f'"arm {moments[0]}"'))
    with caplog.at_level(logging.WARNING, logger="hqp"):
        load_robot(path)
    assert "no body has such an inertia, torques are not to be trusted, at the joints joint1" in caplog.text


@pytest.mark.parametrize("name", ["arm.urdf", "arm.xacro", "arm.urdf.xacro"])
def test_xacro_is_not_told_to_write_over_what_it_reads(tmp_path, name):
    path = write(tmp_path, *chain({"at": "${length} 0 0"}), links=2, name=name)
    with pytest.raises(InvalidInput, match="by xacro first") as refusal:
        load_robot(path)
    source, made = str(refusal.value).split("xacro first: xacro ")[1].split(" > ")
    assert source == name != made
    assert made.endswith(".urdf")


@pytest.mark.parametrize(
    "shape",
    ["<box size='0.1 0.1 0'/>", "<box size='-1 1 1'/>", "<sphere radius='-1'/>", "<cylinder radius='0.1' length='0'/>"],
)
def test_a_shape_without_a_size_is_refused(tmp_path, shape):
    path = write(tmp_path, *chain({}, {}, {}), links=4)
    path.write_text(path.read_text().replace("</link>", f"<collision><geometry>{shape}</geometry></collision></link>"))
    robot = load_robot(path)
    for use in robot.geometry, robot.with_capsules:
        with pytest.raises(InvalidInput, match="its sizes must be positive"):
            use()


@pytest.mark.parametrize("encoding", ["ISO-8859-1", "utf-16", "utf-8-sig"])
def test_names_in_every_encoding(tmp_path, encoding):
    head = "<?xml version='1.0' encoding='ISO-8859-1'?>" if encoding == "ISO-8859-1" else ""
    path = tmp_path / "bras.urdf"
    path.write_bytes(f"{head}<robot name='bras'>{ONE.replace(chr(34) + 'b', chr(34) + 'lié')}</robot>".encode(encoding))
    assert "lié" in load_robot(path).frame_names
    path.write_bytes(f"<robot name='bras'>{ONE.replace(chr(34) + 'b', chr(34) + 'lié')}</robot>".encode("latin-1"))
    with pytest.raises(InvalidInput, match="is not in utf-8; its first line is to name its encoding"):
        load_robot(path)


def test_odd_files_that_are_fine(tmp_path):
    path = tmp_path / "arm.urdf"
    for text in (
        f"<robot name='a' xmlns='http://example.org'>{ONE}</robot>",
        f"<robot name='a'>{ONE.replace(chr(34) + 'j' + chr(34), chr(34) + 'root_joint' + chr(34))}</robot>",
    ):
        path.write_text(text)
        for base in None, "planar", "floating":
            assert load_robot(path, base=base).nv == 1 + {None: 0, "planar": 3, "floating": 6}[base]


def test_what_is_no_part_of_the_robot_does_not_matter(tmp_path):
    """Colours, pictures, elements of others and text for them: with errors of their own, the robot is the same."""
    path = tmp_path / "arm.urdf"
    leaf = (
        '<link name="c"/><joint name="k" type="fixed"><parent link="b"/><child link="c"/><origin xyz="0 0 1"/></joint>'
    )
    for extra in (
        "<material name='m'/><material name='m'><color rgba='x'/></material>",
        "<gazebo><link name='x'><inertial/></link></gazebo>",
        "<transmission><joint name='j'><mimic/></joint></transmission>",
        "<loop_joint name='l'><link1 link='a'/></loop_joint><disable_collisions><link name='a'/></disable_collisions>",
        "<c:foo xmlns:c='http://c'><link name='z'><inertial/></link></c:foo>",
    ):
        path.write_text(f"{OPEN}>{ONE}{leaf}{extra}</robot>")
        robot = load_robot(path)
        assert (robot.joint_names, "c" in robot.frame_names) == (("j",), True)
    hidden = f"<gazebo><![CDATA[ <!-- ]]></gazebo>{leaf}<gazebo><![CDATA[ --> ]]></gazebo>"
    path.write_text(f"{OPEN}>{ONE}{hidden}</robot>")
    assert "c" in load_robot(path).frame_names
    path.write_text(f"{OPEN}>{ONE}{leaf.replace('<link ', '<link xmlns=' + NAME + ' ')}</robot>")
    assert load_robot(path).at([0.0], [0.0]).frame("c").position == pytest.approx([0.0, 0.0, 1.0])


def test_random_stays_in_ranges_with_one_end():
    robot = load_robot("ur5", position_limit={"elbow_joint": (4, np.inf), "wrist_1_joint": (-np.inf, -5)})
    for seed in range(20):
        q = robot.random(np.random.default_rng(seed))
        assert 4.0 <= q[2] <= 4.0 + 2 * np.pi
        assert -5.0 - 2 * np.pi <= q[3] <= -5.0


def test_dynamics_of_the_wrong_size_are_refused():
    robot = load_robot("ur5")
    for call in (
        lambda: robot.mass_matrix(np.zeros(5)),
        lambda: robot.bias(np.zeros(6), np.zeros(7)),
        lambda: robot.inverse_dynamics(np.zeros((2, 6)), np.zeros((3, 6)), np.zeros((2, 6))),
    ):
        with pytest.raises(InvalidInput, match=r"has shape .* takes"):
            call()


@pytest.mark.parametrize("source", ["a" * 5000, "a" * 5000 + ".urdf", "a/" * 5000, "a\0b.urdf"])
def test_names_that_no_file_can_have(source):
    with pytest.raises(InvalidInput, match=r"there is no file|unknown robot"):
        load_robot(source)


def test_options_of_wrong_types():
    class MjModel:
        """Not MuJoCo's."""

    for options, said in (
        ({"source": MjModel()}, "is a MjModel; it must be a name, a file or an MjModel"),
        ({"base": np.zeros(2)}, "base = array.*; it must be one of None, 'fixed'"),
        ({"mimic": np.zeros(2)}, "mimic = array.*; it must be one of 'lock'"),
        ({"tip": []}, r"tip = \[\] is a list; it must be a str"),
        ({"lock": [["j0"]]}, r"lock: \['j0'\] is a list; it must be the name of a joint"),
        ({"lock": b"panda"}, "lock = b'panda' is a bytes"),
        ({"lock": 3}, "lock = 3 is a int; it must be a list of joints"),
    ):
        with pytest.raises(InvalidInput, match=said):
            load_robot(**{"source": "panda", **options})


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
        Controller(robot, SelfCollisionLimit(margin=0.01, gain=1.0), dt=0.01, damping=None)
    assert capfd.readouterr().err == ""


def stl(path, *triangles):
    lines = ["solid flat"]
    for triangle in triangles:
        corners = "".join(f"vertex {' '.join(map(str, corner))}\n" for corner in triangle)
        lines.append(f"facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet")
    path.write_text("\n".join([*lines, "endsolid flat"]))


@pytest.mark.parametrize("count", [1, 2])
def test_a_mesh_without_volume_is_refused_and_crashes_nothing(tmp_path, count):
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(1, 0, 0), (1, 1, 0), (0, 1, 0)]
    stl(tmp_path / "flat.stl", *corners[:count])
    path = write(tmp_path, *chain({}, {}, {}), links=4)
    path.write_text(path.read_text().replace("</link>", f"{MESH.replace('package://arm/hand.stl', 'flat.stl')}</link>"))
    with pytest.raises(InvalidInput, match="is a mesh without volume; it must not be flat"):
        load_robot(path).geometry()


def test_a_shape_that_means_nothing_is_refused(tmp_path):
    path = write(tmp_path, *chain({}, {}, {}), links=4)
    nothing = "<collision><geometry><banana/></geometry></collision>"
    path.write_text(path.read_text().replace("</link>", f"{nothing}</link>", 1))
    with pytest.raises(InvalidInput, match=r"the collision shapes of .* cannot be read"):
        load_robot(path).geometry()


def test_shapes_of_a_file_by_any_name_and_with_shared_names(tmp_path):
    path = shared(tmp_path)
    box = "<collision><geometry><box size='0.1 0.1 0.1'/></geometry></collision>"
    other = tmp_path / "robot.xml"
    other.write_text(path.read_text().replace("</link>", f"{box}</link>"))
    for mimic in "lock", "follow", "free":
        assert len(load_robot(other, mimic=mimic).geometry().geometryObjects) == 4


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


def simple():
    model = pin.Model()
    for parent, name in enumerate(("one", "two")):
        index = model.addJoint(parent, pin.JointModelRX(), pin.SE3.Identity(), name)
        model.addJointFrame(index)
        model.appendBodyToJoint(index, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    return model


def no_parent(model):
    model.parents[2] = 9


def short_range(model):
    model.lowerPositionLimit = np.zeros(1)


def short_names(model):
    del model.names[2]


def odd_home(model):
    model.referenceConfigurations["home"] = np.zeros(5)


def nan_home(model):
    model.referenceConfigurations["home"] = np.full(2, np.nan)


def nan_gravity(model):
    model.gravity.linear = np.array([0.0, np.nan, 0.0])


def negative_speed(model):
    model.upperVelocityLimit[0] = -1.0


def empty_composite(model):
    model.addJoint(2, pin.JointModelComposite(), pin.SE3.Identity(), "nothing")


def lost_frame(model):
    model.frames[1].parentJoint = 9


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (no_parent, "joint 'two' has the parent 9; it must come before it"),
        (short_range, "lowerPositionLimit has 1 numbers; it must have 2"),
        (short_names, "names has 2 entries; there are 3 joints"),
        (odd_home, "configuration 'home' = .*; it must have 2 finite numbers"),
        (nan_home, "configuration 'home' = .*; it must have 2 finite numbers"),
        (nan_gravity, "gravity = .*; it must be finite"),
        (negative_speed, "largest speed of joint 'one' is -1.0; it must be positive"),
        (empty_composite, "joint 'nothing' is a Composite of no joints"),
        (lost_frame, "frame 'one' has the parent joint 9, which is none"),
    ],
)
def test_models_that_would_end_the_process_are_refused(spoil, said):
    model = simple()
    assert PinocchioRobot(model).nv == 2
    spoil(model)
    with pytest.raises(InvalidInput, match=said):
        PinocchioRobot(model)


def test_limits_that_differ_by_direction_are_told(caplog):
    model = simple()
    model.lowerVelocityLimit[:], model.upperVelocityLimit[:] = [-0.1, -9.0], [5.0, 2.0]
    with caplog.at_level(logging.WARNING, logger="hqp"):
        np.testing.assert_array_equal(PinocchioRobot(model).velocity_limit, [5.0, 2.0])
    assert "the upper limit counts for both directions, where the lower one is smaller: one" in caplog.text


def test_places_of_a_base_that_a_model_limits_are_told(caplog):
    model = pin.Model()
    index = model.addJoint(0, pin.JointModelPlanar(), pin.SE3.Identity(), "wheels")
    model.appendBodyToJoint(index, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    model.lowerPositionLimit[:2], model.upperPositionLimit[:2] = -0.3, 0.3
    with caplog.at_level(logging.WARNING, logger="hqp"):
        assert PinocchioRobot(model).position_limit is None
    assert "the places of bases are not limited, whatever the model says: wheels" in caplog.text


def test_a_screw_and_a_composite_are_no_joints_of_mujoco():
    pytest.importorskip("mujoco")
    whole = pin.JointModelComposite()
    whole.addJoint(pin.JointModelRX(), pin.SE3(np.eye(3), np.ones(3)))
    for joint_model in pin.JointModelHZ(0.1), whole:
        model = pin.Model()
        index = model.addJoint(0, joint_model, pin.SE3.Identity(), "screw")
        model.appendBodyToJoint(index, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
        with pytest.raises(InvalidInput, match=r"joint 'screw' .* must turn about one axis, or slide along it"):
            MujocoPlant(PinocchioRobot(model))


def test_a_centre_of_no_mass_is_refused():
    model = pin.Model()
    model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), "one")
    with pytest.raises(InvalidInput, match=r"nothing that .* moves has a mass; it has no centre"):
        Controller(PinocchioRobot(model), CenterOfMassTask([0, 0, 0.0], gain=1.0), dt=0.01, damping=None)


def test_factors_that_cancel_each_other_are_refused(tmp_path):
    robot = load_robot(write(tmp_path, *chain({}, {}), links=3))
    with pytest.raises(InvalidInput, match="cancel each other; name each joint once"):
        Controller(robot, JointCouplingTask({0: 1, "joint0": -1}, gain=1.0), dt=0.01, damping=None)


# All robots of the library.


def tick(name):
    robot = load_robot(name)
    frame = robot.tip or robot.frame_names[-1]
    place = robot.at(robot.home, np.zeros(robot.nv)).frame(frame).position
    goal = PositionTask(place + np.array([0.01, 0.01, 0.02]), frame=frame, gain=1.0) >> PostureTask(
        robot.home, gain=1.0
    )
    limited = robot.position_limit is not None or robot.velocity_limit is not None
    step = Controller(robot, JointLimits() >> goal if limited else goal, dt=0.01, damping=None)(
        robot.home, np.zeros(robot.nv)
    )
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
        "import sys; sys.path.insert(0, sys.argv[1]); import logging, tasks, hqp, numpy as np; logging.disable()\n"
        f"try: robot = tasks.load_robot({name!r}, base={base!r})\n"
        "except hqp.InvalidInput as refusal: sys.exit(print(refusal))\n"
        "frame = robot.frame_names[-1]\n"
        "task = tasks.PositionTask([0.1, 0.2, 0.3], frame=frame, gain=1.0)\n"
        "step = tasks.Controller(robot, task, dt=0.01)(robot.home, np.zeros(robot.nv))\n"
        "robot.at(robot.home, np.zeros(robot.nv)).center_of_mass\n"
    )
    done = subprocess.run([sys.executable, "-c", program, "."], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not [line for line in done.stderr.splitlines() if not line.startswith("hqp: ")]


@pytest.mark.parametrize("home", [[0.0], [[0.0, 0.0]], [np.nan, 0.0], "home", None])
def test_a_home_that_is_no_configuration_is_refused(tmp_path, home):
    robot = load_robot(write(tmp_path, *chain({}, {}), links=3))
    with pytest.raises(InvalidInput, match="home"):
        robot.home = home
    assert robot.home.tolist() == [0.0, 0.0]
    robot.home = [0.5, 7.0]
    assert robot.home.tolist() == [0.5, 1.0]
    robot.position_limit = (-0.2, 0.2)
    assert robot.home.tolist() == [0.2, 0.2]


@pytest.mark.parametrize("position", ["a", [0.1, 0.2], np.nan, None])
def test_a_joint_is_locked_at_a_number(tmp_path, position):
    path = write(tmp_path, *chain({}, {}), links=3)
    if position is None:
        assert load_robot(path, lock={"joint0": None}).joint_names == ("joint1",)
        return
    with pytest.raises(InvalidInput, match="lock of joint 'joint0'"):
        load_robot(path, lock={"joint0": position})


def test_a_torque_limit_of_a_follower_is_refused_as_it_would_have_no_effect(tmp_path):
    path = write(tmp_path, *chain({}, {"mimic": ("joint0", 0.5, 0.0)}), links=3)
    load_robot(path, mimic="free", torque_limit={"joint1": 0.5})
    with pytest.raises(InvalidInput, match="torque limit of joint 'joint1': it follows another"):
        load_robot(path, mimic="follow", torque_limit={"joint1": 0.5})
    with pytest.raises(InvalidInput, match="it is held"):
        load_robot(path, torque_limit={"joint1": 0.5})


def test_a_file_without_a_suffix_in_this_folder(tmp_path, monkeypatch):
    write(tmp_path, *chain({}, {}), links=3, name="robot_description")
    monkeypatch.chdir(tmp_path)
    assert load_robot("./robot_description").nv == 2
