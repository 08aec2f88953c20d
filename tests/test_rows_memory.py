"""Loops know arrays by their addresses: whatever is dropped, copied or changed, they write only into what is alive."""

from __future__ import annotations

import copy
import gc
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import chain
from typing import Any

import numpy as np
import pytest
from live_table import GROUPS, SETTINGS, Case, Made, Setting
from live_work import Alive, as_it_is, seen

from hqp import InvalidInput
from tasks import Controller, JointVelocityLimit, PostureTask
from tasks.base.loops import Call

#: A number that no row has.
POISON = 1.2345678e77
#: Numbers of an array: of a bound, of tables, of blocks, of rows, of work space.
SIZES = (*range(1, 16), 24, 32, 50, 53, 60, 64, 68, 74, 96, 128, 250, 500)


def cases(setting: Setting) -> Iterator[Case]:
    return chain.from_iterable(group(setting) for group in GROUPS.values())


def poisoned() -> list[np.ndarray]:
    """All that was freed, as far as NumPy hands it out again."""
    gc.collect()
    return [np.full(size, POISON) for size in SIZES for _ in range(6)]


def untouched(arrays: list[np.ndarray]) -> bool:
    return all((array == POISON).all() for array in arrays)


@pytest.fixture(autouse=True, scope="module")
def quick() -> Iterator[None]:
    """What there is before these tests is no rubbish, and need not be looked through again and again."""
    settle()
    yield
    gc.unfreeze()
    settle()


def settle() -> None:
    """What there is now is looked through once more, and then no more."""
    gc.collect()
    gc.freeze()


@pytest.mark.parametrize("robot", SETTINGS)
def test_controllers_come_and_go_beside_others_at_work(robot: str) -> None:
    """Each is made, copied, changed and dropped; one of them, and one copy, go on and say what they said."""
    setting, problems = SETTINGS[robot](), list[str]()
    for case in cases(setting):
        settle()
        order, name = case.orders[-1], case.spec.kind.__name__
        alive = Alive(case, setting)
        controller, dropped = alive.controller(order), alive.controller(order)
        first, copied = seen(controller, setting), copy.deepcopy(controller)
        seen(dropped, setting)
        del dropped

        def wrong(what: str, controller: Controller = controller, name: str = name) -> None:
            poison = poisoned()
            seen(controller, setting)
            if not untouched(poison):
                problems.append(f"{name}: {what} writes into what was freed")

        wrong("what is left")
        for stack in JointVelocityLimit(1.0) >> PostureTask(setting.q, gain=1.0), alive.stack:
            controller.change(stack, duration=0.0)
            wrong("a change of stacks")
        for path, change in case.live.items():
            old = alive.get(path)
            with suppress(InvalidInput):
                alive.set(path, change.value if isinstance(change, Made) else change)
                wrong(f"a change of {path}")
            alive.set(path, old)
        poison = poisoned()
        if seen(controller, setting).unlike(first) or seen(copied, setting).unlike(first) or not untouched(poison):
            problems.append(f"{name}: what is left does not say what it said")
    assert not problems, "\n".join(problems)


@pytest.mark.parametrize("robot", SETTINGS)
def test_whoever_has_a_loop_has_all_that_it_is_told_of(robot: str) -> None:
    setting = SETTINGS[robot]()
    for case in cases(setting):
        for order in case.orders:
            run = _loops(case, setting, order)
            poison = poisoned()
            for _ in range(2):
                with np.errstate(all="ignore"):
                    for call in run:
                        call()
            assert untouched(poison), f"{case.spec.kind.__name__}, {order}"


def _loops(case: Case, setting: Setting, order: Any) -> list[Callable[[], object]]:
    """Those of the rows of a part, of which all else is dropped."""
    stack = JointVelocityLimit(2.0) >> case.spec.make({}, as_it_is, {})
    rows = stack.build(setting.robot, order, 0.01)
    q, v, t = setting.states[0]
    rows.fill(setting.robot.at(q, v), t)
    return [call.run for _, plan in rows.plans for call in plan.calls]


def test_what_a_loop_is_told_of_is_an_array_in_one_piece() -> None:
    """It reads them number by number; a view with gaps would have it read, or write, between them."""
    told, setting = list[Call](), SETTINGS["panda"]()
    for case in cases(setting):
        stack = JointVelocityLimit(2.0) >> case.spec.make({}, as_it_is, {})
        rows = stack.build(setting.robot, case.orders[-1], 0.01)
        told += [call for _, plan in rows.plans for call in plan.calls]
    arrays = [entry for call in told for entry in call.table.told if isinstance(entry, np.ndarray)]
    assert len(arrays) > 100
    for array in arrays:
        assert array.flags.c_contiguous or array.flags.f_contiguous
        assert array.dtype in (np.float64, np.int64)
        assert array.flags.aligned
