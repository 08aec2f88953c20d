"""Robots that stand in physics: what is handed over is the same state, and what is asked for is what happens."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from contact_scenes import DT, FEET, Scene, humanoid, moved, quadruped

from hqp import InvalidInput
from tasks import (
    CenterOfMassTask,
    Change,
    Contact,
    Controller,
    Dynamics,
    ForceTask,
    Ground,
    JointLimits,
    JointTorqueLimit,
    Line,
    MujocoPlant,
    PinocchioRobot,
    PoseTask,
    PositionTask,
    PostureTask,
    Record,
    RigidContactPlant,
    Stack,
    Surface,
    Switch,
    from_rpy,
    load_robot,
    simulate,
)

pytest.importorskip("mujoco", reason="physics need MuJoCo: pip install 'hqp[mujoco]'")
sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from _pendulum import Steps
from _standing import moved as slip
from _standing import passed, stops

SCENES = {"humanoid": humanoid, "quadruped": quadruped}
PELVIS = {"humanoid": "pelvis", "quadruped": "base"}


@cache
def scene(name: str) -> Scene:
    return SCENES[name]()


def standing(name: str, task: Stack | CenterOfMassTask | None = None) -> Controller:
    """A controller that keeps the centre of mass where it is, or as it is told."""
    here = scene(name)
    wanted = CenterOfMassTask(here.com, gain=6.0) if task is None else task
    return Controller(here.robot, here.limits >> wanted >> here.rest(PELVIS[name]), order="torque", dt=DT)


def check(record: Record, feet: tuple[Contact, ...]) -> None:
    """It stood: every tick optimal and, of those checked, certified; nothing slipped, no torque or cone was passed."""
    assert record.stopped is None
    assert {status.value for status in record.status} == {"optimal"}
    assert record.certified == record.checked > 0
    assert passed(record, feet) < 1e-9
    for foot in feet:
        assert np.linalg.norm(slip(record, foot), axis=1).max() < 3e-3


@pytest.mark.parametrize("name", SCENES)
def test_a_state_comes_back_as_it_was(name: str) -> None:
    here = scene(name)
    plant = MujocoPlant(here.robot, contacts=here.feet)
    for seed in range(5):
        q, v = moved(here, seed, 10.0)
        plant.set_state(q, v)
        there = plant.state()
        assert np.allclose(there[0], q, atol=1e-15)
        assert np.allclose(there[1], v, atol=1e-13)


def test_a_state_that_is_none_is_refused_and_the_former_name_warns() -> None:
    here = scene("quadruped")
    plant = MujocoPlant(here.robot, contacts=here.feet)
    q, v = moved(here, 0, 1.0)
    plant.set_state(q, v)
    before = plant.state()
    for wrong in (q[:-1], v), (q, v[:-1]), (q * np.nan, v):
        with pytest.raises(InvalidInput):
            plant.set_state(*wrong)
        np.testing.assert_array_equal(np.concatenate(plant.state()), np.concatenate(before))
    with pytest.warns(DeprecationWarning, match="set_state"):
        plant.place(q, v)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"t": float("nan")}, "a switch: t"),
        ({"t": "1"}, "a switch: t"),
        ({"on": 1}, "a switch: on"),
        ({"duration": -1.0}, "a switch: duration"),
        ({"contact": None}, "a switch: contact"),
    ],
)
def test_a_wrong_switch_is_refused_at_once(wrong: dict, told: str) -> None:
    with pytest.raises(InvalidInput, match=told):
        Switch(**({"t": 1.0, "contact": "left", "on": True} | wrong))


@pytest.mark.parametrize("name", SCENES)
def test_points_are_where_the_model_has_them(name: str) -> None:
    here = scene(name)
    plant = MujocoPlant(here.robot, contacts=here.feet)
    q, v = moved(here, 1, 5.0)
    plant.set_state(q, v)
    for foot in here.feet:
        frame = here.robot.at(q, v).frame(foot.frame)
        expected = frame.position + foot.shape.points @ frame.rotation.T
        assert np.allclose(plant.points[foot.name], expected, atol=1e-12)


@pytest.mark.parametrize("name", SCENES)
def test_free_fall(name: str) -> None:
    """Without ground the centre of mass falls as it must; energy, momentum about it and the pose stay those of q, v."""
    here = scene(name)
    robot, model = here.robot, here.robot.model
    plant, data = MujocoPlant(robot), here.robot.model.createData()
    q, v = moved(here, 2)
    begin, none = robot.at(q, v).center_of_mass, np.zeros(robot.nv - 6)
    place, speed = begin.position.copy(), begin.linear @ v
    energy = pin.computeMechanicalEnergy(model, data, q, v)
    turning = pin.computeCentroidalMomentum(model, data, q, v).angular.copy()
    for _ in range(100):
        q, v = plant.advance(q, v, none, DT)
    fallen = place + 0.2 * speed + [0.0, 0.0, -0.5 * 9.81 * 0.2**2]
    assert np.allclose(robot.at(q, v).center_of_mass.position, fallen, atol=1e-8)
    assert pin.computeMechanicalEnergy(model, data, q, v) == pytest.approx(energy, abs=1e-5)
    assert np.allclose(pin.computeCentroidalMomentum(model, data, q, v).angular, turning, atol=1e-7)


def test_free_fall_under_torques_is_that_of_the_model() -> None:
    """One small step, as Pinocchio's forward dynamics say: base and joints, velocities in the axes of the base."""
    here, h = scene("humanoid"), 1e-5
    plant, (q, v) = MujocoPlant(here.robot), moved(here, 3, 2.0)
    tau = np.linspace(-5.0, 5.0, here.robot.nv - 6)
    a = pin.aba(here.robot.model, here.robot.model.createData(), q, v, np.concatenate([np.zeros(6), tau]))
    there = plant.advance(q, v, tau, h)
    assert np.allclose((there[1] - v) / h, a, rtol=1e-3, atol=1e-2 * np.abs(a).max())
    assert np.allclose(there[0], here.robot.integrate(q, h * v + 0.5 * h * h * a), atol=1e-9)


