"""Explanations of levels that are damped by default: each sentence holds at the x of the answer.

A limit that is named is at its bound there, or is said to be left; a level is called damped only where it lacks more
than it would without damping; and what is held beside a large motion is met.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from curved_stacks import DT, answers, arm, state

from hqp import Hierarchy, Side, Solution, solve
from hqp.solution.explaining import COST
from tasks import (
    AtLeast,
    Controller,
    Damped,
    JointLimits,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
)

SEEDS = range(24)


def elbow(seed: int) -> Solution:
    """A strict level below a softened one, which an inequality may stop until levels below leave it."""
    robot, rng = arm(seed), np.random.default_rng(seed)
    first = PositionTask(rng.uniform(-2.0, 2.0, 2), gain=10.0)
    second = OrientationTask(rng.uniform(-3.0, 3.0), gain=10.0)
    high = AtLeast(PositionTask([0.05], mask="y", frame="link2", gain=5.0, name="elbow"))
    stacked = JointLimits() >> high >> first >> Damped(second, None) >> PostureTask(np.full(robot.nv, 0.3), gain=1.0)
    return Controller(robot, stacked, dt=DT)(*state(robot, seed)).solution


@cache
def solutions() -> list[Solution]:
    return [step.solution for step in answers(SEEDS)] + [elbow(seed) for seed in range(60)]


def test_a_limit_that_is_named_is_at_its_bound_or_is_said_to_be_left() -> None:
    held = left = 0
    for solution in solutions():
        h = solution.hierarchy
        value = h.product(solution.x)
        for level in solution.explain().levels:
            for cause in level.causes:
                if cause.side not in (Side.LOWER, Side.UPPER):
                    continue
                rows = list(cause.rows)
                room = value[rows] - h.lower[rows] if cause.side is Side.LOWER else h.upper[rows] - value[rows]
                motion = np.linalg.norm(h.dense()[rows], axis=1) * np.linalg.norm(solution.x)
                away = float((room / np.maximum(1e-5 * motion, 1e-9 * (1.0 + np.abs(value[rows])))).min())
                assert away > 0.9 if cause.left else away < 1.1, (cause, away)
                assert cause.left == str(cause).endswith("left by the levels below")
                held, left = held + (not cause.left), left + cause.left
    assert held > 100
    assert left > 0


def norms(solution: Solution, k: int) -> tuple[float, float]:
    """What level k lacks, and the least that it could lack where those above stay where x is."""
    h = solution.hierarchy.copy()
    value, whole = h.product(solution.x), h.levels[k]
    for j in range(k):
        own, level = slice(*h.pointers[j : j + 2]), h.levels[j]
        out = (level.lower == level.upper) | (value[own] < level.lower - 1e-9) | (value[own] > level.upper + 1e-9)
        level.lower[out] = level.upper[out] = value[own][out]
    best = solve(Hierarchy(h.levels[: k + 1], n=h.n)).levels[k].residual_norm
    own = value[slice(*h.pointers[k : k + 2])]
    return float(np.linalg.norm(whole.weights * (own - np.clip(own, whole.lower, whole.upper)))), best


def lost(solution: Solution, k: int) -> float:
    """What level k lacks more than without damping, relative."""
    lacks, best = norms(solution, k)
    return (lacks - best) / lacks


def test_what_a_level_would_lack_without_damping_is_told_of_those_that_only_lean_on_the_last_velocities_too() -> None:
    leaning = 0
    for solution in solutions():
        for level in solution.relaxed:
            lacks, best = norms(solution, level.level)
            assert level.strict_norm == pytest.approx(best, rel=1e-6, abs=1e-8)
            assert level.excess == pytest.approx(lacks - best, rel=1e-6, abs=1e-6 * lacks + 1e-8)
            leaning += level.damping == 0.0 and level.excess > 1e-3 * lacks
    assert leaning > 5


def test_a_level_is_called_damped_where_it_loses_by_it_and_nowhere_else() -> None:
    damped = undamped = 0
    for solution in solutions():
        softened = solution.certify().softened
        for k, level in enumerate(solution.explain().levels):
            if k not in softened or level.met or level.contradicts:
                continue
            cost = lost(solution, k)
            assert cost > 1e-9 if level.damped else cost <= 1.1 * COST, level
            damped, undamped = damped + bool(level.damped), undamped + (not level.damped)
    assert min(damped, undamped) > 20


def test_where_limits_alone_stop_a_level_it_is_not_called_damped() -> None:
    """Reach and one joint at its limit leave nothing to move: the level lacks as much with damping as without."""
    robot = PlanarArm([0.5, 0.5, 0.5])
    tasks = PositionTask([0.9, 0.6], gain=2.0, name="reach") >> OrientationTask(0.0, gain=2.0, name="level")
    told = [
        Controller(robot, JointVelocityLimit(2.0, name="limits") >> tasks, dt=0.01, damping=damping)(
            [1.1, -1.3, -0.7]
        ).solution.explain()
        for damping in ("curvature", None)
    ]
    assert str(told[0]) == str(told[1])
    assert str(told[0]).endswith("reach, then joint 0 limits (upper)")


def test_what_is_held_beside_a_large_motion_is_met_and_no_more() -> None:
    """A hand near the end of its reach is all but where it should be; a posture far from here moves the joints."""
    robot, held, short = PlanarArm([0.5] * 4, velocity_limit=2.0), 0, 0
    posture = PostureTask(np.array([1.0, -2.0, 1.0, 0.5]), gain=20.0)
    for off in np.geomspace(1e-5, 1e-2, 60):
        q = np.array([0.05, -0.06, 0.04, -0.03])
        place = PositionTask(robot.at(q, np.zeros(4)).pose[:2] + np.array([off, 0.0]), gain=20.0)
        solution = Controller(robot, JointLimits() >> place >> posture, dt=DT)(q).solution
        level, lacks = solution.explain().levels[1], np.abs(solution.levels[1].slack)
        if 1 not in solution.certify().softened or lacks.max() < 1e-8:
            continue
        fast = np.linalg.norm(solution.hierarchy.matrix(1), axis=1) * np.linalg.norm(solution.x)
        held, short = held + level.met, short + (not level.met)
        away = float((lacks / np.maximum(1e-5 * fast, 1e-6 * 20.0 * off)).max())
        assert away < 1.1 if level.met else away > 0.9, (level, away)
        assert not (level.met and level.damped)
    assert min(held, short) > 3, (held, short)
