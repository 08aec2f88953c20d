"""Rows of distances: their law, what is changed in them at work, obstacles of one's own, steps, the interpreter."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import (
    AvoidanceTask,
    Capsule,
    Circle,
    Controller,
    DistanceLimit,
    JointAccelerationLimit,
    JointVelocityLimit,
    LinkCapsule,
    PlanarArm,
    PositionTask,
    SelfCollisionLimit,
    Sphere,
    load_robot,
    planar_links,
    solve_ik,
)
from tasks.obstacles.shapes import Obstacle
from tasks.rows.part import Stack

DT, FAST = 0.01, 1.5
ORDERS = ["velocity", "acceleration"]
ARM = PlanarArm([0.5, 0.4, 0.3], velocity_limit=2.0, acceleration_limit=30.0)


@cache
def robot(name):
    return ARM if name == "arm" else load_robot(name)


def links(name):
    """Some of a robot, made anew."""
    frames = {
        "panda": [("panda_link2", "panda_link3"), ("panda_link4", "panda_link5"), ("panda_link7", [0.0, 0.1, 0.2])],
        "g1": [("left_elbow_link", [0.1, 0.0, 0.0]), ("right_ankle_roll_link", [0.1, 0.0, 0.0]), ("pelvis", [0, 0, 0])],
    }
    return planar_links(ARM, 0.02) if name == "arm" else [LinkCapsule(frame, end, 0.05) for frame, end in frames[name]]


def drifting(t):
    """A centre in space."""
    return (
        np.array([0.6 + 0.1 * np.sin(t), 0.1, 0.5 + 0.1 * t]),
        np.array([0.1 * np.cos(t), 0.0, 0.1]),
        np.array([-0.1 * np.sin(t), 0.0, 0.0]),
    )


def obstacles(name):
    """A ball that moves, one that does not, and a rail, made anew."""
    if name == "arm":
        return [
            Sphere(Circle([1.0, 1.0], 0.3, 4.0), 0.1),
            Sphere([0.9, 0.5], 0.1),
            Capsule([-0.2, 0.8], [0.3, 0.9], 0.05),
        ]
    return [Sphere(drifting, 0.1), Sphere([0.6, 0.3, 0.4], 0.1), Capsule([0.5, -0.5, 0.2], [0.7, 0.5, 0.3], 0.04)]


def states(name, count=4, seed=0):
    rng, own = np.random.default_rng(seed), robot(name)
    for _ in range(count):
        q = rng.uniform(-1.2, 1.2, own.nv) if name == "arm" else own.random(rng)
        yield own.at(q, rng.uniform(-1.0, 1.0, own.nv))


def stack_of(part, *, braked=False):
    limits = JointVelocityLimit(FAST) + JointAccelerationLimit(20.0) if braked else JointVelocityLimit(FAST)
    return limits >> part


def rows(built, state, t=0.0):
    """A, and both bounds."""
    level = built.fill(state, t).levels[-1]
    return np.column_stack([level.A, level.lower, level.upper])


@pytest.mark.parametrize("name", ["arm", "panda", "g1"])
def test_bounds_are_those_of_the_law(name):
    """The reserve is read off a limit without margin, of the largest gain: there the bound is linear in it."""
    own, K, margin = robot(name), 7.0, 0.05
    whole = DistanceLimit(links(name), obstacles(name), margin=0.0, gain=1.0 / DT)
    part = DistanceLimit(links(name), obstacles(name), margin=margin, gain=K)
    plain = {order: stack_of(whole).build(own, order, DT) for order in ORDERS}
    asked = {order: stack_of(part).build(own, order, DT) for order in ORDERS}
    for t, state in enumerate(states(name)):
        found = whole.pairs.measure(own, state, t)
        d, n = found[:, 0], found[:, 1:4]
        ways = np.array([o.core(t + DT)[0] - o.core(t)[0] for o in whole.pairs.obstacles] * len(whole.pairs.links))
        along = (n * ways).sum(axis=1) / DT
        most = rows(plain["velocity"], state, t)[:, -2]
        rho = d + DT * (most - along)
        assert (rho > 0.0).all()
        e = d - margin - rho
        back = np.minimum(np.maximum(-e, 0.0), rho) / DT + K * np.maximum(-e - rho, 0.0)
        end, mean = along + back - K * np.maximum(e, 0.0), along + back - np.maximum(e, 0.0) / DT
        here = rows(asked["velocity"], state, t)
        np.testing.assert_allclose(here[:, -2], end, rtol=1e-9, atol=1e-9)
        assert (here[:, -1] == np.inf).all()
        now = here[:, :-2] @ state.v
        first = rows(plain["acceleration"], state, t)[:, -2]
        far = most - now < -10.0  # there the drift can be read off too
        drift = (most - now) / DT - first
        law = np.maximum((end - now) / DT - drift, 2.0 * (mean - now) / DT)
        there = rows(asked["acceleration"], state, t)
        np.testing.assert_allclose(there[far, -2], law[far], rtol=1e-9, atol=1e-6)
        np.testing.assert_array_equal(there[:, :-2], here[:, :-2])
        assert far.any()


@pytest.mark.parametrize("order", ORDERS)
def test_the_nearest_rows_are_among_all_rows(order):
    for name in "arm", "panda":
        every, few = (
            stack_of(DistanceLimit(links(name), obstacles(name), margin=0.02, gain=9.0, nearest=k), braked=True).build(
                robot(name), order, DT
            )
            for k in (None, 4)
        )
        measure = DistanceLimit(links(name), obstacles(name), margin=0.02, gain=9.0)
        for t, state in enumerate(states(name)):
            chosen = np.sort(np.argsort(measure.distances(robot(name), state, t))[:4])
            np.testing.assert_array_equal(rows(few, state, t), rows(every, state, t)[chosen])


def test_the_nearest_point_is_driven_away():
    for name in "arm", "panda":
        part = AvoidanceTask(links(name), obstacles(name), influence=0.9, speed=0.3, gain=6.0)
        near = DistanceLimit(links(name), obstacles(name), margin=0.0, gain=1.0, nearest=1)
        built = {order: Stack(part).build(robot(name), order, DT) for order in (*ORDERS, "displacement")}
        limit = stack_of(near).build(robot(name), "velocity", DT)
        for t, state in enumerate(states(name)):
            found = near.pairs.measure(robot(name), state, t)
            k = int(np.argmin(found[:, 0]))
            s = min(max(1.0 - found[k, 0] / 0.9, 0.0), 1.0)
            fade = s * s * (3.0 - 2.0 * s)
            obstacle = near.pairs.obstacles[k % len(near.pairs.obstacles)]
            row = rows(built["velocity"], state, t)[0]
            np.testing.assert_allclose(row[:-2], fade * rows(limit, state, t)[0, :-2], rtol=1e-12, atol=1e-15)
            wanted = fade * (found[k, 1:4] @ obstacle.velocity(t) + 0.3 * fade)
            np.testing.assert_allclose(row[-2:], wanted, rtol=1e-12, atol=1e-15)
            np.testing.assert_array_equal(rows(built["displacement"], state, t)[0], row)
            speeds = rows(built["acceleration"], state, t)[0]
            np.testing.assert_array_equal(speeds[:-2], row[:-2])


def at_work():
    """Parts with their attributes that are numbers: who has it, which, and another value."""
    yield "limit", lambda part: part, "margin", 0.06
    yield "limit", lambda part: part, "gain", 3.0
    yield "limit", lambda part: part, "weight", 2.0
    yield "task", lambda part: part, "influence", 0.5
    yield "task", lambda part: part, "speed", 0.7
    yield "task", lambda part: part, "gain", 3.0
    yield "task", lambda part: part, "weight", 2.0
    for kind in "limit", "task":
        yield kind, lambda part: part.pairs.links[1], "radius", 0.07
        yield kind, lambda part: part.pairs.obstacles[1], "radius", 0.2
        yield kind, lambda part: part.pairs.obstacles[1], "centre", [0.2, 0.3]
        yield kind, lambda part: part.pairs.obstacles[0], "centre", Circle([0.5, 0.8], 0.1, 2.0)
        yield kind, lambda part: part.pairs.obstacles[2], "radius", 0.3
        yield kind, lambda part: part.pairs.obstacles[2], "start", [0.1, 0.4]
        yield kind, lambda part: part.pairs.obstacles[2], "end", [0.4, 0.4]


def made(kind):
    if kind == "limit":
        return DistanceLimit(links("arm"), obstacles("arm"), margin=0.02, gain=9.0, nearest=5)
    return AvoidanceTask(links("arm"), obstacles("arm"), influence=0.9, speed=0.3)


@pytest.mark.parametrize("order", ORDERS)
def test_what_is_changed_at_work_is_what_a_fresh_one_has(order):
    for kind, owner, name, value in at_work():
        part, fresh = made(kind), made(kind)
        built = stack_of(part, braked=True).build(ARM, order, DT)
        state = next(states("arm"))
        before = rows(built, state)
        setattr(owner(part), name, value)
        setattr(owner(fresh), name, value)
        other = stack_of(fresh, braked=True).build(ARM, order, DT)
        np.testing.assert_array_equal(rows(built, state, 0.3), rows(other, state, 0.3))
        np.testing.assert_array_equal(built.hierarchy.weights, other.hierarchy.weights)
        if kind == "limit":
            np.testing.assert_array_equal(part.distances(ARM, state), fresh.distances(ARM, state))
        assert name == "weight" or not np.array_equal(before, rows(built, state)) or (kind, order) == ("task", order)


def test_what_cannot_change_at_work_is_refused():
    part = made("limit")
    controller = Controller(ARM, stack_of(part), dt=DT, damping=None)
    link, ball, rail = part.pairs.links[0], part.pairs.obstacles[1], part.pairs.obstacles[2]
    for owner, name, value, word in (
        (part, "gain", 101.0, "at most 100"),
        (part, "margin", -0.1, "negative"),
        (part, "weight", [1.0, 2.0], "weight"),
        (part, "rows", 2, "controller.change"),
        (part, "pairs", None, "controller.change"),
        (part, "margins", 0.1, "margin"),
        (part.pairs, "obstacles", (), "structure"),
        (link, "frame", "link2", "structure"),
        (link, "end", [0.1, 0.0], "structure"),
        (link, "radius", -1.0, "negative"),
        (ball, "center", [0.0, 0.0], "centre"),
        (ball, "centre", [np.nan, 0.0], "finite"),
        (ball, "radius", 0.0, "positive"),
        (rail, "start", [0.0], "start"),
    ):
        before = dict(vars(owner))
        with pytest.raises(InvalidInput, match=word):
            setattr(owner, name, value)
        assert vars(owner) == before
    with pytest.raises(ValueError, match="read-only"):
        rail.start[0] = 1.0
    assert controller(np.zeros(3), np.zeros(3)).ok


@pytest.mark.parametrize("order", ORDERS)
def test_a_margin_of_bodies_is_seen_at_work_and_refused_where_it_drops_pairs(order):
    own = load_robot("panda", lock=["panda_finger_joint1"])
    state = own.at(own.home, np.full(7, 0.3))
    part, whole = (SelfCollisionLimit(margin=0.03, gain=9.0, rows=rows) for rows in (8, 100))
    built = stack_of(part, braked=True).build(own, order, DT)
    for name, value in ("margin", 0.02), ("gain", 4.0):
        setattr(part, name, value)
        fresh = SelfCollisionLimit(margin=part.margin, gain=part.gain)
        other = stack_of(fresh, braked=True).build(own, order, DT)
        np.testing.assert_allclose(rows(built, state), rows(other, state), rtol=1e-9, atol=1e-12)  # Coal starts warm
    every = stack_of(whole, braked=True).build(own, order, DT)
    with pytest.raises(InvalidInput, match="other rows"):  # what is nearer at home is left out
        whole.margin = 0.4
    assert whole.margin == 0.03
    assert np.isfinite(rows(every, state)[:, :-1]).all()
    assert [plan.why for one, plan in built.plans if one is part] == ["the distances of its shapes come from Coal"]


class Pendulum(Obstacle):
    """A rod of one's own, which swings and says no more than it must."""

    radius = 0.05

    def core(self, t):
        return np.array([[0.8, 0.4], [0.8 + 0.1 * np.sin(t), 0.4 - 0.2]]) @ np.eye(2, 3)

    def velocity(self, t):
        return np.array([0.05 * np.cos(t), 0.0, 0.0])


