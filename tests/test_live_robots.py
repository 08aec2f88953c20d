"""The limits of a robot at work may be set; what else it is stays."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from live_table import SETTINGS, Setting, arm, planar, spatial
from live_work import DT, public, refused, seen

import tasks
from hqp import InvalidInput
from tasks import (
    AtMost,
    Controller,
    DistanceLimit,
    JointLimits,
    LinkCapsule,
    PositionTask,
    PostureTask,
    Sphere,
    Stack,
    load_robot,
)


class Borrowed:
    """A robot of a user's own: the least that one needs, with the kinematics of an arm."""

    def __init__(self, **limits: Any) -> None:
        self._arm = arm()
        self.nq = self.nv = self._arm.nq
        self.position_limit, self.torque_limit = self._arm.position_limit, self._arm.torque_limit
        self.velocity_limit, self.acceleration_limit = self._arm.velocity_limit, self._arm.acceleration_limit
        for name, value in limits.items():
            setattr(self, name, value)
        self.mass_matrix, self.bias = self._arm.mass_matrix, self._arm.bias

    def at(self, q: Any, v: Any) -> Any:
        return self._arm.at(q, v)


def ranges(n: int) -> np.ndarray:
    return np.array([np.linspace(-1.4, -1.0, n), np.linspace(1.0, 1.4, n)])


LIMITS: dict[str, Callable[[int], Any]] = {
    "position_limit": ranges,
    "velocity_limit": lambda n: np.linspace(0.1, 0.6, n),
    "acceleration_limit": lambda n: np.linspace(4.0, 8.0, n),
    "torque_limit": lambda n: np.linspace(1.0, 4.0, n),
}
ROBOTS: dict[str, tuple[Callable[..., Any], str]] = {
    "arm": (arm, "arm"),
    "panda": (spatial, "panda"),
    "borrowed": (Borrowed, "arm"),
}


#: The limits of a robot as they stand in a stack.
HELD: dict[str, Callable[[], list[Any]]] = {
    "together": lambda: [JointLimits()],
    "alone": lambda: [tasks.JointPositionLimit(), tasks.JointVelocityLimit(), tasks.JointAccelerationLimit()],
    "ranges": lambda: [tasks.JointPositionLimit()],
    "none": list,
}


def robot_stack(setting: Setting, order: str, held: str, *, others: bool = True) -> Stack:
    """Limits of the robot's own, and what else goes by them: whatever they are claimed by, or others too."""
    parts: list[Any] = HELD[held]()
    if order == "acceleration" and others:
        parts.append(tasks.JointTorqueLimit())
    place = AtMost(PositionTask(setting.point(0.4, 0.2, 0.5), gain=2.0))
    links, balls = [LinkCapsule(setting.frame, [-0.1, 0.0], 0.05)], [Sphere([0.9, 0.9, 0.1], 0.05)]
    apart = DistanceLimit(links, balls, margin=0.02, gain=2.0)
    task = PositionTask(setting.point(0.35, 0.3, 0.3), gain=1.0)
    below = tasks.JointCentringTask(gain=2.0) if others else PostureTask(setting.q, gain=0.5)
    return Stack(*parts, place, *([apart] if held in ("together", "alone") else []), task, below)


@pytest.mark.parametrize("others", [False, True])
@pytest.mark.parametrize("held", HELD)
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("name", ROBOTS)
def test_limits_of_a_robot_are_live(name: str, order: Any, held: str, others: bool) -> None:
    make, where = ROBOTS[name]
    setting, robot = SETTINGS[where](), make()
    controller = Controller(robot, robot_stack(setting, order, held, others=others), order=order, dt=DT)
    first, planned = seen(controller, setting), controller._rows.planned
    for quantity, values in LIMITS.items():
        value, old = values(robot.nv), getattr(robot, quantity)
        other = make(**{quantity: value})
        expected = seen(
            Controller(other, robot_stack(setting, order, held, others=others), order=order, dt=DT), setting
        )
        assert quantity == "torque_limit" or held in ("ranges", "none") or expected.unlike(first), quantity
        setattr(robot, quantity, value)
        assert not seen(controller, setting).unlike(expected), quantity
        setattr(robot, quantity, old)
        assert not seen(controller, setting).unlike(first), quantity
    assert others or controller._rows.planned == planned, "planned anew, for numbers alone"


def test_a_part_that_reads_limits_in_its_own_way_is_planned_anew() -> None:
    """One with a check of its own, also inside of another part."""

    class Checked(PositionTask):
        def check(self, robot: Any, order: Any, dt: float | None) -> None:
            super().check(robot, order, dt)
            if robot.velocity_limit.max() > 3.0:
                raise InvalidInput("velocity limit: the hand is not made for that")

    for task in Checked([0.4, 0.2], gain=2.0), AtMost(Checked([0.4, 0.2], gain=2.0)):
        setting, robot = planar(), arm()
        controller = Controller(robot, JointLimits() >> task, dt=DT)
        first = seen(controller, setting)
        assert not refused(robot, "velocity_limit", 4.0, tells="made for that")
        assert not seen(controller, setting).unlike(first)


