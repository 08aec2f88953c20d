"""Robots of one's own, which offer the methods of the protocols and nothing else, on contacts, commanded by torques."""

from __future__ import annotations

import numpy as np
import pytest
from contact_scenes import DT, Scene, advanced, moved, quadruped

from hqp import InvalidInput
from tasks import (
    CapturePointTask,
    CenterOfMassTask,
    Contact,
    Controller,
    Dynamics,
    ForceTask,
    JointLimits,
    JointTorqueLimit,
    MomentumTask,
    PlanarArm,
    PostureTask,
    load_robot,
)


class OwnState:
    """What a state has to tell, copied out of another one."""

    def __init__(self, robot, state):
        self.robot, self._state = robot, state
        self.q, self.v, self.joints = state.q, state.v, np.array(state.joints)
        self.center_of_mass = state.center_of_mass

    def frame(self, name=None):
        return self._state.frame(name)


class OwnRobot:
    """A robot by plain Python: sizes, states, the manifold, the base, limits and the motion equation."""

    def __init__(self, model):
        self._model = model
        self.nq, self.nv, self.base = model.nq, model.nv, model.base
        self.neutral, self.home = np.array(model.neutral), np.array(model.home)
        self.joint_names, self.joint_units = tuple(model.joint_names), tuple(model.joint_units)
        self.position_limit, self.velocity_limit = model.position_limit, model.velocity_limit
        self.torque_limit, self.acceleration_limit = model.torque_limit, model.acceleration_limit

    def at(self, q, v):
        return OwnState(self, self._model.at(q, v))

    def integrate(self, q, step):
        return self._model.integrate(q, step)

    def difference(self, start, end):
        return self._model.difference(start, end)

    def mass_matrix(self, q):
        return self._model.mass_matrix(q)

    def bias(self, q, v):
        return self._model.bias(q, v)

    def inverse_dynamics(self, q, v, a):
        return self._model.inverse_dynamics(q, v, a)


def standing(scene: Scene, robot):
    """The stack of a robot that stands, and its contacts: one controller has one."""
    feet = [Contact(foot.frame, friction=0.6, name=foot.frame) for foot in scene.feet]
    stand = Dynamics() + feet[0] + feet[1] + feet[2] + feet[3]
    com = CenterOfMassTask(scene.com + np.array([0.02, 0.0, 0.0]), gain=5.0)
    stack = (
        stand >> JointTorqueLimit() + JointLimits() >> com >> PostureTask(scene.q, gain=4.0) + ForceTask(weight=1e-2)
    )
    return Controller(robot, stack, order="torque", dt=DT), feet


def test_a_quadruped_of_ones_own_is_commanded_like_any_other():
    scene = quadruped()
    own, _ = standing(scene, OwnRobot(scene.robot))
    compiled, _ = standing(scene, scene.robot)
    for seed in range(3):
        q, v = moved(scene, seed, 0.3)
        mine, theirs = own(q, v), compiled(q, v)
        assert mine.ok
        assert mine.solution.certify().ok
        np.testing.assert_allclose(mine.a, theirs.a, atol=1e-6)
        np.testing.assert_allclose(mine.tau, theirs.tau, atol=1e-6)
        for foot in mine.forces:
            np.testing.assert_allclose(mine.forces[foot], theirs.forces[foot], atol=1e-6)


def test_its_motion_equation_holds_with_the_forces_that_are_told():
    scene = quadruped()
    robot = OwnRobot(scene.robot)
    controller, feet = standing(scene, robot)
    q, v = np.array(scene.q), np.zeros(robot.nv)
    for k in range(3):
        if k == 1:
            controller.release(feet[0], 0.0)
        step = controller(q, v, k * DT)
        pushed = sum(robot.at(q, v).frame(foot.frame).linear.T @ step.forces[foot.name].sum(axis=0) for foot in feet)
        left = robot.mass_matrix(q) @ step.a + robot.bias(q, v) - pushed
        np.testing.assert_allclose(left[:6], 0.0, atol=1e-8)
        np.testing.assert_allclose(left[6:], step.tau, atol=1e-8)
        q, v = advanced(scene.robot, q, v, step.a)


def test_a_fixed_arm_of_ones_own_presses():
    model = load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=30.0)
    q, answers = np.array([0.0, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8]), []
    for robot in OwnRobot(model), model:
        hand = Contact("panda_hand", centre=(0.0, 0.0, 0.1), friction=0.5, name="hand")
        press = ForceTask([20.0], contact=hand)
        stack = Dynamics() + hand >> JointTorqueLimit() + JointLimits() >> press >> PostureTask(q, gain=4.0)
        step = Controller(robot, stack, order="torque", dt=DT)(q, np.zeros(7))
        assert step.solution.certify().ok
        answers.append(step)
    np.testing.assert_allclose(answers[0].tau, answers[1].tau, atol=1e-6)
    assert answers[0].forces["hand"][0, 2] == pytest.approx(20.0)


def without(name, model):
    """A robot of one's own that lacks an ability."""
    able = {own: value for own, value in vars(OwnRobot).items() if own not in (name, "__dict__", "__weakref__")}
    kind = type("Lacking", (), able)
    robot = kind(model)
    vars(robot).pop(name, None)
    return robot


@pytest.mark.parametrize(
    ("name", "said"),
    [("mass_matrix", "dynamics"), ("bias", "dynamics"), ("torque_limit", "torque")],
)
def test_what_a_robot_of_ones_own_lacks_is_said(name, said):
    scene = quadruped()
    with pytest.raises(InvalidInput, match=said):
        standing(scene, without(name, scene.robot))


def on_one_foot(task):
    scene = quadruped()
    foot = Contact(scene.feet[0].frame, friction=0.6, name="foot")
    stack = Dynamics() + foot >> JointTorqueLimit() >> task >> PostureTask(scene.q, gain=4.0)
    return scene, Controller(OwnRobot(scene.robot), stack, order="torque", dt=DT)


def test_a_task_of_momentum_needs_how_accelerations_change_it():
    """A robot of one's own may tell its momentum, but not the map of accelerations to it."""
    with pytest.raises(InvalidInput, match="momentum"):
        on_one_foot(MomentumTask(gain=3.0))


def test_the_capture_point_takes_the_centre_of_mass_alone():
    scene, controller = on_one_foot(CapturePointTask([0.0, 0.0], gain=3.0))
    assert controller(scene.q, scene.v).solution.certify().ok


def test_arms_in_the_plane_are_refused():
    arm = PlanarArm([0.5, 0.5], acceleration_limit=20.0)
    with pytest.raises(InvalidInput, match=r"moves in the plane; contacts take robots in space|mass|dynamics"):
        Controller(arm, Dynamics() + Contact("tip", friction=0.5) >> PostureTask([0.0, 0.0], gain=1.0), order="torque")
