"""Shapes of robots from anywhere, solids in the world, and which pairs of them are watched."""

from __future__ import annotations

import copy
import pickle

import coal
import mujoco
import numpy as np
import pinocchio as pin
import pytest

from hqp import InvalidInput
from tasks import (
    Box,
    CollisionLimit,
    Controller,
    JointLimits,
    JointVelocityLimit,
    PlanarArm,
    Polyhedron,
    PositionTask,
    SelfCollisionLimit,
    Stack,
    load_robot,
    simulate,
)

PANDA = load_robot("panda", lock=["panda_finger_joint1"])
ARM = """<mujoco><default><joint axis="0 1 0" range="-150 150"/><geom type="capsule" size=".04"/></default>
<worldbody><body name="one" pos="0 0 .5"><joint name="a"/><geom fromto="0 0 0 .4 0 0"/>
<body name="two" pos=".4 0 0"><joint name="b"/><geom type="box" size=".2 .04 .03" pos=".2 0 0"/>
<body name="three" pos=".4 0 0"><joint name="c"/><geom type="cylinder" size=".03 .1" pos=".15 0 0" euler="0 90 0"/>
<geom type="ellipsoid" size=".05 .03 .04" pos=".3 0 0"/><geom name="ghost" contype="0" conaffinity="0" size=".3 1"/>
<body name="four" pos=".35 0 0"><joint name="d"/><geom type="sphere" size=".05" pos=".1 0 0"/>
<site name="tip" pos=".15 0 0"/></body></body></body></body></worldbody>{}</mujoco>"""


def arm(more=""):
    mj = mujoco.MjModel.from_xml_string(ARM.format(more))
    return mj, load_robot(mj, tip="tip", velocity_limit=2.0)


def at(*p):
    T = np.eye(4)
    T[:3, 3] = p
    return T


def test_geoms_of_an_mjcf_are_as_far_apart_as_mujoco_says() -> None:
    mj, robot = arm()
    data, rng = mujoco.MjData(mj), np.random.default_rng(3)
    shapes = SelfCollisionLimit([("one", "three"), ("one", "four"), ("two", "four")], margin=0.0, gain=1.0).shapes(
        robot
    )
    assert len(shapes) == 4  # three has two geoms, and the one that collides with nothing is none
    names = [(body, other) for body, other in shapes.pairs]
    geoms = {"one": [0], "two": [1], "three": [2, 3], "four": [5]}
    checked = 0
    for _ in range(20):
        data.qpos[:] = rng.uniform(-2.0, 2.0, mj.nq)
        mujoco.mj_forward(mj, data)
        found = shapes.distances(robot.at(data.qpos))
        for body, other in dict.fromkeys(names):
            own = min(d for d, pair in zip(found, names, strict=True) if pair == (body, other))
            theirs = min(mujoco.mj_geomDistance(mj, data, i, j, 10.0, None) for i in geoms[body] for j in geoms[other])
            if theirs > 0.01:
                np.testing.assert_allclose(own, theirs, atol=2e-4)  # theirs are iterations, too
                checked += 1
    assert checked > 20


def test_bodies_that_an_mjcf_excludes_are_no_pair() -> None:
    _, free = arm()
    _, robot = arm('<contact><exclude body1="one" body2="four"/></contact>')
    pairs = SelfCollisionLimit(margin=0.01, gain=1.0).shapes(free).pairs
    left = SelfCollisionLimit(margin=0.01, gain=1.0).shapes(robot).pairs
    assert {*pairs} - {*left} == {("one", "four")}


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_an_mjcf_keeps_off_a_box(order) -> None:
    _, robot = arm()
    wall = Box([0.2, 1.0, 1.0], at(0.9, 0.0, 0.5), name="wall")
    away = CollisionLimit([wall], margin=0.02, gain=10.0)
    start = np.array([-1.4, 1.2, 1.6, -0.4])
    assert away.distances(robot, robot.at(start)).min() > 0.05
    limits = JointLimits() if order == "velocity" else JointVelocityLimit(1.0)
    goal = PositionTask([1.0, 0.55], mask="xz", gain=2.0)
    record = simulate(Controller(robot, limits >> away >> goal, order=order, dt=0.005), start, duration=3.0)
    least = min(away.distances(robot, robot.at(q)).min() for q in record.q)
    assert least > 0.018
    assert abs(away.distances(robot, robot.at(record.q[-1])).min() - 0.02) < 2e-3
    assert record.certified_share == 1.0


def test_rows_are_the_derivative_of_the_distance() -> None:
    rng = np.random.default_rng(2)
    points = rng.uniform(-0.2, 0.2, (12, 3))
    solids = [Box([0.3, 0.2, 0.4], at(0.6, 0.4, 0.6)), Polyhedron(points, at(0.3, -0.5, 0.7), name="rock")]
    away = CollisionLimit(solids, bodies=["panda_hand", "panda_link5"], margin=0.0, gain=1.0, rows=100)
    shapes = away.shapes(PANDA)
    assert "panda_hand - rock 2" in shapes.names()
    for q in (PANDA.home, PANDA.home + 0.1):
        v = rng.uniform(-1.0, 1.0, 7)
        A = Stack(away).build(PANDA, "velocity", 0.01).fill(PANDA.at(q), 0.0).dense()
        h = 1e-6
        rate = (shapes.distances(PANDA.at(q + h * v)) - shapes.distances(PANDA.at(q - h * v))) / (2.0 * h)
        np.testing.assert_allclose(A @ v, rate, atol=1e-4)


