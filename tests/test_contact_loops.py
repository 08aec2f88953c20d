"""Closed chains that bear weight: their forces are those of MuJoCo and of Pinocchio, at rest and in motion."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from contact_scenes import DT, advanced, humanoid

from hqp import InvalidInput
from tasks import (
    CenterOfMassTask,
    Contact,
    Controller,
    Dynamics,
    ForceTask,
    JointLimits,
    JointTorqueLimit,
    Loop,
    MujocoPlant,
    OrientationTask,
    PinocchioRobot,
    PositionTask,
    PostureTask,
    RigidContactPlant,
    load_robot,
    simulate,
)
from tasks.contacts.loop import LoopMotion

#: A leg whose knee has no motor: a crank at the hip turns it, by a rod, in a parallelogram. Bodies and joints have the
#: same names.
LEG = """<body name="{n}_hip" pos="{x} {y} 0"><joint name="{n}_hip" axis="1 0 0" range="-1 1"/>
  <geom size=".03" mass=".4"/>
  <body name="{n}_thigh"><joint name="{n}_thigh" axis="0 1 0" range="-1.5 2"/>
    <geom type="capsule" size=".015" fromto="0 0 0 0 0 -.2" mass=".5"/>
    <body name="{n}_shank" pos="0 0 -.2"><joint name="{n}_shank" axis="0 1 0" range="-2.5 -.1"/>
      <geom type="capsule" size=".012" fromto="-.01 0 .06 0 0 -.2" mass=".25"/>
      <site name="{n}_foot" pos="0 0 -.2"/></body></body>
  <body name="{n}_crank"><joint name="{n}_crank" axis="0 1 0" range="-3 3"/>
    <geom type="capsule" size=".01" fromto="0 0 0 -.01 0 .06" mass=".08"/>
    <body name="{n}_rod" pos="-.01 0 .06"><joint name="{n}_rod" axis="0 1 0" range="-3 3"/>
      <geom type="capsule" size=".008" fromto="0 0 0 0 0 -.2" mass=".06"/></body></body></body>"""
PLACES = {"FL": (0.2, 0.1), "FR": (0.2, -0.1), "RL": (-0.2, 0.1), "RR": (-0.2, -0.1)}
CLOSED = "".join(f'<connect name="{n}" body1="{n}_rod" body2="{n}_shank" anchor="0 0 -.2"/>' for n in PLACES)
QUADRUPED = f"""<mujoco><compiler angle="radian"/><worldbody><body name="trunk" pos="0 0 .35"><freejoint/>
  <geom type="box" size=".22 .08 .04" mass="8"/>{"".join(LEG.format(n=n, x=x, y=y) for n, (x, y) in PLACES.items())}