@pytest.mark.parametrize(("start", "duration"), [(0.01, 0.02), (0.0103, 0.0004), (0.01012, 0.00007), (0.0118, 0.0101)])
def test_a_push_is_momentum_whether_it_begins_with_ticks_or_between(start, duration) -> None:
    here = scene("quadruped")
    plant, (q, v) = MujocoPlant(here.robot), (here.q, here.v)
    plant.push("base", [0.0, 60.0, 0.0], duration, start=start)
    mass = sum(inertia.mass for inertia in here.robot.model.inertias)
    speeds = []
    for _ in range(25):
        q, v = plant.advance(q, v, np.zeros(12), DT)
        speeds.append((here.robot.at(q, v).center_of_mass.linear @ v)[1])
    assert np.allclose(speeds[:5], 0.0, atol=1e-9)
    assert np.allclose(speeds[-10:], 60.0 * duration / mass, rtol=1e-4)


@pytest.mark.parametrize("name", SCENES)
def test_held_joints_do_not_creep(name: str) -> None:
    here = scene(name)
    assert MujocoPlant(here.robot, contacts=here.feet).creep(here.q, 1.0) < 1e-5
    assert MujocoPlant(here.robot, contacts=here.feet, ground=Ground(pyramids=True, noslip=0)).creep(here.q, 1.0) < 1e-3


@pytest.mark.parametrize("name", SCENES)
def test_it_stands_and_the_ground_bears_its_weight(name: str) -> None:
    here, plant = scene(name), MujocoPlant(scene(name).robot, contacts=scene(name).feet)
    record = simulate(standing(name), here.q, duration=0.6, plant=plant)
    check(record, here.feet)
    weight = 9.81 * sum(inertia.mass for inertia in here.robot.model.inertias)
    assert np.isclose(sum(f[:, 2].sum() for f in plant.forces.values()), weight, rtol=0.01)
    assert np.linalg.norm(record.errors["center of mass"][-1]) < 1e-3
    for foot in here.feet:
        assert np.allclose(record.forces[foot.name][-1].sum(0), plant.forces[foot.name].sum(0), atol=0.02 * weight)


