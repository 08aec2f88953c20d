"""Bodies as capsules: they hold their shapes, are no larger than they need be, and are kept apart like any others."""

from __future__ import annotations

import coal
import mujoco
import numpy as np
import pinocchio as pin
import pytest

from hqp import InvalidInput
from tasks import (
    Capsule,
    Controller,
    DistanceLimit,
    JointAccelerationLimit,
    JointLimits,
    JointVelocityLimit,
    LinkCapsule,
    PinocchioRobot,
    PlanarArm,
    PositionTask,
    SelfCollisionLimit,
    Stack,
    link_capsules,
    load_robot,
    simulate,
)
from tasks.robots.capsules import enclosing_capsule, smallest_capsule
from tasks.robots.convexity import hull

PANDA = load_robot("panda", lock=["panda_finger_joint1"])
ARM = """<mujoco><default><joint axis="0 1 0" range="-150 150"/><geom type="capsule" size=".04"/></default>
<worldbody><body name="one" pos="0 0 .5"><joint name="a"/><geom fromto=".05 0 .02 .4 .01 0"/>
<body name="two" pos=".4 0 0"><joint name="b"/><geom type="box" size=".2 .04 .03" pos=".2 0 0"/>
<body name="three" pos=".4 0 0"><joint name="c"/><geom type="cylinder" size=".03 .1" pos=".15 0 0" euler="0 90 0"/>
<geom type="ellipsoid" size=".05 .03 .04" pos=".3 0 0"/><geom name="ghost" contype="0" conaffinity="0" size=".3 1"/>
<body name="four" pos=".35 0 0"><joint name="d"/><geom type="sphere" size=".05" pos=".1 0 0"/>
<site name="tip" pos=".15 0 0"/></body></body></body></body></worldbody>{}</mujoco>"""
#: How far each shape of Coal reaches in unit directions u, shape (k, 3) [m].
REACH = {
    "box": (coal.Box(0.2, 0.3, 0.5), lambda u: np.abs(u) @ [0.1, 0.15, 0.25]),
    "cylinder": (coal.Cylinder(0.1, 0.6), lambda u: 0.1 * np.hypot(u[:, 0], u[:, 1]) + 0.3 * np.abs(u[:, 2])),
    "cone": (coal.Cone(0.1, 0.6), lambda u: np.maximum(0.1 * np.hypot(*u.T[:2]) - 0.3 * u[:, 2], 0.3 * u[:, 2])),
    "ellipsoid": (coal.Ellipsoid(0.1, 0.2, 0.3), lambda u: np.linalg.norm(u * [0.1, 0.2, 0.3], axis=1)),
    "sphere": (coal.Sphere(0.2), lambda u: np.full(len(u), 0.2)),
    "capsule": (coal.Capsule(0.1, 0.4), lambda u: 0.1 + 0.2 * np.abs(u[:, 2])),
}
#: The least radius that an infinite cylinder about it could have [m].
LEAST = {"box": np.hypot(0.1, 0.15), "cylinder": 0.1, "cone": 0.1, "ellipsoid": 0.2, "sphere": 0.2, "capsule": 0.1}


def arm(more=""):
    return load_robot(mujoco.MjModel.from_xml_string(ARM.format(more)), tip="tip", velocity_limit=2.0)


def volume(capsule):
    return capsule.radius**2 * (np.linalg.norm(capsule.end - capsule.start) + 4.0 / 3.0 * capsule.radius)


