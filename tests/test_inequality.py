"""Tasks as inequalities at any level, and limits of frames: kept in the closed loop, and in nobody's way before."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from tasks import (
    AtLeast,
    AtMost,
    BoxLimit,
    Controller,
    FrameVelocityLimit,
    JointAccelerationLimit,
    JointCouplingTask,
    JointLimits,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PlaneLimit,
    PlaneTask,
    PositionTask,
    PostureTask,
    Within,
    load_robot,
    simulate,
)

DOWN = np.diag([1.0, -1.0, -1.0])
KEPT = 1e-9
orders = pytest.mark.parametrize("order", ["velocity", "acceleration"])


@cache
def panda():
    return load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=15.0)


def run(stack, order, duration=1.5, dt=0.01, q=None, certify=25):
    record = simulate(
        Controller(panda(), stack, order=order, dt=dt, damping=None),
        panda().home if q is None else q,
        duration=duration,
        certify=certify,
    )
    assert record.stopped is None
    if certify:
        assert record.certified_share == 1.0
    return record


def tip(record, frame=None):
    return np.array([panda().at(q, v).frame(frame).position for q, v in zip(record.q, record.v, strict=True)])


JOINT, PAIR = ["panda_joint4"], {"panda_joint2": 1.0, "panda_joint6": 1.0}
HOME_4, HOME_SUM = -2.356, -0.785 + 1.571
#: Of quantities that are linear in the joints: the part, and how far the quantity is beyond its bound.
LINEAR = {
    "at least": (
        lambda: AtLeast(PostureTask([-2.5], joints=JOINT, gain=8.0)),
        lambda q: -2.5 - q[:, 3],
    ),
    "at most": (
        lambda: AtMost(PostureTask([-2.2], joints=JOINT, gain=8.0)),
        lambda q: q[:, 3] + 2.2,
    ),
    "within": (
        lambda: Within(JointCouplingTask(PAIR, HOME_SUM, gain=5.0), 0.1),
        lambda q: np.abs(q[:, 1] + q[:, 5] - HOME_SUM) - 0.1,
    ),
    "within, askew": (
        lambda: Within(JointCouplingTask(PAIR, HOME_SUM, gain=5.0), 0.2, below=0.05),
        lambda q: np.maximum(q[:, 1] + q[:, 5] - HOME_SUM - 0.2, HOME_SUM - 0.05 - q[:, 1] - q[:, 5]),
    ),
}
TARGETS = [[0.5, 0.4, 0.9], [0.2, 0.1, 0.4], [0.9, 0.0, 0.5]]


@orders
@pytest.mark.parametrize("kind", LINEAR)
@pytest.mark.parametrize("above", [True, False], ids=["above the task", "below the limits"])
def test_a_bound_of_joints_is_never_passed(kind, above, order):
    """At the top it beats the limits too; below them, it is kept as the limits permit, which here is always."""
    make, beyond = LINEAR[kind]
    met = -np.inf
    for target in TARGETS:
        limits, part, reach = JointLimits(), make(), PositionTask(target, gain=3.0)
        stack = part >> limits >> reach if above else limits >> part >> reach >> OrientationTask(DOWN, gain=2.0)
        excess = beyond(run(stack, order).q)
        assert excess.max() <= KEPT
        met = max(met, excess[-1])
    assert met > -0.02  # and somebody did want to


#: Limits of the tip, and how far it is beyond them.
CARTESIAN = {
    "elbow": (
        lambda: AtLeast(PositionTask([0.5], frame="panda_link4", mask="z", gain=5.0)),
        lambda r: 0.5 - tip(r, "panda_link4")[:, 2],
    ),
    "box": (
        lambda: BoxLimit([0.2, -0.3, 0.2], [0.5, 0.3, 0.7], gain=5.0),
        lambda r: np.maximum([0.2, -0.3, 0.2] - tip(r), tip(r) - [0.5, 0.3, 0.7]).max(axis=1),
    ),
    "open box": (
        lambda: BoxLimit([-np.inf, -np.inf, 0.3], [0.45, np.inf, np.inf], gain=5.0),
        lambda r: np.maximum(0.3 - tip(r)[:, 2], tip(r)[:, 0] - 0.45),
    ),
    "plane": (
        lambda: PlaneLimit([2.0, 1.0, -2.0], -0.3, gain=4.0),
        lambda r: -0.3 - tip(r) @ [2 / 3, 1 / 3, -2 / 3],
    ),
}


@orders
@pytest.mark.parametrize("kind", CARTESIAN)
def test_a_bound_in_space_is_never_passed_on_the_way_to_it(kind, order):
    make, beyond = CARTESIAN[kind]
    met = -np.inf
    for target in ([0.3, 0.4, 0.75], [0.8, -0.2, 0.1], [0.1, -0.1, 0.9]):
        stack = JointLimits() >> make() >> PositionTask(target, gain=3.0) >> OrientationTask(DOWN, gain=2.0)
        record = run(stack, order, duration=2.0)
        excess = beyond(record)
        assert excess[0] < 0.0
        assert excess.max() <= KEPT
        met = max(met, excess.max())
    assert met > -0.01


def around(t):
    """A circle below the floor of 0.3 m, once a second."""
    w, r = 2 * np.pi, 0.12
    c, s = np.cos(w * t), np.sin(w * t)
    return (
        np.array([0.5 + r * c, r * s, 0.25]),
        np.array([-r * w * s, r * w * c, 0.0]),
        np.array([-r * w * w * c, -r * w * w * s, 0.0]),
    )


@orders
def test_along_a_bound_in_space_it_is_passed_by_the_bend_of_a_tick(order):
    """The rows are linear within a tick, the way is not: the error is one of the tick, and goes with it."""
    worst = []
    for dt in (0.01, 0.005, 0.0025):
        part = PlaneLimit([0, 0, 1], 0.3, gain=10.0)
        stack = JointVelocityLimit(2.0) >> part >> PositionTask(around, gain=10.0)
        worst.append(max(0.3 - tip(run(stack, order, dt=dt, certify=0))[:, 2].min(), 0.0))
    assert worst[0] < 2e-3
    for coarse, fine in pairwise(worst):
        assert fine < 0.65 * coarse


@orders
def test_speeds_are_kept(order):
    """At velocity order to the last digit; at acceleration order but for the bend of a tick, of second order."""
    limit = [0.15, 0.1, 0.2]
    for frame, mask, reference in ((None, "xyz", "local_world_aligned"), ("panda_link6", "xyz", "local")):
        stack = JointLimits() >> FrameVelocityLimit(limit, frame=frame, mask=mask, reference=reference)
        excess = []
        for dt in (0.01, 0.005):
            record = run(stack >> PositionTask([0.2, 0.5, 0.2], gain=5.0), order, dt=dt, duration=1.0)
            q, v = (record.q[:-1], record.v[1:]) if order == "velocity" else (record.q, record.v)
            seen = [panda().at(*pair).frame(frame) for pair in zip(q, v, strict=True)]
            moves = [frame.linear @ own for frame, own in zip(seen, v, strict=True)]
            if reference == "local":
                moves = [frame.rotation.T @ move for frame, move in zip(seen, moves, strict=True)]
            excess.append((np.abs(moves) - limit).max())
            assert excess[-1] > -1e-3  # and is used
        if order == "velocity":
            assert max(excess) <= KEPT
        else:
            assert excess[0] < 5e-4
            assert excess[1] < 0.35 * excess[0] + KEPT


@pytest.mark.parametrize("kind", ["joint", "plane"])
def test_from_beyond_it_comes_back_at_its_rate(kind):
    K, dt, start = 3.0, 0.002, panda().home
    if kind == "joint":
        part, away = AtLeast(PostureTask([-2.0], joints=JOINT, gain=K)), lambda r: -2.0 - r.q[:, 3]
    else:
        part, away = AtMost(PlaneTask([0, 0, 1], 0.3, gain=K)), lambda r: tip(r)[:, 2] - 0.3
    record = run(part >> PostureTask(start, gain=1.0), "velocity", dt=dt, duration=1.0)
    left = away(record)
    assert left[0] > 0.1
    exact = (1.0 - K * dt) ** np.arange(len(left)) if kind == "joint" else np.exp(-K * record.t)
    np.testing.assert_allclose(left / left[0], exact, atol=1e-12 if kind == "joint" else 5e-3)
    np.testing.assert_allclose(record.errors[part.name][:, 0], left if kind == "joint" else -left, atol=1e-12)


def test_from_beyond_it_comes_back_at_acceleration_order_too():
    K = 3.0
    part = AtLeast(PostureTask([-2.0], joints=JOINT, gain=K))
    record = run(part >> PostureTask(panda().home, gain=0.5), "acceleration", dt=0.002, duration=2.0)
    left = -2.0 - record.q[:, 3]
    exact = (1 + K * record.t) * np.exp(-K * record.t)
    pushed = record.t < 0.5  # then it brakes, where less is allowed
    np.testing.assert_allclose(left[pushed] / left[0], exact[pushed], atol=2e-3)
    assert (left / left[0] - exact).max() < 2e-3


@orders
def test_far_from_their_bounds_they_are_in_nobodys_way(order):
    reach = PositionTask([0.5, 0.2, 0.6], gain=2.0) >> OrientationTask(DOWN, gain=2.0)
    free = run(JointLimits() >> reach, order)
    far = (
        AtLeast(PositionTask([-0.5], mask="z", gain=2.0, name="floor"))
        + AtMost(PostureTask(panda().home + 3.0, gain=2.0))
        + Within(JointCouplingTask(PAIR, 0.0, gain=2.0), 9.0)
        + BoxLimit([-9] * 3, [9] * 3, gain=2.0)
        + FrameVelocityLimit(9.0)
    )
    np.testing.assert_allclose(run(JointLimits() >> far >> reach, order).q, free.q, rtol=0.0, atol=1e-9)


@orders
def test_below_what_contradicts_it_it_gives_way(order):
    reach = PositionTask([0.5, 0.0, 0.2], gain=3.0)
    alone = run(reach, order, duration=2.5)
    for part in (AtLeast(PositionTask([0.4], mask="z", gain=3.0, name="floor")), PlaneLimit([0, 0, 1], 0.4, gain=3.0)):
        both = run(reach >> part, order, duration=2.5)
        np.testing.assert_allclose(tip(both), tip(alone), atol=2e-3)
        np.testing.assert_allclose(tip(both)[-1], [0.5, 0.0, 0.2], atol=1e-2)
        above = run(part >> reach, order, duration=2.5)
        np.testing.assert_allclose(tip(above)[-1], [0.5, 0.0, 0.4], atol=1e-2)  # the other way round it wins


@orders
def test_the_residual_above_does_not_know_of_it(order):
    reach = PositionTask([0.5, 0.0, 0.2], gain=3.0)
    part = AtLeast(PositionTask([0.4], mask="z", gain=3.0, name="floor"))
    limits = JointLimits(JointVelocityLimit(0.3), JointAccelerationLimit(15.0))
    rng = np.random.default_rng(6)
    options = {"order": order, "dt": 0.01, "damping": None}
    both, alone = (
        Controller(panda(), limits >> reach >> part, **options),
        Controller(panda(), limits >> reach, **options),
    )
    for _ in range(30):
        q, v = panda().home + rng.uniform(-0.3, 0.3, 7), rng.uniform(-0.2, 0.2, 7)
        mine, other = both(q, v).solution, alone(q, v).solution
        for k in range(2):
            assert abs(mine.levels[k].residual_norm - other.levels[k].residual_norm) <= 1e-9 * (
                1.0 + other.levels[k].residual_norm
            )
        assert mine.certify().ok


@orders
def test_a_box_in_the_plane(order):
    arm = PlanarArm([0.5, 0.4, 0.3], acceleration_limit=20.0)
    box = BoxLimit([0.1, 0.0], [0.6, 0.9], gain=5.0)
    tasks = JointVelocityLimit(2.0) >> box >> PositionTask([1.0, 0.2], gain=3.0)
    record = simulate(
        Controller(arm, tasks, order=order, dt=0.01, damping=None), [0.4, 0.9, 0.6], duration=2.0, certify=20
    )
    assert record.stopped is None
    assert record.certified_share == 1.0
    assert (record.pose[:, 0] - 0.6).max() <= KEPT
    assert record.pose[-1, 0] > 0.59
    assert np.abs(record.errors["box"]).max() <= KEPT


@orders
def test_a_band_never_excludes_itself(order):
    """Its two bounds are in order from any motion: also from beyond one, on a way that bends towards the other."""
    arm = PlanarArm([0.5, 0.5, 0.5], velocity_limit=3.0, acceleration_limit=20.0)
    for seed in range(40):
        rng = np.random.default_rng(seed)
        q, v = rng.uniform(-1.5, 1.5, 3), rng.uniform(-3.0, 3.0, 3)
        target = arm.pose(q)[:2] + rng.normal(0.0, 0.1, 2)
        band = Within(PositionTask(target, gain=20.0), rng.uniform(0.0, 0.1))
        controller = Controller(arm, JointLimits() >> band, order=order, dt=0.01, damping=None)
        assert controller(q, v).ok
        level = controller.hierarchy.levels[1]
        assert (level.lower <= level.upper).all()
