"""Wheels and balls that bear a robot: they roll as tasks of wheels do, and their forces act where they touch."""

from __future__ import annotations

import copy
from functools import cache

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from contact_scenes import DT, advanced, quadruped

from hqp import InvalidInput
from tasks import (
    CenterOfMassTask,
    Contact,
    Controller,
    Dynamics,
    ForceTask,
    JointLimits,
    JointTorqueLimit,
    MujocoPlant,
    PinocchioRobot,
    PositionTask,
    PostureTask,
    RigidContactPlant,
    RollingTask,
    Stack,
    SupportLimit,
    Surface,
    load_robot,
    simulate,
)
from tasks.contacts.motion import ContactMotion

RADIUS = 0.1
WHEEL = """<body name="{}" pos="{} {} 0"><joint name="{}_joint" axis="0 1 0"/>
  <geom type="cylinder" size=".1 .02" euler="90 0 0" mass="1"/></body>"""
WHEELS = {"fl": (0.25, 0.25), "fr": (0.25, -0.25), "rl": (-0.25, 0.25), "rr": (-0.25, -0.25)}
CART = f"""<mujoco><worldbody><body name="base" pos="0 0 .1"><freejoint/>
  <geom type="box" size=".3 .2 .05" mass="10"/>{"".join(WHEEL.format(n, x, y, n) for n, (x, y) in WHEELS.items())}
  <body name="mast" pos="0 0 .05"><joint name="mast" axis="0 1 0" range="-60 60"/>
    <geom type="capsule" fromto="0 0 0 0 0 .6" size=".03" mass="3"/></body></body></worldbody></mujoco>"""


@cache
def cart() -> PinocchioRobot:
    return load_robot(mujoco.MjModel.from_xml_string(CART), torque_limit=30.0, acceleration_limit=200.0)


def wheels() -> tuple[Contact, ...]:
    return tuple(Contact(name, radius=RADIUS, friction=0.6) for name in WHEELS)


def test_it_is_written_as_it_was_made() -> None:
    assert repr(wheels()[0]) == "Contact('fl', radius=0.1, friction=0.6)"


def drive(feet: tuple[Contact, ...]) -> Controller:
    """The cart speeds up to 0.3 m/s and goes on, its mast upright."""

    def way(t: float):
        done = min(t, 1.0)
        x = 0.15 * done * done + 0.3 * (t - done)
        return np.array([x, 0.0, 0.0]), np.array([0.3 * done, 0.0, 0.0]), np.array([0.3 * (t < 1.0), 0.0, 0.0])

    standing = Dynamics() + feet[0] + feet[1] + feet[2] + feet[3] >> JointTorqueLimit() + JointLimits()
    upright = PostureTask([0.0], joints=["mast"], gain=5.0) + ForceTask(weight=1e-3)
    stack = standing >> PositionTask(way, frame="base", mask="x", gain=5.0) >> upright
    return Controller(cart(), stack, order="torque", dt=DT)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.1, -0.2, 1.0)])
def test_what_rolls_is_held_as_by_a_task_of_a_wheel(normal) -> None:
    robot, rng = cart(), np.random.default_rng(1)
    contact = ContactMotion(Contact("fl", radius=RADIUS, friction=0.6, normal=normal))
    task = RollingTask(RADIUS, frame="fl", normal=normal, gain=1.0)
    for _ in range(3):
        state = robot.at(
            robot.integrate(robot.home, 0.3 * rng.standard_normal(robot.nv)), rng.standard_normal(robot.nv)
        )
        J, told = contact.jacobian(state), task.jacobian(state)
        turn = np.linalg.lstsq(told.T, J.T, rcond=None)[0].T  # slip is told along other axes of the plane
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
        np.testing.assert_allclose(turn @ told, J, atol=1e-12)
        np.testing.assert_allclose(turn @ task.drift(state), contact.drift(state), atol=1e-12)


def test_it_goes_back_to_its_height_and_to_no_place() -> None:
    robot, shared = cart(), ContactMotion(Contact("fl", radius=RADIUS, friction=0.6, gain=5.0))
    controller = Controller(robot, Stack(shared.contact) >> PostureTask(robot.home, gain=1.0), dt=0.01)
    controller(robot.home)
    moved = robot.home.copy()
    moved[:3] += [0.02, 0.03, 0.01]
    v = controller(moved).v
    frame = robot.at(moved, v).frame("fl")
    np.testing.assert_allclose(
        frame.linear @ v + np.cross(frame.angular @ v, [0, 0, -RADIUS]), [0, 0, -0.05], atol=1e-9
    )