</body></worldbody><equality>{CLOSED}</equality></mujoco>"""
#: A bent arm in a plane, the end of which the world holds.
HELD = """<mujoco><default><joint axis="0 1 0"/><geom type="capsule" size=".02"/></default><worldbody>
  <body name="one"><joint name="a"/><geom fromto="0 0 0 .1 0 .3"/>
  <body name="two" pos=".1 0 .3"><joint name="b"/><geom fromto="0 0 0 .3 0 .1"/>
  <body name="three" pos=".3 0 .1"><joint name="c"/><geom fromto="0 0 0 .1 0 -.2"/></body></body></body></worldbody>
  <equality>{}</equality></mujoco>"""
BENT = {"thigh": 0.7, "shank": -1.4, "crank": -0.7, "rod": 1.4}
DRIVEN, PASSIVE = ("hip", "thigh", "crank"), ("shank", "rod")


class Walker(NamedTuple):
    """A quadruped that stands on four closed chains."""

    mj: mujoco.MjModel
    robot: PinocchioRobot
    q: np.ndarray
    loops: tuple[Loop, ...]
    feet: tuple[Contact, ...]

    def controller(self) -> Controller:
        """The centre of mass goes to and fro, on all feet."""
        here = self.robot.at(self.q, np.zeros(self.robot.nv))
        place = here.center_of_mass.position.copy()
        way = np.array([0.02, 0.02, -0.03])

        def sway(t: float):
            c, s = 1.0 - np.cos(3.0 * t), np.sin(3.0 * t)
            return place + way * c, 3.0 * way * s, 9.0 * way * (1.0 - c)

        standing = sum((*self.loops, *self.feet), Dynamics())
        stack = standing >> JointTorqueLimit() + JointLimits() >> CenterOfMassTask(sway, gain=5.0)
        upright = OrientationTask(np.eye(3), frame="trunk", gain=8.0)
        rest = upright >> PostureTask(self.q, gain=4.0) + ForceTask(weight=1e-2)
        return Controller(self.robot, stack >> rest, order="torque", dt=DT)

    def gap(self, q: np.ndarray) -> float:
        """How far its chains are open [m]."""
        state = self.robot.at(q)
        return max(np.abs(LoopMotion(loop).error(state, 0.0)).max() for loop in self.loops)


@cache
def walker() -> Walker:
    mj = mujoco.MjModel.from_xml_string(QUADRUPED)
    torques = {f"{n}_{joint}": 60.0 if joint in DRIVEN else 0.0 for n in PLACES for joint in DRIVEN + PASSIVE}
    robot = load_robot(mj, torque_limit=torques, acceleration_limit=500.0)
    q = robot.configuration({f"{n}_{joint}": angle for n in PLACES for joint, angle in BENT.items()})
    feet = tuple(Contact(f"{n}_foot", friction=0.6, name=f"{n} foot") for n in PLACES)
    return Walker(mj, robot, q, Loop.of(robot), feet)


def run(here: Walker, ticks: int = 500):
    """Ticks of ideal integration, as (q, v, step)."""
    controller, q, v = here.controller(), here.q, np.zeros(here.robot.nv)
    for k in range(ticks):
        step = controller(q, v, k * DT)
        assert step.ok
        yield q, v, step
        q, v = advanced(here.robot, q, v, step.a)


def lacking(here: Walker, q, v, step) -> np.ndarray:
    """What MuJoCo's inverse dynamics of the open chains need beyond all forces of a step, in order of the robot."""
    mj, robot, data = here.mj, here.robot, mujoco.MjData(here.mj)
    own = [mj.joint(name) for name in robot.joint_names[6:]]
    joints, places = [j.dofadr[0] for j in own], [j.qposadr[0] for j in own]
    R, w = robot.at(q, v).frame("trunk").rotation, v[3:6]
    data.qpos[:7], data.qpos[places] = q[[0, 1, 2, 6, 3, 4, 5]], q[7:]
    for numbers, linear, told in (data.qvel, v[:3], v), (data.qacc, step.a[:3] + np.cross(w, v[:3]), step.a):
        numbers[:3], numbers[3:6], numbers[joints] = R @ linear, told[3:6], told[6:]
    mj.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    mujoco.mj_inverse(mj, data)
    total, J = data.qfrc_inverse.copy(), np.zeros((3, mj.nv))
    for foot in here.feet:
        site = data.site(foot.frame)
        mujoco.mj_jac(mj, data, J, None, site.xpos, mj.site(foot.frame).bodyid[0])
        total -= J.T @ step.forces[foot.name][0]
    for loop in here.loops:
        for frame, at, sign in (loop.a, loop.at, 1.0), (loop.b, loop.at_b, -1.0):
            body = data.body(frame)
            mujoco.mj_jac(mj, data, J, None, body.xpos + body.xmat.reshape(3, 3) @ at, mj.body(frame).id)
            total -= sign * J.T @ step.forces[loop.name]
    return np.concatenate([total[:6], total[joints] - step.tau])