def test_a_quadruped_that_is_pushed_comes_back() -> None:
    here, plant = scene("quadruped"), MujocoPlant(scene("quadruped").robot, contacts=scene("quadruped").feet)
    plant.push("base", [0.0, 60.0, 0.0], 0.2, start=0.1)
    record = simulate(standing("quadruped"), here.q, duration=1.2, plant=plant)
    check(record, here.feet)
    off = np.linalg.norm(record.errors["center of mass"], axis=1)
    assert off.max() > 0.02
    assert off[-1] < 0.01


@pytest.mark.parametrize(("way", "gain"), [((60.0, 0.0, 0.0), 6.0), ((0.0, 60.0, 0.0), 3.0)], ids=["ahead", "aside"])
def test_a_humanoid_that_is_pushed_comes_back(way: tuple[float, float, float], gain: float) -> None:
    """By nearly as much as its feet can bear; joints may brake as hard as its contacts ask for."""
    here = scene("humanoid")
    robot = load_robot("g1", acceleration_limit=2000.0)
    stack = here.limits >> CenterOfMassTask(here.com, gain=gain) >> here.rest()
    plant = MujocoPlant(robot, contacts=here.feet)
    plant.push("pelvis", way, 0.2, start=0.1)
    record = simulate(Controller(robot, stack, order="torque", dt=DT), here.q, duration=2.0, plant=plant)
    check(record, here.feet)
    off = np.linalg.norm(record.errors["center of mass"], axis=1)
    assert off.max() > 0.015
    assert off[-1] < 0.01


def test_on_ice_it_slips() -> None:
    """The physics judge by their own friction, not by what the controller takes it to be."""
    here = scene("quadruped")
    plant = MujocoPlant(here.robot, contacts=here.feet, ground=Ground(friction=0.02))
    plant.push("base", [0.0, 60.0, 0.0], 0.2)
    record = simulate(standing("quadruped"), here.q, duration=0.3, plant=plant)
    assert max(np.linalg.norm(slip(record, foot), axis=1).max() for foot in here.feet) > 3e-3


@pytest.mark.parametrize("name", [*SCENES, "lines"])
def test_contacts_that_hold_give_the_accelerations_that_were_told(name: str) -> None:
    here = humanoid(points=None, line=0.17, centre=(0.035, 0.0, -0.03)) if name == "lines" else scene(name)
    task = CenterOfMassTask(here.com + np.array([0.01, 0.02, -0.02]), gain=5.0)
    rest = here.rest(PELVIS.get(name, "pelvis"))
    controller = Controller(here.robot, here.limits >> task >> rest, order="torque", dt=DT)
    plant = RigidContactPlant(here.robot, here.feet, holding=lambda: controller.loaded)
    q, v = here.q, here.v
    for k in range(60):
        step = controller(q, v, k * DT)
        after = plant.advance(q, v, step.tau, 1e-6)
        if k % 20 == 0:
            assert np.allclose((after[1] - v) / 1e-6, step.a, atol=1e-6)
        q, v = plant.advance(q, v, step.tau, DT)
    held = np.array([np.linalg.norm(force[:3]) for force in plant.forces.values()])
    asked = np.array([np.linalg.norm(step.forces[foot.name].sum(axis=0)) for foot in here.feet])
    assert np.allclose(held.sum(), asked.sum(), rtol=0.1)
    foot = here.feet[0]
    frames = (here.robot.at(there).frame(foot.frame) for there in (q, here.q))
    now, before = (frame.position + frame.rotation @ foot.shape.centre for frame in frames)
    assert np.linalg.norm(now - before) < 1e-5


def test_a_foot_is_lifted_where_contacts_hold() -> None:
    record, feet = lifted(
        lambda controller, feet: RigidContactPlant(scene("humanoid").robot, feet, holding=lambda: controller.loaded)
    )
    check(record, feet)


@pytest.mark.sweep
def test_a_foot_is_lifted_in_physics() -> None:
    record, feet = lifted(lambda controller, feet: MujocoPlant(scene("humanoid").robot, contacts=feet))
    check(record, feet)


