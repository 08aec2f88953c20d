"""Problems of inverse kinematics that are kept between calls: to plan one takes about as long as to solve it.

A robot keeps, for each thread, the problems of the last stacks that were solved on it. A call with a stack of the same
form takes the kept problem, writes its own targets and gains into it and starts cold: the answer is that of a new
problem, to the last bit. Stacks are of the same form if they differ by numbers alone, with constant targets; what else
differs is a problem of its own. Parts of a user's own classes, and targets that move, are planned anew in every call.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from hqp.checks import listed

from ..base.checks import Array
from ..base.live import Live, beside
from ..base.once import once
from ..robots.robot import Robot
from ..rows.part import Part, Stack, of_levels
from ..targets.turns import constant
from .linearised import Linearised

#: So many problems a robot and thread are kept, the last used last.
KEPT = 8
#: Types of values that nobody can change in place.
FIXED = frozenset({str, int, float, bool, type(None)})
#: What tells a problem from others on the same robot.
Key = tuple[Any, ...]


def borrow(
    robot: Robot, stack: Stack, goal: Part | Iterable[Part] | None, tolerance: Array, backend: str
) -> tuple[Key | None, Linearised]:
    """The problem of a stack, and its key if it may be kept.

    Parameters
    ----------
    robot, stack, goal, tolerance, backend
        See :class:`Linearised`.

    Raises
    ------
    InvalidInput
        As :class:`Linearised` does.
    """
    wanted = [goal] if isinstance(goal, Part) else goal if goal is None else listed(goal, "goal", "tasks of the stack")
    parts: dict[int, Live] = {}
    form = _form(stack.levels, parts)
    if form is None or not isinstance(robot, Live) or not of_library(type(robot)) or not isinstance(backend, str):
        return None, Linearised(robot, stack, wanted, tolerance, backend)
    number = {own: k for k, own in enumerate(parts)}
    key = form, backend, *tolerance.tolist(), *([] if wanted is None else [number.get(id(part)) for part in wanted])
    found = _kept(robot).pop(key, None)
    if found is not None and found.take(list(parts.values())):
        return key, found
    copies: dict[int, Live] = {}
    levels = _copied(stack.levels, copies)
    own: list[Any] | None = None if wanted is None else [copies.get(id(part), part) for part in wanted]
    problem = Linearised(robot, of_levels([(level, None) for level in levels]), own, tolerance, backend)
    return (key if problem.stay(list(copies.values())) else None), problem


def give_back(key: Key | None, problem: Linearised) -> None:
    """Keep the problem for the next call of this thread with such a stack."""
    if key is None or not isinstance(problem.robot, Live):
        return
    kept = _kept(problem.robot)
    kept[key] = problem
    if len(kept) > KEPT:
        del kept[next(iter(kept))]


def _kept(robot: Live) -> dict[Key, Linearised]:
    """The problems that a robot keeps for this thread; they go with the robot."""
    own = beside(robot)
    try:
        found: dict[Key, Linearised] = own.problems
    except AttributeError:
        found = own.problems = {}
    return found


class _OpenError(Exception):
    """Something that a problem cannot be kept for."""


def _form(value: Any, parts: dict[int, Live]) -> Key | None:
    """What parts are, beside their numbers, and where the same one comes again; None if that may change in place.

    Parameters
    ----------
    value : tuple of tuples of Part
    parts : dict of int to Live
        Gets all live objects on the way, by their ids.
    """
    try:
        return tuple(_told(level, parts) for level in value)
    except _OpenError:
        return None


def _told(value: Any, parts: dict[int, Live]) -> Any:
    kind = type(value)
    if kind in FIXED:
        return value
    if kind is tuple:
        return tuple([_told(each, parts) for each in value])
    if kind is np.ndarray:
        return value.shape, value.dtype, value.tobytes()
    if not (isinstance(value, Live) and of_library(kind)):
        raise _OpenError
    if id(value) in parts:
        return "again", list(parts).index(id(value))
    parts[id(value)] = value
    numbers, told = kind._numbers, list[Any]([kind])
    for name, own in vars(value).items():
        told.append(name)
        if name not in numbers:
            told.append(_told(own, parts))
        elif type(own) not in FIXED and type(own) is not np.ndarray:
            told.append(_constant(own))
    return tuple(told)


def _constant(target: object) -> tuple[object, ...]:
    """The form of a constant target of this library."""
    form = constant(target)
    if form is None or not all(of_library(kind) for kind in form if isinstance(kind, type)):
        raise _OpenError
    return form


@once
def of_library(kind: type) -> bool:
    """Whether a class is of this library, and does what is known of it."""
    return kind.__module__.partition(".")[0] == __name__.partition(".")[0]


def _copied(value: Any, copies: dict[int, Live]) -> Any:
    """The same parts, as copies that nobody else has.

    Parameters
    ----------
    value : tuple of tuples of Part
    copies : dict of int to Live
        Gets them by the ids of their originals, in the order of :func:`_form`.
    """
    if type(value) is tuple:
        return tuple([_copied(each, copies) for each in value])
    if not isinstance(value, Live):
        return value
    if id(value) not in copies:
        copies[id(value)] = own = object.__new__(type(value))
        same = type(value)._numbers  # arrays and constant targets, which nobody changes in place
        vars(own).update({name: it if name in same else _copied(it, copies) for name, it in vars(value).items()})
    return copies[id(value)]