def test_any_geometry_model_will_do_and_links_as_capsules() -> None:
    model = pin.buildSampleModelManipulator()
    geometry = pin.GeometryModel()
    for joint in (1, 3, 6):
        shape = pin.GeometryObject(f"capsule {joint}", joint, pin.SE3.Identity(), coal.Capsule(0.05, 0.2))
        geometry.addGeometryObject(shape)
    from tasks import PinocchioRobot

    robot = PinocchioRobot(model, tip="effector_body").with_geometry(geometry)
    shapes = SelfCollisionLimit(margin=0.0, gain=1.0).shapes(robot)
    assert set(shapes.pairs) <= {(model.names[a], model.names[b]) for a, b in ((1, 3), (1, 6), (3, 6))}
    for other in copy.copy(robot), copy.deepcopy(robot), pickle.loads(pickle.dumps(robot)):
        assert other.geometry().ngeoms == 3
    q = robot.random(np.random.default_rng(1))
    again = SelfCollisionLimit(margin=0.0, gain=1.0).distances(copy.deepcopy(robot), copy.deepcopy(robot).at(q))
    np.testing.assert_array_equal(again, SelfCollisionLimit(margin=0.0, gain=1.0).distances(robot, robot.at(q)))


def test_an_srdf_leaves_pairs_out(tmp_path) -> None:
    path = tmp_path / "panda.srdf"
    path.write_text(
        '<robot name="panda"><disable_collisions link1="panda_hand" link2="panda_link0" reason="Never"/></robot>'
    )
    whole = SelfCollisionLimit(margin=0.01, gain=1.0).shapes(PANDA).pairs
    for without in (path, str(path), [("panda_link0", "panda_hand")]):
        left = SelfCollisionLimit(without=without, margin=0.01, gain=1.0).shapes(PANDA).pairs
        assert {frozenset(pair) for pair in whole} - {frozenset(pair) for pair in left} == {
            frozenset(("panda_hand", "panda_link0"))
        }


def test_a_box_that_is_moved_is_seen_at_the_next_tick() -> None:
    table = Box([0.6, 0.6, 0.1], at(0.5, 0.0, 0.1), name="table")
    away = CollisionLimit([table], margin=0.02, gain=10.0)
    stack = JointLimits() >> away >> PositionTask([0.5, 0.0, 0.1], gain=5.0)
    controller = Controller(PANDA, stack, dt=0.01)
    before = controller(PANDA.home).v
    table.at = at(0.5, 0.0, 0.3)
    fresh = Controller(PANDA, stack, dt=0.01)(PANDA.home).v
    np.testing.assert_allclose(controller(PANDA.home).v, fresh, atol=1e-3)  # witnesses of flat faces are not unique
    assert np.abs(before - fresh).max() > 1e-3


def test_a_point_is_a_place_with_the_axes_of_the_world() -> None:
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    for solid in Box([0.1, 0.2, 0.3], [0.5, 0.1, 0.2]), Polyhedron(corners, [0.5, 0.1, 0.2]):
        np.testing.assert_array_equal(solid.at, at(0.5, 0.1, 0.2))
        solid.at = [0.4, 0.0, 0.0]
        np.testing.assert_array_equal(solid.at, at(0.4, 0.0, 0.0))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Box([0.1, -0.2, 0.3]), "size"),
        (lambda: Box([0.1, 0.2]), "(3,)"),
        (lambda: Box([0.1, 0.2, 0.3], np.eye(3)), "(4, 4)"),
        (lambda: Box([0.1, 0.2, 0.3], [0.5, np.nan, 0.2]), "at"),
        (lambda: Polyhedron(np.eye(3)), "plane"),
        (lambda: CollisionLimit([], margin=0.0, gain=1.0), "got none"),
        (lambda: CollisionLimit([1.0], margin=0.0, gain=1.0), "Box or Polyhedron"),
        (lambda: PANDA.with_geometry(pin.GeometryModel()), "no shapes"),
        (lambda: PANDA.with_geometry("shapes"), "geometry"),
        (
            lambda: SelfCollisionLimit(without=[("panda_hand", "hand")], margin=0.0, gain=1.0).shapes(PANDA),
            "panda_hand",
        ),
        (lambda: SelfCollisionLimit(without="nowhere.srdf", margin=0.0, gain=1.0), "nowhere.srdf"),
        (
            lambda: CollisionLimit([Box([1.0, 1.0, 1.0])], bodies=["panda_link0"], margin=0.0, gain=1.0).shapes(PANDA),
            "panda_link0",
        ),
        (
            lambda: Controller(
                PlanarArm([1.0]), Stack(CollisionLimit([Box([1.0] * 3)], margin=0.0, gain=1.0)), dt=0.01
            ),
            "load_robot",
        ),
    ],
)
def test_what_is_wrong_is_refused_in_words(make, words: str) -> None:
    with pytest.raises(InvalidInput) as refusal:
        make()
    assert words in str(refusal.value)
