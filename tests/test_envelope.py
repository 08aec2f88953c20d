"""Position, velocity and acceleration limits together: no contradiction, no violation, and always back inside.

No solver takes part: whatever x is chosen between the bounds, however malicious, must be safe.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from kernels import compiled
from stopping import path_of_stop, slow_down

from hqp import InvalidInput
from tasks import JointAccelerationLimit, JointPositionLimit, JointVelocityLimit, PlanarArm, Stack
from tasks.limits.position import RETURN_SPEED
from tasks.rows.kernels import envelope as loops

ORDERS = ["velocity", "acceleration"]


class Joints:
    """So many joints without links: what limits ask of a robot, and no more."""

    position_limit = velocity_limit = acceleration_limit = None

    def __init__(self, n):
        self.nq = self.nv = n

    def at(self, q, v):
        return SimpleNamespace(q=np.asarray(q, dtype=float), v=np.asarray(v, dtype=float))


def bounds(stack, robot, order, dt, q, v):
    """Lower and upper bounds of all limits, shape (limits, nv)."""
    hierarchy = stack.build(robot, order, dt).fill(robot.at(q, v), 0.0)
    assert hierarchy.find_fault() is None
    return hierarchy.lower.reshape(-1, robot.nv), hierarchy.upper.reshape(-1, robot.nv)


def step(order, dt, q, v, x):
    """One tick of the robot; its acceleration too."""
    if order == "velocity":
        return q + dt * x, x, (x - v) / dt
    return q + dt * v + 0.5 * dt**2 * x, v + dt * x, x


class Crowd:
    """Joints with random limits, a fifth of them outside; all can stop before the limit that they are heading for."""

    def __init__(self, n, order, dt):
        rng = self.rng = np.random.default_rng(0)
        width, centre = 10 ** rng.uniform(-3, 1, n), rng.uniform(-2, 2, n)
        away = np.where(rng.random(n) < 0.5, -1.0, 1.0) * (0.5 * width + 10 ** rng.uniform(-12, 0, n))
        self.order, self.dt = order, dt
        self.v_max, self.a_max = 10 ** rng.uniform(-0.5, 0.7, n), 10 ** rng.uniform(0.3, 2.5, n)
        self.lower, self.upper = centre - 0.5 * width, centre + 0.5 * width
        self.lower[rng.random(n) < 0.05], self.upper[rng.random(n) < 0.05] = -np.inf, np.inf
        self.q = centre + np.where(rng.random(n) < 0.2, away, rng.uniform(-0.5, 0.5, n) * width)
        v = rng.uniform(-1, 1, n) * self.v_max
        self.v = slow_down(self.q, v, self.lower, self.upper, self.a_max, dt, order)

    def excess(self, q):
        return np.maximum(q - self.upper, self.lower - q)

    def move(self, x):
        """One tick; accelerations, and how far beyond its range each joint came at any time in it."""
        q, v = self.q, self.v
        self.q, self.v, a = step(self.order, self.dt, q, v, x)
        farthest = self.excess(self.q)
        if self.order == "acceleration":
            turns = v * self.v < 0.0  # the peak is inside the tick
            peak = q - np.divide(v**2, 2.0 * a, out=np.zeros_like(a), where=turns)
            farthest = np.where(turns, np.maximum(farthest, self.excess(peak)), farthest)
        return a, farthest


CHOICES = {
    "rest if possible": lambda least, most, rng, k: np.clip(0.0, least, most),
    "always up": lambda least, most, rng, k: most,
    "always down": lambda least, most, rng, k: least,
    "to and fro": lambda least, most, rng, k: np.where(k // (1 + np.arange(len(least)) % 40) % 2, least, most),
    "random": lambda least, most, rng, k: least + (most - least) * rng.random(len(least)),
    "random extremes": lambda least, most, rng, k: np.where(rng.random(len(least)) < 0.5, least, most),
}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("dt", [0.05, *(pytest.param(dt, marks=pytest.mark.sweep) for dt in (0.01, 0.02))])
@pytest.mark.parametrize("choice", CHOICES)
def test_whatever_is_chosen_between_the_bounds_keeps_all_limits(order, dt, choice):
    n = 1000
    crowd, robot = Crowd(n, order, dt), Joints(n)
    limits = JointPositionLimit(crowd.lower, crowd.upper) + JointVelocityLimit(crowd.v_max)
    rows = (limits + JointAccelerationLimit(crowd.a_max)).build(robot, order, dt)
    inside = crowd.excess(crowd.q) <= 0.0
    for k in range(round(10.0 / dt)):
        with np.errstate(all="raise"):
            hierarchy = rows.fill(robot.at(crowd.q, crowd.v), 0.0)
        lower, upper = hierarchy.lower.reshape(3, n), hierarchy.upper.reshape(3, n)
        least, most = lower.max(axis=0), upper.min(axis=0)
        assert np.all(least <= most)
        now, unit = (0.0, 1.0) if order == "velocity" else (crowd.v, dt)
        np.testing.assert_allclose(upper[1], (crowd.v_max - now) / unit, atol=1e-9)  # it had not to be relaxed
        np.testing.assert_allclose(lower[1], (-crowd.v_max - now) / unit, atol=1e-9)

        a, farthest = crowd.move(CHOICES[choice](least, most, crowd.rng, k))
        assert np.all(np.abs(a) <= crowd.a_max + 1e-9)
        assert np.all(np.abs(crowd.v) <= crowd.v_max + 1e-9)
        assert np.all(farthest[inside] <= 1e-9)
        inside |= crowd.excess(crowd.q) <= 1e-9
    assert inside.all()


POSITIONS, SIZES = st.floats(-1e12, 1e12), st.floats(1e-9, 1e9)


@given(
    q=POSITIONS, v=POSITIONS, low=POSITIONS, inner=POSITIONS, width=SIZES, v_max=SIZES, a_max=SIZES, speed=SIZES,
    dt=st.floats(1e-6, 10.0), order=st.sampled_from(ORDERS),
)  # fmt: skip
def test_the_bounds_leave_something_from_any_state(q, v, low, inner, width, v_max, a_max, speed, dt, order):
    """However far outside, however fast, however narrow; and with several limits of a kind that exclude each other."""
    stack = JointVelocityLimit(v_max) >> (
        JointPositionLimit(low, np.nextafter(low + width, np.inf), return_speed=speed)
        + JointAccelerationLimit(a_max)
        + JointPositionLimit(inner, np.inf)
        + JointPositionLimit(-np.inf, inner - width)
        + JointVelocityLimit(0.1 * v_max)
        + JointAccelerationLimit(2.0 * a_max)
    )
    lower, upper = bounds(stack, Joints(1), order, dt, [q], [v])
    assert lower.max() <= upper.min()


@pytest.mark.parametrize("order", ORDERS)
@given(room=st.floats(0.0, 100.0), v=st.floats(-10.0, 10.0), a_max=st.floats(0.1, 100.0), dt=st.floats(1e-3, 0.1))
def test_the_largest_velocity_is_just_enough_to_stop(order, room, v, a_max, dt):
    """The tick in which it is reached, and then a stop in whole ticks, use up the room."""
    spent = 0.5 * dt * v if order == "acceleration" else 0.0
    if spent > room:
        return
    p = np.array([compiled(loops, "largest_velocity").largest_velocity(room - spent, a_max, dt)])
    tick = dt * p if order == "velocity" else 0.5 * dt * (v + p)
    used = tick + path_of_stop(p, np.array([a_max]), dt, order)
    np.testing.assert_allclose(used, room, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_a_joint_that_is_pushed_against_its_limit_comes_to_rest_on_it(order):
    """In finite time, exactly, without a reversal, and stays."""
    robot, dt, q, v = Joints(2), 0.01, np.array([0.1, -0.3]), np.array([-0.4, 1.0])
    rows = (JointPositionLimit(-1.0, [0.5, 0.7]) + JointAccelerationLimit([3.0, 7.0])).build(robot, order, dt)
    speeds = []
    for _ in range(200):
        q, v, _ = step(order, dt, q, v, rows.fill(robot.at(q, v), 0.0).upper.reshape(2, 2).min(axis=0))
        speeds.append(v)
    np.testing.assert_allclose(q, [0.5, 0.7], atol=1e-12)
    np.testing.assert_allclose(speeds[-20:], 0.0, atol=1e-12)
    assert np.min(speeds[20:]) >= -1e-12
    assert np.max(speeds) > 0.7


def come_to_rest(stack, robot, order, dt, q, v, ticks):
    """Positions, velocities and accelerations of joints that want to stand still, as far as the limits permit."""
    record = []
    for _ in range(ticks):
        lower, upper = bounds(stack, robot, order, dt, q, v)
        still = np.zeros(robot.nv) if order == "velocity" else -v / dt
        q, v, a = step(order, dt, q, v, np.clip(still, lower.max(axis=0), upper.min(axis=0)))
        record.append((q, v, a))
    return np.array(record).swapaxes(0, 1)


@pytest.mark.parametrize("order", ORDERS)
def test_the_way_back_is_slow_and_ends_at_rest_on_the_limit(order):
    arm, dt = PlanarArm([0.5, 0.5], acceleration_limit=5.0), 0.01
    stack = Stack(JointPositionLimit([-1.0, -1.0], [1.0, np.inf], return_speed=0.4))
    q, v, a = come_to_rest(stack, arm, order, dt, np.array([1.7, -1.2]), np.zeros(2), 300)
    np.testing.assert_allclose(q[-1], [1.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(v[-1], 0.0, atol=1e-12)
    assert np.abs(v[5:]).max() == pytest.approx(0.4)
    assert np.abs(a[:20]).max() == pytest.approx(5.0)  # the robot's own: the stack has no limit
    q, _, a = come_to_rest(Stack(stack) + JointAccelerationLimit(), arm, order, dt, np.array([1.7, -1.2]), v[-1], 300)
    assert np.all(np.abs(q[-1]) <= 1.0)
    assert np.abs(a).max() == pytest.approx(5.0)


def test_without_an_acceleration_limit_the_velocity_order_returns_at_once():
    stack = Stack(JointPositionLimit(-1.0, 1.0))
    q, v, _ = come_to_rest(stack, Joints(1), "velocity", 0.01, np.array([1.018]), np.zeros(1), 5)
    np.testing.assert_allclose(v[:, 0], [-RETURN_SPEED] * 3 + [-0.3, 0.0], atol=1e-10)
    np.testing.assert_allclose(q[-1], 1.0, atol=1e-12)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("excess", [1e-16, 1e-12, 1e-7])
def test_a_joint_outside_by_round_off_is_not_kicked(order, excess):
    arm = PlanarArm([0.5], acceleration_limit=50.0)
    stack = Stack(JointPositionLimit(-1.0, 0.0))
    _, v, _ = come_to_rest(stack, arm, order, 0.01, np.array([excess]), np.zeros(1), 5)
    assert np.abs(v).max() <= 1.001 * excess / 0.01


@pytest.mark.parametrize("order", ORDERS)
def test_the_velocity_limit_bounds_the_way_back_too(order):
    """That of the stack, and else the robot's own."""
    dt, start = 0.01, (np.array([2.0, 1.9]), np.zeros(2))
    own = PlanarArm([0.5, 0.5], velocity_limit=[0.1, 0.2], acceleration_limit=5.0)
    limit = JointPositionLimit(-1.0, 1.0)
    _, v, _ = come_to_rest(Stack(limit), own, order, dt, *start, 100)
    np.testing.assert_allclose(v.min(axis=0), [-0.1, -0.2])
    _, v, _ = come_to_rest(limit >> JointVelocityLimit(0.3), own, order, dt, *start, 100)
    np.testing.assert_allclose(v.min(axis=0), [-0.3, -0.3])


