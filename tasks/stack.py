"""Tasks and limits in order of priority, and the hierarchy that they write."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, get_args

import numpy as np
from numpy.typing import NDArray

from hqp import DampingRule, Hierarchy, InvalidInput, Level
from hqp.checks import of_type, one_of, truth
from hqp.errors import brief

from ._checks import Array, per_row, positive_scalar
from .limits.envelope import Envelope
from .limits.joint_limits import JointLimits
from .limits.limit import JointLimit
from .part import Order, Part, Tick
from .robots.robot import Robot, RobotState, as_robot, neutral, on_pinocchio

if TYPE_CHECKING:
    from .compiled import CompiledRows

#: One level, and how it is damped.
Ruled = tuple[tuple[Part, ...], DampingRule | None]

ALLOWED = "a stack takes tasks, limits and stacks: a >> b puts b below a, a + b puts both on one level"


class Stack:
    """Levels of tasks and limits, the highest first.

    ``limits >> position + orientation >> posture`` declares three levels; ``+`` binds tighter than
    ``>>``. ``Stack(a, b, c)`` is ``a >> b >> c``. A stack is a declaration: it holds no numbers of
    any robot or tick and may serve several controllers.

    Parameters
    ----------
    *parts : task, limit or Stack
        The highest priority first.

    Attributes
    ----------
    levels : tuple of tuples of Part

    Raises
    ------
    InvalidInput
        If there is nothing in it, something is neither a task nor a limit, or one of them comes twice.
    """

    levels: tuple[tuple[Part, ...], ...]
    damping: tuple[DampingRule | None, ...]

    def __init__(self, *parts: Part | Stack) -> None:
        if not parts:
            raise InvalidInput(f"an empty stack asks for nothing; {ALLOWED}")
        self.levels = tuple(level for part in parts for level in _levels_of(part))
        self.damping = tuple(rule for part in parts for rule in (part.damping if isinstance(part, Stack) else (None,)))
        seen: set[int] = set()
        for part in self:
            if id(part) in seen:
                raise InvalidInput(f"{part.label()} is in the stack twice; make a second one if both are meant")
            seen.add(id(part))

    def __rshift__(self, lower: Part | Stack) -> Stack:
        return Stack(self, lower)

    def __add__(self, other: Part | Stack) -> Stack:
        mine, theirs = self.levels, _levels_of(other)
        if len(mine) != 1 or len(theirs) != 1:
            raise InvalidInput(
                f"+ joins parts of one level, but got {self!r} + {other!r};"
                " say which level is meant with brackets: a >> (b + c)"
            )
        if any(self.damping) or (isinstance(other, Stack) and any(other.damping)):
            raise InvalidInput(
                f"a level is damped as a whole, but got {self!r} + {other!r}; put the brackets around all of it:"
                " Damped(a + b, rule)"
            )
        return _of_levels([(mine[0] + theirs[0], None)])

    def swapped(self, first: Part, second: Part) -> Stack:
        """The same parts, these two in each other's place, with the damping of a level that each has for itself.

        Raises
        ------
        InvalidInput
            If one of them is not in the stack.
        """
        levels, here, there = list(self._ruled()), self._level(first), self._level(second)
        if len(self.levels[here]) == len(self.levels[there]) == 1:
            levels[here], levels[there] = levels[there], levels[here]
            return _of_levels(levels)
        other = {id(first): second, id(second): first}
        return _of_levels((tuple(other.get(id(part), part) for part in level), rule) for level, rule in levels)

    def without(self, *parts: Part) -> Stack:
        """The stack without these parts, and without the levels that they leave empty.

        Raises
        ------
        InvalidInput
            If one of them is not in the stack, or nothing is left.
        """
        gone = {id(part) for part in parts if self._level(part) >= 0}
        return _of_levels(
            (tuple(part for part in level if id(part) not in gone), rule) for level, rule in self._ruled()
        )

    def inserted(self, part: Part | Stack, *, below: Part | None = None) -> Stack:
        """The stack with a new level, or levels, right below that of another part; without it, at the top.

        Raises
        ------
        InvalidInput
            If `below` is not in the stack, or `part` is in it already.
        """
        place, levels = 0 if below is None else self._level(below) + 1, list(self._ruled())
        new = part._ruled() if isinstance(part, Stack) else [(level, None) for level in _levels_of(part)]
        return _of_levels([*levels[:place], *new, *levels[place:]])

    def _level(self, part: Part) -> int:
        """Where a part stands."""
        for k, level in enumerate(self.levels):
            if any(own is part for own in level):
                return k
        shown = repr(part) if isinstance(part, Part) else brief(part)
        raise InvalidInput(f"{shown} is not in the stack {self!r}")

    def _ruled(self) -> Iterable[Ruled]:
        """Every level with its damping."""
        return zip(self.levels, self.damping, strict=True)

    def __iter__(self) -> Iterator[Part]:
        """All parts, from the highest level down."""
        return (part for level in self.levels for part in level)

    def __contains__(self, part: object) -> bool:
        """Whether this very part is in it."""
        return any(own is part for own in self)

    def __len__(self) -> int:
        """Number of levels."""
        return len(self.levels)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Stack) and (self.levels, self.damping) == (other.levels, other.damping)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return " >> ".join(map(_shown, self.levels, self.damping))

    def build(self, robot: Robot, order: Order, dt: float | None = None, *, compiled: bool = True) -> Rows:
        """The hierarchy of this stack for one robot, ready to be filled.

        Parameters
        ----------
        robot : Robot
        order : {"velocity", "acceleration"}
            Whether x is the joint velocities [rad/s] or accelerations [rad/s^2].
        dt : float, optional
            Tick [s]; needed by limits of the other order.
        compiled : bool
            Whether rows may be written by :mod:`tasks.compiled` where it knows how: the same rows, sooner.

        Returns
        -------
        Rows
            Its ``.hierarchy`` holds the numbers, its ``.fill(state, t)`` writes them.

        Raises
        ------
        InvalidInput
            If a part does not fit the robot, or the rest of the stack; names the part. If the robot is none, the order
            none of the two, or dt not positive.
        """
        robot = as_robot(robot)
        one_of(order, get_args(Order), "order")
        tick = None if dt is None else positive_scalar(dt, "dt", unit="s")
        return Rows(self, robot, order, tick, truth(compiled, "compiled"))


class Rows:
    """A stack at work on one robot: a hierarchy, and which part writes where.

    Attributes
    ----------
    hierarchy : hqp.Hierarchy
        Refilled in place: nothing is stacked or copied per tick.
    compiled : bool
        Whether all parts are written by :mod:`tasks.compiled`.
    """

    def __init__(self, stack: Stack, robot: Robot, order: Order, dt: float | None, compiled: bool) -> None:
        self._robot, self._order, self._dt = robot, order, dt
        for part in stack:
            part.check(robot, order, dt)
        self.hierarchy = Hierarchy([_empty_level(level, robot, order) for level in stack.levels], n=robot.nv)
        self._views: list[tuple[Part, Array | None, Array, Array]] = []
        self._unweighted: list[tuple[Array, Array, NDArray[np.intp]]] = []  # rows that ask for nothing
        self._merged: list[tuple[Array, Array, list[tuple[Array, Array]]]] = []
        for view, parts in zip(self.hierarchy.levels, stack.levels, strict=True):
            row = 0
            for part in parts:
                own = slice(row, row + part.size(robot))
                row = own.stop
                self._views.append((part, None if view.A is None else view.A[own], view.lower[own], view.upper[own]))
                without = per_row(part.weight, part.size(robot), f"{part.label()}: weight") == 0.0
                if without.any():
                    self._unweighted.append((view.lower[own], view.upper[own], np.flatnonzero(without)))
                if isinstance(part, JointLimits):
                    alone = [(limit, None, *np.zeros((2, robot.nv))) for limit in part.of(robot)]
                    self._views.extend(alone)
                    self._merged.append((view.lower[own], view.upper[own], [bounds[2:] for bounds in alone]))
        self._envelope = Envelope(((part, lower, upper) for part, _, lower, upper in self._views), robot, order)
        rest = Tick(robot, robot.at(neutral(robot), np.zeros(robot.nv)), 0.0, order, dt, self._envelope)
        with np.errstate(all="ignore"):  # what is infinite is refused in words
            for part in stack:
                part.check_beside(rest)
        self._compiled: CompiledRows | None = None
        self._written = self._views  # by the parts themselves
        if compiled and order == "velocity" and on_pinocchio(robot):
            from .compiled import CompiledRows

            self._compiled = CompiledRows(self._views, robot, dt, self._envelope)
            self._written = [view for view in self._views if id(view[0]) not in self._compiled.parts]
        self.compiled = not self._written
        self._relaxed = any(isinstance(view[0], JointLimit) for view in self._written)

    def bounds(self, part: Part) -> tuple[Array, Array] | None:
        """Lower and upper bounds that a part writes (views), or None if it is not in the stack."""
        return next(((lower, upper) for own, _, lower, upper in self._views if own is part), None)

    def fill(self, state: RobotState, t: float) -> Hierarchy:
        """Let every part write its rows for this state and time t [s]; the hierarchy, for convenience."""
        if self._compiled is not None:
            self._compiled.write(state, t)
        if self._written:
            tick = Tick(self._robot, state, t, self._order, self._dt, self._envelope)
            for part, A, lower, upper in self._written:
                part.write(tick, A, lower, upper)
            if self._relaxed:
                self._envelope.reconcile(tick)
                self._merge()
        for lower, upper, rows in self._unweighted:
            lower[rows], upper[rows] = -np.inf, np.inf
        return self.hierarchy

    def _merge(self) -> None:
        """All limits of the joints in one row a joint."""
        for lower, upper, limits in self._merged:
            lower[:], upper[:] = limits[0]
            for low, high in limits[1:]:
                np.maximum(lower, low, out=lower)
                np.minimum(upper, high, out=upper)


def _empty_level(parts: tuple[Part, ...], robot: Robot, order: Order) -> Level:
    """One level without numbers yet: plain bounds if all its parts are plain, rows otherwise."""
    name = " + ".join(of_type(part.name, str, f"name of a {type(part).__name__}") for part in parts)
    weights = np.concatenate([per_row(p.weight, p.size(robot), f"{p.label()}: weight") for p in parts])
    weights[weights == 0.0] = 1.0  # of rows that are free
    labels = [label for part in parts for label in part.labels(robot, order)]
    zeros = np.zeros(len(weights))
    if all(part.plain for part in parts):
        indices = np.concatenate([p.variables(robot) for p in parts])
        return Level.bounds(zeros, zeros, indices=indices, weights=weights, name=name, labels=labels)
    identity = np.eye(robot.nv)
    A = [identity[p.variables(robot)] if p.plain else np.zeros((p.size(robot), robot.nv)) for p in parts]
    return Level(np.concatenate(A), zeros, zeros, weights=weights, name=name, labels=labels)


def _of_levels(levels: Iterable[Ruled]) -> Stack:
    """A stack of these levels, the empty ones left out."""
    kept = [(level, rule) for level, rule in levels if level]
    stack = object.__new__(Stack)
    stack.levels, stack.damping = tuple(level for level, _ in kept), tuple(rule for _, rule in kept)
    return Stack(stack) if kept else Stack()


def _shown(level: tuple[Part, ...], rule: DampingRule | None) -> str:
    parts = " + ".join(map(repr, level))
    return parts if rule is None else f"Damped({parts}, {rule!r})"


def _levels_of(part: Part | Stack) -> tuple[tuple[Part, ...], ...]:
    if isinstance(part, Stack):
        return part.levels
    if isinstance(part, Part):
        return ((part,),)
    raise InvalidInput(f"{brief(part)} is a {type(part).__name__}; {ALLOWED}")
