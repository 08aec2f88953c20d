"""Distances of links to obstacles: their gradients, and a margin that is kept tick by tick, whatever is asked."""

from __future__ import annotations

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
    Sphere,
    load_robot,
    planar_links,
    simulate,
)
from tasks.obstacles.links import Placed
from tasks.obstacles.pairs import Pairs
from tasks.obstacles.reserve import reserve
from tasks.obstacles.shapes import nearest_points

KEPT = 1e-6
MARGIN, DT, SPEED = 0.03, 0.01, 1.5
#: Links of a Panda, each carried by the first of its frames.
PANDA = [("panda_link2", "panda_link3"), ("panda_link4", "panda_link5"), ("panda_link7", "panda_hand_tcp")]


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
    record = simulate(Controller(arm, stack, order=order, dt=DT), start, duration=2.5, certify=0)
    assert record.stopped is None, record.stopped
    return least(measure, record, arm).min() - MARGIN, np.linalg.norm(record.errors["position"][-1])


@pytest.mark.parametrize("seed", range(10))
def test_the_margin_is_kept_at_every_tick(seed):
    assert kept(seed)[0] >= -KEPT


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(10, 200))
def test_the_margin_is_kept_in_many_scenes(seed):
    assert kept(seed)[0] >= -KEPT
