"""Joints of several axes: names, units and limits are those of each axis, on every path."""

from __future__ import annotations

import logging

import numpy as np
import pinocchio as pin
import pytest
from urdf_files import chain, write

from hqp import InvalidInput
from tasks import (
    Controller,
    JointAccelerationLimit,
    JointCouplingTask,
    JointLimits,
    JointPositionLimit,
    JointVelocityLimit,
    MujocoPlant,
    PinocchioRobot,
    PositionTask,
    PostureTask,
    load_robot,
    simulate,
    solve_ik,
)


def composite(*parts):
    whole = pin.JointModelComposite()
    for k, part in enumerate(parts):
        whole.addJoint(part, pin.SE3(np.eye(3), np.array([0.1 * k, 0.0, 0.05])))
    return whole


def hinges():
    tilted = np.array([0.6, 0.0, 0.8])
    return pin.JointModelRX(), pin.JointModelRevoluteUnaligned(tilted), pin.JointModelRZ()


#: A joint, the units of its axes, and which of them have a position.
JOINTS = {
    "two hinges": (lambda: composite(*hinges()[:2]), "rad rad", "yy"),
    "three hinges": (lambda: composite(*hinges()), "rad rad rad", "yyy"),
    "slide and hinge": (lambda: composite(pin.JointModelPX(), pin.JointModelRZ()), "m rad", "yy"),
    "hinge and slide": (lambda: composite(pin.JointModelRZ(), pin.JointModelPZ()), "rad m", "yy"),
    "nested": (
        lambda: composite(composite(pin.JointModelPX(), pin.JointModelPY()), pin.JointModelRZ()),
        "m m rad",
        "yyy",
    ),
    "slide and wheel": (lambda: composite(pin.JointModelPX(), pin.JointModelRUBZ()), "m rad", "yn"),
    "six axes": (
        lambda: composite(pin.JointModelPX(), pin.JointModelPY(), pin.JointModelPZ(), *hinges()),
        "m m m rad rad rad",
        "yyyyyy",
    ),
    "translation": (pin.JointModelTranslation, "m m m", "yyy"),
    "Euler angles": (pin.JointModelSphericalZYX, "rad rad rad", "yyy"),
    "universal": (lambda: pin.JointModelUniversal(np.array([1.0, 0, 0]), np.array([0, 1.0, 0])), "rad rad", "yy"),
    "screw": (lambda: pin.JointModelHZ(0.1), "rad", "y"),
    "ball": (pin.JointModelSpherical, "rad rad rad", "nnn"),
    "planar": (pin.JointModelPlanar, "m m rad", "nnn"),
    "floating": (pin.JointModelFreeFlyer, "m m m rad rad rad", "nnnnnn"),
}
HALF = 0.35


def model_of(name):
    """A hinge, this joint, and a slide, each with a body; every position between -0.35 and 0.35 [rad], [m]."""
    make, _, _ = JOINTS[name]
    model = pin.Model()
    parent = 0
    for called, own in ("first", pin.JointModelRY()), ("several", make()), ("last", pin.JointModelPX()):
        place = pin.SE3(pin.exp3(np.array([0.1, 0.2, 0.3])), np.array([0.2, 0.1, 0.3]))
        parent = model.addJoint(parent, own, place, called)
        model.addJointFrame(parent)
        model.appendBodyToJoint(
            parent, pin.Inertia(1.0, np.array([0.1, 0.0, 0.1]), 0.1 * np.eye(3)), pin.SE3.Identity()
        )
    model.addFrame(pin.Frame("tip", parent, 0, pin.SE3(np.eye(3), np.array([0.2, 0.3, 0.4])), pin.FrameType.OP_FRAME))
    for axis in range(model.nq):
        model.lowerPositionLimit[axis], model.upperPositionLimit[axis] = -HALF, HALF
    model.velocityLimit[:] = 2.0
    return model


def positions(robot, q):
    return {name: value for name, value, *_ in robot.describe(q)}


