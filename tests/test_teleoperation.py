"""A Panda that is led about by hand: a minute of targets, half of them far out of reach, at both orders.

Limits hold, no answer is missing, no level is worse for those below it, and samples are certified. The long run:
``python -m pytest -m sweep -k teleoperation``.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from hqp import Hierarchy, Solver
from tasks import AtLeast, Controller, JointLimits, OrientationTask, PositionTask, PostureTask, load_robot
from tasks.base.rotations import exp

DT = 0.005
KEPT = 1e-9
FREQUENCIES = np.array([0.0175, 0.0325, 0.0775, 0.1325])  # [Hz]


@cache
def panda():
    return load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=15.0)


def waves(seed, amplitude, haste):
    """A smooth random motion of three numbers: a sum of sines, with its two derivatives."""
    rng = np.random.default_rng(seed)
    a, phase, w = (
        amplitude * rng.uniform(0.3, 1.0, (4, 3)),
        rng.uniform(0, 2 * np.pi, (4, 3)),
        2 * np.pi * haste * FREQUENCIES,
    )
    w = w[:, None]

    def motion(t):
        angle = w * t + phase
        return (a * np.sin(angle)).sum(0), (a * w * np.cos(angle)).sum(0), -(a * w * w * np.sin(angle)).sum(0)

    return motion


def leader(seed, haste):
    """Where the hand is led to: about the middle of the workspace, and out of it, up to 2 m away."""
    wave, middle = waves(seed, 0.65, haste), np.array([0.3, 0.0, 0.5])

    def motion(t):
        place, velocity, acceleration = wave(t)
        return middle + place, velocity, acceleration

    return motion


def turning(seed, haste):
    """How it is turned: up to a radian from home; the angular velocity is a difference, as a device tells it."""
    wave, h, home = waves(seed, 0.3, haste), 1e-4, panda().at(panda().home, np.zeros(7)).frame().rotation

    def motion(t):
        before, now, after = (exp(wave(t + s)[0]) @ home for s in (-h, 0.0, h))
        spin = (after - before) @ now.T / (2 * h)
        omega = 0.5 * np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
        return now, omega, np.zeros(3)

    return motion


def stack(seed, haste):
    return (
        JointLimits()
        >> PositionTask(leader(seed, haste), gain=5.0)
        >> OrientationTask(turning(seed + 1, haste), gain=4.0)
        >> AtLeast(PositionTask([0.4], frame="panda_link4", mask="z", gain=4.0, name="elbow"))
        >> PostureTask(panda().home, gain=1.0)
    )


def run(order, seconds, seed, haste=1.0, truncated_every=1, certify_every=100):
    """What went wrong, at worst; how far the target was out of reach; how much was checked."""
    robot, rng, hand = panda(), np.random.default_rng(seed), leader(seed, haste)
    controller = Controller(robot, stack(seed, haste), order=order, dt=DT, damping=None)
    levels = controller.hierarchy.levels
    shorter = [Hierarchy(levels[:k], n=robot.nv) for k in range(1, len(levels))]
    solvers = [Solver() for _ in shorter]
    (lower, upper), fastest, hardest = robot.position_limit, robot.velocity_limit, robot.acceleration_limit
    worst = dict.fromkeys(("position", "velocity", "acceleration", "residual"), 0.0)
    count = dict.fromkeys(
        ("ticks", "not optimal", "certified", "not certified", "out of reach", "at a limit", "all met"), 0
    )
    q, v = robot.home, np.zeros(robot.nv)
    for tick in range(round(seconds / DT)):
        step = controller(q, v, tick * DT)
        solution, x = step.solution, step.solution.x
        count["ticks"] += 1
        count["not optimal"] += not step.ok
        count["out of reach"] += bool(np.linalg.norm(hand(tick * DT)[0] - [0.0, 0.0, 0.333]) > 0.95)
        count["at a limit"] += bool(np.any(solution.levels[0].active))
        count["all met"] += solution.levels[2].residual_norm < 1e-6
        if rng.random() < 1.0 / certify_every:
            proved = solution.certify().ok
            count["certified"] += proved
            count["not certified"] += not proved
        if tick % truncated_every == 0:
            for k, (short, solver) in enumerate(zip(shorter, solvers, strict=True)):
                for own, whole in zip(short.levels, levels, strict=False):
                    if own.A is not None:
                        own.A[:] = whole.A
                    own.lower[:], own.upper[:] = whole.lower, whole.upper
                alone = solver.solve(short)
                count["not optimal"] += not alone.ok
                for mine, other in zip(solution.levels[: k + 1], alone.levels, strict=False):
                    off = abs(mine.residual_norm - other.residual_norm) / max(1.0, other.residual_norm)
                    worst["residual"] = max(worst["residual"], off)
        before = v
        q, v = (q + DT * x, x) if order == "velocity" else (q + DT * v + 0.5 * DT**2 * x, v + DT * x)
        worst["position"] = max(worst["position"], (q - upper).max(), (lower - q).max())
        worst["velocity"] = max(worst["velocity"], (np.abs(v) - fastest).max())
        worst["acceleration"] = max(worst["acceleration"], (np.abs(v - before) - DT * hardest).max())
    return worst, count


def check(worst, count):
    assert max(worst.values()) <= KEPT, worst
    assert not count["not optimal"], count
    assert not count["not certified"], count
    assert count["certified"] > 0


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_two_seconds(order):
    check(*run(order, 2.0, seed=3, haste=4.0, truncated_every=4, certify_every=20))


@pytest.mark.sweep
@pytest.mark.parametrize("haste", [1.0, 4.0])
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_minute(order, haste):
    """Slowly, so that the hand keeps up where it can, and in haste, so that it hardly ever does."""
    worst, count = run(order, 60.0, seed=3, haste=haste)
    check(worst, count)
    assert count["ticks"] == 12000
    assert 0.4 < count["out of reach"] / count["ticks"] < 0.6
    assert count["at a limit"] > 3000
    assert haste > 1.0 or count["all met"] > 500
