"""Distances of links to obstacles: their gradients, and a margin that is kept tick by tick, whatever is asked."""

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
    JointLimits,
    JointVelocityLimit,
    LinkCapsule,
    PlanarArm,
    PositionTask,
    PostureTask,
    SelfCollisionLimit,
    Sphere,
    load_robot,
    planar_links,
    simulate,
)
from tasks.obstacles.links import axes
from tasks.obstacles.pairs import Pairs

KEPT = 1e-6
MARGIN, DT, SPEED = 0.03, 0.01, 1.5
#: Links of a Panda, each carried by the first of its frames.
APART = LinkCapsule("panda_link2", "panda_link4", 0.1)  # a joint lies between the two: neither carries the other
PANDA = [("panda_link2", "panda_link3"), ("panda_link4", "panda_link5"), ("panda_link7", "panda_hand_tcp")]


@cache
def panda():
    return load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=15.0)


def scene(seed):
    """An arm among circles, a start, and a path of its tip that can be followed at one and a half times the margin."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 7))
    arm = PlanarArm(rng.uniform(0.2, 0.4, n), position_limit=(-2.6, 2.6), velocity_limit=SPEED)
    links = planar_links(arm, 0.02)
    while True:
        circles = [
            Sphere(rng.uniform(0.35, 1.2) * np.array([np.cos(a), np.sin(a)]), rng.uniform(0.05, 0.2))
            for a in rng.uniform(-np.pi, np.pi, int(rng.integers(1, 4)))
        ]
        limit = DistanceLimit(links, circles, margin=MARGIN, gain=20.0)
        for _ in range(20):
            start, end = rng.uniform(-1.5, 1.5, (2, n))
            postures = (start + s * (end - start) for s in np.linspace(0.0, 1.0, 30))
            room = min(limit.distances(arm, arm.at(q, 0 * q)).min() for q in postures)
            if 1.5 * MARGIN < room < 3.0 * MARGIN:
                return arm, links, circles, start, path(arm, start, end, 2.0)


def path(arm, start, end, duration):
    """The tip while the joints go from start to end."""

    def tip(t):
        s, rate = min(t / duration, 1.0), float(t < duration) / duration
        q, v = start + s * (end - start), rate * (end - start)
        state = arm.at(q, v)
        return state.pose[:2], state.twist[:2], state.drift[:2]

    return tip


def least(limit, record, arm, ticks=slice(None)):
    """The least distance at each tick."""
    told = zip(record.q[ticks], record.t[ticks], strict=True)
    return np.array([limit.distances(arm, arm.at(q, np.zeros(arm.nv)), t).min() for q, t in told])


def kept(seed, kind="limit", order="velocity"):
    """The least distance of a run less the margin [m], and how far the tip is off its path at the end [m]."""
    arm, links, circles, start, target = scene(seed)
    measure = DistanceLimit(links, circles, margin=MARGIN, gain=20.0)
    own = {
        "limit": measure,
        "task": AvoidanceTask(links, circles, influence=4 * MARGIN, speed=0.3),
        "none": None,
    }[kind]
    limits = JointLimits() if order == "velocity" else JointLimits(JointVelocityLimit(), JointAccelerationLimit(40.0))
    reach = PositionTask(target, gain=5.0)
    stack = limits >> reach if own is None else limits >> own >> reach
    if order == "acceleration":  # joints that no task asks for would go on and on
        stack = stack >> PostureTask(start, gain=2.0)
    record = simulate(Controller(arm, stack, order=order, dt=DT, damping=None), start, duration=2.5, certify=0)
    assert record.stopped is None, record.stopped
    return least(measure, record, arm).min() - MARGIN, np.linalg.norm(record.errors["position"][-1])


@pytest.mark.parametrize("seed", range(5))
def test_the_margin_is_kept_at_every_tick(seed):
    assert kept(seed)[0] >= -KEPT


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(5, 200))
def test_the_margin_is_kept_in_many_scenes(seed):
    assert kept(seed)[0] >= -KEPT


def test_at_acceleration_order_it_brakes_in_time():
    """Here the acceleration limits leave enough; it is not so in every scene."""
    assert min(kept(seed, order="acceleration")[0] for seed in range(4)) >= -KEPT


def test_without_it_links_go_through_obstacles():
    """So the scenes do ask for it."""
    assert min(kept(seed, "none")[0] for seed in (4, 10)) < -MARGIN


def scenery():
    """Links and obstacles of all kinds, at random states: of a planar arm, and of a Panda."""
    arm, rng = PlanarArm([0.5, 0.4, 0.3]), np.random.default_rng(3)
    circle, pole = Sphere([0.9, 0.5], 0.1), Capsule([-0.2, 0.8], [0.3, 0.9], 0.05)
    ball, rail = Sphere([0.6, 0.3, 0.4], 0.1), Capsule([0.5, -0.5, 0.2], [0.7, 0.5, 0.3], 0.04)
    chains = [LinkCapsule(frame, end, 0.06) for frame, end in PANDA]
    for robot, links, shapes in (arm, planar_links(arm, 0.02), [circle, pole]), (panda(), chains, [ball, rail]):
        for _ in range(6):
            q = rng.uniform(-1.2, 1.2, arm.nv) if robot is arm else robot.random(rng)
            yield robot, links, shapes, q, rng.uniform(-1.0, 1.0, robot.nv)


def rows(robot, part, q, v, order="velocity", *, dt=DT, fastest=SPEED, t=0.0):
    """A and the lower bounds of a part where no joint is faster than this."""
    built = (JointVelocityLimit(fastest) >> part).build(robot, order, dt)
    level = built.fill(robot.at(np.asarray(q), np.asarray(v)), t).levels[1]
    return level.A.copy(), level.lower.copy()


def test_gradients_are_those_of_finite_differences():
    h = 1e-5
    for robot, links, shapes, q, v in scenery():
        limit = DistanceLimit(links, shapes, margin=0.0, gain=1.0)

        def told(q, robot=robot, limit=limit):
            return limit.distances(robot, robot.at(q, np.zeros(robot.nv)))

        slope = [(told(q + h * step) - told(q - h * step)) / (2 * h) for step in np.eye(robot.nv)]
        np.testing.assert_allclose(rows(robot, limit, q, v)[0], np.transpose(slope), atol=1e-6)


def test_drifts_are_those_of_the_nearest_point_on_its_link():
    """Far away both orders ask for one velocity at the end of the tick: what differs is what the joints leave it."""
    h, compared = 1e-5, 0
    for robot, links, shapes, q, v in scenery():
        limit = DistanceLimit(links, shapes, margin=0.0, gain=1.0 / DT)
        (A, end), (_, least) = rows(robot, limit, q, v), rows(robot, limit, q, v, "acceleration")
        for k, (_, *n, x, y, z) in enumerate(limit.pairs.measure(robot, robot.at(q, v))):
            now = A[k] @ v
            if end[k] > -5.0:  # there the mean velocity of the tick is what counts
                continue
            frame, point = links[k // len(shapes)].frame, np.array([x, y, z])
            here = robot.at(q, v).frame(frame)
            local = axes(here).T @ (point - here.position)
            sides = []
            for side in (h, -h):
                there = robot.at(q + side * v, v).frame(frame)
                sides.append(n @ (there.linear - np.cross(axes(there) @ local, there.angular, axisb=0).T))
            compared += 1
            np.testing.assert_allclose((end[k] - now) / DT - least[k], (sides[0] - sides[1]) @ v / (2 * h), atol=1e-5)
    assert compared > 20


def test_the_reserve_is_never_less_than_what_a_tick_takes():
    rng, dt, w = np.random.default_rng(8), 0.02, 1.5
    for robot, links, shapes, q, _ in scenery():
        limit, rest = DistanceLimit(links, shapes, margin=0.0, gain=1.0 / dt), np.zeros(robot.nv)
        A, least = rows(robot, limit, q, rest, dt=dt, fastest=w)
        here = limit.distances(robot, robot.at(q, rest))
        rho = here + dt * least  # with this gain and no margin the bound is (rho - d) / dt
        radii = np.ravel([[link.radius + shape.radius for shape in shapes] for link in links])
        for v in rng.choice([-w, w], (20, robot.nv)):
            there = limit.distances(robot, robot.at(q + dt * v, rest))
            clear = np.minimum(here, there) + radii > 1e-3  # of the cores
            assert (there >= here + dt * A @ v - rho - 1e-12)[clear].all()


def test_nearest_points_of_segments():
    rng, grid = np.random.default_rng(0), np.linspace(0.0, 1.0, 101)[:, None]
    arm = PlanarArm([1.0])
    for _ in range(50):
        q, own = rng.uniform(-1.0, 1.0, 1), rng.uniform(-1.0, 1.0, 3)
        second = rng.uniform(-1.0, 1.0, (2, 3))
        state = arm.at(q, np.zeros(1))
        frame = state.frame("link1")
        first = np.array([frame.position, frame.position + axes(frame) @ own])
        d, *n, x, y, z = Pairs([LinkCapsule("link1", own, 0.1)], [Capsule(*second, 0.2)], "pairs").measure(arm, state)[
            0
        ]
        ways = [a + grid * (b - a) for a, b in (first, second)]
        best = np.linalg.norm(ways[0][:, None] - ways[1][None], axis=2).min()
        assert best - 0.03 < d + 0.3 <= best + 1e-12
        other = [x, y, z] - (d + 0.3) * np.array(n)
        for point, (a, b) in ([x, y, z], first), (other, second):  # both points are on their segments
            s = (point - a) @ (b - a) / ((b - a) @ (b - a))
            assert -1e-9 <= s <= 1.0 + 1e-9
            np.testing.assert_allclose(a + s * (b - a), point, atol=1e-9)


def test_an_obstacle_that_comes_drives_the_arm_away():
    arm = PlanarArm([0.4, 0.4, 0.4], velocity_limit=3.0)
    links = planar_links(arm, 0.02)
    coming = Sphere(Circle([1.0, 1.0], 0.5, 4.0), 0.1)
    limit = DistanceLimit(links, [coming], margin=MARGIN, gain=30.0)
    q = np.array([0.3, 0.5, 0.5])
    stack = JointVelocityLimit() >> limit >> PostureTask(q, gain=5.0)
    record = simulate(Controller(arm, stack, dt=DT, damping=None), q, duration=4.0, certify=25)
    apart = least(limit, record, arm)
    assert record.stopped is None
    assert record.certified_share == 1.0
    assert apart.min() >= MARGIN - KEPT
    assert apart.min() < 2 * MARGIN  # it did come


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_far_away_it_is_in_nobodys_way(order):
    arm = PlanarArm([0.4, 0.4, 0.4], velocity_limit=2.0, acceleration_limit=20.0)
    limit = DistanceLimit(planar_links(arm, 0.02), [Sphere([9.0, 9.0], 0.1)], margin=MARGIN, gain=20.0)
    task = AvoidanceTask(planar_links(arm, 0.02), [Sphere([9.0, 9.0], 0.1)], influence=0.3, speed=0.3)
    reach, q = PositionTask([0.6, 0.5], gain=3.0), [0.1, 0.4, 0.4]
    limits = JointVelocityLimit() + JointAccelerationLimit()
    runs = [
        simulate(Controller(arm, stack, order=order, dt=DT, damping=None), q, duration=1.0, certify=0).q
        for stack in (limits >> reach, limits >> limit >> reach, limits >> task >> reach)
    ]
    np.testing.assert_allclose(runs[1], runs[0], atol=1e-9)
    np.testing.assert_allclose(runs[2], runs[0], atol=1e-9)


def test_from_inside_the_margin_it_comes_back():
    arm = PlanarArm([0.5, 0.5], velocity_limit=2.0)
    limit = DistanceLimit(planar_links(arm, 0.02), [Sphere([0.7, 0.15], 0.1)], margin=0.1, gain=10.0)
    q = np.zeros(2)
    record = simulate(Controller(arm, JointVelocityLimit() >> limit, dt=DT, damping=None), q, duration=1.0, certify=0)
    apart = least(limit, record, arm)
    assert apart[0] < 0.05
    assert apart[-1] >= 0.1 - KEPT
    assert (np.diff(apart) > -KEPT).all()


def test_a_few_rows_keep_what_all_of_them_keep():
    arm, links, circles, start, target = scene(4)
    every, few = (DistanceLimit(links, circles, margin=MARGIN, gain=20.0, nearest=k) for k in (None, 3))
    assert every.rows == len(links) * len(circles)
    assert every.labels(arm, "velocity")[0].row == "link 1 - obstacle 1"
    assert every.labels(arm, "velocity")[0].unit == "m/s"
    stack = JointLimits() >> few >> PositionTask(target, gain=5.0)
    record = simulate(Controller(arm, stack, dt=DT, damping=None), start, duration=2.5, certify=0)
    assert least(every, record, arm).min() >= MARGIN - KEPT


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_hand_stops_before_its_own_body(order):
    body = SelfCollisionLimit(margin=0.03, gain=10.0)
    limits = JointLimits() if order == "velocity" else JointLimits(JointVelocityLimit(), JointAccelerationLimit(15.0))
    reach = PositionTask([0.0, 0.0, 0.2], gain=3.0)
    least = {}
    for name, stack in ("free", limits >> reach), ("kept", limits >> body >> reach):
        stack = stack >> PostureTask(panda().home, gain=1.0)
        record = simulate(
            Controller(panda(), stack, order=order, dt=DT, damping=None), panda().home, duration=2.0, certify=25
        )
        assert record.stopped is None
        apart = [body.distances(panda(), panda().at(q, np.zeros(7))).min() for q in record.q[::4]]
        least[name] = min(apart)
    assert least["free"] < -0.01
    # Faces of hulls turn within a tick, for which no reserve is kept; at acceleration order they do so twice.
    missed = 1e-4 if order == "velocity" else 5e-4
    assert 0.03 - missed < least["kept"] < 0.035


def test_gradients_of_pairs_of_bodies_are_those_of_finite_differences():
    robot, h = panda(), 1e-4
    body = SelfCollisionLimit([("panda_hand", "panda_link0"), ("panda_link6", "panda_link1")], margin=0.01, gain=5.0)
    shapes, rng = body.shapes(robot), np.random.default_rng(1)
    assert sorted(shapes.names()) == ["panda_link0 - panda_hand", "panda_link1 - panda_link6"]
    for _ in range(5):
        q = robot.home + rng.uniform(-0.2, 0.2, 7)

        def told(q):
            return shapes.distances(robot.at(q, np.zeros(7)))

        slope = np.array([(told(q + h * step) - told(q - h * step)) / (2 * h) for step in np.eye(7)]).T
        np.testing.assert_allclose(rows(robot, body, q, np.zeros(7))[0], slope, atol=1e-3)


def test_the_nearest_bodies_are_found_without_measuring_all():
    shapes, rng = SelfCollisionLimit(margin=0.01, gain=5.0).shapes(panda()), np.random.default_rng(2)
    for _ in range(10):
        state = panda().at(panda().random(rng), np.zeros(7))
        apart = shapes.distances(state)
        np.testing.assert_allclose(apart[shapes.closest(state, 6)], np.sort(apart)[:6], atol=1e-9)


ARM = PlanarArm([0.5, 0.5])
LINKS, BALL = planar_links(ARM, 0.02), Sphere([0.5, 0.5], 0.1)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: Sphere([0.0, 0.0], -0.1), "radius"),
        (lambda: Sphere([np.nan, 0.0], 0.1), "centre"),
        (lambda: Sphere([0.0], 0.1), "centre"),
        (lambda: Capsule([0.0, 0.0], [np.inf, 0.0], 0.1), "end"),
        (lambda: LinkCapsule("tip", [0.1, 0.0], -1.0), "radius"),
        (lambda: DistanceLimit(LINKS, [BALL], margin=-0.1, gain=5.0), "margin"),
        (lambda: DistanceLimit(LINKS, [BALL], margin=0.1, gain=0.0), "gain"),
        (lambda: DistanceLimit([], [BALL], margin=0.1, gain=5.0), "LinkCapsule"),
        (lambda: DistanceLimit(LINKS, ["ball"], margin=0.1, gain=5.0), "Obstacle"),
        (lambda: AvoidanceTask(LINKS, [BALL], influence=0.0, speed=0.1), "influence"),
        (lambda: SelfCollisionLimit(margin=np.nan, gain=5.0), "margin"),
    ],
)
def test_refusals_of_numbers(make, word):
    with pytest.raises(InvalidInput, match=word):
        make()


@pytest.mark.parametrize(
    ("robot", "part", "word"),
    [
        (ARM, lambda: DistanceLimit(LINKS, [BALL], margin=0.1, gain=101.0), "at most 100"),
        (ARM, lambda: DistanceLimit([LinkCapsule("hand", [0.1, 0.0], 0.1)], [BALL], margin=0.1, gain=5.0), "hand"),
        (ARM, lambda: DistanceLimit([LinkCapsule("link1", "tip", 0.1)], [BALL], margin=0.1, gain=5.0), "way round"),
        (None, lambda: DistanceLimit([APART], [BALL], margin=0.1, gain=5.0), "'panda_link4'; end at a joint"),
        (ARM, lambda: SelfCollisionLimit(margin=0.1, gain=5.0), "load_robot"),
        (None, lambda: SelfCollisionLimit([("hand", "panda_link0")], margin=0.1, gain=5.0), "panda_hand"),
    ],
)
def test_refusals_by_the_robot(robot, part, word):
    with pytest.raises(InvalidInput, match=word):
        Controller(robot or panda(), part(), dt=DT, damping=None)


def test_refused_without_a_limit_of_the_speed():
    limit = DistanceLimit(LINKS, [BALL], margin=0.1, gain=5.0)
    with pytest.raises(InvalidInput, match="JointVelocityLimit"):
        Controller(ARM, limit, dt=DT, damping=None)
    limited = Controller(ARM, JointVelocityLimit(2.0) >> limit, order="velocity", dt=DT, damping=None)
    assert limited([0.0, 0.0], [0.0, 0.0]).ok
    with pytest.raises(InvalidInput, match="dt"):
        Controller(ARM, limit, damping=None)


@pytest.mark.parametrize("obstacle", [Sphere([5.0, 0.5], 0.1), Capsule([5.0, 0.5], [5.0, 0.6], 0.1)])
def test_obstacles_of_two_numbers_beside_a_robot_in_space_are_told(caplog, obstacle) -> None:
    """They lie on the floor, which is where a planar robot is."""
    panda = load_robot("panda", lock=["panda_finger_joint1"])
    limit = DistanceLimit([LinkCapsule("panda_link7", "panda_hand_tcp", 0.06)], [obstacle], margin=0.01, gain=5.0)
    with caplog.at_level("WARNING", logger="hqp"):
        Controller(ARM, JointVelocityLimit(1.0) >> DistanceLimit(LINKS, [obstacle], margin=0.01, gain=5.0), dt=0.01)
        assert "two numbers" not in caplog.text
        Controller(panda, JointVelocityLimit(1.0) >> limit, dt=0.01)
    assert f"obstacles of two numbers are at z = 0: {type(obstacle).__name__}" in caplog.text