@pytest.mark.parametrize("order", ORDERS)
def test_a_joint_beyond_its_velocity_limit_brakes_as_hard_as_it_may(order):
    limits = JointVelocityLimit(1.0) + JointAccelerationLimit(10.0)
    _, v, a = come_to_rest(limits, Joints(1), order, 0.01, np.zeros(1), np.array([1.55]), 5)
    np.testing.assert_allclose(a, -10.0)
    for fast in [1.55], v[2]:
        lower, upper = bounds(limits, Joints(1), order, 0.01, [0.0], fast)
        assert lower.max() == upper.min()


@pytest.mark.parametrize("order", ORDERS)
def test_a_limit_alone_writes_its_own_numbers(order):
    """The robot's own limits do not relax a velocity limit in a stack that asks for no other."""
    arm, v = PlanarArm([0.5], velocity_limit=1.0, acceleration_limit=2.0), np.array([3.0])
    _, upper = bounds(Stack(JointVelocityLimit()), arm, order, 0.01, np.zeros(1), v)
    assert upper[0, 0] == pytest.approx(1.0 if order == "velocity" else -200.0)


@pytest.mark.parametrize("order", ORDERS)
def test_a_free_side_stays_free(order):
    """Unlike the bound of the acceleration limit, it never becomes active."""
    limits = JointPositionLimit([-np.inf, 0.0], [1.0, np.inf]) + JointAccelerationLimit(5.0)
    lower, upper = bounds(limits, Joints(2), order, 0.01, [0.0, 0.0], [0.1, -0.1])
    assert lower[0, 0] == -np.inf
    assert upper[0, 1] == np.inf
    assert np.isfinite([upper[0, 0], lower[0, 1]]).all()