def lifted(plant_of):
    """A humanoid shifts its weight, lifts its right foot by 2 cm and puts it down, in 2 s."""
    here = scene("humanoid")
    state = here.robot.at(here.q, here.v)
    over, foot = state.frame(FEET[0]).position, state.frame(FEET[1])
    com = CenterOfMassTask(stops(here.com, (1.0, [here.com[0], over[1], here.com[2]])), gain=6.0)
    way = stops(foot.position, (1.25, None), (0.25, np.add(foot.position, [0.0, 0.0, 0.02])), (0.25, foot.position))
    swing = PoseTask((way, foot.rotation), frame=FEET[1], gain=20.0)
    controller = standing("humanoid", com + swing)
    switches = [Switch(1.05, "right", on=False, duration=0.1), Switch(1.8, "right", on=True, duration=0.1)]
    plant = plant_of(controller, here.feet)
    record = simulate(controller, here.q, duration=1.95, plant=plant, changes=switches)
    heights = [here.robot.at(q, v).frame(FEET[1]).position[2] for q, v in zip(record.q, record.v, strict=True)]
    assert np.isclose(max(heights) - heights[0], 0.02, atol=1e-3)
    assert not record.forces["right"][590:890].any()
    return record, here.feet


@pytest.mark.parametrize("told", [True, False])
def test_damping_that_is_told_is_no_disturbance(told: bool) -> None:
    """Files of MuJoCo tell of viscous damping: with it in the motion equation a robot goes where it is told."""
    here = quadruped()
    here.robot.model.damping[6:] = 1.0
    motion = Dynamics(joint_damping=here.robot.model.damping if told else None)
    standing = motion + here.feet[0] + here.feet[1] + here.feet[2] + here.feet[3] >> JointTorqueLimit() + JointLimits()
    low = CenterOfMassTask(stops(here.com, (0.4, here.com - [0.0, 0.0, 0.06])), gain=6.0)
    controller = Controller(here.robot, standing >> low >> here.rest("base"), order="torque", dt=DT)
    record = simulate(controller, here.q, duration=0.4, plant=MujocoPlant(here.robot, contacts=here.feet))
    assert record.stopped is None
    off = np.linalg.norm(record.errors["center of mass"], axis=1).max()
    assert off < 1e-3 if told else off > 3e-3
    q, v = record.q[-40], record.v[-40]
    step = controller(q, v, float(record.t[-40]))
    needed = pin.rnea(here.robot.model, here.robot.model.createData(), q, v, step.a) + here.robot.model.damping * v
    lacking = needed[6:] - step.tau - pushed(here, q, step)
    assert (np.abs(lacking).max() < 1e-9) == told


def pushed(here: Scene, q: np.ndarray, step) -> np.ndarray:
    """The joint torques that the contact forces of a step give."""
    model, data = here.robot.model, here.robot.model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    frames = [(here.robot.frame_index(foot.frame), step.forces[foot.name][0]) for foot in here.feet]
    total = sum(pin.getFrameJacobian(model, data, i, pin.LOCAL_WORLD_ALIGNED)[:3].T @ f for i, f in frames)
    return np.asarray(total)[6:]


def test_an_arm_presses_a_table() -> None:
    robot = load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=50.0)
    tip = robot.at(robot.home, np.zeros(7)).frame()
    hand = Contact("panda_hand_tcp", friction=0.5, name="hand")
    press = ForceTask(stops([0.0], (0.3, [20.0])), contact=hand)
    stack = Dynamics() + hand >> JointTorqueLimit() + JointLimits() >> press
    rest = PositionTask(tip.position, gain=5.0) + PostureTask(robot.home, gain=4.0) + ForceTask(weight=1e-3)
    controller = Controller(robot, stack >> rest, order="torque", dt=DT)
    plant = MujocoPlant(robot, contacts=[hand])
    record = simulate(controller, robot.home, duration=0.8, plant=plant)
    check(record, (hand,))
    assert plant.forces["hand"][0, 2] == pytest.approx(20.0, abs=0.2)
    assert record.forces["hand"][-1, 0, 2] == pytest.approx(20.0, abs=1e-6)


