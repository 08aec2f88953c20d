"""A robot by MuJoCo: the same dynamics as its model, by another road, and a closed loop that keeps its torques."""

from __future__ import annotations

import sys
from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest

from hqp import InvalidInput, MissingPackage
from tasks import (
    Contact,
    Controller,
    JointLimits,
    JointTorqueLimit,
    MujocoPlant,
    OrientationTask,
    PinocchioRobot,
    PlanarArm,
    PositionTask,
    PostureTask,
    RigidContactPlant,
    load_robot,
    simulate,
)
from tasks.robots.library import data_folder

mujoco = pytest.importorskip("mujoco", reason="physics need MuJoCo: pip install 'hqp[mujoco]'")


@cache
def panda(**limits):
    return load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=30.0, **limits)


def motions(robot, count=10):
    rng = np.random.default_rng(1)
    return [(robot.random(rng), *rng.normal(size=(2, robot.nv))) for _ in range(count)]


def torques(model, data, dofs, q, v, a):
    """MuJoCo's own inverse dynamics, of the bodies alone."""
    data.qpos[dofs], data.qvel[dofs], data.qacc[dofs] = q, v, a
    mujoco.mj_inverse(model, data)
    return (data.qfrc_inverse + data.qfrc_passive)[dofs]


@pytest.mark.parametrize("name", ["panda", "ur5", "z1", "xarm7"])
def test_both_models_take_the_same_torques(name):
    model = (panda() if name == "panda" else load_robot(name)).model.copy()
    model.armature = np.linspace(0.1, 0.3, model.nv)
    robot = PinocchioRobot(model)
    plant = MujocoPlant(robot)
    np.testing.assert_array_equal(plant.model.dof_damping[plant.dofs], model.damping)
    for motion in motions(robot):
        tau = torques(plant.model, plant.data, plant.dofs, *motion)
        np.testing.assert_allclose(tau, robot.inverse_dynamics(*motion), rtol=1e-9, atol=1e-9)


def test_mujoco_reads_the_same_robot_from_the_file():
    """The URDF itself, without meshes and with the fingers held: MuJoCo lumps the inertias as Pinocchio does."""
    root = ElementTree.parse(data_folder() / "panda_description/urdf/panda.urdf").getroot()
    for link in root.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    for joint in root.iter("joint"):
        if "finger" in joint.get("name", ""):
            joint.set("type", "fixed")
            for mimic in joint.findall("mimic"):
                joint.remove(mimic)
    model = mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))
    model.jnt_limited[:] = 0
    data = mujoco.MjData(model)
    for motion in motions(panda()):
        tau = torques(model, data, np.arange(7), *motion)
        np.testing.assert_allclose(tau, panda().inverse_dynamics(*motion), rtol=1e-9, atol=1e-9)


def test_what_holds_the_arm_holds_it():
    """Gravity torques keep a robot at rest, and energy stays where nothing pulls, damps or drives."""
    robot, plant = panda(), MujocoPlant(panda())
    q, v = plant.advance(robot.home, np.zeros(7), robot.bias(robot.home, np.zeros(7)), 0.01)
    np.testing.assert_allclose(q, robot.home, atol=1e-12)
    np.testing.assert_allclose(v, 0.0, atol=1e-12)
    model = robot.model.copy()
    model.damping, model.gravity.linear = np.zeros(7), np.zeros(3)
    free = PinocchioRobot(model)
    plant, v = MujocoPlant(free), np.linspace(1.0, -1.0, 7)
    energy = v @ free.mass_matrix(q) @ v / 2
    for _ in range(50):
        q, v = plant.advance(q, v, np.zeros(7), 0.01)
    assert v @ free.mass_matrix(q) @ v / 2 == pytest.approx(energy, rel=1e-6)


def test_a_tick_is_cut_into_steps():
    """The motion is that of the time that passes, however the tick is cut."""
    robot = panda()
    tau = robot.bias(robot.home, np.zeros(7)) + 1.0
    ends = []
    for step in 1.0, 5e-4, 3e-4:
        plant = MujocoPlant(robot, step=step)
        ends.append(plant.advance(robot.home, np.zeros(7), tau, 2e-3)[0])
        assert plant.model.opt.timestep <= step
        assert plant.data.time == pytest.approx(2e-3)
    np.testing.assert_allclose(ends, [ends[1]] * 3, atol=1e-9)
    assert "7 degrees of freedom" in repr(plant)


def test_the_loop_keeps_its_torques_and_its_task():
    """Measured in MuJoCo, driven by torques alone: position first, with motors that are too weak for the rest."""
    motors = (29.0,) * 4 + (4.0,) * 3
    robot = panda(torque_limit=motors)
    hand = robot.at(robot.home, np.zeros(7)).frame()
    reach = PositionTask(np.add(hand.position, [0.1, 0.3, -0.1]), gain=15.0)
    stack = JointTorqueLimit() >> JointLimits() >> reach >> OrientationTask(hand.rotation, gain=15.0)
    controller = Controller(robot, stack >> PostureTask(robot.home, gain=2.0), order="torque", dt=2e-3, damping=None)
    record = simulate(controller, robot.home, duration=1.5, plant=MujocoPlant(robot))
    assert record.stopped is None
    assert record.certified == record.checked
    assert (np.abs(record.tau) - motors).max() <= 1e-9
    assert record.active["torque"].any()
    assert np.linalg.norm(record.errors["position"][-1]) < 1e-3
    model = simulate(controller, robot.home, duration=1.5)  # the plant lags by its damping, and no more
    assert 0.0 < np.abs(model.q - record.q).max() < 0.05


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_plant_is_moved_by_torques(order):
    controller = Controller(panda(), JointLimits(), order=order, dt=2e-3, damping=None)
    with pytest.raises(InvalidInput, match=f"moved by torques, but order = '{order}'; it must be 'torque'"):
        simulate(controller, panda().home, duration=0.1, plant=MujocoPlant(panda()))


