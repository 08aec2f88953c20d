"""Joint limits: their bounds at both orders, and that no motion ever exceeds them."""

from __future__ import annotations

from functools import reduce
from operator import add, rshift
from types import SimpleNamespace

import numpy as np
import pytest
from stopping import slow_down

from hqp import InvalidInput
from tasks import (
    Controller,
    JointAccelerationLimit,
    JointPositionLimit,
    JointTorqueLimit,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
    load_robot,
    simulate,
)
from tasks.limits.limit import JointLimit

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
    record = simulate(Controller(ARM, limits >> tasks, order=order, dt=dt, damping=None), Q, duration=1.5, certify=1)
    assert record.stopped is None
    assert np.all(np.abs(record.v) <= v_max + 1e-9)
    assert np.all(np.abs(record.a) <= a_max + 1e-9 / dt)
    assert np.abs(record.v).max(axis=0) == pytest.approx(v_max, abs=1e-9)  # and they are used to the full
    assert record.certified_share == 1.0

    free = simulate(
        Controller(ARM, tasks, order=order, dt=dt, backend="pseudoinverse", damping=None), Q, duration=0.2, certify=0
    )
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
        (JointPositionLimit(-1.0, 1.0), "velocity", None, "'position': at velocity order it needs the tick"),
        (JointPositionLimit(-1.0, [1.0, 2.0]), "velocity", 0.1, r"highest has shape \(2,\).*\(3,\): one a joint"),
        (JointPositionLimit(), "velocity", 0.1, r"JointPositionLimit\(-2.0, 2.0\)"),
        (JointPositionLimit(-1.0, 1.0), "acceleration", 0.1, r"JointAccelerationLimit\(20.0\)"),
    ],
)
def test_refuses_what_does_not_fit(part, order, dt, named):
    with pytest.raises(InvalidInput, match=named):
        Controller(ARM, part, order=order, dt=dt, damping=None)


def test_position_bounds_far_from_the_limit_and_near():
    """Far: v^2 = 2 a_max d, but for half a step of the velocity. Near: one tick to rest on it, or two."""
    dt, a_max, rest = 0.01, 20.0, np.zeros(3)
    for order, spent in ("velocity", 0.0), ("acceleration", 0.5 * dt * V):
        _, upper = bounds(JointPositionLimit(-9.0, Q + 1.0) + JointAccelerationLimit(a_max), order, dt)
        p = upper[:3] if order == "velocity" else V + dt * upper[:3]
        np.testing.assert_allclose(p, np.sqrt(2.0 * a_max * (1.0 - spent)) - 0.5 * a_max * dt, rtol=1e-3)
    for order, unit in ("velocity", dt), ("acceleration", dt**2):
        stack = JointPositionLimit(Q - 2e-4, Q + 1e-4) + JointAccelerationLimit(a_max)
        level = stack.build(ARM, order, dt).fill(ARM.at(Q, rest), 0.0).levels[0]
        np.testing.assert_allclose(level.lower[:3], -2e-4 / unit)
        np.testing.assert_allclose(level.upper[:3], 1e-4 / unit)


def test_a_position_limit_without_numbers_is_the_robots_own():
    arm = PlanarArm([0.5, 0.4], position_limit=([-1.0, -np.inf], 2.0))
    assert JointPositionLimit().range(arm).tolist() == [[-1.0, -np.inf], [2.0, 2.0]]
    assert JointPositionLimit(0.0, [1.0, 3.0]).range(arm).tolist() == [[0.0, 0.0], [1.0, 3.0]]
    foreign = SimpleNamespace(nq=2, nv=2, at=arm.at)  # one that has never heard of limits
    with pytest.raises(InvalidInput, match=r"no position limit of its own; give one in rad: JointPositionLimit\(-2.0"):
        JointPositionLimit().range(foreign)
    JointPositionLimit(-1.0, 1.0).check(foreign, "velocity", 0.1)