def test_forces_are_saved(tmp_path: Path) -> None:
    record = simulate(standing("quadruped"), scene("quadruped").q, duration=0.02)
    record.save(tmp_path / "run.npz")
    loaded = Record.load(tmp_path / "run.npz")
    assert list(loaded.forces) == [foot.name for foot in scene("quadruped").feet]
    for name, forces in record.forces.items():
        assert forces.shape == (10, 1, 3)
        np.testing.assert_array_equal(loaded.forces[name], forces)


@pytest.mark.sweep
def test_twenty_seconds_of_walking_in_place() -> None:
    here, phase, ramp = scene("humanoid"), 0.4, 0.05
    state = here.robot.at(here.q, here.v)
    places = {name: state.frame(frame) for name, frame in zip(("right", "left"), FEET[::-1], strict=True)}
    sides = {name: place.position[1] for name, place in places.items()}
    steps = Steps(sides, here.com, places["left"].position[2] - 0.03, phase, 2.0, 18.0, 0.03)
    swings = [
        PoseTask((steps.foot(name, place.position, 2 * ramp), place.rotation), frame=frame, gain=20.0, name=name)
        for (name, place), frame in zip(places.items(), FEET[::-1], strict=True)
    ]
    controller = standing("humanoid", CenterOfMassTask(steps.center_of_mass, gain=10.0) + swings[0] + swings[1])
    plant = MujocoPlant(here.robot, contacts=here.feet)
    record = simulate(controller, here.q, duration=20.0, plant=plant, changes=steps.switches(ramp))
    check(record, here.feet)
    assert np.linalg.norm(record.errors["center of mass"], axis=1).max() < 5e-3


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda here: MujocoPlant(here.robot, contacts=[Contact("nose", friction=0.5)]), "no frame 'nose'|'nose'"),
        (lambda here: MujocoPlant(here.robot, contacts=[3]), "a contact = 3 is a int; it must be a Contact"),
        (lambda here: MujocoPlant(here.robot, ground=3), "ground = 3 is a int; it must be a Ground"),
        (lambda here: Ground(friction=-1.0), "Ground: friction"),
        (lambda here: Ground(noslip=-1), "Ground: noslip"),
        (
            lambda here: MujocoPlant(here.robot, contacts=here.feet, ground=Ground(time_constant=1e-4)),
            "time_constant = 0.0001 s must be at least twice the step of the physics, 0.001 s",
        ),
        (lambda here: MujocoPlant(here.robot).push("nose", [0, 0, 1], 0.1), "push: frame"),
        (lambda here: MujocoPlant(here.robot).push("universe", [0, 0, 1], 0.1), "on nothing that has mass, and moves"),
        (lambda here: MujocoPlant(here.robot).push("base", [0, 1], 0.1), r"push: force has shape \(2,\)"),
        (lambda here: MujocoPlant(here.robot).push("base", [0, 0, 1], 0.0), "push: duration = 0.0 s must be positive"),
        (lambda here: RigidContactPlant(3, []), "needs the model of a PinocchioRobot"),
    ],
)
def test_refusals(make, named: str) -> None:
    with pytest.raises(InvalidInput, match=named):
        make(scene("quadruped"))


@pytest.mark.parametrize(
    ("switches", "named"),
    [
        ([(0.05, "left", True)], "t = 0.05 s: .*'left' is on already by then; it can be released"),
        ([(0.05, "left", False), (0.02, "left", False)], "t = 0.05 s: .*'left' is off already by then"),
        ([(0.02, "left", False), (0.04, "left", True), (0.06, "left", True)], "t = 0.06 s"),
    ],
)
def test_a_switch_to_where_a_contact_is_already_is_refused_before_the_run(switches, named: str) -> None:
    controller, here = standing("humanoid"), scene("humanoid")
    ticks: list[float] = []
    changes = [Switch(t, name, on=on) for t, name, on in switches]
    with pytest.raises(InvalidInput, match=named):
        simulate(controller, here.q, duration=0.1, changes=changes, progress=ticks.append)
    assert not ticks
    assert controller.bears("left")


