"""The rows that loops write from the data of a robot are those that follow from what its states tell."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from plain import from_states

from hqp import Status
from tasks import (
    AtLeast,
    AtMost,
    AxisTask,
    BoxLimit,
    CenterOfMassTask,
    Controller,
    JointAccelerationLimit,
    JointLimits,
    JointPositionLimit,
    JointVelocityLimit,
    Line,
    OrientationTask,
    Part,
    PoseTask,
    PositionTask,
    PostureTask,
    RotationSetpoint,
    Setpoint,
    Stack,
    Turn,
    Within,
    load_robot,
)
from tasks.base.rotations import exp
from tasks.robots.pinocchio import PinocchioRobot

DT = 0.005
BRAKING = JointLimits(JointPositionLimit(), JointVelocityLimit(1.0), JointAccelerationLimit(20.0))


def frame_tasks(frame: str, rng: np.random.Generator) -> list[Part]:
    """A task of every kind that the kernel knows."""
    p, R = rng.standard_normal(3), exp(rng.standard_normal(3))
    place = {"frame": frame, "gain": 2.0}
    return [
        PositionTask(p, frame=frame, gain=[1.0, 2.0, 3.0]),
        PositionTask(p, mask="xz", reference="local", **place),
        PositionTask(Line(p, p + 1.0, 2.0), **place),
        PositionTask(Setpoint(p), **place),
        OrientationTask(R, **place),
        OrientationTask(R, mask="yz", reference="local", **place),
        OrientationTask(0.3, **place),
        OrientationTask(Turn(R, np.eye(3), 2.0), reference="local", **place),
        OrientationTask(RotationSetpoint(R), **place),
        PoseTask(p, R, **place),
        PoseTask(p, R, reference="world", **place),
        PoseTask(p, R, reference="local", mask="x z ry", **place),
        AtLeast(PositionTask([0.4], mask="z", **place)),
        AtMost(PositionTask(p, **place)),
        Within(OrientationTask(R, **place), [0.1, 0.2, 0.3], below=0.5),
        BoxLimit([-1.0, -np.inf, 0.0], [1.0, 1.0, np.inf], **place),
    ]


def whole_stack(robot: PinocchioRobot, limits: Part, rng: np.random.Generator) -> Stack:
    parts = [limits]
    for frame in robot.frame_names[-1], robot.frame_names[len(robot.frame_names) // 2], "universe":
        parts += frame_tasks(frame, rng)
    parts += [CenterOfMassTask([0.1, 0.2], mask="xy", gain=2.0), CenterOfMassTask(np.zeros(3), gain=[1.0, 2.0, 3.0])]
    parts += [PostureTask([0.1, 0.2], joints=robot.joint_names[robot.base :][:2], gain=2.0)]
    return Stack(*parts, PostureTask(robot.home, gain=[2.0] * (robot.nv - robot.base)))


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("limits", [JointLimits(), BRAKING], ids=repr)
@pytest.mark.parametrize("name", ["panda", "ur5", "g1", "tiago", "talos"])
def test_both_ways_write_the_same_rows(name: str, limits: Part, order: Any) -> None:
    if (order, limits is BRAKING) == ("acceleration", False):
        return  # nothing to brake with
    robot, rng = load_robot(name), np.random.default_rng(1)
    stack = whole_stack(robot, limits, rng)
    fast, plain = stack.build(robot, order, DT), stack.build(from_states(robot), order, DT)
    for _ in range(10):
        q = robot.integrate(robot.random(rng), 0.05 * rng.standard_normal(robot.nv))  # now and then out of its range
        v, t = rng.standard_normal(robot.nv), float(rng.uniform(-0.5, 2.5))
        ours, theirs = (rows.fill(robot.at(q, v), t).numbers.copy() for rows in (fast, plain))
        np.testing.assert_allclose(ours, theirs, rtol=1e-11, atol=1e-11)


def test_targets_that_are_set_from_outside_are_seen_at_the_next_tick() -> None:
    robot = load_robot("ur5")
    hand, turn = Setpoint(np.zeros(3)), RotationSetpoint(np.eye(3))
    stack = PositionTask(hand, gain=2.0) >> OrientationTask(turn, gain=2.0)
    rows = stack.build(robot, "velocity")
    state = robot.at(robot.home, np.zeros(6))
    tip = state.frame()
    hand.move(tip.position + np.array([0.1, 0.0, 0.0]), velocity=[0.0, 1.0, 0.0])
    turn.move(exp([0.0, 0.0, 0.5]) @ tip.rotation, omega=[3.0, 0.0, 0.0])
    assert rows.fill(state, 0.0).lower == pytest.approx([0.2, 1.0, 0.0, 3.0, 0.0, 1.0])


def test_parts_which_it_does_not_know_stand_beside_those_which_it_does() -> None:
    class Mine(PositionTask):
        """A subclass may say anything."""

        def error(self, state, t):
            return super().error(state, t) + 1.0

    robot = load_robot("ur5")
    aim = AxisTask([0.0, 0.0, -1.0], gain=2.0)
    stack = JointLimits() >> PositionTask([0.4, 0.2, 0.4], gain=2.0) >> aim >> Mine([0.4, 0.2, 0.4], gain=2.0)
    rows = stack.build(robot, "velocity", DT)
    measured = {type(part) for part, plan in rows.plans if plan.python is not None}
    assert Mine in measured
    assert not measured & {JointLimits, PositionTask}
    h = rows.fill(robot.at(robot.home, np.zeros(6)), 0.0)
    np.testing.assert_array_equal(h.levels[3].lower, h.levels[1].lower + 2.0)


def test_limits_beside_the_merged_ones_have_their_say() -> None:
    robot = load_robot("ur5")
    stack = JointLimits() >> JointVelocityLimit(0.1) >> PositionTask([0.4, 0.2, 0.4], gain=2.0)
    level = stack.build(robot, "velocity", DT).fill(robot.at(robot.home, np.zeros(6)), 0.0).levels[1]
    np.testing.assert_array_equal(level.upper, 0.1)
    assert Controller(robot, stack, dt=DT, damping=None)(robot.home, np.zeros(6)).ok


@pytest.mark.parametrize("where", ["q", "v", "t", "target"])
def test_numbers_that_mean_nothing_are_a_status(where: str) -> None:
    robot, hand = load_robot("ur5"), Setpoint([0.4, 0.2, 0.4])
    controller = Controller(robot, JointLimits() >> PositionTask(hand, gain=2.0), dt=DT, damping=None)
    q, v, t = np.array(robot.home), np.zeros(6), 0.0
    assert controller(q, v, t).ok
    if where == "q":
        q[2] = np.nan
    elif where == "v":
        v[1] = np.nan
    elif where == "t":
        t = np.inf
    else:
        hand.move([0.4, np.nan, 0.4])
    assert controller(q, v, t).solution.status is Status.INVALID