@pytest.mark.parametrize("name", JOINTS)
def test_names_units_and_ranges_are_those_of_each_axis(name):
    _, units, has = JOINTS[name]
    robot = PinocchioRobot(model_of(name), tip="tip")
    several = units.split()
    own = ["several"] if len(several) == 1 else [f"several[{i}]" for i in range(len(several))]
    assert robot.joint_names == ("first", *own, "last")
    assert robot.joint_units == ("rad", *several, "m")
    limited = ["y", *has, "y"]
    np.testing.assert_array_equal(np.isfinite(robot.position_limit).all(axis=0), [one == "y" for one in limited])
    assert {row.unit for row in JointLimits().labels(robot, "velocity")} == {f"{unit}/s" for unit in robot.joint_units}


@pytest.mark.parametrize("name", JOINTS)
def test_a_step_moves_each_axis_by_its_velocity(name):
    """The position of an axis follows its velocity, and no other one."""
    robot = PinocchioRobot(model_of(name), tip="tip")
    rng = np.random.default_rng(1)
    q = robot.random(rng)
    for column, axis in enumerate(robot.joint_names):
        step = np.zeros(robot.nv)
        step[column] = 0.01
        before, after = positions(robot, q), positions(robot, robot.integrate(q, step))
        moved = {one for one in before if abs(after[one] - before[one]) > 1e-12}
        assert moved == ({axis} if axis in before else set())
        if axis in before:
            assert after[axis] - before[axis] == pytest.approx(0.01)


def limited(name, path):
    """The robot, the parts that limit it, and the range of every axis that has one, by each way to say it."""
    _, _, has = JOINTS[name]
    ends = np.where(np.array(["y", *has, "y"]) == "y", 0.2, np.inf)
    model = model_of(name)
    own = PinocchioRobot(model, tip="tip", acceleration_limit=15.0)
    low, high = -ends, ends
    if path == "model":
        return own, JointLimits(), own.position_limit
    if path == "arrays":
        robot = PinocchioRobot(model, tip="tip", acceleration_limit=15.0, position_limit=(low, high))
        return robot, JointLimits(), (low, high)
    if path == "names":
        named = {axis: (-0.2, 0.2) for axis, end in zip(own.joint_names, ends, strict=True) if np.isfinite(end)}
        robot = PinocchioRobot(model, tip="tip", acceleration_limit=15.0, position_limit=named)
        return robot, JointLimits(), (low, high)
    if path == "by hand":
        free = PinocchioRobot(model, tip="tip", position_limit=(-low * -9, high * 9))
        limits = JointLimits(JointPositionLimit(low, high), JointVelocityLimit(2.0), JointAccelerationLimit(15.0))
        return free, limits, (low, high)
    free = PinocchioRobot(model, tip="tip", acceleration_limit=15.0, position_limit=(-9.0, 9.0))
    return free, JointPositionLimit(-0.2, 0.2) + JointVelocityLimit(), (low, high)


@pytest.mark.parametrize("path", ["model", "arrays", "names", "by hand", "numbers"])
@pytest.mark.parametrize("name", JOINTS)
def test_every_axis_keeps_its_limits(name, path):
    robot, limits, (low, high) = limited(name, path)
    for order in "velocity", "acceleration":
        for way in 1.0, -1.0:
            far = PostureTask(robot.integrate(robot.neutral, np.full(robot.nv, 3.0 * way)), gain=4.0)
            record = simulate(
                Controller(robot, limits >> far, order=order, dt=0.01, damping=None),
                robot.neutral,
                duration=1.2,
                certify=40,
            )
            assert record.stopped is None
            assert record.certified_share == 1.0
            assert np.abs(record.v).max() <= 2.0 + 1e-9
            for q in record.q:
                for axis, value in positions(robot, q).items():
                    column = robot.joint_names.index(axis)
                    assert low[column] - 1e-9 <= value <= high[column] + 1e-9, axis
            at_end = positions(robot, record.q[-1])
            for column, axis in enumerate(robot.joint_names):
                if np.isfinite(high[column]):
                    assert at_end[axis] == pytest.approx(high[column] if way > 0 else low[column], abs=1e-6)
    for target in [2.0, 2.0, 2.0], [-2.0, 0.5, -1.0]:
        found = solve_ik(robot, limits >> PositionTask(target, gain=1.0), iterations=60)
        for axis, value in positions(robot, found.q).items():
            column = robot.joint_names.index(axis)
            assert low[column] - 1e-9 <= value <= high[column] + 1e-9, axis


