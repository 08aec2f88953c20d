"""A change on a live controller gives what a fresh controller with that value gives; or it is refused by name."""

from __future__ import annotations

import copy
import gc
import inspect
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from live_table import GROUPS, SETTINGS, Case, Made, Setting, arm, planar, spatial

import tasks
from hqp import InvalidInput
from tasks import (
    AtMost,
    Controller,
    DistanceLimit,
    JointLimits,
    JointVelocityLimit,
    LinkCapsule,
    Part,
    PositionTask,
    PostureTask,
    Sphere,
    Stack,
    load_robot,
    solve_ik,
)
from tasks.live import number
from tasks.obstacles.shapes import Obstacle

DT = 0.01


# What is compared: the numbers of the hierarchy, and what is commanded.


@dataclass(frozen=True)
class Seen:
    """What a controller says in some states."""

    rows: list[np.ndarray]
    x: list[np.ndarray]
    ok: list[bool]

    def unlike(self, other: Seen) -> str:
        """How they differ; nothing if they do not."""
        for mine, theirs in zip(self.rows, other.rows, strict=True):
            if mine.shape != theirs.shape or not np.allclose(mine, theirs, rtol=1e-12, atol=1e-12, equal_nan=True):
                return "other rows"
        if self.ok != other.ok:
            return "another status"
        for mine, theirs, ok in zip(self.x, other.x, self.ok, strict=True):
            if ok and not np.allclose(mine, theirs, rtol=1e-8, atol=1e-8):  # the same optimum, from another start
                return f"another motion, by {np.abs(mine - theirs).max():.1e}"
        return ""


def seen(controller: Controller, setting: Setting) -> Seen:
    rows, x, ok = list[np.ndarray](), list[np.ndarray](), list[bool]()
    for q, v, t in setting.states:
        step = controller(q, v, t)
        for k, level in enumerate(controller.hierarchy.levels):
            rows.append(np.column_stack([controller.hierarchy.matrix(k), level.lower, level.upper, level.weights]))
        command = step.v if step.order == "velocity" else step.a
        assert command is not None
        x.append(command)
        ok.append(step.ok)
    return Seen(rows, x, ok)


def as_it_is(kind: Any) -> Any:
    return kind


def subclassed(kind: Any) -> Any:
    """A class of a user's own, with attributes set before and after those of its base."""
    if not issubclass(kind, Part):
        return kind

    def begin(self: Any, *args: Any, **options: Any) -> None:
        self.before = 1.0
        kind.__init__(self, *args, **options)
        self.after = [2.0]

    return type(f"Own{kind.__name__}", (kind,), {"__init__": begin, "__module__": __name__})


class Alive:
    """A part, all that it holds, and its stack."""

    def __init__(self, case: Case, setting: Setting, wrap: Callable[[Any], Any] = as_it_is, **changes: Any) -> None:
        self.found: dict[str, Any] = {}
        self.part = case.spec.make(changes, wrap, self.found)
        beside = AtMost(PositionTask(setting.point(0.5, 0.2, 0.3), gain=2.0))  # which goes by the limits of the joints
        below = PositionTask(setting.point(0.35, 0.3, 0.3), gain=1.0) >> PostureTask(setting.q, gain=0.5)
        self.stack = JointVelocityLimit(2.0) >> self.part >> beside >> below
        self.setting = setting

    def owner(self, path: str) -> tuple[Any, str]:
        where, _, name = path.rpartition(".")
        return self.found[where], name

    def get(self, path: str) -> Any:
        owner, name = self.owner(path)
        return getattr(owner, name)

    def set(self, path: str, value: Any) -> None:
        owner, name = self.owner(path)
        setattr(owner, name, value)

    def controller(self, order: Any) -> Controller:
        return Controller(self.setting.robot, self.stack, order=order, dt=DT)


def fresh(case: Case, setting: Setting, path: str, change: Any, order: Any) -> Seen:
    """What a controller says whose part was made with a value."""
    made = change if isinstance(change, Made) else Made(change, {path: change})
    alive = Alive(case, setting, **(made.keywords or {}))
    if made.keywords is None:
        alive.set(path, made.value)
    return seen(alive.controller(order), setting)


