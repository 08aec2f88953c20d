"""Joint limits: their bounds at both orders, and that no motion ever exceeds them."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import (
    Controller,
    JointAccelerationLimit,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PositionTask,
    simulate,
)

ARM = PlanarArm([0.5, 0.4, 0.3])
Q, V = np.array([0.3, 0.5, -0.4]), np.array([0.2, -0.9, 1.0])


def bounds(part, order, dt=0.01):
    rows = (part >> OrientationTask(0.0, gain=1.0)).build(ARM, order, dt)
    level = rows.fill(ARM.at(Q, V), 0.0).levels[0]
    return level.lower, level.upper


@pytest.mark.parametrize("limit", [1.5, [1.0, 2.0, 3.0]])
def test_bounds_at_both_orders(limit):
    top, dt = np.asarray(limit) * np.ones(3), 0.01
    for part, order, lower, upper in (
        (JointVelocityLimit(limit), "velocity", -top, top),
        (JointVelocityLimit(limit), "acceleration", (-top - V) / dt, (top - V) / dt),
        (JointAccelerationLimit(limit), "velocity", V - top * dt, V + top * dt),
        (JointAccelerationLimit(limit), "acceleration", -top, top),
    ):
        for mine, expected in zip(bounds(part, order, dt), (lower, upper), strict=True):
            np.testing.assert_allclose(mine, expected, rtol=1e-14)


@pytest.mark.parametrize("gain", [10.0, 20.0])
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_no_motion_exceeds_its_limits(order, gain):
    """A target out of reach and gains too high: without limits the joints would run away."""
    v_max, a_max, dt = np.array([0.6, 1.0, 1.2]), np.array([8.0, 9.0, 10.0]), 0.01
    tasks = PositionTask([1.5, 0.8], gain=gain) >> OrientationTask(2.0, gain=1.5 * gain)
    limits = JointVelocityLimit(v_max) + JointAccelerationLimit(a_max)
    record = simulate(Controller(ARM, limits >> tasks, order=order, dt=dt), Q, duration=1.5, certify=1)
    assert record.stopped is None
    assert np.all(np.abs(record.v) <= v_max + 1e-9)
    assert np.all(np.abs(record.a) <= a_max + 1e-9 / dt)
    assert np.abs(record.v).max(axis=0) == pytest.approx(v_max, abs=1e-9)  # and they are used to the full
    assert record.certified_share == 1.0

    free = simulate(Controller(ARM, tasks, order=order, dt=dt, backend="pseudoinverse"), Q, duration=0.2, certify=0)
    assert free.diverged_at is not None or np.abs(free.v).max() > 2 * v_max.max()


def test_a_limit_without_a_number_is_the_robots_own():
    arm = PlanarArm([0.5, 0.4], velocity_limit=[1.0, 2.0])
    rows = (JointVelocityLimit() >> OrientationTask(0.0, gain=1.0)).build(arm, "velocity")
    level = rows.fill(arm.at(np.zeros(2), np.zeros(2)), 0.0).levels[0]
    np.testing.assert_array_equal(level.upper, [1.0, 2.0])
    with pytest.raises(InvalidInput, match="the robot has no acceleration limit of its own"):
        JointAccelerationLimit().largest(arm)


@pytest.mark.parametrize(
    ("part", "order", "dt", "named"),
    [
        (JointVelocityLimit(1.0), "acceleration", None, "'velocity': at acceleration order it needs the tick"),
        (JointAccelerationLimit(1.0), "velocity", None, "'acceleration': at velocity order it needs the tick"),
        (JointVelocityLimit([1.0, 2.0]), "velocity", 0.1, r"limit has shape \(2,\).*\(3,\): one a joint"),
        (JointVelocityLimit(), "velocity", 0.1, r"JointVelocityLimit\(3.0\)"),
    ],
)
def test_refuses_what_does_not_fit(part, order, dt, named):
    with pytest.raises(InvalidInput, match=named):
        Controller(ARM, part, order=order, dt=dt)


@pytest.mark.parametrize("limit", [0.0, -1.0, np.nan, np.inf, 1e200, [1.0, -1.0, 1.0]])
def test_refuses_limits_that_are_none(limit):
    with pytest.raises(InvalidInput, match=r"JointVelocityLimit 'velocity': limit.* rad/s must be positive"):
        JointVelocityLimit(limit)


def test_a_name_is_a_string():
    with pytest.raises(InvalidInput, match="name of a JointVelocityLimit = 5 is a int; it must be a str"):
        JointVelocityLimit(1.0, name=5)