@pytest.mark.parametrize("name", ["ball", "planar", "floating", "slide and wheel"])
def test_a_range_is_refused_where_an_axis_has_no_position(name):
    robot = PinocchioRobot(model_of(name), tip="tip")
    axis = robot.joint_names[2]
    with pytest.raises(InvalidInput, match=r"position limit of 'several\[1\]' = \(-1, 1\): it is one of several"):
        PinocchioRobot(model_of(name), position_limit={axis: (-1, 1)})
    with pytest.raises(InvalidInput, match=r"joint 'several\[\d\]' from -1 to 1 (m|rad); it has no position"):
        Controller(robot, JointPositionLimit(-np.ones(robot.nv), np.ones(robot.nv)), dt=0.01, damping=None)


def test_physics_of_several_joints_in_one_body(tmp_path):
    """Hinges and a slide in a row, with nothing between, are one body of MuJoCo: the torques of the model move it."""
    mujoco = pytest.importorskip("mujoco")
    path = tmp_path / "hip.xml"
    path.write_text(
        '<mujoco><worldbody><body name="base" pos="0 0 1"><geom size=".1" mass="2"/><joint name="x" type="slide"'
        ' axis="1 0 0"/><body name="leg" pos="0 .1 0" euler="10 20 30"><joint name="a" axis="1 0 0" pos=".1 .2 0"'
        ' ref="5"/><joint name="b" axis="0 1 1" pos="0 0 .3"/><joint name="c" type="slide" axis="0 0 1"/>'
        '<geom size=".1" mass="1" pos="0 0 -.3"/><body name="shin" pos="0 0 -.5"><joint name="k" axis="0 1 0"/>'
        '<geom type="box" size=".05 .02 .2" mass=".7"/></body></body></body></worldbody></mujoco>'
    )
    robot = load_robot(path)
    plant = MujocoPlant(robot)
    rng = np.random.default_rng(0)
    for _ in range(3):
        q, v, tau = rng.uniform(-0.5, 0.5, (3, robot.nv))
        data = plant.data
        data.qpos[plant.dofs], data.qvel[plant.dofs], data.qfrc_applied[plant.dofs] = q, v, tau
        mujoco.mj_forward(plant.model, data)
        expected = np.linalg.solve(robot.mass_matrix(q), tau - robot.bias(q, v))
        np.testing.assert_allclose(data.qacc[plant.dofs], expected, rtol=1e-9, atol=1e-9)


BALLS = """<mujoco><worldbody><body name="base" pos="0 0 1"><freejoint/><geom size=".1" mass="2"/>
  <body name="leg" pos="0 .1 0" euler="10 20 30">
    <joint name="hip" type="ball" pos=".02 0 .1" damping=".3" armature=".02"/>
    <geom type="capsule" fromto="0 0 0 .1 0 -.3" size=".03" mass="1"/><body name="shin" pos="0 0 -.5"><joint name="k"/>
    <geom type="box" size=".05 .02 .2" mass=".7"/></body></body></body></worldbody></mujoco>"""