def test_the_motion_equation_of_mujoco_holds_with_their_forces() -> None:
    here = walker()
    passive = [i for i, name in enumerate(here.robot.joint_names[6:]) if name.endswith(PASSIVE)]
    for k, (q, v, step) in enumerate(run(here)):
        if k % 50 == 0:
            assert np.abs(lacking(here, q, v, step)).max() < 1e-9
            assert np.abs(step.tau[passive]).max() < 1e-9
            assert np.abs(step.forces["FL"]).max() > 20.0
            assert step.solution.certify().ok
    assert here.gap(q) < 1e-9


def test_they_bear_the_robot_in_physics() -> None:
    """The chains of MuJoCo are springs: they open by less than a micrometre, and bear what was asked for."""
    here = walker()
    plant = MujocoPlant(here.robot, contacts=here.feet)
    record = simulate(here.controller(), here.q, duration=1.0, plant=plant)
    assert record.stopped is None
    assert {status.value for status in record.status} == {"optimal"}
    assert record.certified == record.checked > 0
    assert 0.0 < max(map(here.gap, record.q[::10])) < 1e-6
    assert np.linalg.norm(record.errors["center of mass"], axis=1).max() < 2e-3
    for name, asked in record.forces.items():
        assert np.linalg.norm(plant.forces[name] - asked[-1]) < 0.02 * np.linalg.norm(asked[-1])


def test_chains_that_hold_move_as_told() -> None:
    here = walker()
    plant = RigidContactPlant(here.robot, here.feet)
    for k, (q, v, step) in enumerate(run(here, 201)):
        if k % 100 == 0:
            np.testing.assert_allclose((plant.advance(q, v, step.tau, 1e-6)[1] - v) / 1e-6, step.a, atol=1e-6)
            for loop in here.loops:  # across the plane of a chain forces do nothing, and any will do
                f = here.robot.at(q, v).frame(loop.a).rotation.T @ step.forces[loop.name]
                np.testing.assert_allclose(plant.forces[loop.name][[0, 2]], f[[0, 2]], atol=1e-6)


def test_across_a_gap_their_forces_push_nothing_but_the_chain() -> None:
    """As springs leave it: forces at both points, a gap apart, would turn the whole robot, and grew without bound."""
    here = walker()
    q = here.q.copy()
    q[7:] += 1e-3 * np.cos(np.arange(len(q) - 7))
    assert here.gap(q) > 1e-5
    step = here.controller()(q, np.zeros(here.robot.nv))
    model, data = here.robot.model, here.robot.model.createData()
    needed = pin.rnea(model, data, q, np.zeros(model.nv), step.a)[:6]
    pin.framesForwardKinematics(model, data, q)
    for foot in here.feet:
        frame = data.oMf[here.robot.frame_index(foot.frame)]
        force = pin.Force(frame.rotation.T @ step.forces[foot.name][0], np.zeros(3))
        needed -= (data.oMi[1].inverse() * frame).act(force).vector
    assert np.abs(needed).max() < 1e-9
    assert max(np.abs(step.forces[loop.name]).max() for loop in here.loops) < 500.0


@pytest.mark.parametrize(
    "held", ['<connect body1="three" anchor=".1 0 -.2"/>', '<weld body1="three" anchor=".1 0 0"/>']
)
def test_what_holds_an_arm_from_the_world_bears_it_in_physics(held: str) -> None:
    robot = load_robot(mujoco.MjModel.from_xml_string(HELD.format(held)), torque_limit=[20.0, 20.0, 0.0])
    (loop,) = Loop.of(robot)
    stack = Dynamics() + loop >> JointTorqueLimit() >> PostureTask(np.zeros(3), gain=5.0)
    plant = MujocoPlant(robot)
    record = simulate(Controller(robot, stack, order="torque", dt=DT), np.zeros(3), duration=0.5, plant=plant)
    assert record.stopped is None
    assert np.abs(record.q).max() < 1e-4
    asked, found = record.forces[loop.name][-1], plant.forces[loop.name]
    plane = [0, 2, 4] if len(asked) == 6 else [0, 2]  # all that three joints in a plane can tell
    assert np.abs(asked[plane]).min() > 0.01
    np.testing.assert_allclose(found[plane], asked[plane], atol=0.01 * np.abs(asked).max())


