"""Bad input of the robotics: refused where it is given, in words which name the thing and what is allowed."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from hqp import InvalidInput, Status
from tasks import (
    AtLeast,
    AtMost,
    AxisTask,
    BoxLimit,
    CenterOfMassTask,
    Controller,
    FrameVelocityLimit,
    JointCouplingTask,
    JointLimits,
    JointVelocityLimit,
    LookAtTask,
    OrientationTask,
    PlanarArm,
    PlaneLimit,
    PlaneTask,
    PoseTask,
    PositionTask,
    PostureTask,
    Within,
    load_robot,
    simulate,
)

PLANAR = PlanarArm([0.5, 0.4, 0.3])


@cache
def robot(name):
    return load_robot(name, lock=["panda_finger_joint1"] if name == "panda" else ())


def control(name, part, **options):
    return Controller(PLANAR if name == "planar" else robot(name), part, **options)


def position(target=(0.3, 0.0, 0.5), gain=1.0, **options):
    return PositionTask(target, gain=gain, **options)


@pytest.mark.parametrize(
    ("source", "options", "named"),
    [
        ("nowhere/arm.urdf", {}, "there is no file 'nowhere/arm.urdf'"),
        ("arm.xml", {}, "there is no file 'arm.xml'"),
        ("arm.sdf", {}, "there is no file 'arm.sdf'"),
        ("pandaa", {}, "unknown robot 'pandaa'; did you mean 'panda'"),
        ("", {}, "unknown robot ''; give a URDF or MJCF file, or one of panda, ur3"),
        (5, {}, "robot = 5 is a int; it must be a name, a file or an MjModel"),
        ("panda", {"tip": "panda_hnd"}, r"'panda_hnd' is no frame of .*did you mean 'panda_hand'"),
        ("panda", {"lock": ["panda_finger"]}, "'panda_finger' is no joint; did you mean 'panda_finger_joint"),
        ("panda", {"lock": "panda_joint1"}, "lock = 'panda_joint1' is a str; it must be a list of joints"),
        ("panda", {"lock": {"panda_joint1": np.nan}}, "lock of joint 'panda_joint1' = nan must be finite"),
        (
            "g1",
            {"lock": {"root_joint": 1.0}},
            "lock of joint 'root_joint': it has several axes, and can only be held at its neutral",
        ),
        ("panda", {"mimic": "no"}, "mimic = 'no'; it must be one of 'lock', 'follow', 'free'"),
        ("panda", {"base": "yes"}, "base = 'yes'; it must be one of None, 'fixed', 'planar', 'floating'"),
        ("panda", {"body": "panda_link0"}, r"body = \['panda_link0'\], but a URDF has one robot"),
        ("panda", {"body": 3}, "body = 3 must be the name of a body, or a list of names"),
        ("panda", {"velocity_limit": -1.0}, "'panda'.*velocity limit = -1.0 rad/s must not be negative"),
        (
            "panda",
            {"acceleration_limit": [1, 2]},
            r"acceleration limit has shape \(2,\); it must be one number, or \(8,\)",
        ),
        (
            "panda",
            {"position_limit": (1.0, -1.0)},
            "joint 'panda_joint1' from 1 to -1 rad; the lowest must not be above the highest",
        ),
    ],
)
def test_robots(source, options, named):
    with pytest.raises(InvalidInput, match=named):
        load_robot(source, **options)


JOINT = (
    '<robot name="arm"><link name="base"/><link name="link"/><joint name="elbow" type="revolute"><parent link="base"/>'
    '<child link="link"/><axis xyz="0 0 1"/><limit lower="{}" upper="{}" velocity="{}" effort="1"/></joint></robot>'
)


@pytest.mark.parametrize(
    ("suffix", "text", "named"),
    [
        (
            ".urdf",
            JOINT.format(2, -2, 1),
            "arm.urdf': the range of joint 'elbow' is from 2 to -2 rad; the lowest must not",
        ),
        (".urdf", "<robot><link", "arm.urdf' is no valid XML: unclosed token: line 1"),
        (".urdf", "", "arm.urdf' has no XML element; URDF begins with <robot>"),
        (".urdf", "<html/>", "arm.urdf' begins with <html>; URDF begins with <robot>, MJCF with <mujoco>"),
        (
            ".urdf",
            JOINT.format(-1, 1, 1).replace("revolute", "banana"),
            r"no valid URDF: Joint \[elbow\] has no known type",
        ),
        (".urdf", JOINT.format(-1, 1, -1), "arm.urdf' is no valid URDF: .*velocity"),
        (".xml", "<mujoco><worldbody>", "arm.xml': MuJoCo cannot read it: XML parse error"),
        (".xml", "<html/>", "arm.xml' begins with <html>"),
    ],
)
def test_files(tmp_path, suffix, text, named):
    path = tmp_path / f"arm{suffix}"
    path.write_text(text)
    with pytest.raises(InvalidInput, match=f"(?s){named}"):
        load_robot(path)


def test_a_speed_of_zero_in_a_file_means_that_nothing_is_known(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(JOINT.format(-1, 1, 0))
    arm = load_robot(path)
    assert arm.velocity_limit is None
    assert [limit.quantity for limit in JointLimits().of(arm)] == ["position"]


KNEE = ["left_knee_joint"]
NO_SINGLE = "has no single position; it turns without end, or is a part of a ball or of a floating or planar base"


@pytest.mark.parametrize(
    ("name", "make", "named"),
    [
        ("panda", lambda: position(frame="panda_hnd"), "frame 'panda_hnd' is no frame of .*'panda'.*'panda_hand'"),
        ("panda", lambda: position(relative_to="panda_hnd"), "relative_to 'panda_hnd' is no frame.*'panda_hand'"),
        (
            "panda",
            lambda: position(frame="left_sole_link"),
            "PositionTask 'position': frame 'left_sole_link' is no frame",
        ),
        (
            "planar",
            lambda: position([0, 0], frame="hand"),
            "'hand' is no frame of .*there are tip, link1, link2, link3",
        ),
        ("g1", lambda: position(name="hand"), "'hand': .*'g1'.* has no tip; give the task a frame, or the robot a tip"),
        ("g1", lambda: AxisTask([0, 0, 1], gain=1.0), "AxisTask 'axis': .* has no tip; give the task a frame"),
        ("g1", lambda: FrameVelocityLimit(1.0), "'speed': .* has no tip; give the task a frame"),
        ("g1", lambda: BoxLimit([0] * 3, [1] * 3, gain=1.0), "'box': .* has no tip; give the task a frame"),
        (
            "panda",
            lambda: PostureTask([0], joints=["panda_joint9"], gain=1.0),
            "'panda_joint9' is no joint.*'panda_joint",
        ),
        ("panda", lambda: PostureTask([0], joints=[9], gain=1.0), r"joint = 9; the robot has the joints 0 \.\. 6"),
        ("panda", lambda: PostureTask([0, 0], joints=[0, "panda_joint1"], gain=1.0), "names one twice"),
        ("panda", lambda: JointCouplingTask({"panda_joint9": 1}, gain=1.0), "'panda_joint9' is no joint.*'panda_joint"),
        ("tiago", lambda: PostureTask([0], joints=["wheel_right_joint"], gain=1.0), f"'wheel_right_joint' {NO_SINGLE}"),
        ("tiago", lambda: JointCouplingTask({"wheel_left_joint": 1}, gain=1.0), f"'wheel_left_joint' {NO_SINGLE}"),
        ("g1", lambda: PostureTask([0], joints=["root_joint[0]"], gain=1.0), rf"'root_joint\[0\]' {NO_SINGLE}"),
        ("g1", lambda: PostureTask([0] * 35, gain=1.0), r"target has shape \(35,\); the robot takes \(36,\)"),
        (
            "g1",
            lambda: PostureTask(lambda t: (np.zeros(36),) * 3, gain=1.0),
            r"takes trajectories of \(29,\): its 36 positions have 35 velocities; name the joints",
        ),
        ("panda", lambda: AtLeast(position(gain=101)), "AtLeast 'position': gain = 101 .* it must be at most 100"),
        ("panda", lambda: BoxLimit([0] * 3, [1] * 3, gain=200), "BoxLimit 'box': gain = 200 .* it must be at most 100"),
        ("panda", lambda: Within(position(), [1, 1]), r"Within 'position': below has shape \(2,\); .*\(3,\)"),
        ("planar", lambda: JointLimits(), "'joint limits': the robot has no limits of its own; give them: JointLimits"),
        ("planar", lambda: position(), "a planar arm has no z; give x and y"),
        ("planar", lambda: position(reference="local"), "a planar arm knows the axes of the world only"),
        ("planar", lambda: CenterOfMassTask([0, 0], gain=1.0), "does not tell its centre of mass"),
        ("planar", lambda: OrientationTask(np.eye(3), gain=1.0), "turns about z only; give one angle"),
        ("planar", lambda: AxisTask([0, 1, 0], gain=1.0), "turns about z only; give it an OrientationTask"),
        ("planar", lambda: LookAtTask([0, 1, 0], gain=1.0), "turns about z only; give it an OrientationTask"),
        ("planar", lambda: PlaneTask([0, 1, 0], 0, relative_to="link1", gain=1.0), "knows the axes of the world only"),
        ("planar", lambda: BoxLimit([0, 0], [1, 1], relative_to="link1", gain=1.0), "knows the axes of the world only"),
        ("planar", lambda: FrameVelocityLimit(1.0), "'speed': a planar arm has x, y and rz only"),
        ("planar", lambda: FrameVelocityLimit(1.0, mask="xy", relative_to="link1"), "knows the axes of the world only"),
        ("planar", lambda: FrameVelocityLimit(1.0, mask="xy", reference="local"), "knows the axes of the world only"),
    ],
)
def test_what_does_not_fit_the_robot(name, make, named):
    part = make()
    with pytest.raises(InvalidInput, match=named):
        control(name, part, dt=0.01)


def test_a_point_of_weight_needs_no_tip():
    """It has no frame: on a robot without a tip it may still be seen from a foot."""
    for relative_to in (None, "left_ankle_roll_link"):
        assert control("g1", CenterOfMassTask([0, 0, 0.5], relative_to=relative_to, gain=1.0)).hierarchy.n == 35


NAN = [0.0, np.nan, 0.0]


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: position(NAN), r"PositionTask 'position': target\[1\] = nan must be finite"),
        (
            lambda: OrientationTask(np.full((3, 3), np.nan), gain=1),
            r"OrientationTask 'orientation': target\[0, 0\] = nan",
        ),
        (lambda: OrientationTask(np.nan, gain=1), "target = nan must be finite"),
        (lambda: PoseTask(NAN, np.eye(3), gain=1), r"PoseTask 'pose', position: target\[1\] = nan"),
        (lambda: PoseTask([0, 0, 0], np.eye(3) * np.nan, gain=1), r"PoseTask 'pose', rotation: target\[0, 0\] = nan"),
        (lambda: AxisTask(NAN, gain=1), r"AxisTask 'axis': target\[1\] = nan"),
        (lambda: LookAtTask(NAN, gain=1), r"LookAtTask 'lookat': target\[1\] = nan"),
        (lambda: PlaneTask([0, 0, 1], np.nan, gain=1), "PlaneTask 'plane': target = nan"),
        (lambda: PlaneTask(NAN, 1, gain=1), r"PlaneTask 'plane': normal\[1\] = nan"),
        (lambda: CenterOfMassTask(NAN, gain=1), r"'center of mass': target\[1\] = nan"),
        (lambda: PostureTask(NAN, gain=1), r"PostureTask 'posture': target\[1\] = nan"),
        (lambda: JointCouplingTask({0: 1}, np.nan, gain=1), "JointCouplingTask 'jointcoupling': target = nan"),
        (lambda: JointCouplingTask({0: np.nan}, gain=1), "factor of 0 = nan must be finite"),
        (lambda: OrientationTask(np.ones((3, 3)), gain=1), r"is no rotation: R\^T R differs from the identity by 3"),
        (lambda: OrientationTask(-np.eye(3), gain=1), "is a reflection, not a rotation"),
        (lambda: position(frame=3), "frame = 3 is a int; it must be a str"),
        (lambda: position(reference="tool"), "reference = 'tool'; it must be one of 'world', 'local'"),
        (lambda: position(mask="q"), "mask = 'q'; it must name some of x, y, z, each once"),
        (lambda: position(mask="xx"), "mask = 'xx'; it must name some of x, y, z, each once"),
        (lambda: position(mask=""), "mask = ''; it must name some of x, y, z"),
        (lambda: position(mask=5), r"mask = \[5\]; it must say True or False of x, y, z, and True once"),
        (lambda: position(mask=[1, 0, 1]), r"mask = \[1, 0, 1\]; it must say True or False"),
        (lambda: position(mask=[False] * 3), "it must say True or False of x, y, z, and True once"),
        (lambda: position(mask=[True] * 4), "it must say True or False of x, y, z"),
        (lambda: position([0, 0], mask="z"), r"target has shape \(2,\); it must be \(1,\) or \(3,\)"),
        (lambda: PoseTask([0] * 3, np.eye(3), mask="x rq", gain=1), "mask = 'x rq'; it must name some of x, y, z, rx"),
        (lambda: OrientationTask(0.3, mask="z", gain=1), "one angle turns about z; a mask needs a rotation"),
        (lambda: PostureTask([0], joints="elbow", gain=1), "joints = 'elbow' is a str; it must be a list of joints"),
        (lambda: PostureTask([0], joints=[1, 2], gain=1), r"target has shape \(1,\); it must be \(2,\)"),
        (lambda: JointCouplingTask({"elbow": 0}, gain=1), "factors = {'elbow': 0.0}; one must not be zero"),
        (lambda: JointCouplingTask("elbow", gain=1), "factors = 'elbow' is a str; it must be a dict"),
        (lambda: AtLeast(JointVelocityLimit(1.0)), "AtLeast takes a Task, not a JointVelocityLimit"),
        (lambda: AtMost(position() >> position()), "AtMost takes a Task, not a Stack"),
        (lambda: Within("hand", 1.0), "Within takes a Task, not a str"),
        (lambda: Within(position(name="hand"), -1.0), "Within 'hand': tolerance = -1.0 must not be negative"),
        (lambda: Within(position(), [1, 1, -1]), r"tolerance = \[1.0, 1.0, -1.0\] must not be negative"),
        (lambda: Within(position(), np.nan), "tolerance = nan must not be negative"),
        (lambda: Within(position(), 1.0, below=-1.0), "'position': tolerance below = -1.0 must not be negative"),
        (lambda: Within(position(), "a"), "tolerance is not an array of real numbers"),
        (
            lambda: BoxLimit([0, 1, 0], [1, 1, 1], gain=1, name="cell"),
            r"box 'cell': lower = \[.*\] must be below upper",
        ),
        (lambda: BoxLimit(NAN, [1, 1, 1], gain=1), r"box 'box': lower = .*must be below upper"),
        (lambda: BoxLimit([0], [1], gain=1), r"box 'box': lower has shape \(1,\); it must be \(3,\), or \(2,\)"),
        (
            lambda: BoxLimit([0, 0], [1, 1, 1], gain=1),
            r"box 'box': upper has shape \(3,\); it must be \(3,\), or \(2,\)",
        ),
        (lambda: PlaneTask([0, 0, 0], 1, gain=1), r"normal = \[0.0, 0.0, 0.0\] has no direction; its length must be"),
        (lambda: PlaneLimit([0, 0, 0], 1, gain=1), "PlaneTask 'plane': normal = .* has no direction"),
        (lambda: PlaneTask([0, 1], 1, gain=1), r"normal has shape \(2,\); it must be \(3,\)"),
        (lambda: AxisTask([0, 0, 0], gain=1), "AxisTask 'axis': direction = .* has no direction"),
        (lambda: AxisTask([0, 0, 1], axis=[0, 0, 0], gain=1), "AxisTask 'axis': axis = .* has no direction"),
        (lambda: LookAtTask([0, 0, 1], axis=[0, 0, 0], gain=1), "LookAtTask 'lookat': axis = .* has no direction"),
        (lambda: FrameVelocityLimit(0.0), "FrameVelocityLimit 'speed': limit = 0.0 must be positive"),
        (lambda: FrameVelocityLimit([1.0, 2.0]), r"'speed': limit has shape \(2,\); it must be one number, or \(3,\)"),
        (lambda: FrameVelocityLimit(1.0, mask="w"), "'speed': mask = 'w'; it must name some of x, y, z, rx"),
        (
            lambda: JointLimits(JointVelocityLimit(1), JointVelocityLimit(2)),
            "there are two of a kind; one of each is taken",
        ),
        (lambda: JointLimits(position()), "a part of JointLimits = .*PositionTask; it must be a JointLimit"),
    ],
)
def test_numbers_that_mean_nothing(make, named):
    with pytest.raises(InvalidInput, match=named):
        make()


@pytest.mark.parametrize("dt", [0.0, -0.1, np.nan, np.inf])
def test_a_tick_is_positive(dt):
    with pytest.raises(InvalidInput, match=f"dt = {dt} s must be positive"):
        control("panda", position(), dt=dt)


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: control("panda", position())([0] * 6, [0] * 7), r"q has shape \(6,\); the robot takes \(7,\)"),
        (lambda: control("g1", PostureTask(robot("g1").home, gain=1))([0] * 35, [0] * 35), r"the robot takes \(36,\)"),
        (lambda: control("g1", PostureTask(robot("g1").home, gain=1))([0] * 36, [0] * 36), r"the robot takes \(35,\)"),
        (lambda: simulate(control("panda", position(), dt=0.1), [0] * 6, duration=1), r"the robot takes \(7,\)"),
        (lambda: robot("panda").at([0] * 6, [0] * 7), r"q has shape \(6,\); .*'panda'.* takes \(7,\)"),
        (lambda: robot("panda").at([0] * 7, "no"), "v is not an array of real numbers"),
        (
            lambda: robot("panda").configuration({"panda_joint": 1}),
            "'panda_joint' is no joint of the robot; did you mean",
        ),
        (lambda: robot("g1").configuration({"root_joint[0]": 1}), r"'root_joint\[0\]': it is one of several of a base"),
    ],
)
def test_configurations_of_the_wrong_length(call, named):
    with pytest.raises(InvalidInput, match=named):
        call()


def breaking(rows):
    """A trajectory that is NaN after its first second."""
    return lambda t: (np.full(rows, np.nan if t > 1.0 else 0.3), np.zeros(rows), np.zeros(rows))


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize(
    "make",
    [
        lambda: PositionTask(breaking(3), gain=1.0),
        lambda: PositionTask(breaking(3), reference="local", gain=1.0),
        lambda: OrientationTask(lambda t: (np.eye(3) * (np.nan if t > 1.0 else 1.0), *np.zeros((2, 3))), gain=1.0),
        lambda: OrientationTask(breaking(1), gain=1.0),
        lambda: PoseTask(breaking(3), np.eye(3), gain=1.0),
        lambda: AxisTask(breaking(3), gain=1.0),
        lambda: LookAtTask(breaking(3), gain=1.0),
        lambda: PlaneTask([0, 0, 1], breaking(1), gain=1.0),
        lambda: CenterOfMassTask(breaking(3), gain=1.0),
        lambda: PostureTask(breaking(7), gain=1.0),
        lambda: PostureTask(breaking(1), joints=[3], gain=1.0),
        lambda: JointCouplingTask({0: 1, 1: 1}, breaking(1), gain=1.0),
        lambda: AtLeast(PositionTask(breaking(3), gain=1.0)),
        lambda: Within(LookAtTask(breaking(3), gain=1.0), 0.1),
    ],
)
def test_nan_in_the_loop_is_a_status_and_no_exception(make, order):
    part = make()
    controller = control("panda", JointVelocityLimit(1.0) >> part, order=order, dt=0.01)
    home, rest = robot("panda").home, np.zeros(7)
    assert controller(home, rest, 0.0).ok
    broken = controller(home, rest, 2.0).solution
    assert broken.status is Status.INVALID
    assert f"level 1 ('{part.name}')" in broken.message
    for q, v in ((home * np.nan, rest), (np.full(7, np.inf), rest)):
        assert controller(q, v, 0.0).solution.status is Status.INVALID
    if order == "acceleration":
        assert controller(home, rest * np.nan, 0.0).solution.status is Status.INVALID
    assert controller(home, rest, 0.5).ok  # and it goes on