CASES = [pytest.param(group, robot, id=f"{group}-{robot}") for robot in SETTINGS for group in GROUPS]


def every_case() -> Iterator[tuple[Case, Setting]]:
    for make in SETTINGS.values():
        for group in GROUPS.values():
            for case in group(make()):
                yield case, make()


# The law.


@pytest.mark.parametrize(("group", "robot"), CASES)
def test_a_change_gives_what_a_fresh_controller_gives(group: str, robot: str) -> None:
    """Before and after the controller is made, there and back, of a class and of a subclass."""
    setting, problems = SETTINGS[robot](), list[str]()
    for case in GROUPS[group](setting):
        for path, change in (case.live | case.either).items():
            told = set[str]()
            for order in case.orders:
                try:
                    told.update(_ignored(case, setting, path, change, order, may_refuse=path in case.either))
                except Exception as error:  # so that the others are told too
                    told.add(f"{order}: {type(error).__name__}: {error}")
            problems += [f"{case.spec.kind.__name__}.{path}: {what}" for what in sorted(told)]
    assert not problems, "\n".join(problems)


def _ignored(case: Case, setting: Setting, path: str, change: Any, order: Any, *, may_refuse: bool) -> Iterator[str]:
    value, expected = change.value if isinstance(change, Made) else change, None
    for wrap in as_it_is, subclassed:
        label = f"{order}, {'subclass, ' if wrap is subclassed else ''}"
        alive, early = Alive(case, setting, wrap), Alive(case, setting, wrap)
        controller = alive.controller(order)
        first, old = seen(controller, setting), alive.get(path)
        try:
            alive.set(path, value)
        except InvalidInput as refusal:
            if not may_refuse:
                yield f"{label}refused: {refusal}"
            elif path.rpartition(".")[2] not in str(refusal):
                yield f"{label}the refusal does not name it: {refusal}"
            if what := seen(controller, setting).unlike(first):
                yield f"{label}refused, but it has changed: {what}"
            continue
        expected = expected or fresh(case, setting, path, change, order)
        if what := seen(controller, setting).unlike(expected):
            yield f"{label}set at work: {what}"
        early.set(path, value)
        if what := seen(early.controller(order), setting).unlike(expected):
            yield f"{label}set before: {what}"
        try:
            alive.set(path, old)
        except InvalidInput as refusal:
            yield f"{label}the old value is refused: {refusal}"
        if what := seen(controller, setting).unlike(first):
            yield f"{label}set back: {what}"


@pytest.mark.parametrize(("group", "robot"), CASES)
def test_the_other_values_of_the_table_tell(group: str, robot: str) -> None:
    """A value that changes nothing would prove nothing."""
    setting = SETTINGS[robot]()
    for case in GROUPS[group](setting):
        before = {order: seen(Alive(case, setting).controller(order), setting) for order in case.orders}
        for path, change in case.live.items():
            with suppress(InvalidInput):  # for the law to tell
                after = [fresh(case, setting, path, change, order).unlike(before[order]) for order in case.orders]
                assert any(after), f"{case.spec.kind.__name__}.{path}"


@pytest.mark.parametrize(("group", "robot"), CASES)
def test_structure_is_refused_and_all_goes_on(group: str, robot: str) -> None:
    setting, problems = SETTINGS[robot](), list[str]()
    for case in GROUPS[group](setting):
        order = case.orders[-1]
        for wrap in as_it_is, subclassed:
            alive = Alive(case, setting, wrap)
            controller = alive.controller(order)
            first = seen(controller, setting)
            for path in case.stays:
                owner, name = alive.owner(path)
                problems += _refused(owner, name, getattr(owner, name, None))
                problems += _refused(owner, name, "panda_link3" if name in ("frame", "relative_to") else 1)
            if what := seen(controller, setting).unlike(first):
                problems.append(f"{case.spec.kind.__name__}: after refusals {what}")
    assert not problems, "\n".join(dict.fromkeys(problems))