def test_hands_that_hold_one_thing_bear_an_arm_in_physics() -> None:
    """A loop that is given, with its orientation: a forearm without motors hangs on the other hand, by all six."""
    scene = humanoid()
    state = scene.robot.at(scene.q, scene.v)
    a, b = state.frame("left_rubber_hand"), state.frame("right_rubber_hand")
    held = {"at_b": b.rotation.T @ (a.position - b.position), "rotation": b.rotation.T @ a.rotation}
    hands = Loop("left_rubber_hand", "right_rubber_hand", turns=False, name="hands", **held)
    limp = [name.startswith(("right_wrist", "right_elbow")) for name in scene.robot.joint_names]
    weak = JointTorqueLimit(np.where(limp, 0.0, scene.robot.torque_limit))
    standing = Dynamics() + scene.feet[0] + scene.feet[1] + hands >> weak + JointLimits()
    com = CenterOfMassTask(scene.com, gain=6.0)
    reach = PositionTask(a.position + np.array([0.05, 0.0, 0.05]), frame="left_rubber_hand", gain=5.0)
    controller = Controller(scene.robot, standing >> com >> reach >> scene.rest(), order="torque", dt=DT)
    plant = MujocoPlant(scene.robot, contacts=scene.feet, loops=[hands])
    record = simulate(controller, scene.q, duration=1.0, plant=plant)
    assert record.stopped is None
    asked = record.forces["hands"][-1]
    assert np.linalg.norm(asked[:3]) > 5.0
    assert np.linalg.norm(asked[3:]) > 1.0
    np.testing.assert_allclose(plant.forces["hands"], asked, atol=0.05)
    assert np.abs(LoopMotion(hands).error(scene.robot.at(record.q[-1]), 0.0)).max() < 1e-4


def test_plants_close_what_they_are_told_to() -> None:
    here = walker()
    assert [loop.name for loop in MujocoPlant(here.robot).loops] == list(PLACES)
    assert MujocoPlant(here.robot, loops=()).model.neq == 0
    assert MujocoPlant(here.robot, loops=here.loops[:1]).model.neq == 1
    assert [loop.name for loop in RigidContactPlant(here.robot, [], loops=here.loops[1:]).loops] == ["FR", "RL", "RR"]


@pytest.mark.parametrize("plant", [MujocoPlant, lambda robot, **given: RigidContactPlant(robot, [], **given)])
@pytest.mark.parametrize(
    ("loops", "named"),
    [
        ([3], "a loop = 3 is a int; it must be a Loop"),
        ([Loop("trunk", "nose")], "'nose' is no frame"),
        ([Loop("FL_rod", "FR_rod", turns=False)], "axes that are found at the first tick; give rotation="),
        ([Loop("FL_rod", "FR_rod", name="twice")] * 2, "two of them are called 'twice'"),
    ],
)
def test_plants_refuse_loops_that_are_none(plant, loops, named: str) -> None:
    with pytest.raises(InvalidInput, match=named):
        plant(walker().robot, loops=loops)


def test_contacts_of_a_body_that_is_called_as_its_joint_are_found() -> None:
    here = walker()
    feet = [Contact("FL_shank", centre=(0.0, 0.0, -0.2), friction=0.6, name="foot")]
    plant = MujocoPlant(here.robot, contacts=feet)
    plant.set_state(here.q, np.zeros(here.robot.nv))
    plant.push("FL_shank", [0.0, 0.0, 1.0], 0.1)
    np.testing.assert_allclose(plant.points["foot"][0], here.robot.at(here.q).frame("FL_foot").position, atol=1e-12)
    assert list(RigidContactPlant(here.robot, feet).contacts) == feet


def test_the_table_of_a_stack_names_who_writes_a_loop() -> None:
    rows = {row.part: row.writer for row in walker().controller().describe()}
    assert rows["LoopMotion 'FL'"] == "write_loop"