@pytest.mark.parametrize("name", ["arm", "panda"])
@pytest.mark.parametrize("quantity", LIMITS)
def test_a_robot_refuses_what_cannot_be_its_limit(name: str, quantity: str) -> None:
    make, where = ROBOTS[name]
    setting, robot = SETTINGS[where](), make()
    controller = Controller(robot, robot_stack(setting, "acceleration", "together"), order="acceleration", dt=DT)
    first = seen(controller, setting)
    wrong = [-1.0, np.ones(2), "a"] if quantity != "position_limit" else [(1.0, -1.0), np.ones((2, 2)), 3.0]
    problems = [problem for value in wrong for problem in refused(robot, quantity, value, tells=quantity[:5])]
    assert not problems, "\n".join(problems)
    assert not seen(controller, setting).unlike(first)
    assert not getattr(robot, quantity).flags.writeable


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("comes", [False, True])
@pytest.mark.parametrize("quantity", LIMITS)
def test_a_limit_that_comes_or_goes_is_seen_or_refused(quantity: str, comes: bool, order: Any) -> None:
    """With it `JointLimits` may have one kind more or less, and another part none to go by."""
    setting, some = planar(), {quantity: LIMITS[quantity](4)}
    before, after = ({quantity: None}, some) if comes else (some, {quantity: None})
    robot, other = arm(**before), arm(**after)
    stack = JointLimits() >> PositionTask([0.4, 0.2], gain=2.0)
    try:
        controller = Controller(robot, stack, order=order, dt=DT)
    except InvalidInput:
        return
    first, refusal = seen(controller, setting), ""
    try:
        setattr(robot, quantity, after[quantity])
    except InvalidInput as error:
        refusal = str(error)
    expected = first if refusal else seen(Controller(other, stack, order=order, dt=DT), setting)
    assert not refusal or quantity[:5] in refusal
    assert not seen(controller, setting).unlike(expected)


@pytest.mark.parametrize("name", ["arm", "panda"])
def test_a_copied_robot_has_limits_of_its_own(name: str) -> None:
    make, where = ROBOTS[name]
    setting, robot = SETTINGS[where](), make()
    controller = Controller(robot, robot_stack(setting, "velocity", "together"), dt=DT)
    earlier, first = copy.deepcopy(controller), seen(controller, setting)
    robot.velocity_limit = LIMITS["velocity_limit"](robot.nv)
    later = copy.deepcopy(controller)
    assert first.unlike(seen(controller, setting))
    assert not seen(earlier, setting).unlike(first)
    assert not seen(later, setting).unlike(seen(controller, setting))


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_rows_that_begin_at_the_neutral_configuration_follow_it_into_other_ranges(order: Any) -> None:
    def made(robot: Any) -> Controller:
        folded = tasks.LinearHolonomicTask(np.eye(7)[[3]], 0.1, gain=2.0)
        return Controller(robot, JointLimits() >> folded >> PostureTask(setting.q, gain=1.0), order=order, dt=DT)

    setting, robot = SETTINGS["panda"](), spatial()
    controller, ends, zero = made(robot), robot.position_limit, robot.neutral
    first, home = seen(controller, setting), robot.home
    assert zero[3] < 0.0, "zero is out of the range of this joint"
    robot.position_limit = np.full((2, 7), 1.0) * [[-1.0], [1.0]]
    assert robot.neutral[3] == 0.0
    assert not seen(controller, setting).unlike(seen(made(robot), setting))
    assert (np.abs(robot.home) <= 1.0).all()
    robot.position_limit = ends
    assert not seen(controller, setting).unlike(first)
    np.testing.assert_array_equal(robot.home, home)


#: What a robot knows of its file, and where it starts: no controller goes by it.
FREE = {"closures", "home", "left_out", "recipe", "scene", "source", "springs"}


@pytest.mark.parametrize("name", ["arm", "panda"])
def test_all_else_of_a_robot_stays(name: str) -> None:
    make, where = ROBOTS[name]
    setting, robot = SETTINGS[where](), make()
    controller = Controller(robot, robot_stack(setting, "velocity", "together"), dt=DT)
    first, problems = seen(controller, setting), list[str]()
    for attribute in sorted(public(robot) - LIMITS.keys() - FREE):
        problems += refused(robot, attribute, getattr(robot, attribute))
        problems += refused(robot, attribute, 1)
    for attribute in LIMITS:
        problems += refused(robot, f"{attribute}s", 1.0, tells=f"'{attribute}'")
    assert not problems, "\n".join(problems)
    assert not seen(controller, setting).unlike(first)


def test_a_robot_with_a_floating_base_sees_them_too() -> None:
    robot = load_robot("g1")
    hand = PositionTask([0.3, 0.2, 0.1], frame=robot.frame_names[-1], gain=2.0)
    controller = Controller(robot, hand >> PostureTask(robot.home, gain=1.0), dt=DT, damping=None)
    still = np.zeros(robot.nv)
    first = controller(robot.home, still).v
    hand.gain = 4.0
    other = controller(robot.home, still).v
    np.testing.assert_allclose(hand_speed(robot, other), 2.0 * hand_speed(robot, first), atol=1e-9)


def hand_speed(robot: Any, v: Any) -> Any:
    return robot.at(robot.home, np.zeros(robot.nv)).frame(robot.frame_names[-1]).linear @ v