class Towed(Sphere):
    """A ball that tells another velocity than that of its centre."""

    def velocity(self, t):
        return np.array([0.3, 0.1 * t, 0.0])


@pytest.mark.parametrize("order", ORDERS)
def test_obstacles_of_ones_own_are_asked_at_every_tick(order):
    own, ball = Pendulum(), Towed([0.9, 0.6], 0.1)
    limit = DistanceLimit(links("arm"), [own, ball], margin=0.02, gain=9.0)
    built = stack_of(limit).build(ARM, order, DT)
    task = Stack(AvoidanceTask(links("arm"), [ball], influence=2.0, speed=0.3)).build(ARM, "velocity", DT)
    speeds = []
    for t, state in enumerate(states("arm")):
        still = [Capsule(*own.core(t)[:, :2], 0.05), Sphere([0.9, 0.6], 0.1)]
        same = DistanceLimit(links("arm"), still, margin=0.02, gain=9.0)
        np.testing.assert_allclose(limit.distances(ARM, state, t), same.distances(ARM, state), rtol=1e-12)
        np.testing.assert_allclose(
            rows(built, state, t)[:, :3],
            rows(stack_of(same).build(ARM, order, DT), state)[:, :3],
            rtol=1e-12,
            atol=1e-14,
        )
        speeds.append(rows(task, state, t)[0, -1] - rows(task, state, 0.0)[0, -1])
    assert np.abs(speeds[1:]).min() > 1e-4