def test_a_switch_is_judged_by_the_stack_that_is_solved_by_then() -> None:
    controller, here = standing("humanoid"), scene("humanoid")
    other = Change(0.02, Stack(PostureTask(here.q, gain=1.0)), duration=0.0)
    with pytest.raises(InvalidInput, match=r"t = 0.04 s, by when another stack is solved: 'left' is no contact"):
        simulate(controller, here.q, duration=0.1, changes=[Switch(0.04, "left", on=False), other])
    controller.release("left")
    assert not controller.bears("left")
    with pytest.raises(InvalidInput, match="'left' is off already"):
        simulate(controller, here.q, duration=0.1, changes=[Switch(0.04, "left", on=False)])
    with pytest.raises(InvalidInput, match="'lift' is no contact"):
        controller.bears("lift")


def test_a_switch_names_a_contact_of_the_stack() -> None:
    with pytest.raises(InvalidInput, match="'nose' is no contact of the stack"):
        simulate(standing("quadruped"), scene("quadruped").q, duration=0.1, changes=[Switch(0.0, "nose", on=True)])


# The robot that is handed over is the robot.

LINK = """<link name="{}"><inertial><mass value="{}"/>
<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/><origin xyz="{}"/><axis xyz="{}"/>
<limit lower="-2" upper="2" effort="50" velocity="5"/></joint>"""
FREE_JOINT = """<mujoco><default><joint armature="0.5" damping="2"/></default><worldbody><body pos="0 0 1">
<joint name="root" type="free"/><geom size=".1" mass="2"/><body name="leg" pos=".1 0 0"><joint name="hip" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .3 0 -.3" size=".02" mass="1"/></body></body></worldbody></mujoco>"""


def legged(folder: Path, cross: str = '<link name="cross"/>', hip: str = "hip") -> PinocchioRobot:
    """A floating base with a leg of three joints, two of which turn about a link without mass."""
    links = LINK.format("trunk", 3.0, i=0.02) + LINK.format("thigh", 1.0, i=0.02) + LINK.format("shank", 1.0, i=0.02)
    joints = (
        JOINT.format(hip, "trunk", "thigh", "0 0 -0.3", "1 0 0")
        + JOINT.format("swing", "thigh", "cross", "0 0.1 -0.3", "0 1 0")
        + JOINT.format("bend", "cross", "shank", "0 0 -0.05", "1 0 0")
    )
    (folder / "leg.urdf").write_text(f'<robot name="leg">{links}{cross}{joints}</robot>')
    return load_robot(folder / "leg.urdf", base="floating")


def mass_matrix(plant: MujocoPlant) -> np.ndarray:
    """That of MuJoCo where the base is not turned: its velocities then are those of the robot."""
    import mujoco

    mujoco.mj_fwdPosition(plant.model, plant.data)
    M = np.zeros((plant.model.nv, plant.model.nv))
    for row, unit in zip(M, np.eye(len(M)), strict=True):
        mujoco.mj_mulM(plant.model, plant.data, row, unit)
    return M


@pytest.mark.parametrize("hip", ["hip", "world"])
@pytest.mark.parametrize("kind", ["urdf", "mjcf"])
def test_the_inertia_of_the_plant_is_that_of_the_robot(tmp_path: Path, kind: str, hip: str) -> None:
    if kind == "urdf":
        robot = legged(tmp_path, hip=hip)
    else:
        (tmp_path / "robot.xml").write_text(FREE_JOINT.replace("hip", hip))
        robot = load_robot(tmp_path / "robot.xml")
    plant, q = MujocoPlant(robot), robot.home.copy()
    q[7:] = np.linspace(0.3, 0.6, len(q) - 7)
    plant.set_state(q, np.zeros(robot.nv))
    np.testing.assert_allclose(mass_matrix(plant), robot.mass_matrix(q), atol=1e-12)
    np.testing.assert_array_equal(plant.model.dof_damping, robot.model.damping)
    before = plant.state()[1]
    plant.push("thigh" if kind == "urdf" else "leg", [10.0, 0.0, 0.0], 0.01)
    assert np.abs(plant.advance(q, before, np.zeros(len(q) - 7), 0.01)[1]).max() > 0.01


