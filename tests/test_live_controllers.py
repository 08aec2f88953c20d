"""Who sees a change: all controllers of a part, in a change of stacks too, and copies only what was there before."""

from __future__ import annotations

import copy
import gc
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from live_table import SETTINGS, arm
from live_work import DT, at_work, misspelt, public, refused, seen

from hqp import InvalidInput
from tasks import AtMost, Controller, PositionTask, PostureTask, solve_ik


@pytest.mark.parametrize("robot", SETTINGS)
def test_controllers_and_stacks_stay(robot: str) -> None:
    at = at_work(robot)
    first, problems = seen(at.controller, at.setting), list[str]()
    for owner in at.controller, at.stack:
        for name in sorted(public(owner)):
            problems += refused(owner, name, getattr(owner, name))
            problems += refused(owner, misspelt(name), 1, tells=f"'{name}'")
    for name, value in {
        "dt": 0.1,
        "order": "acceleration",
        "stack": at.task,
        "robot": arm(),
        "bakend": "native",
    }.items():
        problems += refused(at.controller, name, value)
    assert not problems, "\n".join(problems)
    assert not seen(at.controller, at.setting).unlike(first)
    with pytest.raises(InvalidInput, match="change"):
        at.controller.stack = at.stack
    with pytest.raises(InvalidInput, match=r"controller\.change"):
        at.task.frame = "link2"


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("robot", SETTINGS)
def test_a_gain_that_diverges_at_work_is_refused_and_nothing_changes(robot: str, order: Any) -> None:
    at = at_work(robot, order)
    wrapped = PositionTask(at.setting.point(0.4, 0.2, 0.5), gain=2.0)
    inside = Controller(at.setting.robot, AtMost(wrapped) >> PostureTask(at.setting.q, gain=0.5), order=order, dt=DT)
    slow = Controller(at.setting.robot, at.stack, order=order, dt=0.5)  # which takes less
    before = [(controller, seen(controller, at.setting)) for controller in (at.controller, inside, slow)]
    for part, gain in (at.task, 1000.0), (at.task, 20.0), (wrapped, 1000.0):
        old = part.gain
        with pytest.raises(InvalidInput, match="gain = "):
            part.gain = gain
        assert part.gain is old
    for controller, first in before:
        assert not seen(controller, at.setting).unlike(first)
    del slow, before, controller
    gc.collect()
    at.task.gain = 20.0  # of which nobody is left to say no
    free = PositionTask(at.setting.point(0.4, 0.2, 0.5), gain=2.0)
    free.gain = 1e6
    with pytest.raises(InvalidInput, match="gain = "):
        Controller(at.setting.robot, free, order=order, dt=DT)


CHANGES: dict[str, Callable[[SimpleNamespace], None]] = {
    "gain": lambda at: setattr(at.task, "gain", 3.0),
    "target": lambda at: setattr(at.task, "target", at.setting.point(0.3, 0.4, 0.4)),
    "weight": lambda at: setattr(at.task, "weight", 0.0),
    "limit": lambda at: setattr(at.limits, "limit", 0.1),
}


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("robot", SETTINGS)
@pytest.mark.parametrize("change", CHANGES)
def test_all_controllers_of_a_part_see_a_change_and_copies_have_their_own(change: str, robot: str, order: Any) -> None:
    at, fresh_one = at_work(robot, order), at_work(robot, order)
    CHANGES[change](fresh_one)
    again = Controller(at.setting.robot, fresh_one.stack, order=order, dt=DT)
    first, expected = seen(at.controller, at.setting), seen(again, at.setting)
    assert expected.unlike(first)
    second, earlier = Controller(at.setting.robot, at.stack, order=order, dt=DT), copy.deepcopy(at.controller)
    assert not seen(earlier, at.setting).unlike(first)
    CHANGES[change](at)
    later, alone = copy.deepcopy(at.controller), copy.deepcopy(at.stack)
    for controller in at.controller, second, later, Controller(at.setting.robot, alone, order=order, dt=DT):
        assert not seen(controller, at.setting).unlike(expected)
    assert not seen(earlier, at.setting).unlike(first)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("robot", SETTINGS)
@pytest.mark.parametrize("change", CHANGES)
def test_a_change_is_seen_in_a_transition(change: str, robot: str, order: Any) -> None:
    """In what is left behind as in what is to come."""

    def under_way(early: bool, late: bool) -> list[np.ndarray]:
        at = at_work(robot, order)
        q, v, _ = at.setting.states[0]
        if early:
            CHANGES[change](at)
            at.controller = Controller(at.setting.robot, at.stack, order=order, dt=DT)
        at.controller.change(at.stack.without(at.limits), duration=1.0)
        at.controller(q, v, 0.0)
        if late:
            CHANGES[change](at)
        steps = [at.controller(q, v, t) for t in (0.3, 0.7, 1.2)]
        return [step.v if order == "velocity" else step.a for step in steps]

    for mine, theirs in zip(under_way(False, True), under_way(True, False), strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("robot", SETTINGS)
def test_inverse_kinematics_sees_what_was_set(robot: str) -> None:
    at, fresh_one = at_work(robot), at_work(robot)
    assert solve_ik(at.setting.robot, at.stack, at.setting.q)
    goal = at.setting.point(0.3, 0.4, 0.4)
    at.task.target = goal
    fresh_one.task = PositionTask(goal, gain=2.0)
    found = solve_ik(at.setting.robot, at.stack, at.setting.q)
    expected = solve_ik(at.setting.robot, fresh_one.task >> PostureTask(at.setting.q, gain=0.5), at.setting.q)
    assert found
    np.testing.assert_allclose(found.q, expected.q, atol=1e-6)
