"""What the laws of live numbers share: parts at work, what their controllers say, and what a refusal is."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from live_table import GROUPS, SETTINGS, Case, Made, Setting

from hqp import InvalidInput
from tasks import AtMost, Controller, JointVelocityLimit, Part, PositionTask, PostureTask
from tasks.base.live import number

DT = 0.01


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


def every_case() -> Iterator[tuple[Case, Setting]]:
    for make in SETTINGS.values():
        for group in GROUPS.values():
            for case in group(make()):
                yield case, make()


def refused(owner: Any, name: str, value: Any, *, tells: str | None = None) -> list[str]:
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


def public(owner: Any) -> set[str]:
    """The data of an object, and the properties and declarations of its class."""
    kind = type(owner)
    declared = {name for name in dir(kind) if not callable(inspect.getattr_static(kind, name))}
    return {name for name in declared | vars(owner).keys() if not name.startswith("_")}


def of_the_class(owner: Any, name: str) -> bool:
    """Whether a name is given by the class alone: a method, a ClassVar, a property without a setter."""
    found = inspect.getattr_static(type(owner), name, None)
    if name in vars(owner) or isinstance(found, number) or (isinstance(found, property) and found.fset is not None):
        return False
    return hasattr(type(owner), name)


def misspelt(name: str) -> str:
    """Two letters in each other's place; of a short name, or where they are one, a letter twice."""
    swapped = name[:-3] + name[-3:-1][::-1] + name[-1]
    if len(name) == 1:
        return name * 2
    return swapped if len(name) > 4 and swapped != name else f"{name[:2]}{name[1:]}"


def at_work(robot: str = "panda", order: Any = "velocity") -> SimpleNamespace:
    """A controller, its stack and its parts."""
    setting = SETTINGS[robot]()
    limits, task = JointVelocityLimit(1.0), PositionTask(setting.point(0.4, 0.2, 0.5), gain=2.0)
    stack = limits >> task >> PostureTask(setting.q, gain=0.5)
    controller = Controller(setting.robot, stack, order=order, dt=DT)
    return SimpleNamespace(setting=setting, limits=limits, task=task, stack=stack, controller=controller)
