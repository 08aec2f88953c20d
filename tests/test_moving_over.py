"""Habits of other libraries: states without speeds, transforms as targets, limits looked at, configurations between."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from hqp import InvalidInput
from tasks import (
    Controller,
    OrientationTask,
    PlanarArm,
    PoseSetpoint,
    PoseTask,
    PositionTask,
    Stack,
    load_robot,
)
from tasks.base.rotations import exp

PANDA = load_robot("panda", lock=["panda_finger_joint1"])
G1 = load_robot("g1")
R, P = exp(np.array([0.3, -0.5, 0.9])), np.array([0.4, 0.1, 0.5])


class Pose:
    """A transform of a library that we do not know."""

    def __init__(self, matrix: np.ndarray) -> None:
        self.matrix = matrix

    def as_matrix(self) -> np.ndarray:
        return self.matrix

    def translation(self) -> np.ndarray:
        return self.matrix[:3, 3]

    def rotation(self) -> Rotation:
        return Rotation.from_matrix(self.matrix[:3, :3])


def rows(task) -> np.ndarray:
    hierarchy = Stack(task).build(PANDA, "velocity", 0.01).fill(PANDA.at(PANDA.home), 0.0)
    return np.column_stack([hierarchy.dense(), hierarchy.lower])


def test_states_without_speeds_are_at_rest() -> None:
    for robot, q in (PANDA, PANDA.home), (PlanarArm([0.5, 0.4]), np.array([0.3, 0.2])):
        assert (robot.at(q).v == 0.0).all()
        np.testing.assert_array_equal(robot.at(q).frame().position, robot.at(q, np.zeros(robot.nv)).frame().position)


def test_a_transform_is_a_target_wherever_a_pose_is() -> None:
    T = pin.SE3(R, P)
    forms = T, T.homogeneous, Pose(T.homogeneous), PoseSetpoint(T)
    for form in forms:
        for make, plain in (
            (PoseTask, PoseTask(P, R, gain=2.0)),
            (PositionTask, PositionTask(P, gain=2.0)),
            (OrientationTask, OrientationTask(R, gain=2.0)),
        ):
            np.testing.assert_allclose(rows(make(form, gain=2.0)), rows(plain), atol=1e-14)
            other = make(PANDA.at(PANDA.home).transform(), gain=2.0)
            other.target = form
            np.testing.assert_allclose(rows(other), rows(plain), atol=1e-14)
    np.testing.assert_allclose(rows(OrientationTask(Rotation.from_matrix(R), gain=2.0)), rows(plain), atol=1e-14)


def test_a_transform_as_a_live_target_is_seen() -> None:
    task = PoseTask.hold(PANDA.at(PANDA.home), gain=2.0)
    controller = Controller(PANDA, Stack(task), dt=0.01)
    assert np.abs(controller(PANDA.home).v).max() < 1e-12
    task.target = pin.SE3(R, P)
    fresh = Controller(PANDA, Stack(PoseTask(P, R, gain=2.0)), dt=0.01)
    np.testing.assert_allclose(controller(PANDA.home).v, fresh(PANDA.home).v, atol=1e-9)


def test_transforms_are_those_of_pinocchio() -> None:
    q = G1.random(np.random.default_rng(2))
    state, data = G1.at(q), G1.model.createData()
    pin.framesForwardKinematics(G1.model, data, q)
    hand, foot = (data.oMf[G1.model.getFrameId(name)] for name in ("left_rubber_hand", "right_ankle_roll_link"))
    np.testing.assert_allclose(state.transform("left_rubber_hand"), hand.homogeneous, atol=1e-14)
    seen = state.transform("left_rubber_hand", "right_ankle_roll_link")
    np.testing.assert_allclose(seen, foot.actInv(hand).homogeneous, atol=1e-12)


def test_transforms_of_a_planar_arm() -> None:
    state = PlanarArm([0.5, 0.4]).at([0.3, 0.2])
    back = state.transform("link1") @ state.transform("tip", "link1")
    np.testing.assert_allclose(back, state.transform("tip"), atol=1e-15)
    np.testing.assert_allclose(back[:3, 3], state.frame().position, atol=1e-15)


def test_check_limits_names_joint_value_and_range() -> None:
    PANDA.check_limits(PANDA.home)
    q = np.array(PANDA.home)
    q[3] = 0.25
    with pytest.raises(InvalidInput, match=r"'panda_joint4' is at 0\.25 rad, and its range is -3\.07\d* \.\. -0\.0698"):
        PANDA.check_limits(q)
    PANDA.check_limits(q, tolerance=0.5)
    with pytest.raises(InvalidInput, match="must be finite"):
        PANDA.check_limits(np.full(7, np.nan))
    with pytest.raises(InvalidInput, match=r"'joint 1' is at 2 rad.*-1 \.\. 1"):
        PlanarArm([0.5, 0.5], position_limit=(-1.0, 1.0)).check_limits([0.0, 2.0])
    PlanarArm([0.5, 0.5]).check_limits([0.0, 200.0])


def test_interpolation_goes_the_way_of_the_difference() -> None:
    rng = np.random.default_rng(5)
    first, last = G1.random(rng), G1.random(rng)
    for share in 0.0, 0.3, 1.0:
        between = G1.interpolate(first, last, share)
        np.testing.assert_allclose(
            G1.difference(between, pin.interpolate(G1.model, first, last, share)), 0.0, atol=1e-9
        )
    np.testing.assert_allclose(PlanarArm([1.0, 1.0]).interpolate([0.0, 1.0], [1.0, 3.0], 0.5), [0.5, 2.0])
    with pytest.raises(InvalidInput, match=r"end has shape \(3,\)"):
        G1.interpolate(first, np.zeros(3), 0.5)


def test_keyframes_are_configurations_by_name() -> None:
    xml = """<mujoco><worldbody><body><joint name="a" axis="0 0 1"/><geom size="0.1"/></body></worldbody>
    <keyframe><key name="reach" qpos="0.7"/></keyframe></mujoco>"""
    robot = load_robot(mujoco.MjModel.from_xml_string(xml))
    assert robot.configuration("reach") == pytest.approx([0.7])