def test_a_position_limit_reads_like_its_declaration():
    assert repr(JointPositionLimit()) == "JointPositionLimit()"
    assert repr(JointPositionLimit(-1, [1, 2], return_speed=0.25)) == (
        "JointPositionLimit(-1.0, [1.0, 2.0], return_speed=0.25)"
    )


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: JointPositionLimit(-1.0), r"'position': upper is missing; give both in rad"),
        (lambda: JointPositionLimit(upper=1.0), "lower is missing"),
        (
            lambda: JointPositionLimit(1.0, 0.5),
            "range: joint 0 from 1 to 0.5; the lowest must not be above the highest",
        ),
        (lambda: JointPositionLimit([0.0, 2.0], 1.0), "joint 1 from 2 to 1"),
        (lambda: JointPositionLimit(np.nan, 1.0), "joint 0 from nan"),
        (lambda: JointPositionLimit([0.0, 2.0], [3.0] * 3), r"lowest has shape \(2,\)"),
        (lambda: JointPositionLimit("a", 1.0), "'position': lower is not an array of real numbers"),
        (lambda: JointPositionLimit(0.0, 1.0, return_speed=0.0), "return speed = 0.0 rad/s must be positive"),
        (lambda: JointPositionLimit(0.0, 1.0, name=5), "name of a JointPositionLimit = 5"),
    ],
)
def test_refuses_ranges_that_are_none(make, named):
    with pytest.raises(InvalidInput, match=named):
        make()


@pytest.mark.parametrize("limit", [-1.0, np.nan, np.inf, 1e200, [1.0, -1.0, 1.0]])
def test_refuses_limits_that_are_none(limit):
    with pytest.raises(InvalidInput, match=r"JointVelocityLimit 'velocity': limit.* rad/s must not be negative, and"):
        JointVelocityLimit(limit)


def test_a_name_is_a_string():
    with pytest.raises(InvalidInput, match="name of a JointVelocityLimit = 5 is a int; it must be a str"):
        JointVelocityLimit(1.0, name=5)


def test_a_position_limit_needs_a_velocity_a_position():
    robot = SimpleNamespace(nq=4, nv=3, at=ARM.at)
    with pytest.raises(InvalidInput, match="4 positions and 3 velocities"):
        JointPositionLimit(-1.0, 1.0).check(robot, "velocity", 0.1)


def random_motion(seed, order):
    """A random arm with all limits, tasks that ask for too much, and a start, every fifth of them outside."""
    rng = np.random.default_rng(seed)
    n, dt = int(rng.integers(2, 7)), float(rng.uniform(0.02, 0.05))
    middle, width = rng.uniform(-1.5, 1.5, n), 10 ** rng.uniform(-1.0, 0.7, n)
    lower, upper = middle - 0.5 * width, middle + 0.5 * width
    q = rng.uniform(lower, upper)
    if seed % 5 == 0:
        out = rng.permutation(n) < rng.integers(1, n + 1)
        beyond = rng.uniform(0.0, 0.5, n)
        q = np.where(out, np.where(rng.random(n) < 0.5, lower - beyond, upper + beyond), q)
    lower[rng.random(n) < 0.1], upper[rng.random(n) < 0.1] = -np.inf, np.inf
    v_max, a_max = rng.uniform(0.3, 3.0, n), rng.uniform(3.0, 40.0, n)
    v = slow_down(q, rng.uniform(-1.0, 1.0, n) * v_max, lower, upper, a_max, dt, order)

    lengths, phi, gain = rng.uniform(0.2, 0.6, n), rng.uniform(-np.pi, np.pi), rng.uniform(1.0, 6.0)
    arm = PlanarArm(lengths, position_limit=(lower, upper), velocity_limit=v_max, acceleration_limit=a_max)
    limits = [JointPositionLimit(), JointVelocityLimit(), JointAccelerationLimit()]
    stack = reduce(rng.choice([add, rshift]), [limits[k] for k in rng.permutation(3)])
    reach = rng.uniform(0.0, 1.5) * lengths.sum()
    stack = stack >> PositionTask([reach * np.cos(phi), reach * np.sin(phi)], gain=gain)
    below = [OrientationTask(phi, gain=gain), PostureTask(rng.uniform(-2.0, 2.0, n), gain=gain)]
    return Controller(arm, stack >> below[rng.integers(2)], order=order, dt=dt, damping=None), q, v