def test_a_cart_is_driven_by_the_forces_at_its_wheels() -> None:
    robot, feet = cart(), wheels()
    controller, q, v = drive(feet), robot.home, np.zeros(robot.nv)
    for k in range(600):
        step = controller(q, v, k * DT)
        assert step.ok
        if k % 50 == 0:
            assert step.solution.certify().ok
            data = robot.model.createData()
            lacking = pin.rnea(robot.model, data, q, v, step.a)
            pin.computeJointJacobians(robot.model, data, q)
            pin.updateFramePlacements(robot.model, data)
            for foot in feet:
                J = pin.getFrameJacobian(robot.model, data, robot.frame_index(foot.frame), pin.LOCAL_WORLD_ALIGNED)
                lacking -= (J[:3] - pin.skew(np.array([0.0, 0.0, -RADIUS])) @ J[3:]).T @ step.forces[foot.name][0]
                cop = robot.at(q).frame(foot.frame).rotation @ step.cop[foot.name]
                np.testing.assert_allclose(cop, [0.0, 0.0, -RADIUS], atol=1e-12)
            np.testing.assert_allclose(lacking, np.concatenate([np.zeros(6), step.tau]), atol=1e-9)
        q, v = advanced(robot, q, v, step.a)
    np.testing.assert_allclose(RADIUS * q[7:11], q[0], atol=1e-9)
    np.testing.assert_allclose(q[0], 0.15 + 0.3 * 0.2, atol=1e-4)
    np.testing.assert_allclose(q[2], RADIUS, atol=1e-9)


def test_a_cart_is_driven_in_physics() -> None:
    feet = wheels()
    plant = MujocoPlant(cart(), contacts=feet)
    record = simulate(drive(feet), cart().home, duration=1.5, plant=plant)
    assert record.stopped is None
    assert {status.value for status in record.status} == {"optimal"}
    np.testing.assert_allclose(record.q[-1, 0], 0.3, atol=1e-3)
    np.testing.assert_allclose(RADIUS * record.q[-1, 7:11], record.q[-1, 0], atol=2e-3)
    for name, points in plant.points.items():
        hub = cart().at(record.q[-1]).frame(name).position
        np.testing.assert_allclose(points[0], hub - [0.0, 0.0, RADIUS], atol=1e-9)
        assert abs(points[0, 2]) < 1e-4


def test_wheels_that_hold_roll_as_told() -> None:
    """On constraints of Pinocchio: with the accelerations and forces that the controller tells, at any speed."""
    feet, robot = wheels(), cart()
    controller, q, v = drive(feet), robot.home, np.zeros(robot.nv)
    plant = RigidContactPlant(robot, feet)
    for k in range(300):
        step = controller(q, v, k * DT)
        if k % 60 == 20:
            other = copy.deepcopy(plant)
            after = other.advance(q, v, step.tau, 1e-6)
            np.testing.assert_allclose((after[1] - v) / 1e-6, step.a, atol=1e-6)
            for foot in feet:
                there = robot.at(q).frame(foot.frame).rotation @ other.forces[foot.name][:3]
                np.testing.assert_allclose(there[1:], step.forces[foot.name][0][1:], atol=0.2)  # x is not unique
        q, v = plant.advance(q, v, step.tau, DT)
    np.testing.assert_allclose(RADIUS * q[7:11], q[0], atol=1e-6)
    assert q[0] > 0.05
    np.testing.assert_allclose(q[2], RADIUS, atol=1e-9)