class Half(DistanceLimit):
    """Rows of one's own, made of those of the parent."""

    def write(self, tick, A, lower, upper):
        super().write(tick, A, lower, upper)
        lower *= 0.5


@pytest.mark.parametrize("order", ORDERS)
def test_a_subclass_may_write_on_top_of_its_parent(order):
    half, whole = (
        kind(links("arm"), obstacles("arm"), margin=0.02, gain=9.0, nearest=3) for kind in (Half, DistanceLimit)
    )
    both = [stack_of(part, braked=True).build(ARM, order, DT) for part in (half, whole)]
    for t, state in enumerate(states("arm")):
        own, parent = (rows(built, state, t) for built in both)
        np.testing.assert_allclose(own[:, :-2], parent[:, :-2], rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(own[:, -2], 0.5 * parent[:, -2], rtol=1e-11, atol=1e-11)
    assert [plan.python is None for plan in (both[0].plans[-1][1], both[1].plans[-1][1])] == [False, True]


def test_a_step_of_the_joints_leaves_what_is_beyond_the_margin():
    state = next(states("arm"))
    limit = DistanceLimit(links("arm"), obstacles("arm"), margin=0.05, gain=1e3)  # a gain says nothing here
    here = rows(Stack(limit).build(ARM, "displacement"), state)
    np.testing.assert_allclose(here[:, -2], 0.05 - limit.distances(ARM, state), rtol=1e-12)


def test_inverse_kinematics_goes_around_obstacles():
    reach = PositionTask([0.55, 0.55], gain=1.0)
    free = solve_ik(ARM, reach, [0.2, 0.5, 0.5])
    elbow = ARM.at(free.q, np.zeros(3)).frame("link1").position
    limit = DistanceLimit(planar_links(ARM, 0.02), [Sphere(elbow, 0.05)], margin=0.03, gain=20.0)  # no tick is needed
    assert limit.distances(ARM, ARM.at(free.q, np.zeros(3))).min() < 0.0
    kept = solve_ik(ARM, limit >> reach, [0.2, 0.5, 0.5])
    assert free.reached
    assert kept.reached
    assert limit.distances(ARM, ARM.at(kept.q, np.zeros(3))).min() > 0.03 - 1e-4