def massless():
    model = panda().model.copy()
    model.inertias[7] = type(model.inertias[7]).Zero()
    return PinocchioRobot(model)


@pytest.mark.parametrize(
    ("robot", "named"),
    [
        (lambda: PlanarArm([1, 1]), "need the model of a PinocchioRobot"),
        (lambda: load_robot("ur5", base="planar"), "joint 'root_joint' .* must turn about one axis, or slide along it"),
        (massless, "MuJoCo refuses .*inertia must have positive"),
    ],
)
def test_refuses_robots_that_it_cannot_move(robot, named):
    with pytest.raises(InvalidInput, match=named):
        MujocoPlant(robot())


def test_refuses_a_step_that_is_none():
    with pytest.raises(InvalidInput, match=r"step = 0.0 s must be positive"):
        MujocoPlant(panda(), step=0.0)


def test_without_mujoco_there_is_a_hint(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingPackage, match=r"pip install 'hqp\[mujoco\]'"):
        MujocoPlant(panda())


# What is wrong is refused in words


def test_numbers_that_run_away_end_a_run():
    """MuJoCo would put the robot back to where it began, and the run go on as if nothing was."""
    robot = panda()
    stack = JointLimits() >> PostureTask(robot.home, gain=5.0)
    plant = MujocoPlant(robot)
    plant.push("panda_hand", [1e13, 0.0, 0.0], 1.0)
    controller = Controller(robot, stack, order="torque", dt=2e-3, damping=None)
    record = simulate(controller, robot.home, duration=0.1, plant=plant)
    assert record.stopped is not None
    assert record.stopped.diverged
    plant, fresh = MujocoPlant(robot), MujocoPlant(robot)
    still = np.zeros(robot.nv)
    q, _ = plant.advance(robot.home, still, still + 1e13, 0.01)
    assert not np.isfinite(q).all()
    assert np.array_equal(
        plant.advance(robot.home, still, still, 0.01)[0], fresh.advance(robot.home, still, still, 0.01)[0]
    )


@pytest.mark.parametrize("make", [MujocoPlant, lambda robot: RigidContactPlant(robot, [])])
@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"q": np.zeros(3)}, r"q has shape \(3,\)"),
        ({"v": np.zeros(2)}, r"v has shape \(2,\)"),
        ({"tau": np.zeros(1)}, r"tau has shape \(1,\); it must be"),
        ({"tau": np.full(7, np.nan)}, r"tau\[0\] = nan must be finite"),
        ({"dt": 0.0}, "dt = 0.0 s must be positive"),
        ({"dt": np.nan}, "dt = nan s must be positive"),
    ],
)
def test_plants_refuse_what_is_not_of_their_robot(make, changed, told):
    robot = panda()
    given = {"q": robot.home, "v": np.zeros(robot.nv), "tau": np.zeros(robot.nv), "dt": 1e-3} | changed
    with pytest.raises(InvalidInput, match=told):
        make(robot).advance(**given)


def test_pushes_that_are_over_are_refused():
    plant = MujocoPlant(panda())
    with pytest.raises(InvalidInput, match="it would end at -1 s, and the clock of the plant stands at 0 s"):
        plant.push("panda_hand", [1.0, 0.0, 0.0], 1.0, start=-2.0)


class Gives:
    """A plant that gives anything."""

    def __init__(self, given):
        self.given = given

    def advance(self, q, v, tau, dt):
        return self.given


@pytest.mark.parametrize(
    ("plant", "told"),
    [
        (MujocoPlant, "a plant has advance"),
        (Gives(None), r"advance gave NoneType; it must be \(q, v\)"),
        (Gives((np.zeros(2), np.zeros(7))), r"advance gave shapes \(2,\) and \(7,\)"),
        (Gives((np.zeros(7) * 1j, np.zeros(7))), "advance gave q, which is not an array of real numbers"),
        (Gives((np.zeros(7), ["1"] * 7)), "advance gave v, which is not an array of real numbers"),
    ],
)
def test_what_is_no_plant_is_refused(plant, told):
    controller = Controller(panda(), JointLimits(), order="torque", dt=2e-3, damping=None)
    with pytest.raises(InvalidInput, match=told):
        simulate(controller, panda().home, duration=0.1, plant=plant)


def test_contacts_of_a_plant_have_names_of_their_own_and_hold_by_them():
    robot, still = panda(), np.zeros(7)
    pair = Contact("panda_hand", name="a"), Contact("panda_link5", name="a")
    for make in (lambda: MujocoPlant(robot, contacts=pair)), (lambda: RigidContactPlant(robot, pair)):
        with pytest.raises(InvalidInput, match="two of them are called 'a'"):
            make()
    for given, told in (
        (["left"], "'left', which is no contact of the plant"),
        ("a", "it must give a list of names"),
        (3, "gave 3"),
    ):
        plant = RigidContactPlant(robot, pair[:1], holding=lambda given=given: given)
        with pytest.raises(InvalidInput, match=told):
            plant.advance(robot.home, still, still, 1e-3)
