"""What stands beside a robot in its MJCF: solids where MuJoCo has them, as far away as MuJoCo says."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import CollisionLimit, Controller, JointLimits, PlanarArm, PositionTask, load_robot, scene_solids, simulate

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("pinocchio")

SCENE = """
<mujoco>
  <asset><mesh name="wedge" vertex="0 0 0  .2 0 0  0 .2 0  0 0 .3"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1" pos="0 0 -.4" euler="3 -5 0"/>
    <geom name="post" type="cylinder" size=".04 .3" pos="-.5 .4 .2" euler="20 10 0"/>
    <geom name="paint" type="box" size=".1 .1 .1" contype="0" conaffinity="0"/>
    <body name="table" pos=".7 .1 -.2" euler="0 0 30">
      <geom type="box" size=".2 .3 .02"/>
      <body name="cup" pos="0 .1 .1"><geom type="ellipsoid" size=".03 .04 .06"/>
        <geom name="lid" size=".02" pos="0 0 .1"/></body>
      <body name="mount" pos="-.7 -.1 .2">
        <geom type="box" size=".05 .05 .05"/>
        <body name="upper"><joint name="pan" axis="0 0 1" range="-150 150" limited="true"/>
          <joint name="lift" axis="0 1 0" range="-90 90" limited="true"/>
          <geom name="arm" type="capsule" size=".03" fromto=".1 0 0 .35 0 0"/>
          <body name="lower" pos=".4 0 0"><joint name="elbow" axis="0 1 0" range="-150 150" limited="true"/>
            <geom name="hand" type="box" size=".1 .02 .03" pos=".12 0 0"/></body>
        </body>
      </body>
    </body>
    <body name="rock" pos="-.3 -.5 .1"><geom type="mesh" mesh="wedge"/></body>
    <body name="beam" pos=".1 .6 .3"><geom type="capsule" size=".05" fromto="0 0 0 .3 .1 .2"/></body>
    <body name="goal" mocap="true"><geom size=".05"/></body>
    <body name="cube" pos=".5 -.5 0"><freejoint/><geom type="box" size=".03 .03 .03"/></body>
  </worldbody>
</mujoco>"""
#: Named by their geoms, or by body and number; not: what does not collide, what moves, and the robot.
STANDING = ["floor", "post", "table 0", "cup 0", "lid", "rock 0", "beam 0"]


@pytest.fixture(scope="module")
def scene():
    return mujoco.MjModel.from_xml_string(SCENE)


@pytest.fixture(scope="module")
def robot(scene):
    return load_robot(scene, body="mount", velocity_limit=2.0)


def test_all_that_stands_is_found_and_nothing_else(robot):
    assert [solid.name for solid in scene_solids(robot)] == STANDING


@pytest.mark.parametrize("names", [["table"], ["lid", "rock"], ["cup"], []])
def test_bodies_and_geoms_may_be_named(robot, names):
    own = {"table": ["table 0"], "lid": ["lid"], "rock": ["rock 0"], "cup": ["cup 0", "lid"]}
    assert [solid.name for solid in scene_solids(robot, names)] == [one for name in names for one in own[name]]


def colliding(scene, body):
    return [i for i in range(scene.ngeom) if scene.geom_bodyid[i] == scene.body(body).id and scene.geom_contype[i]]


def test_distances_are_those_of_mujoco(scene, robot):
    data, rng, fromto = mujoco.MjData(scene), np.random.default_rng(0), np.zeros(6)
    away = CollisionLimit(scene_solids(robot), margin=0.0, gain=1.0)
    geoms = [i for own in ("world", "table", "cup", "rock", "beam") for i in colliding(scene, own)]
    pairs = [(scene.geom(own).id, other) for own in ("arm", "hand") for other in geoms]
    seen = 0
    for _ in range(20):
        q = robot.random(rng)
        for name, value in zip(robot.joint_names, q, strict=True):
            data.qpos[scene.joint(name).qposadr[0]] = value
        mujoco.mj_kinematics(scene, data)
        theirs = np.array([mujoco.mj_geomDistance(scene, data, *pair, 9.0, fromto) for pair in pairs])
        ours = away.distances(robot, robot.at(q))
        clear = theirs > 1e-3  # how deep shapes overlap is another algorithm
        np.testing.assert_allclose(ours[clear], theirs[clear], atol=2e-5)
        assert (ours[~clear] < 2e-3).all()
        nearest = away.shapes(robot).closest(robot.at(q), 4)
        np.testing.assert_allclose(np.sort(ours)[:4], ours[nearest], atol=1e-9)
        seen += clear.sum()
    assert seen > 200


def test_a_hand_that_is_led_into_the_table_stops_above_it(robot):
    away = CollisionLimit(scene_solids(robot, ["table", "floor"]), margin=0.02, gain=10.0)
    stack = JointLimits() >> away >> PositionTask([0.6, 0.05, -0.3], frame="lower", gain=5.0)
    controller = copy.deepcopy(Controller(robot, stack, dt=0.005, damping=None))
    record = simulate(controller, [0.1, -0.8, 0.6], duration=2.0, certify=20)
    least = min(away.distances(robot, robot.at(q)).min() for q in record.q)
    assert 0.0195 < least < 0.0215
    assert record.certified == record.checked


def test_what_cannot_be_is_refused(robot):
    with pytest.raises(InvalidInput, match="nothing that stands is called 'tabel'; did you mean 'table'"):
        scene_solids(robot, ["tabel"])
    with pytest.raises(InvalidInput, match="called 'cube'"):
        scene_solids(robot, ["cube"])
    with pytest.raises(InvalidInput, match="was not loaded from an MJCF"):
        scene_solids(PlanarArm([0.5, 0.5]))
    with pytest.raises(InvalidInput, match="robot"):
        scene_solids("robot")


def test_a_height_field_is_refused_unless_it_is_left_out(scene):
    field = '<asset><hfield name="hills" nrow="2" ncol="2" size="1 1 1 1" elevation="0 1 1 0"/>'
    text = SCENE.replace("<asset>", field).replace(
        "<worldbody>", '<worldbody><geom name="hills" type="hfield" hfield="hills"/>'
    )
    robot = load_robot(mujoco.MjModel.from_xml_string(text), body="mount")
    with pytest.raises(InvalidInput, match="geom 'hills' has no convex shape; leave it out by names"):
        scene_solids(robot)
    assert len(scene_solids(robot, ["table"])) == 1
