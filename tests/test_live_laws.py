"""A change of a part at work gives what a fresh controller with that value gives; or it is refused by name."""

from __future__ import annotations

import copy
import inspect
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from live_table import GROUPS, SETTINGS, Case, Made, Setting, arm, spatial
from live_work import (
    Alive,
    as_it_is,
    at_work,
    every_case,
    fresh,
    misspelt,
    of_the_class,
    public,
    refused,
    seen,
    subclassed,
)

import tasks
from hqp import InvalidInput
from tasks import LinkCapsule, Part
from tasks.obstacles.shapes import Obstacle

CASES = [pytest.param(group, robot, id=f"{group}-{robot}") for robot in SETTINGS for group in GROUPS]


@pytest.mark.parametrize(("group", "robot"), CASES)
def test_a_change_gives_what_a_fresh_controller_gives(group: str, robot: str) -> None:
    """Before and after the controller is made, there and back, of a class and of a subclass."""
    setting, problems = SETTINGS[robot](), list[str]()
    for case in GROUPS[group](setting):
        for path, change in (case.live | case.either).items():
            told, tells = set[str](), set[str]()
            for order in case.orders:
                try:
                    told.update(_ignored(case, setting, path, change, order, tells, may_refuse=path in case.either))
                except Exception as error:  # so that the others are told too
                    told.add(f"{order}: {type(error).__name__}: {error}")
            if path in case.live and not tells:
                told.add("the other value changes nothing, and proves nothing")
            problems += [f"{case.spec.kind.__name__}.{path}: {what}" for what in sorted(told)]
    assert not problems, "\n".join(problems)


def _ignored(
    case: Case, setting: Setting, path: str, change: Any, order: Any, tells: set[str], *, may_refuse: bool
) -> Iterator[str]:
    """What is wrong; a value by which a fresh controller differs leaves its order in `tells`."""
    value, expected = change.value if isinstance(change, Made) else change, None
    for wrap in (as_it_is, subclassed) if order == case.orders[-1] else (as_it_is,):
        label = f"{order}, {'subclass, ' if wrap is subclassed else ''}"
        alive = Alive(case, setting, wrap)
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
        if expected is None:
            expected = fresh(case, setting, path, change, order)
            if expected.unlike(first):
                tells.add(order)
        if what := seen(controller, setting).unlike(expected):
            yield f"{label}set at work: {what}"
        if wrap is subclassed:  # once is enough: a new controller reads what there is
            early = Alive(case, setting, wrap)
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
                problems += refused(owner, name, getattr(owner, name, None))
                problems += refused(owner, name, "panda_link3" if name in ("frame", "relative_to") else 1)
            if what := seen(controller, setting).unlike(first):
                problems.append(f"{case.spec.kind.__name__}: after refusals {what}")
    assert not problems, "\n".join(dict.fromkeys(problems))


def test_rows_hang_on_the_state_alone() -> None:
    """Whatever came before: other states, or the same one."""
    problems = list[str]()
    for case, setting in every_case():
        for order in case.orders:
            controller = Alive(case, setting).controller(order)
            first = seen(controller, setting)
            for states in setting.states[:1] * 2, setting.states[::-1], setting.states[1:2] * 3:
                for q, v, t in states:
                    controller(q, v, t)
                if what := seen(controller, setting).unlike(first):
                    problems.append(f"{case.spec.kind.__name__}, {order}: {what}")
    assert not problems, "\n".join(dict.fromkeys(problems))


def test_every_answer_is_certified() -> None:
    problems = list[str]()
    for case, setting in every_case():
        for order in case.orders:
            controller = Alive(case, setting).controller(order)
            for q, v, t in setting.states:
                solution = controller(q, v, t).solution
                if solution.ok and not (proof := solution.certify()).ok:
                    problems.append(f"{case.spec.kind.__name__}, {order}: {proof}")
    assert not problems, "\n".join(dict.fromkeys(problems))


def test_the_table_knows_every_part() -> None:
    made = {type(owner) for case, setting in every_case() for owner in Alive(case, setting).found.values()}
    for name in tasks.__all__:
        kind = getattr(tasks, name)
        if getattr(kind, "__module__", "").startswith("tasks.contacts."):
            continue  # what needs others beside it: see test_contacts_live.py
        if isinstance(kind, type) and issubclass(kind, Part | Obstacle | LinkCapsule):
            assert any(issubclass(other, kind) for other in made), name


def test_the_table_knows_every_attribute() -> None:
    known, there = dict[type, set[str]](), dict[type, set[str]]()
    for case, setting in every_case():
        alive = Alive(case, setting)
        for owner in alive.found.values():
            data = {name for name in public(owner) if not of_the_class(owner, name)}
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
                if not name.startswith("_") and (type(owner), name) not in done and of_the_class(owner, name):
                    done.add((type(owner), name))
                    problems += refused(owner, name, 1)
    assert not problems, "\n".join(problems)


def test_a_misspelt_attribute_is_refused_with_the_nearest_name() -> None:
    problems = list[str]()
    for case, setting in every_case():
        alive = Alive(case, setting)
        for path in (*case.live, *case.stays):
            owner, name = alive.owner(path)
            if name in public(owner):
                problems += refused(owner, misspelt(name), 1, tells=f"'{name}'")
    assert not problems, "\n".join(dict.fromkeys(problems))


def test_copies_refuse_too() -> None:
    robots = [arm(), spatial()]
    parts = [owner for case, setting in every_case() for owner in Alive(case, setting).found.values()]
    work = [owner for robot in SETTINGS for owner in (at_work(robot).controller, at_work(robot).stack)]
    problems = list[str]()
    for owner in (*parts, *robots, *work):
        problems += refused(copy.deepcopy(owner), "misspelt", 1)
    assert not problems, "\n".join(dict.fromkeys(problems))


def test_a_keyword_that_is_no_attribute_is_not_taken_for_one() -> None:
    """``task.direction = ...`` is not set beside `target` without a word."""
    problems = list[str]()
    for case, setting in every_case():
        for owner in Alive(case, setting).found.values():
            for name in inspect.signature(type(owner)).parameters:
                if name not in public(owner) and name not in ("args", "kwargs", "options", "limits"):
                    problems += refused(owner, name, 1.0)
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
