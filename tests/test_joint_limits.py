"""All joint limits in one row a joint: the same motion as each by itself, and the right one is named."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from hqp import Side
from tasks import (
    Controller,
    JointAccelerationLimit,
    JointLimits,
    JointPositionLimit,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
    load_robot,
    simulate,
)

DOWN = np.diag([1.0, -1.0, -1.0])


@cache
def robot(name, accelerates):
    limit = 15.0 if accelerates else None
    if name == "panda":
        return load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=limit)
    return PlanarArm(
        [0.5, 0.4, 0.3], position_limit=(-1.5, 1.5), velocity_limit=[1.0, 1.5, 2.0], acceleration_limit=limit
    )


def each(accelerates):
    limits = JointPositionLimit() + JointVelocityLimit()
    return limits + JointAccelerationLimit() if accelerates else limits


STARTS = {"planar": [0.4, 0.9, 0.6], "panda": [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]}
TARGETS = {
    "planar": [PositionTask([1.5, 0.3], gain=4.0), PositionTask([-0.9, -0.3], gain=6.0)],
    "panda": [
        PositionTask([0.9, 0.5, 0.9], gain=4.0) >> OrientationTask(DOWN, gain=3.0),
        PositionTask([-0.5, 0.6, 0.1], gain=4.0),
    ],
}


@pytest.mark.parametrize("name", STARTS)
@pytest.mark.parametrize(
    ("order", "accelerates"), [("velocity", False), ("velocity", True), ("acceleration", True)], ids=str
)
def test_the_same_motion_as_each_by_itself(name, order, accelerates):
    arm, q0 = robot(name, accelerates), np.array(STARTS[name])
    for target in TARGETS[name]:
        tasks = target >> PostureTask(q0 - 1.0, gain=2.0)
        one, three = (
            simulate(Controller(arm, limits >> tasks, order=order, dt=0.01, damping=None), q0, duration=2.0, certify=20)
            for limits in (JointLimits(), each(accelerates))
        )
        assert one.stopped is None
        np.testing.assert_allclose(one.q, three.q, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(one.v, three.v, rtol=0.0, atol=1e-9)
        assert (one.certified_share, three.certified_share) == (1.0, 1.0)
        assert np.abs(one.active["joint limits"]).sum() > 50  # and it was not for nothing


def test_the_same_bounds_from_any_state():
    """From beyond all limits too, where they relax each other: the intersection is not empty, and is theirs."""
    arm, rng = robot("planar", True), np.random.default_rng(4)
    for order in ("velocity", "acceleration"):
        one = (JointLimits() >> OrientationTask(0.0, gain=1.0)).build(arm, order, 0.01)
        three = (each(True) >> OrientationTask(0.0, gain=1.0)).build(arm, order, 0.01)
        for _ in range(200):
            state = arm.at(rng.uniform(-2.0, 2.0, 3), rng.uniform(-3.0, 3.0, 3))
            mine, theirs = one.fill(state, 0.0).levels[0], three.fill(state, 0.0).levels[0]
            np.testing.assert_array_equal(mine.lower, theirs.lower.reshape(3, 3).max(axis=0))
            np.testing.assert_array_equal(mine.upper, theirs.upper.reshape(3, 3).min(axis=0))
            assert (mine.lower <= mine.upper).all()


def causes(limits, arm, q, v, target, order="velocity", dt=0.01):
    """What holds back a posture, of each joint that is held: side and name of the limit."""
    solution = Controller(arm, limits >> PostureTask(target, gain=5.0), order=order, dt=dt)(q, v).solution
    assert solution.certify().ok
    return {cause.row: (cause.side, cause.part) for cause in solution.explain().levels[1].causes}


def test_the_limit_that_holds_a_joint_is_named():
    arm = robot("planar", False)
    found = causes(JointLimits(), arm, [0.0, 1.499, -1.5], [0.0] * 3, [1.4, 2.0, -2.0])
    assert found == {
        "joint 0": (Side.UPPER, "velocity limit"),
        "joint 1": (Side.UPPER, "position limit"),
        "joint 2": (Side.LOWER, "position limit"),
    }
    panda = robot("panda", False)
    q = np.array(STARTS["panda"])
    q[3] = panda.position_limit[0, 3] + 1e-3
    found = causes(JointLimits(), panda, q, np.zeros(7), q + np.eye(7)[4] - np.eye(7)[3])
    assert found == {
        "panda_joint4": (Side.LOWER, "position limit"),
        "panda_joint5": (Side.UPPER, "velocity limit"),
    }


def test_at_velocity_order_with_accelerations():
    arm, v = robot("planar", True), [1.0, 0.0, 0.0]
    found = causes(JointLimits(), arm, [0.0, 1.4999, 0.0], v, [1.4, 2.0, 1.0])
    assert found == {
        "joint 0": (Side.UPPER, "velocity limit"),
        "joint 1": (Side.UPPER, "position or acceleration limit"),
        "joint 2": (Side.UPPER, "position or acceleration limit"),
    }


def test_at_acceleration_order():
    arm, v = robot("planar", True), [1.0, 0.0, 0.0]
    found = causes(JointLimits(), arm, [0.0, 1.4999, 0.0], v, [9.0, 9.0, 9.0], "acceleration")
    assert found == {
        "joint 0": (Side.UPPER, "position or velocity limit"),
        "joint 1": (Side.UPPER, "position or velocity limit"),
        "joint 2": (Side.UPPER, "acceleration limit"),
    }


def test_a_limit_that_is_not_there_is_not_named():
    arm = robot("planar", False)
    position, velocity = JointLimits(JointPositionLimit()), JointLimits(JointVelocityLimit())
    found = causes(position, arm, [0.0, 1.5, 0.0], [0.0] * 3, [0.1, 2.0, 0.1])
    assert found == {"joint 1": (Side.UPPER, "position limit")}
    found = causes(velocity, arm, [0.0] * 3, [1.0, 0.0, 0.0], [9.0, 0.1, 0.1], "acceleration")
    assert found == {"joint 0": (Side.UPPER, "velocity limit")}
    speeds = np.array([1.0, np.inf, 2.0])  # as of a model that names some
    some = SimpleNamespace(nq=3, nv=3, at=arm.at, position_limit=arm.position_limit, velocity_limit=speeds)
    found = causes(JointLimits(), some, [0.0, 1.5, 0.0], [0.0] * 3, [0.1, 2.0, 0.1])
    assert found == {"joint 1": (Side.UPPER, "position limit")}


def test_in_words():
    arm = robot("planar", False)
    controller = Controller(arm, JointLimits() >> PostureTask([1.4, 0.0, 0.0], gain=5.0), dt=0.01)
    text = str(controller([0.0] * 3, [0.0] * 3).solution.explain())
    assert "joint limits met" in text
    assert "posture short by 6 rad/s: joint 0 velocity limit (upper)" in text


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_it_counts_where_the_limits_it_stands_for_count(order):
    """Its accelerations are those that a position limit elsewhere in the stack brakes with."""
    arm = robot("planar", False)
    together = JointLimits(JointVelocityLimit(), JointAccelerationLimit(10.0)) >> JointPositionLimit()
    apart = JointVelocityLimit() + JointAccelerationLimit(10.0) >> JointPositionLimit()
    runs = [
        simulate(Controller(arm, limits >> TARGETS["planar"][1], order=order, dt=0.01), STARTS["planar"], duration=1.5)
        for limits in (together, apart)
    ]
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0.0, atol=1e-9)
    assert (np.abs(runs[0].q) <= 1.5 + 1e-9).all()