def test_an_inertia_without_a_mass_is_not_lost(tmp_path: Path) -> None:
    robot = legged(tmp_path, LINK.format("cross", 0.0, i=0.02))
    with pytest.raises(InvalidInput, match="mass and inertia"):
        MujocoPlant(robot)


def test_what_a_base_has_in_one_direction_alone_is_refused(tmp_path: Path) -> None:
    model = legged(tmp_path).model.copy()
    model.damping = np.array([1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    with pytest.raises(InvalidInput, match=r"of joint 'root_joint' \[1\.0, 2\.0, .* must be the same"):
        MujocoPlant(PinocchioRobot(model))


def test_a_contact_on_a_link_that_mujoco_does_not_have_is_refused(tmp_path: Path) -> None:
    robot = legged(tmp_path)
    with pytest.raises(InvalidInput, match="Contact 'foot': frame 'cross' is on a link without mass"):
        MujocoPlant(robot, contacts=[Contact("cross", name="foot")])
    plant, q = MujocoPlant(robot, contacts=[Contact("shank", name="foot")]), robot.home
    plant.set_state(q, np.zeros(robot.nv))
    np.testing.assert_allclose(plant.points["foot"][0], robot.at(q).frame("shank").position, atol=1e-12)


TILTED, MOVING = Surface(rotation=from_rpy(0.2, 0.0, 0.0)), Surface(Line([0.0] * 3, [0.1, 0.0, 0.0], 1.0))


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"surface": TILTED}, "level, and it must be"),
        ({"surface": MOVING}, "its surface moves"),
        ({"normal": (1.0, 0.0, 0.0)}, "level, and it must be"),
        ({"surface": TILTED, "normal": TILTED.rotation(0.0)[0].T @ [0.0, 0.0, 1.0]}, None),
        ({"surface": Surface([0.0, 0.0, 0.3], from_rpy(0.0, 0.0, 1.0))}, None),
    ],
)
def test_the_ground_is_the_surface_of_the_contacts(options: dict, told: str | None) -> None:
    robot, contact = load_robot("go2"), Contact("FL_foot", name="FL", **options)
    if told is None:
        assert MujocoPlant(robot, contacts=[contact]).contacts == (contact,)
        return
    with pytest.raises(InvalidInput, match=f"MujocoPlant: Contact 'FL': .*{told}"):
        MujocoPlant(robot, contacts=[contact])


def test_a_surface_that_moves_is_no_contact_that_holds_in_the_world() -> None:
    with pytest.raises(InvalidInput, match="RigidContactPlant: Contact 'FL': its surface moves"):
        RigidContactPlant(load_robot("go2"), [Contact("FL_foot", name="FL", surface=MOVING)])


def test_joints_that_follow_are_refused_in_words() -> None:
    with pytest.raises(InvalidInput, match="follow others; load it with mimic='lock'"):
        RigidContactPlant(load_robot("panda", mimic="follow"), [])


@pytest.mark.parametrize("make", [MujocoPlant, lambda robot: RigidContactPlant(robot, [])])
def test_what_a_plant_was_made_with_stays_and_its_step_may_be_set(make) -> None:
    plant = make(load_robot("go2"))
    with pytest.raises(InvalidInput, match="contacts is part of its structure"):
        plant.contacts = ()
    with pytest.raises(InvalidInput, match=r"step = 0\.0 s must be positive"):
        plant.step = 0.0
    plant.step = 1e-3
    assert plant.step == 1e-3


def test_a_step_too_long_for_the_ground_is_refused_at_any_time() -> None:
    plant = MujocoPlant(load_robot("go2"), contacts=[Contact("FL_foot", name="FL")])
    with pytest.raises(InvalidInput, match=r"time_constant = 0\.005 s must be at least twice the step"):
        plant.step = 0.004
    assert plant.step == 5e-4