def _refused(owner: Any, name: str, value: Any, *, tells: str | None = None) -> list[str]:
    """What is wrong with the refusal of an attribute."""
    before = dict(vars(owner))
    label = f"{type(owner).__name__}.{name} = {value!r:.40}"
    try:
        setattr(owner, name, value)
    except InvalidInput as refusal:
        kept = vars(owner).keys() == before.keys() and all(vars(owner)[key] is old for key, old in before.items())
        wrong = [] if kept else [f"{label}: refused, but set"]
        return wrong if (tells or name) in str(refusal) else [*wrong, f"{label}: the refusal says {refusal}"]
    except Exception as error:  # whatever it is, it is not the refusal of the house
        return [f"{label}: {type(error).__name__}: {error}"]
    vars(owner).clear()
    vars(owner).update(before)
    return [f"{label}: not refused"]


# All attributes of all parts.


def _public(owner: Any) -> set[str]:
    """The data of an object, and the properties and declarations of its class."""
    kind = type(owner)
    declared = {name for name in dir(kind) if not callable(inspect.getattr_static(kind, name))}
    return {name for name in declared | vars(owner).keys() if not name.startswith("_")}


def _of_the_class(owner: Any, name: str) -> bool:
    """Whether a name is given by the class alone: a method, a ClassVar, a property without a setter."""
    found = inspect.getattr_static(type(owner), name, None)
    if name in vars(owner) or isinstance(found, number) or (isinstance(found, property) and found.fset is not None):
        return False
    return hasattr(type(owner), name)


def test_the_table_knows_every_part() -> None:
    made = {type(owner) for case, setting in every_case() for owner in Alive(case, setting).found.values()}
    for name in tasks.__all__:
        kind = getattr(tasks, name)
        if isinstance(kind, type) and issubclass(kind, Part | Obstacle | LinkCapsule):
            assert any(issubclass(other, kind) for other in made), name


def test_the_table_knows_every_attribute() -> None:
    known, there = dict[type, set[str]](), dict[type, set[str]]()
    for case, setting in every_case():
        alive = Alive(case, setting)
        for owner in alive.found.values():
            data = {name for name in _public(owner) if not _of_the_class(owner, name)}
            there.setdefault(type(owner), set()).update(data)
        for path in (*case.live, *case.either, *case.stays):
            owner, name = alive.owner(path)
            known.setdefault(type(owner), set()).add(name)
    missing = {kind.__name__: names - known.get(kind, set()) for kind, names in there.items()}
    assert not {kind: names for kind, names in missing.items() if names}


def test_what_the_class_gives_is_refused() -> None:
    """Methods, and what says of which kind it is."""
    problems, done = list[str](), set[tuple[type, str]]()
    for case, setting in every_case():
        for owner in Alive(case, setting).found.values():
            for name in dir(type(owner)):
                if not name.startswith("_") and (type(owner), name) not in done and _of_the_class(owner, name):
                    done.add((type(owner), name))
                    problems += _refused(owner, name, 1)
    assert not problems, "\n".join(problems)


def test_a_misspelt_attribute_is_refused_with_the_nearest_name() -> None:
    problems = list[str]()
    for case, setting in every_case():
        alive = Alive(case, setting)
        for path in (*case.live, *case.stays):
            owner, name = alive.owner(path)
            if name in _public(owner):
                problems += _refused(owner, misspelt(name), 1, tells=f"'{name}'")
    assert not problems, "\n".join(dict.fromkeys(problems))


def test_copies_refuse_too() -> None:
    robots = [arm(), spatial()]
    parts = [owner for case, setting in every_case() for owner in Alive(case, setting).found.values()]
    work = [owner for robot in SETTINGS for owner in (_at_work(robot).controller, _at_work(robot).stack)]
    problems = list[str]()
    for owner in (*parts, *robots, *work):
        problems += _refused(copy.deepcopy(owner), "misspelt", 1)
    assert not problems, "\n".join(dict.fromkeys(problems))


def misspelt(name: str) -> str:
    """Two letters in each other's place; of a short name, one twice."""
    return f"{name[:-3]}{name[-2]}{name[-3]}{name[-1]}" if len(name) > 4 else f"{name[:2]}{name[1:]}"


