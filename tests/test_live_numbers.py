"""Numbers set on a part at work are written where its plan has put them; what is more has it planned anew."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from live_table import SETTINGS, Setting
from live_work import DT

from hqp import InvalidInput
from tasks import (
    AtMost,
    Controller,
    Fixed,
    JointAccelerationLimit,
    JointLimits,
    JointPositionLimit,
    JointVelocityLimit,
    OrientationTask,
    Part,
    PlanarArm,
    PositionTask,
    PostureTask,
    Setpoint,
    Stack,
)
from tasks.rows.hierarchy_writer import HierarchyWriter

ORDERS = ["velocity", "acceleration"]


class Parts:
    """The parts of one stack, by name."""

    def __init__(self, setting: Setting, hand: type[PositionTask] = PositionTask) -> None:
        n = setting.robot.nv
        self.range = JointPositionLimit(np.full(n, -3.0), np.full(n, 3.0))
        self.speed, self.acceleration = JointVelocityLimit(2.0), JointAccelerationLimit(15.0)
        self.bounded = PositionTask(setting.point(0.5, 0.2, 0.3), gain=2.0)
        self.bound, self.hand = AtMost(self.bounded), hand(setting.point(0.4, 0.2, 0.5), gain=2.0)
        self.turn, self.rest = OrientationTask(0.3, gain=1.0), PostureTask(setting.q, gain=0.5)

    @property
    def stack(self) -> Stack:
        limits = JointLimits(self.range, self.speed, self.acceleration)
        return limits >> self.bound >> self.hand >> self.turn >> self.rest


def numbers(rows: HierarchyWriter, setting: Setting) -> np.ndarray:
    """All rows, at the states of the setting."""
    return np.array([rows.fill(setting.robot.at(q, v), t).numbers.copy() for q, v, t in setting.states])


def like_fresh(rows: HierarchyWriter, parts: Parts, setting: Setting, order: Any) -> None:
    fresh = parts.stack.build(setting.robot, order, DT)
    np.testing.assert_allclose(numbers(rows, setting), numbers(fresh, setting), rtol=1e-12, atol=1e-12)


def changes(s: Setting) -> list[tuple[str, str, Any]]:
    """Numbers that are set one after the other."""
    n = s.robot.nv
    return [
        ("hand", "target", s.point(0.3, 0.3, 0.4)),
        ("hand", "position", s.point(0.2, 0.3, 0.4)),
        ("hand", "gain", 3.0),
        ("hand", "damping_ratio", 0.8),
        ("hand", "cap", 0.1),
        ("hand", "deceleration", 0.5),
        ("hand", "cap", None),
        ("hand", "weight", 0.5),
        ("turn", "target", 0.7),
        ("turn", "weight", 0.0),
        ("turn", "gain", 3.0),
        ("turn", "weight", 2.0),
        ("rest", "target", s.q + 0.1),
        ("rest", "gain", np.linspace(0.3, 0.6, n)),
        ("bounded", "target", s.point(0.4, 0.3, 0.2)),
        ("bounded", "gain", 3.0),
        ("bound", "below", -0.3),
        ("bound", "above", np.array(0.2)),
        ("speed", "limit", np.linspace(1.0, 2.0, n)),
        ("acceleration", "limit", 20.0),
        ("range", "upper", np.full(n, 2.5)),
        ("range", "return_speed", 0.4),
    ]


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("robot", SETTINGS)
def test_numbers_alone_need_no_new_plan(robot: str, order: Any) -> None:
    setting = SETTINGS[robot]()
    parts = Parts(setting)
    rows = parts.stack.build(setting.robot, order, DT)
    planned, shared = rows.planned, rows.shared
    for part, name, value in changes(setting):
        setattr(getattr(parts, part), name, value)
        like_fresh(rows, parts, setting, order)
    assert rows.planned == planned
    assert rows.shared is shared


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("robot", SETTINGS)
def test_what_is_more_than_a_number_is_planned(robot: str, order: Any) -> None:
    """There and back: targets that begin to move, and with numbers in between."""
    setting = SETTINGS[robot]()
    parts = Parts(setting)
    rows = parts.stack.build(setting.robot, order, DT)
    there, back = setting.point(0.3, 0.3, 0.4), setting.point(0.4, 0.2, 0.5)
    setpoint = Setpoint(there)
    for value in setpoint, back, there, setpoint, there:
        parts.hand.target = value
        like_fresh(rows, parts, setting, order)
    setpoint.move(back)  # which nobody listens to any more
    like_fresh(rows, parts, setting, order)


def test_states_that_are_no_numbers_spoil_no_change() -> None:
    setting = SETTINGS["arm"]()
    parts = Parts(setting)
    rows = parts.stack.build(setting.robot, "velocity", DT)
    nowhere = np.full(setting.robot.nv, np.nan)
    for limit in 10.0, 20.0, 12.0:
        rows.fill(setting.robot.at(nowhere, nowhere), 0.0)
        parts.acceleration.limit = limit
        parts.hand.target = setting.point(0.1 * setting.robot.nv, 0.2, 0.5)
        like_fresh(rows, parts, setting, "velocity")


class Careful(PositionTask):
    """It has its own say in what it takes."""

    def check(self, *given: Any) -> None:
        super().check(*given)
        if self.target(0.0)[0][0] > 1.0 or self.weight.max() > 1.0:
            raise InvalidInput("careful: not so far")


def test_a_subclass_with_a_check_of_its_own_is_asked() -> None:
    setting = SETTINGS["arm"]()
    parts = Parts(setting, Careful)
    rows = parts.stack.build(setting.robot, "velocity", DT)
    first, old = numbers(rows, setting), parts.hand.target
    for name, value in ("target", setting.point(2.0, 0.2, 0.5)), ("weight", 3.0):
        with pytest.raises(InvalidInput, match="careful"):
            setattr(parts.hand, name, value)
    assert parts.hand.target is old
    np.testing.assert_array_equal(numbers(rows, setting), first)
    parts.hand.target = setting.point(0.2, 0.2, 0.5)
    like_fresh(rows, parts, setting, "velocity")


class Shifted(PositionTask):
    """With a number of its own, which it tells nobody of."""

    @property
    def position(self) -> Any:
        place = np.array(super().position(0.0)[0])
        place[0] += vars(self).get("_shift", 0.0)
        return Fixed(place)


def test_what_was_set_without_a_word_is_taken_up_with_the_next_number() -> None:
    setting = SETTINGS["arm"]()
    parts = Parts(setting, Shifted)
    rows = parts.stack.build(setting.robot, "velocity", DT)
    parts.hand._shift = 0.1
    parts.hand.gain = 3.0
    like_fresh(rows, parts, setting, "velocity")


class Halved(JointVelocityLimit):
    """Bounds that are half of what it is given."""

    def ends(self, robot: Any) -> np.ndarray:
        return 0.5 * super().ends(robot)


def test_limits_of_ones_own_follow() -> None:
    setting = SETTINGS["arm"]()
    limit = Halved(2.0)
    rows = (limit >> PositionTask(setting.point(0.4, 0.2, 0.5), gain=2.0)).build(setting.robot, "velocity", DT)
    q, v, t = setting.states[0]
    for largest in 1.0, 3.0:
        limit.limit = largest
        view = rows.fill(setting.robot.at(q, v), t).levels[0]
        assert view.upper.tolist() == (-view.lower).tolist() == [0.5 * largest] * setting.robot.nv


@pytest.mark.parametrize("name", ["target", "gain", "weight"])
def test_a_wrong_number_is_refused_at_once_and_nothing_has_changed(name: str) -> None:
    setting = SETTINGS["arm"]()
    parts = Parts(setting)
    rows = parts.stack.build(setting.robot, "velocity", DT)
    first = numbers(rows, setting)
    part: Part
    for part in parts.hand, parts.rest:
        for value in (np.nan, [0.1] * 9, "far"):
            old = getattr(part, name)
            with pytest.raises(InvalidInput):
                setattr(part, name, value)
            assert getattr(part, name) is old
            np.testing.assert_array_equal(numbers(rows, setting), first)


@pytest.mark.parametrize("order", ORDERS)
def test_damping_by_curvature_goes_by_the_gains_of_now(order: Any) -> None:
    """Out of reach, where levels give way by how fast each is to go."""
    setting = SETTINGS["arm"]()

    def made(gain: float) -> tuple[PositionTask, Controller]:
        task = PositionTask(setting.point(4.0, 1.0, 0.5), gain=gain)
        stack = JointVelocityLimit(2.0) >> task >> OrientationTask(0.3, gain=2.0) >> PostureTask(setting.q, gain=0.5)
        return task, Controller(setting.robot, stack, order=order, dt=DT)

    def commands(controller: Controller) -> np.ndarray:
        steps = [controller(0.01 * np.ones_like(q) + 0.02 * q, v, t) for q, v, t in setting.states]
        assert any(step.relaxed for step in steps)
        return np.array([step.v if order == "velocity" else step.a for step in steps])

    task, controller = made(2.0)
    before = commands(controller)
    task.gain = 6.0
    _, fresh = made(6.0)
    expected = commands(fresh)
    assert not np.allclose(before, expected, atol=1e-3)
    np.testing.assert_allclose(commands(controller), expected, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("order", ORDERS)
def test_limits_that_change_one_by_one_are_those_of_a_fresh_controller(order: Any) -> None:
    """A limit that changes writes its own numbers alone, also after one that was refused; the others hold on."""
    arm = PlanarArm([0.4, 0.4, 0.4, 0.3])
    q, v = np.array([0.3, 0.7, 0.9, 0.4]), np.array([0.5, -0.4, 0.3, 0.1])

    def made(low: float, high: float, speed: float, brakes: float) -> tuple[Controller[Any, Any, Any], list[Any]]:
        limits = [JointPositionLimit(low, high), JointVelocityLimit(speed), JointAccelerationLimit(brakes)]
        stack = JointLimits(*limits) >> PositionTask([0.4, 0.9], gain=5.0)
        return Controller(arm, stack, order=order, dt=DT), limits

    now = {"low": -2.0, "high": 1.0, "speed": 1.0, "brakes": 20.0}
    live, (position, velocity, acceleration) = made(**now)
    owners = {"low": (position, "lower"), "high": (position, "upper"), "speed": (velocity, "limit")}
    owners["brakes"] = acceleration, "limit"
    for name, value in ("speed", 0.5), ("brakes", 5.0), ("high", 0.91), ("speed", 1.5), ("low", -1.0), ("brakes", 30.0):
        part, attribute = owners[name]
        with pytest.raises(InvalidInput):
            setattr(part, attribute, np.ones(7))
        setattr(part, attribute, value)
        now[name] = value
        fresh, _ = made(**now)
        live(q, v), fresh(q, v)
        for got, wanted in zip(live.bounds(next(iter(live.stack))), fresh.bounds(next(iter(fresh.stack))), strict=True):
            np.testing.assert_array_equal(got, wanted)
        ours, theirs = (each.hierarchy for each in (live, fresh))
        np.testing.assert_array_equal(ours.lower, theirs.lower)
        np.testing.assert_array_equal(ours.upper, theirs.upper)


@pytest.mark.parametrize(
    ("first", "later", "sizes"), [(3, 2, r"\(3,\)"), (3, 1, r"\(3,\)"), (2, 1, r"\(2,\) or \(3,\)")]
)
def test_a_target_of_another_size_is_told_the_sizes_that_there_are(first: int, later: int, sizes: str) -> None:
    """Of a task in space, two coordinates were refused as they must be "(2,) or (3,)"."""
    task = PositionTask(np.ones(first), gain=1.0)
    with pytest.raises(InvalidInput, match=rf"target has shape \({later},\); it must be {sizes}$"):
        task.target = np.ones(later)
