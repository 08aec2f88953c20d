"""What an answer says of itself is of its own tick, whatever was set since, and by what the parts were then."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

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
    Step,
)

DT, Q, V = 0.01, np.array([0.3, 0.4, 1.9]), np.array([0.5, -0.2, 0.9])
#: Out of reach, and in reach.
TARGETS = {"far": [1.9, 0.4], "near": [0.8, 0.9]}


def made(far: str, order: Any, damping: Any, **limits: Any) -> Controller:
    robot = PlanarArm([0.5, 0.5, 0.5], position_limit=(-2.0, 2.0), **limits)
    tip = PositionTask(TARGETS[far], gain=20.0)
    stack = JointLimits() >> tip >> OrientationTask(0.4, gain=20.0) >> PostureTask([0.2] * 3, gain=1.0)
    return Controller(robot, stack, order=order, dt=DT, damping=damping)


def told(step: Step) -> str:
    """All that a step says of itself in words, and whether it is proved."""
    relaxed = [
        (level.name, f"{level.damping:.4g}", [(soft.cause, f"{soft.share:.4g}") for soft in level.softened])
        for level in step.relaxed
    ]
    return f"{step.solution.explain()}\n{relaxed}\n{step.solution.certify().ok}"


#: Limits that a robot may have at work, one after the other; position limits at acceleration order need the last.
LIMITS: list[dict[str, Any]] = [
    {"velocity_limit": np.full(3, 1.5), "acceleration_limit": np.full(3, 30.0)},
    {"velocity_limit": np.full(3, 0.7), "acceleration_limit": np.full(3, 30.0)},
    {"velocity_limit": np.full(3, 0.7), "acceleration_limit": None},
    {"velocity_limit": None, "acceleration_limit": np.full(3, 20.0)},
    {"velocity_limit": np.full(3, 2.5), "acceleration_limit": np.full(3, 10.0)},
]


@pytest.mark.parametrize("damping", ["curvature", None])
@pytest.mark.parametrize("far", TARGETS)
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_limits_are_named_as_those_of_a_fresh_controller_and_as_they_were(order: str, far: str, damping: Any) -> None:
    """Read at once, and only after all other ticks; with limits that came, changed, and went."""
    live, late, words = made(far, order, damping, **LIMITS[0]), list[Step](), list[str]()
    for limits in LIMITS:
        if order == "acceleration" and limits["acceleration_limit"] is None:
            continue
        for name, value in limits.items():
            setattr(live.robot, name, value)
        step, fresh = live(Q, V), made(far, order, damping, **limits)(Q, V)
        assert str(step.solution.explain()) == str(fresh.solution.explain())
        late.append(live(Q, V))
        words.append(told(copy.deepcopy(late[-1])))
        late[-1] = live(Q, V)  # of which nothing has been read
    assert len(set(words)) > 1
    for step, told_then in zip(late, words, strict=True):
        assert told(step) == told_then
        assert told(pickle.loads(pickle.dumps(step))) == told_then


#: Of the limits of a level, one that is set to a number.
SET: dict[str, Callable[[JointLimits], None]] = {
    "velocity": lambda all_of: setattr(all_of.limits[1], "limit", 0.6),
    "acceleration": lambda all_of: setattr(all_of.limits[2], "limit", 8.0),
    "range": lambda all_of: setattr(all_of.limits[0], "upper", 1.91),
}


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("name", SET)
def test_a_limit_that_is_set_is_named_from_then_on(name: str, order: Any) -> None:
    def one() -> tuple[Controller, JointLimits]:
        limits = JointLimits(JointPositionLimit(-2.0, 2.0), JointVelocityLimit(1.0), JointAccelerationLimit(30.0))
        stack = limits >> PositionTask(TARGETS["far"], gain=20.0) >> PostureTask([0.2] * 3, gain=1.0)
        return Controller(PlanarArm([0.5, 0.5, 0.5]), stack, order=order, dt=DT), limits

    (live, limits), (other, others) = one(), one()
    before, same = live(Q, V), str(other(Q, V).solution.explain())
    SET[name](limits)
    SET[name](others)
    fresh = Controller(other.robot, other.stack, order=order, dt=DT)
    assert str(live(Q, V).solution.explain()) == str(fresh(Q, V).solution.explain())
    assert str(before.solution.explain()) == same
