"""Springs of joints, as a file of MuJoCo has them: in the motion equation, and in physics."""

from __future__ import annotations

import copy
import logging

import mujoco
import numpy as np
import pytest

from hqp import InvalidInput
from tasks import Controller, Dynamics, JointLimits, JointTorqueLimit, MujocoPlant, PostureTask, load_robot

TEXT = """<mujoco><worldbody><body name="one">
  <joint name="hip" axis="0 1 0" range="-90 90" stiffness="30" springref="20"/>
  <geom type="capsule" fromto="0 0 0 0 0 -.4" size=".04"/><body name="two" pos="0 0 -.4">
  <joint name="leg" type="slide" axis="0 0 1" stiffness="800" ref=".1" springref=".05"/>
  <geom type="capsule" fromto="0 0 0 0 0 -.3" size=".03"/><body name="three" pos="0 0 -.3">
  <joint name="ankle" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".02"/>
  </body></body></body></worldbody></mujoco>"""


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(TEXT)


def test_they_are_read_and_said(model, caplog) -> None:
    with caplog.at_level(logging.WARNING, logger="hqp"):
        robot = load_robot(model)
    assert robot.springs == {"hip": (30.0, pytest.approx(np.radians(20.0))), "leg": (800.0, pytest.approx(0.05))}
    assert robot.left_out == ("springs of the joints hip, leg (Dynamics(springs=robot.springs) counts them)",)
    assert copy.deepcopy(robot).springs == robot.springs
    assert load_robot(model, lock=["hip"]).springs == {"leg": (800.0, pytest.approx(0.05))}
    assert load_robot("panda").springs == {}


@pytest.mark.usefixtures("nothing_told")
def test_those_of_joints_that_follow_others_are_said(caplog) -> None:
    equality = '<equality><joint joint1="ankle" joint2="hip" polycoef="0 1 0 0 0"/></equality></mujoco>'
    text = TEXT.replace('name="ankle"', 'name="ankle" stiffness="5"').replace("</mujoco>", equality)
    with caplog.at_level(logging.WARNING, logger="hqp"):
        robot = load_robot(mujoco.MjModel.from_xml_string(text), mimic="follow")
    assert list(robot.springs) == ["hip", "leg"]
    assert "springs of joints that follow others are left out: ankle" in caplog.text


@pytest.mark.parametrize("own", [True, False], ids=["the file", "the plant"])
def test_what_is_told_is_what_happens(model, own: bool) -> None:
    """The torques cause the accelerations in MuJoCo, in its model of the file and in that of the plant."""
    robot = load_robot(model, torque_limit=500.0, acceleration_limit=300.0)
    stack = (
        Dynamics(springs=robot.springs) >> JointTorqueLimit() + JointLimits() >> PostureTask([0.3, 0.1, 0.5], gain=3.0)
    )
    controller, rng = Controller(robot, stack, order="torque", dt=2e-3), np.random.default_rng(0)
    for _ in range(4):
        q, v = robot.integrate(robot.home, 0.1 * rng.standard_normal(3)), 0.3 * rng.standard_normal(3)
        step = controller(q, v)
        if own:
            data = mujoco.MjData(model)
            data.qpos[:], data.qvel[:], data.qfrc_applied[:] = q, v, step.tau
            mujoco.mj_forward(model, data)
            np.testing.assert_allclose(data.qacc, step.a, atol=1e-8)
        else:
            after = MujocoPlant(robot).advance(q, v, step.tau, 1e-6)[1]
            np.testing.assert_allclose((after - v) / 1e-6, step.a, atol=2e-3)


def test_they_may_be_set_at_work(model) -> None:
    robot = load_robot(model, torque_limit=500.0)
    dynamics = Dynamics()
    controller = Controller(robot, dynamics >> PostureTask(robot.home, gain=3.0), order="torque", dt=2e-3)
    without = controller(robot.home, np.zeros(3)).tau
    dynamics.springs = {"ankle": (10.0, 0.2)}
    np.testing.assert_allclose(controller(robot.home, np.zeros(3)).tau - without, [0.0, 0.0, -2.0], atol=1e-9)


@pytest.mark.parametrize(
    ("springs", "named"),
    [
        ({"hpi": (1.0, 0.0)}, "hip"),
        ({"hip": (-1.0, 0.0)}, "springs of 'hip'"),
        ({"hip": 3.0}, "must be a pair: stiffness and rest"),
        ([3.0], "springs"),
    ],
)
def test_refusals(model, springs, named: str) -> None:
    with pytest.raises(InvalidInput, match=named):
        Controller(load_robot(model, torque_limit=9.0), Dynamics(springs=springs), order="torque", dt=2e-3)


def test_a_joint_without_a_position_has_none() -> None:
    robot = load_robot("go2", acceleration_limit=500.0)
    with pytest.raises(InvalidInput, match=r"joint 'root_joint\[2\]' has no position of its own"):
        Controller(robot, Dynamics(springs={"root_joint[2]": (1.0, 0.0)}), order="torque", dt=2e-3)