def test_of_two_ranges_that_exclude_each_other_the_first_holds():
    limits = JointPositionLimit(-1.0, 0.0) >> JointPositionLimit(0.5, 1.0)
    q, _, _ = come_to_rest(limits, Joints(1), "velocity", 0.01, np.array([0.2]), np.zeros(1), 100)
    np.testing.assert_allclose(q[-1], 0.0, atol=1e-12)


def test_one_limit_in_two_stacks_brakes_as_each_of_them_permits():
    limit, robot, state = JointPositionLimit(-1.0, 1.0), Joints(1), (np.array([0.9]), np.array([0.0]))
    soft, hard = (bounds(limit + JointAccelerationLimit(a), robot, "velocity", 0.1, *state)[1][0] for a in (1.0, 100.0))
    assert soft < hard


def test_needs_to_know_how_hard_it_can_brake():
    limit = JointPositionLimit(-1.0, 1.0, name="shoulder")
    with pytest.raises(InvalidInput, match=r"'shoulder': at acceleration order .*JointAccelerationLimit\(20.0\)"):
        Stack(limit).build(PlanarArm([0.5]), "acceleration", 0.01)
    Stack(limit).build(PlanarArm([0.5], acceleration_limit=1.0), "acceleration", 0.01)
    (limit + JointAccelerationLimit(1.0)).build(PlanarArm([0.5]), "acceleration", 0.01)