def test_a_keyword_that_is_no_attribute_is_not_taken_for_one() -> None:
    """``task.direction = ...`` is not set beside `target` without a word."""
    problems = list[str]()
    for case, setting in every_case():
        for owner in Alive(case, setting).found.values():
            for name in inspect.signature(type(owner)).parameters:
                if name not in _public(owner) and name not in ("args", "kwargs", "options", "limits"):
                    problems += _refused(owner, name, 1.0)
    assert not problems, "\n".join(dict.fromkeys(problems))


def test_nobody_writes_into_a_number() -> None:
    problems = list[str]()
    for case, setting in every_case():
        alive = Alive(case, setting)
        alive.controller(case.orders[-1])
        for path in case.live:
            value = alive.get(path)
            if isinstance(value, np.ndarray) and value.flags.writeable:
                problems.append(f"{case.spec.kind.__name__}.{path}: an array that can be written into")
            if isinstance(value, dict):
                with pytest.raises((TypeError, InvalidInput)):
                    value[0] = 5.0
    assert not problems, "\n".join(dict.fromkeys(problems))


# Robots.


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


def robot_stack(setting: Setting, order: str, alone: bool) -> Stack:
    """Limits of the robot's own, together or one by one, and what else goes by them."""
    parts: list[Any] = [JointLimits()]
    if alone:
        parts = [tasks.JointPositionLimit(), tasks.JointVelocityLimit(), tasks.JointAccelerationLimit()]
    if order == "acceleration":
        parts.append(tasks.JointTorqueLimit())
    place = AtMost(PositionTask(setting.point(0.4, 0.2, 0.5), gain=2.0))
    links, balls = [LinkCapsule(setting.frame, [-0.1, 0.0], 0.05)], [Sphere([0.9, 0.9, 0.1], 0.05)]
    apart = DistanceLimit(links, balls, margin=0.02, gain=2.0)
    task = PositionTask(setting.point(0.35, 0.3, 0.3), gain=1.0)
    return Stack(*parts, place, apart, task, tasks.JointCentringTask(gain=2.0))


@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("name", ROBOTS)
def test_limits_of_a_robot_are_live(name: str, order: Any, alone: bool) -> None:
    make, where = ROBOTS[name]
    setting, robot = SETTINGS[where](), make()
    controller = Controller(robot, robot_stack(setting, order, alone), order=order, dt=DT)
    first = seen(controller, setting)
    for quantity, values in LIMITS.items():
        value, old = values(robot.nv), getattr(robot, quantity)
        other = make(**{quantity: value})
        expected = seen(Controller(other, robot_stack(setting, order, alone), order=order, dt=DT), setting)
        assert quantity == "torque_limit" or expected.unlike(first), quantity
        setattr(robot, quantity, value)
        assert not seen(controller, setting).unlike(expected), quantity
        setattr(robot, quantity, old)
        assert not seen(controller, setting).unlike(first), quantity


@pytest.mark.parametrize("name", ["arm", "panda"])
@pytest.mark.parametrize("quantity", LIMITS)
def test_a_robot_refuses_what_cannot_be_its_limit(name: str, quantity: str) -> None:
    make, where = ROBOTS[name]
    setting, robot = SETTINGS[where](), make()
    controller = Controller(robot, robot_stack(setting, "acceleration", False), order="acceleration", dt=DT)
    first = seen(controller, setting)
    wrong = [-1.0, np.ones(2), "a"] if quantity != "position_limit" else [(1.0, -1.0), np.ones((2, 2)), 3.0]
    problems = [problem for value in wrong for problem in _refused(robot, quantity, value, tells=quantity[:5])]
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
    controller = Controller(robot, robot_stack(setting, "velocity", False), dt=DT)
    earlier, first = copy.deepcopy(controller), seen(controller, setting)
    robot.velocity_limit = LIMITS["velocity_limit"](robot.nv)
    later = copy.deepcopy(controller)
    assert first.unlike(seen(controller, setting))
    assert not seen(earlier, setting).unlike(first)
    assert not seen(later, setting).unlike(seen(controller, setting))