def test_a_ball_that_spins_leans_and_sinks_comes_back_to_its_height() -> None:
    scene, rng = quadruped(), np.random.default_rng(3)
    robot, radius, feet = scene.robot, 0.02, [Contact(foot.frame, radius=0.02) for foot in scene.feet]
    plant, q, v = RigidContactPlant(robot, feet), scene.q, scene.v
    q, v = plant.advance(q, v, np.zeros(12), DT)  # which notes where they are held
    q, v = robot.integrate(q, 0.02 * rng.standard_normal(18)), 0.3 * rng.standard_normal(18)
    for _ in range(800):
        q, v = plant.advance(q, v, 20.0 * (scene.q[7:] - q[7:]) - 2.0 * v[6:], DT)
    for foot in scene.feet:
        here, there = robot.at(q, v).frame(foot.frame), robot.at(scene.q).frame(foot.frame)
        slip = here.linear @ v + np.cross(here.angular @ v, [0.0, 0.0, -radius])
        np.testing.assert_allclose(slip, 0.0, atol=1e-6)
        np.testing.assert_allclose(here.position[2], there.position[2], atol=1e-6)


@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_at_rest_it_is_a_point_where_it_is_lowest(turn: float) -> None:
    """All rows are those of a point there: of forces, of motion, and of the polygon that the robot stands on."""
    scene, radius = quadruped(), 0.02
    robot, q = scene.robot, scene.robot.integrate(scene.q, np.r_[np.zeros(3), turn, 0.5 * turn, 0.0, np.zeros(12)])
    state = robot.at(q, scene.v)
    below = [state.frame(foot.frame).rotation.T @ [0.0, 0.0, -radius] for foot in scene.feet]
    balls = [Contact(foot.frame, radius=radius, friction=0.6) for foot in scene.feet]
    points = [Contact(foot.frame, centre=at, friction=0.6) for foot, at in zip(scene.feet, below, strict=True)]
    told = []
    for feet in balls, points:
        standing = Dynamics() + feet[0] + feet[1] + feet[2] + feet[3]
        stack = standing >> JointTorqueLimit() >> SupportLimit() >> CenterOfMassTask(scene.com, gain=5.0)
        rows = stack.build(robot, "acceleration", DT).fill(state, 0.0)
        told.append((rows.dense(), rows.lower, rows.upper))
    for ball, point in zip(*told, strict=True):
        np.testing.assert_allclose(ball, point, atol=1e-12)


def test_feet_that_are_balls_roll_as_a_robot_leans() -> None:
    scene, radius = quadruped(), 0.02
    robot, feet = scene.robot, tuple(Contact(foot.frame, radius=0.02, friction=0.6) for foot in scene.feet)
    balls = scene._replace(feet=feet)
    com = CenterOfMassTask(scene.com + np.array([0.02, 0.0, -0.02]), gain=5.0)
    controller = Controller(robot, balls.limits >> com >> balls.rest("base"), order="torque", dt=DT)
    q, v = scene.q, scene.v
    for k in range(500):
        step = controller(q, v, k * DT)
        assert step.ok
        q, v = advanced(robot, q, v, step.a)
    assert step.solution.certify().ok
    for foot in feet:
        before, after = (robot.at(each).frame(foot.frame) for each in (scene.q, q))
        turned = pin.log3(after.rotation @ before.rotation.T)
        assert np.linalg.norm(turned) > 0.01
        np.testing.assert_allclose(after.position - before.position, np.cross(turned, [0.0, 0.0, radius]), atol=1e-5)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Contact("fl", radius=0.1, points=[(0.0, 0.0, 0.0)]), "radius = 0.1 m, touches the world at one point"),
        (lambda: Contact("fl", radius=0.1, surface=Surface([0.0, 0.0, 0.1], None)), "it takes no points"),
        (lambda: Contact("fl", radius=0.0), "radius"),
    ],
)
def test_refusals(make, named: str) -> None:
    with pytest.raises(InvalidInput, match=named):
        make()


def test_a_base_in_the_plane_tells_no_weight_for_friction() -> None:
    """Its rows have none of the normal forces: they grew as wheels wanted, and a cart drove off at 70 g."""
    robot = load_robot(mujoco.MjModel.from_xml_string(CART), base="planar", torque_limit=30.0)
    with pytest.raises(InvalidInput, match=r"'fl': its friction hangs on the weight .* base='floating'"):
        Controller(robot, Dynamics() + wheels()[0] >> JointTorqueLimit(), order="torque", dt=DT)
    wall = Contact("base", friction=0.5, normal=(-1.0, 0.0, 0.0))
    assert Controller(robot, Dynamics() + wall >> JointTorqueLimit(), order="torque", dt=DT)(
        robot.home, np.zeros(robot.nv)
    ).ok
