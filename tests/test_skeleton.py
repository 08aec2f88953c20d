"""Stick figures: lines between the joints, where the joints are."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import PlanarArm
from tasks.robots.loading import load_robot
from tasks.robots.skeleton import skeleton


def test_a_planar_arm_is_the_line_of_its_points():
    arm = PlanarArm([0.7, 0.5, 0.3])
    q = np.array([0.4, -0.8, 1.1])
    segments = skeleton(arm, q)
    assert segments.shape == (3, 2, 3)
    assert np.array_equal(segments[:, 0, :2], arm.points(q)[:-1])
    assert np.array_equal(segments[:, 1, :2], arm.points(q)[1:])
    assert not segments[..., 2].any()


def test_an_arm_of_pinocchio_is_one_line_from_its_base_to_its_tip():
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    segments = skeleton(robot, robot.home)
    assert np.array_equal(segments[0, 0], np.zeros(3))
    assert np.allclose(segments[1:, 0], segments[:-1, 1], atol=1e-12)
    assert np.allclose(segments[-1, 1], robot.at(robot.home, np.zeros(7)).frame().position, atol=1e-12)
    ends = [robot.at(robot.home, np.zeros(7)).frame(f"panda_joint{i}").position for i in (4, 5, 7)]
    for end in ends:
        assert np.linalg.norm(segments[:, 1] - end, axis=1).min() < 1e-12


def test_lengths_do_not_change_as_the_joints_move():
    robot = load_robot("ur5")
    rng = np.random.default_rng(1)
    lengths = [np.linalg.norm(np.diff(skeleton(robot, robot.random(rng)), axis=1), axis=-1) for _ in range(3)]
    assert np.allclose(lengths[1:], lengths[0], atol=1e-12)


def test_a_floating_base_hangs_on_nothing_and_frames_are_drawn_when_named():
    robot = load_robot("g1")
    alone = skeleton(robot, robot.home)
    with_hands = skeleton(robot, robot.home, frames=["left_rubber_hand", "right_rubber_hand"])
    assert len(with_hands) == len(alone) + 2
    assert not (alone == 0.0).all(axis=-1).any()
    hand = robot.at(robot.home, np.zeros(robot.nv)).frame("left_rubber_hand").position
    assert np.allclose(with_hands[-2, 1], hand, atol=1e-12)


def test_it_does_not_disturb_the_state_of_a_tick():
    robot = load_robot("ur5")
    state = robot.at(robot.home, np.zeros(6))
    before = state.frame().position.copy()
    skeleton(robot, robot.home + 0.5)
    assert np.array_equal(state.frame("tool0").position, before)


def test_what_has_no_skeleton_is_refused():
    arm, robot = PlanarArm([1.0]), load_robot("ur5")
    with pytest.raises(InvalidInput, match=r"q has shape \(2,\); the robot takes \(1,\)"):
        skeleton(arm, [0.0, 0.0])
    with pytest.raises(InvalidInput, match="'hand' is no frame"):
        skeleton(robot, robot.home, frames=["hand"])

    class Point:
        nq = nv = 1

        def at(self, q, v):
            return None

    with pytest.raises(InvalidInput, match=r"a robot has nq, nv and at\(q, v\)"):
        skeleton(3, [0.0])  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match="no skeleton"):
        skeleton(Point(), [0.0])  # type: ignore[arg-type]