#: What a robot knows of its file, and where it starts: no controller goes by it.
FREE = {"home", "left_out", "recipe", "source"}


@pytest.mark.parametrize("name", ["arm", "panda"])
def test_all_else_of_a_robot_stays(name: str) -> None:
    make, where = ROBOTS[name]
    setting, robot = SETTINGS[where](), make()
    controller = Controller(robot, robot_stack(setting, "velocity", False), dt=DT)
    first, problems = seen(controller, setting), list[str]()
    for attribute in sorted(_public(robot) - LIMITS.keys() - FREE):
        problems += _refused(robot, attribute, getattr(robot, attribute))
        problems += _refused(robot, attribute, 1)
    for attribute in LIMITS:
        problems += _refused(robot, f"{attribute}s", 1.0, tells=f"'{attribute}'")
    assert not problems, "\n".join(problems)
    assert not seen(controller, setting).unlike(first)


# Controllers and stacks.


def _at_work(robot: str = "panda", order: Any = "velocity") -> SimpleNamespace:
    """A controller, its stack and its parts."""
    setting = SETTINGS[robot]()
    limits, task = JointVelocityLimit(1.0), PositionTask(setting.point(0.4, 0.2, 0.5), gain=2.0)
    stack = limits >> task >> PostureTask(setting.q, gain=0.5)
    controller = Controller(setting.robot, stack, order=order, dt=DT)
    return SimpleNamespace(setting=setting, limits=limits, task=task, stack=stack, controller=controller)


@pytest.mark.parametrize("robot", SETTINGS)
def test_controllers_and_stacks_stay(robot: str) -> None:
    at = _at_work(robot)
    first, problems = seen(at.controller, at.setting), list[str]()
    for owner in at.controller, at.stack:
        for name in sorted(_public(owner)):
            problems += _refused(owner, name, getattr(owner, name))
            problems += _refused(owner, misspelt(name), 1, tells=f"'{name}'")
    for name, value in {
        "dt": 0.1,
        "order": "acceleration",
        "stack": at.task,
        "robot": arm(),
        "bakend": "native",
    }.items():
        problems += _refused(at.controller, name, value)
    assert not problems, "\n".join(problems)
    assert not seen(at.controller, at.setting).unlike(first)
    with pytest.raises(InvalidInput, match="change"):
        at.controller.stack = at.stack
    with pytest.raises(InvalidInput, match=r"controller\.change"):
        at.task.frame = "link2"


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("robot", SETTINGS)
def test_a_gain_that_diverges_at_work_is_refused_and_nothing_changes(robot: str, order: Any) -> None:
    at = _at_work(robot, order)
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


# Whoever else looks.


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
    at, fresh_one = _at_work(robot, order), _at_work(robot, order)
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
        at = _at_work(robot, order)
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
    at, fresh_one = _at_work(robot), _at_work(robot)
    assert solve_ik(at.setting.robot, at.stack, at.setting.q)
    goal = at.setting.point(0.3, 0.4, 0.4)
    at.task.target = goal
    fresh_one.task = PositionTask(goal, gain=2.0)
    found = solve_ik(at.setting.robot, at.stack, at.setting.q)
    expected = solve_ik(at.setting.robot, fresh_one.task >> PostureTask(at.setting.q, gain=0.5), at.setting.q)
    assert found
    np.testing.assert_allclose(found.q, expected.q, atol=1e-6)


def test_a_robot_with_a_floating_base_sees_them_too() -> None:
    robot = load_robot("g1")
    hand = PositionTask([0.3, 0.2, 0.1], frame=robot.frame_names[-1], gain=2.0)
    controller = Controller(robot, hand >> PostureTask(robot.home, gain=1.0), dt=DT)
    still = np.zeros(robot.nv)
    first = controller(robot.home, still).v
    hand.gain = 4.0
    other = controller(robot.home, still).v
    np.testing.assert_allclose(hand_speed(robot, other), 2.0 * hand_speed(robot, first), atol=1e-9)


def hand_speed(robot: Any, v: Any) -> Any:
    return robot.at(robot.home, np.zeros(robot.nv)).frame(robot.frame_names[-1]).linear @ v