def run(seed, order, duration):
    """The worst violation in one closed loop, of each kind; of positions, from when a joint is first inside.

    And how many ticks the solver left below the limits: x is then the optimum of the levels above, limits included.
    """
    controller, q, v = random_motion(seed, order)
    arm, dt, worst, unsolved = controller.robot, controller.dt, {}, 0
    lower, upper = arm.position_limit
    tops = [k for k, parts in enumerate(controller.stack.levels) if isinstance(parts[0], JointLimit)]

    def note(what, values):
        worst[what] = max(worst.get(what, 0.0), float(np.max(values)))

    inside = np.maximum(q - upper, lower - q) <= 1e-9
    for k in range(round(duration / dt)):
        answer = controller(q, v, k * dt)
        unsolved += not answer.ok
        levels = [answer.solution.hierarchy.levels[i] for i in tops]
        least = np.concatenate([level.lower for level in levels]).reshape(3, -1).max(axis=0)
        most = np.concatenate([level.upper for level in levels]).reshape(3, -1).min(axis=0)
        note("contradiction of bounds", least - most)
        slack = max(np.abs(answer.solution.levels[i].slack).max() for i in tops)
        note("slack of a limit, relative", slack / (1.0 + np.abs(answer.solution.x).max()))
        before = v
        if order == "velocity":
            v = answer.v
            q = q + dt * v
        else:
            q, v = q + dt * v + 0.5 * dt**2 * answer.a, v + dt * answer.a
        excess = np.maximum(q - upper, lower - q)
        inside |= excess <= 1e-9
        note("position", np.where(inside, excess, 0.0))
        note("velocity", np.abs(v) - arm.velocity_limit)
        note("acceleration, over a tick", np.abs(v - before) - dt * arm.acceleration_limit)
    note("joints that stay outside", ~inside)
    return worst, unsolved


def test_the_limits_of_a_robot_may_be_given_as_they_are() -> None:
    """Of a base that floats they are infinite; changed for some joints, they are limits still."""
    robot = load_robot("go2", acceleration_limit=100.0)
    own = JointVelocityLimit() + JointAccelerationLimit()
    given = JointVelocityLimit(robot.velocity_limit) + JointAccelerationLimit(robot.acceleration_limit)
    state = robot.at(robot.home, np.zeros(robot.nv))
    rows = [stack.build(robot, "acceleration", 0.01).fill(state, 0.0) for stack in (own, given)]
    np.testing.assert_array_equal(rows[0].lower, rows[1].lower)
    np.testing.assert_array_equal(rows[0].upper, rows[1].upper)
    weak = np.where(np.arange(robot.nv) == 8, 0.0, robot.torque_limit)
    np.testing.assert_array_equal(JointTorqueLimit(weak).largest(robot), weak)
    for kind in JointVelocityLimit, JointAccelerationLimit, JointTorqueLimit:
        with pytest.raises(InvalidInput, match="limit"):
            kind(np.inf)
        with pytest.raises(InvalidInput, match="limit"):
            kind([1.0, -np.inf])


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("first", range(0, 20, 5))
def test_motions_keep_all_limits(first, order):
    """Twenty random closed loops, a fifth of them from outside: back inside, and no limit ever broken."""
    for seed in range(first, first + 5):
        worst, unsolved = run(seed, order, duration=4.0)
        assert max(worst.values()) <= 1e-9, (seed, worst)
        assert not unsolved


@pytest.mark.sweep
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("first", range(0, 1000, 100))
def test_1000_motions_keep_all_limits(first, order):
    """1000 random starts, 200 of them outside, 10 s each at both orders: ``python -m pytest -m sweep -k limits``.

    A hundred of them take some 30 000 ticks. The solver may leave three of them unsolved, below the limits, and where
    joints rest on their limits its own slack may reach 1e-8.
    """
    total = 0
    for seed in range(first, first + 100):
        worst, unsolved = run(seed, order, duration=10.0)
        assert worst.pop("slack of a limit, relative") <= 1e-8, seed
        assert max(worst.values()) <= 1e-9, (seed, worst)
        total += unsolved
    assert total <= 3
