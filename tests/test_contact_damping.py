"""Damped levels where contact forces are unknowns: at rest damping costs nothing, as forces may stay."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from contact_scenes import DT, Scene, advanced, humanoid

from tasks import CenterOfMassTask, Controller, Damped, Damping, PositionTask, PostureTask, SupportLimit

HAND = "right_rubber_hand"


def controller_of(scene: Scene, level: Damped | CenterOfMassTask | PositionTask) -> Controller:
    return Controller(scene.robot, scene.limits >> level >> scene.rest(), order="torque", dt=DT)


@pytest.mark.parametrize("damping", [0.01, 0.03])
def test_a_damped_level_in_reach_is_met_at_rest(damping: float) -> None:
    scene = humanoid()
    level = CenterOfMassTask(scene.com + np.array([0.0, 0.02, -0.01]), gain=5.0)
    controller, q, v = controller_of(scene, Damped(level, damping)), scene.q, scene.v
    for k in range(1500):
        step = controller(q, v, DT * k)
        q, v = advanced(scene.robot, q, v, step.a)
    assert step.solution.certify().ok
    off = level.target(0.0)[0] - scene.robot.at(q, v).center_of_mass.position
    assert np.linalg.norm(off) < 1e-4
    assert np.abs(v).max() < 1e-2


def test_a_damped_hand_lets_the_robot_stand() -> None:
    scene = humanoid()
    start = scene.robot.at(scene.q, scene.v).frame(HAND).position
    hand = PositionTask(start + np.array([0.1, 0.0, 0.1]), frame=HAND, gain=3.0)
    stack = scene.limits >> SupportLimit(0.02) >> Damped(hand, 0.3) >> scene.rest()
    controller, q, v = Controller(scene.robot, stack, order="torque", dt=DT), scene.q, scene.v
    for k in range(1000):
        step = controller(q, v, DT * k)
        q, v = advanced(scene.robot, q, v, step.a)
    borne = sum(force[:, 2].sum() for force in step.forces.values())
    weight = 9.81 * scene.robot.mass_matrix(scene.q)[0, 0]
    assert borne == pytest.approx(weight, rel=0.05)
    assert (
        scene.robot.at(q, v).frame("pelvis").position[2] > 0.9 * scene.robot.at(scene.q, v).frame("pelvis").position[2]
    )


def test_a_copy_goes_on_with_the_forces_that_levels_are_damped_towards() -> None:
    scene = humanoid()
    level = Damped(CenterOfMassTask(scene.com + np.array([0.0, 0.02, 0.0]), gain=5.0), 0.1)
    controller, q, v = controller_of(scene, level), scene.q, scene.v
    for k in range(5):
        step = controller(q, v, DT * k)
        q, v = advanced(scene.robot, q, v, step.a)
    other = copy.deepcopy(controller)
    np.testing.assert_allclose(other(q, v, 0.01).tau, controller(q, v, 0.01).tau, rtol=0.0, atol=1e-6)


def test_who_is_left_strict_says_so() -> None:
    scene = humanoid()
    level = CenterOfMassTask(scene.com, gain=5.0)
    assert "strict, as forces are unknowns" in repr(controller_of(scene, level))
    assert "strict" not in repr(controller_of(scene, Damped(level, 0.1)))
    hand = PositionTask([0.2, -0.1, 0.8], frame=HAND, gain=3.0)
    assert "strict" not in repr(Controller(scene.robot, hand, dt=DT))
    beside = scene.limits >> hand + PostureTask(scene.q, gain=4.0, weight=0.1) + Damping(0.1)
    assert "strict" not in repr(Controller(scene.robot, beside, order="torque", dt=DT))
    asked = Controller(scene.robot, scene.limits >> level, order="torque", dt=DT, damping=None)
    assert "damping=None" in repr(asked)
    assert "strict" not in repr(asked)