@pytest.mark.parametrize("kind", ["without end", "balls"])
def test_physics_of_joints_without_end_and_of_balls(kind):
    """States come back as they were, and torques accelerate the robot as its model says."""
    mujoco = pytest.importorskip("mujoco")
    robot = load_robot("kinova") if kind == "without end" else load_robot(mujoco.MjModel.from_xml_string(BALLS))
    assert robot.nq != robot.nv
    plant, rng = MujocoPlant(robot), np.random.default_rng(0)
    still, first = robot.integrate(robot.home, np.zeros(robot.nv)), robot.base
    for _ in range(3):
        q, v = robot.integrate(still, rng.uniform(-2.0, 2.0, robot.nv)), rng.uniform(-1.0, 1.0, robot.nv)
        tau = rng.uniform(-1.0, 1.0, robot.nv - first)
        plant.set_state(q, v)
        there = plant.state()
        np.testing.assert_allclose(robot.difference(q, there[0]), 0.0, atol=1e-12)
        np.testing.assert_allclose(there[1], v, atol=1e-12)
        plant.data.qfrc_applied[plant.dofs] = tau
        mujoco.mj_forward(plant.model, plant.data)
        forces = np.concatenate([np.zeros(first), tau]) - robot.model.damping * v
        expected = np.linalg.solve(robot.mass_matrix(q), forces - robot.bias(q, v))
        np.testing.assert_allclose(plant.data.qacc[plant.dofs], expected[first:], rtol=1e-9, atol=1e-9)
        after = plant.advance(q, v, tau, 1e-6)
        np.testing.assert_allclose(robot.difference(q, after[0]), 1e-6 * v, atol=1e-9)


def test_a_ball_on_a_link_without_mass_is_refused_in_physics():
    mujoco = pytest.importorskip("mujoco")
    text = BALLS.replace('armature=".02"/>', '/><joint name="slide" type="slide" axis="0 0 1"/>')
    robot = load_robot(mujoco.MjModel.from_xml_string(text))
    with pytest.raises(InvalidInput, match="the ball 'hip' moves a link without mass"):
        MujocoPlant(robot)


# Units.


@pytest.mark.parametrize(
    ("factors", "unit"), [({"first": 1, "joint1": 2}, "rad"), ({"rail": 1}, "m"), ({"rail": 1, "first": 1}, "(rad, m)")]
)
def test_the_unit_of_a_sum_of_joints(tmp_path, factors, unit):
    parts = [*chain({}, {}, {"kind": "prismatic"})]
    parts[0], parts[2] = parts[0].replace("joint0", "first"), parts[2].replace("joint2", "rail")
    robot = load_robot(write(tmp_path, *parts, links=4))
    task = JointCouplingTask(factors, 0.5, gain=2.0)
    assert task.row_names(robot) == [("sum", unit)]
    found = solve_ik(robot, task)
    assert found.reached
    assert list(found.errors["jointcoupling"]) == [unit]


def test_tolerances_count_in_the_unit_of_the_joint(tmp_path):
    """A slide is met to a length, a hinge to an angle, and a sum of both to the smaller."""
    robot = load_robot(write(tmp_path, *chain({"kind": "prismatic"}, {}), links=3))
    both = PostureTask([0.5, 0.5], gain=1.0)
    summed = JointCouplingTask({"joint0": 1, "joint1": 1}, 0.5, gain=1.0)
    for task in both, summed:
        for tolerance, enough in ((0.6, 1e-9), False), ((1e-9, 0.6), False), ((0.6, 0.6), True):
            found = solve_ik(robot, task, robot.neutral, tolerance=tolerance, settle=False)
            assert found.reached
            assert (found.iterations == 0) == enough
    assert set(solve_ik(robot, both).errors["posture"]) == {"m", "rad"}


def test_what_stops_a_slide_is_told_in_metres(tmp_path):
    robot = load_robot(write(tmp_path, *chain({"kind": "prismatic"}, {}), links=3), tip="link2")
    found = solve_ik(robot, PositionTask([5.0, 5.0, 5.0], gain=1.0), restarts=False)
    h = found.solution.hierarchy
    assert [(h.label_of(row).row, h.label_of(row).unit) for row in range(2)] == [("joint0", "m"), ("joint1", "rad")]


def test_a_runaway_is_told_by_name_and_unit(tmp_path, caplog):
    path = write(tmp_path, *chain({"kind": "prismatic", "lower": 0, "upper": 0}, {}), links=3)
    with caplog.at_level(logging.ERROR, logger="hqp"):
        robot = load_robot(path)
    far = PostureTask([1e4, 0.0], gain=50.0)
    record = simulate(Controller(robot, far, dt=0.01, damping=None), [0.0, 0.0], duration=1.0, speed_cap=100.0)
    assert record.stopped is not None
    assert "joint0 moves at 5e+05 m/s" in str(record.stopped)