@pytest.mark.parametrize("kind", REACH)
def test_a_capsule_reaches_as_far_as_its_shape_in_every_direction(kind) -> None:
    shape, reach = REACH[kind]
    u = np.random.default_rng(1).normal(size=(2000, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    placement = pin.SE3.Random()
    geometry = pin.GeometryModel()
    geometry.addGeometryObject(pin.GeometryObject("it", 0, 0, placement, shape))
    found = enclosing_capsule(geometry, 0)
    outwards = u @ placement.translation + reach(u @ placement.rotation)
    assert (np.maximum(u @ found.start, u @ found.end) + found.radius >= outwards - 1e-9).all()
    assert LEAST[kind] - 1e-9 <= found.radius < 1.35 * LEAST[kind]
    if kind in {"sphere", "capsule"}:
        np.testing.assert_allclose(found.radius, LEAST[kind], rtol=1e-6)
        np.testing.assert_allclose(
            np.linalg.norm(found.end - found.start), 0.4 if kind == "capsule" else 0.0, atol=1e-5
        )


def test_it_is_as_small_wherever_the_points_are_turned_and_no_axis_by_chance_is_better() -> None:
    rng = np.random.default_rng(4)
    for _ in range(5):
        points = rng.uniform(-1.0, 1.0, (20, 3)) * rng.uniform(0.2, 1.0, 3)
        turned = points @ pin.SE3.Random().rotation.T + 3.0
        own = smallest_capsule(points, np.zeros(20))
        assert volume(smallest_capsule(turned, np.zeros(20))) == pytest.approx(volume(own), rel=0.2)
        ball = max(np.linalg.norm(points - 0.5 * (points.min(axis=0) + points.max(axis=0)), axis=1))
        assert volume(own) <= 4.0 / 3.0 * ball**3
        for axis in rng.normal(size=(50, 3)):
            unit = axis / np.linalg.norm(axis)
            along, off = points @ unit, points - np.outer(points @ unit, unit)
            radius = np.linalg.norm(off - off.mean(axis=0), axis=1).max()
            assert volume(own) <= 1.02 * radius**2 * (np.ptp(along) + 4.0 / 3.0 * radius)


def test_links_of_an_mjcf_are_capsules_in_the_frames_of_their_bodies() -> None:
    one, two, three, four = link_capsules(arm())
    assert [link.name for link in (one, two, three, four)] == ["one", "two", "three", "four"]
    ends = sorted([one.start.tolist(), one.end.tolist()])
    np.testing.assert_allclose(ends, [[0.05, 0.0, 0.02], [0.4, 0.01, 0.0]], atol=1e-6)
    assert one.radius == pytest.approx(0.04)
    np.testing.assert_allclose([four.start, four.end], [[0.1, 0.0, 0.0]] * 2, atol=1e-6)
    assert 0.05 <= two.radius < 0.07
    assert 0.04 <= three.radius < 0.05  # of both of its geoms
    assert "start=" in repr(one)


@pytest.mark.parametrize("robot", [PANDA, arm()], ids=["urdf", "mjcf"])
def test_capsules_are_never_farther_apart_than_what_they_hold(robot) -> None:
    round_ = robot.with_capsules()
    limit = SelfCollisionLimit(margin=0.0, gain=1.0)
    watched = limit.shapes(round_).pairs
    whole = SelfCollisionLimit(watched, margin=0.0, gain=1.0)
    rng, apart = np.random.default_rng(7), 0
    for _ in range(10):
        q = robot.random(rng)
        shapes = dict.fromkeys(map(frozenset, watched), np.inf)
        for pair, d in zip(whole.shapes(robot).pairs, whole.distances(robot, robot.at(q)), strict=True):
            shapes[frozenset(pair)] = min(shapes[frozenset(pair)], d)
        for pair, d in zip(watched, limit.distances(round_, round_.at(q)), strict=True):
            if d > 0.0:
                assert d <= shapes[frozenset(pair)] + 1e-6
                apart += 1
    assert apart > 20


def test_some_bodies_and_pairs_that_are_excluded() -> None:
    robot = arm('<contact><exclude body1="one" body2="four"/></contact>')
    some = robot.with_capsules(["three"]).geometry()
    assert [(shape.name, type(shape.geometry).__name__) for shape in some.geometryObjects] == [
        ("one 0", "Capsule"),
        ("two 0", "Box"),
        ("three", "Capsule"),
        ("four 0", "Sphere"),
    ]
    pairs = SelfCollisionLimit(margin=0.01, gain=1.0).shapes(robot.with_capsules()).pairs
    assert ("one", "four") not in pairs
    assert ("one", "three") in pairs


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_rows_are_the_derivative_of_the_distance_with_a_start_too(order) -> None:
    robot, rng = arm(), np.random.default_rng(2)
    pole = Capsule([0.6, 0.2, 0.2], [0.5, 0.3, 1.2], 0.05)
    limit = DistanceLimit(link_capsules(robot), [pole], margin=0.0, gain=1.0)
    stack = Stack(JointVelocityLimit(1.0) + JointAccelerationLimit(20.0) + limit)
    q = np.array([-1.1, 0.9, 0.7, -0.4])
    A = stack.build(robot, order, 0.01).fill(robot.at(q), 0.0).dense()[-4:]
    h = 1e-6
    for v in rng.uniform(-1.0, 1.0, (3, 4)):
        ahead, behind = (limit.distances(robot, robot.at(q + s * v)) for s in (h, -h))
        np.testing.assert_allclose(A @ v, (ahead - behind) / (2.0 * h), atol=1e-5)


def test_links_as_capsules_keep_off_a_pole_and_off_each_other() -> None:
    robot = PANDA.with_capsules()
    body = SelfCollisionLimit(margin=0.02, gain=10.0)
    pole = DistanceLimit(
        link_capsules(PANDA), [Capsule([0.45, 0.3, 0.0], [0.45, 0.3, 0.8], 0.03)], margin=0.02, gain=20.0
    )
    reach = PositionTask([0.05, 0.05, 0.15], gain=3.0)
    record = simulate(Controller(robot, JointLimits() >> pole >> body >> reach, dt=0.005), robot.home, duration=1.5)
    states = [robot.at(q) for q in record.q]
    assert min(pole.distances(robot, state).min() for state in states) > 0.02 - 1e-6
    least = min(body.distances(robot, state).min() for state in states)
    assert 0.019 < least < 0.021  # capsules are round: the margin is passed by less than between flat faces
    assert record.certified_share == 1.0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: link_capsules(PANDA, ["panda_hnd"]), "did you mean 'panda_hand'"),
        (lambda: link_capsules(PANDA, []), "empty"),
        (lambda: link_capsules(PANDA, "panda_hand"), "bodies"),
        (lambda: link_capsules(PANDA, [3]), "a body = 3 is a int"),
        (lambda: link_capsules(PlanarArm([1.0])), "load_robot"),
        (lambda: PANDA.with_capsules(["panda_hand_tcp"]), "no body with a shape"),
        (lambda: LinkCapsule("a", "b", 0.1, start=[0.0, np.nan, 0.0]), "finite"),
        (lambda: LinkCapsule("a", "b", 0.1, start="c"), "start"),
        (lambda: LinkCapsule("a", "b", 0.1, start=[1.0]), "start has shape (1,)"),
        (lambda: plane().with_capsules(), "Halfspace"),
    ],
)
def test_what_is_wrong_is_refused_in_words(make, words) -> None:
    with pytest.raises(InvalidInput) as refusal:
        make()
    assert words in str(refusal.value)


def plane():
    geometry = pin.GeometryModel()
    geometry.addGeometryObject(pin.GeometryObject("floor", 1, pin.SE3.Identity(), coal.Halfspace(0.0, 0.0, 1.0, 0.0)))
    return PinocchioRobot(pin.buildSampleModelManipulator(), tip="effector_body").with_geometry(geometry)


def test_a_hull_is_held_at_its_corners() -> None:
    points = np.random.default_rng(3).normal(size=(30, 3))
    geometry = pin.GeometryModel()
    geometry.addGeometryObject(pin.GeometryObject("rock", 0, 0, pin.SE3.Identity(), hull(points, "rock")))
    start, end, radius = enclosing_capsule(geometry, 0)
    way = end - start
    share = np.clip((points - start) @ way / max(way @ way, 1e-12), 0.0, 1.0)
    assert np.linalg.norm(points - start - share[:, None] * way, axis=1).max() == pytest.approx(radius, rel=1e-9)


def test_a_robot_without_shapes_is_refused(tmp_path) -> None:
    """A file may have none; no capsules, or no pairs, would be kept from nothing."""
    arm = tmp_path / "arm.urdf"
    arm.write_text(
        "<robot name='arm'><link name='base'/><link name='bar'/>"
        "<joint name='turn' type='revolute'><parent link='base'/><child link='bar'/><axis xyz='0 0 1'/>"
        "<limit lower='-1' upper='1' velocity='1' effort='1'/></joint></robot>"
    )
    bare = load_robot(arm, tip="bar")
    for ask in (
        lambda: link_capsules(bare),
        lambda: Controller(bare, JointLimits() >> SelfCollisionLimit(margin=0.1, gain=5.0), dt=0.01),
    ):
        with pytest.raises(InvalidInput, match=r"'arm'.*no collision shapes"):
            ask()
