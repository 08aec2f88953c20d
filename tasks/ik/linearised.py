"""A stack linearised at successive configurations: the hierarchy of one step, and the norms of the errors."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

import hqp
from hqp import InvalidInput, Solution
from hqp.checks import listed
from hqp.errors import brief

from ..base.checks import Array, finite, numbers
from ..base.live import Live, reachable, watch_alone
from ..joints.posture import PostureTask
from ..robots.answers import integration
from ..robots.robot import Robot, base, joint_positions
from ..rows.expansion import Expanded
from ..rows.hierarchy_writer import HierarchyWriter
from ..rows.inequality import Inequality
from ..rows.levels import Levels
from ..rows.part import Part, Stack
from ..rows.row_writer import RowWriter
from ..rows.task import Task
from .newton import Room, levels_of_steps, ranges

#: Parts that have an error.
JUDGED = (Task, Inequality)
#: Half width of the random range of a joint without limits [rad], [m].
HALF_TURN = np.pi


class Visit:
    """A configuration of the search, with its errors.

    Parameters
    ----------
    q : array, shape (nq,)
    found : array
        What :func:`tasks.ik.kernels.steps.judge` has found there; nobody else may write into it.
    small : list of float
        The tolerance of each level.

    Attributes
    ----------
    q : array, shape (nq,)
    squares : array
        Of the errors, task by task and unit by unit.
    reached : bool
        Whether the goal is met within the tolerance.
    error : float
        The norm of all errors of the goal [m, rad].
    levels : array
        The weighted norm of the errors of each level.
    rank : tuple
        Key that sorts configurations, best first: whether the goal is reached, then the norms of the levels rounded to
        whole tolerances, then the remainders.
    """

    __slots__ = ("_rank", "_small", "error", "levels", "q", "reached", "squares")

    def __init__(self, q: Array, found: Array, small: list[float]) -> None:
        self.q, self.reached, self.error = q, bool(found.item(0)), found.item(1)
        self.squares, self.levels = found[2 : -len(small)], found[-len(small) :]
        self._small, self._rank = small, tuple[Any, ...]()

    @property
    def rank(self) -> tuple[Any, ...]:
        if not self._rank:
            levels = self.levels.tolist()
            whole = [norm // small for norm, small in zip(levels, self._small, strict=True)]
            self._rank = (not self.reached, *whole, *levels)
        return self._rank

    def __lt__(self, other: Visit) -> bool:
        return self.rank < other.rank


class Linearised:
    """The hierarchy of one step of a robot.

    Parameters
    ----------
    robot : Robot
    stack : Stack
    goal : tasks of the stack, or None
        What must be met; None for all but postures.
    tolerance : array, shape (2,)
        A length [m] and an angle [rad].
    backend : str

    Attributes
    ----------
    small : array
        For each level, the tolerance [m], [rad] of its most exact task.
    solves : int
        How many hierarchies were solved so far.
    """

    def __init__(
        self, robot: Robot, stack: Stack, goal: Part | Iterable[Part] | None, tolerance: Array, backend: str
    ) -> None:
        self.robot, self.solves = robot, 0
        solved, unknowns, meant = stack.expanded(robot, "displacement")
        self._alone = all(len(parts) == 1 and id(parts[0]) == part for part, parts in meant.items())
        levels = levels_of_steps(stack, solved)
        wanted = _wanted([part for level in levels for part in level if isinstance(part, JUDGED)], goal)
        self.room = Room(*ranges(robot, solved))
        step = Levels(((self.room,), *map(tuple, levels)), (None,) * (1 + len(levels)))
        self._rows = HierarchyWriter(Expanded(step, unknowns, {}), robot, "displacement", live=False)
        self.hierarchy, self._solver = self._rows.hierarchy, hqp.Solver(backend)
        self._parts: list[Live] = []
        self._stale = False
        self._still = numbers(np.zeros(robot.nv), "v")
        self.integrate = integration(robot)
        self._here: Visit | None = None
        self._measure(levels, wanted, tolerance)
        low, high = self.room.low, self.room.high
        self._from = np.maximum(low, np.minimum(high - 2.0 * HALF_TURN, -HALF_TURN))
        self._to = np.minimum(high, np.maximum(low + 2.0 * HALF_TURN, HALF_TURN))

    def stay(self, parts: list[Live]) -> bool:
        """Be ready for stacks of the same form; False if what is planned goes by more than their numbers.

        Parameters
        ----------
        parts : list of Live
            All live objects of the stack, which nobody else has.
        """
        if not (self._alone and self._rows.stands_still):  # a part that stands for others has numbers there
            return False
        self._parts, self._owners = parts, dict[int, list[int]]()
        for k, part in enumerate(self._rows.levels.all_parts):
            for held in reachable(part):
                self._owners.setdefault(id(held), []).append(k)
        watch_alone(self.robot, self)  # type: ignore[arg-type]  # who keeps problems asks for a live robot
        return True

    def admit(self, part: Live, name: str) -> None:
        """The robot has changed; see :class:`tasks.base.live.Watcher`."""
        self._stale = True

    def take(self, given: list[Live]) -> bool:
        """Begin anew with the numbers of other parts of the same form; False if that takes another plan."""
        if self._stale:
            return False
        for own, other in zip(self._parts, given, strict=True):
            before, now = vars(own), vars(other)
            changed = [name for name in own._numbers if name in now and not _same(before[name], now[name])]
            if changed:
                before.update({name: now[name] for name in changed})
                owners = self._owners.get(id(own), ())
                if not owners or "weight" in changed or not self._rows.renumber(own, changed, owners):
                    return False
        self.solves, self._here = 0, None
        self._solver.forget()
        return True

    def _measure(self, levels: list[list[RowWriter]], wanted: list[RowWriter], tolerance: Array) -> None:
        """Which rows make up the error of a task in one unit, that of the goal and of a level, and what is small."""
        from ..base.loops import Call
        from .kernels.steps import judge

        group, level_of, goal = list[int](), list[int](), list[bool]()
        self._names: list[tuple[str, str]] = []
        most, small, self._levels = list[float](), list[float](), list[int]()
        calls = dict[str, int]()
        for k, level in enumerate(levels):
            allowed = []
            for part in level:
                rows = part.size(self.robot)
                level_of += [k] * rows
                goal += [part in wanted] * rows
                if not isinstance(part, JUDGED):
                    group += [-1] * rows
                    continue
                calls[part.name] = calls.get(part.name, 0) + 1
                name = part.name if calls[part.name] == 1 else f"{part.name} {calls[part.name]}"
                units = [label.unit for label in part.labels(self.robot, "displacement")]
                kinds = list(dict.fromkeys(units))
                group += [len(self._names) + kinds.index(unit) for unit in units]
                for unit in kinds:
                    allowed.append(_tolerance(unit, tolerance))
                    most.append(allowed[-1] ** 2 if part in wanted else np.inf)
                    self._names.append((name, unit))
                    self._levels.append(k + 1)  # level 0 of the hierarchy is the room
            small.append(min(allowed, default=1.0))
        nv, h = self.robot.nv, self.hierarchy
        self._below, self._above, squared = h.lower[nv:], h.upper[nv:], h.weights[nv:] ** 2
        self._most, self.small, self._allowed = np.array(most), np.array(small), small
        self._found = np.zeros(2 + len(most) + len(small))
        of, at, of_goal = (np.array(own, dtype=np.int64) for own in (group, level_of, goal))
        numbers = (self._below, self._above, of, at, of_goal, squared, self._most, self._found)
        self._judge = Call(judge, len(of), len(most), len(small), *numbers).run
        self._sums = np.array([squared * (at == k) for k in range(len(small))])

    def inside(self, q: Any) -> Array:
        """A configuration of this robot, its joints moved into their ranges."""
        given = finite(q, "q0")
        if given.shape != (self.robot.nq,):
            raise InvalidInput(f"q0 has shape {given.shape}; the robot takes ({self.robot.nq},), one number a joint")
        joints = joint_positions(self.robot.at(given, self._still))
        step = np.clip(joints, self.room.low, self.room.high) - joints
        return np.asarray(self.integrate(given, step)) if step.any() else given

    def random(self, q: Array, rng: np.random.Generator, count: int) -> list[Array]:
        """`count` random configurations in the joint ranges, with a floating base as in q."""
        steps = rng.uniform(self._from, self._to, (count, self.robot.nv))
        steps -= joint_positions(self.robot.at(q, self._still))
        steps[:, : base(self.robot)] = 0.0
        return [self.integrate(q, step) for step in steps]

    def visit(self, q: Array) -> Visit:
        """Linearise at q and compute the errors; does nothing if the last visit was at q."""
        if self._here is None or self._here.q is not q:
            self._linearise(q)
            self._here = Visit(q, self._found.copy(), self._allowed)
        return self._here

    def nearest(self, candidates: Iterable[Array]) -> Array:
        """The one of several configurations with the least error of the goal."""
        least, best = np.inf, None
        for q in candidates:
            self._linearise(q)
            error = self._found.item(1)
            if best is None or error < least:
                least, best = error, q
        self._here = None
        assert best is not None
        return best

    def _linearise(self, q: Array) -> None:
        self._rows.fill(self.robot.at(q, self._still), 0.0)
        self._judge()

    def solve(self, radius: float, share: float = 1.0) -> Solution:
        """The step from where the last visit was, within the radius and a share of the way to every limit."""
        self.room.open(radius, share)
        self.solves += 1
        return self._solver.solve(self.hierarchy)

    def left(self, step: Array) -> Array:
        """The weighted norm of the errors of each level that the linearised rows leave after a step."""
        moved = self.hierarchy.product(step)[self.robot.nv :]
        missing = np.maximum(self._below - moved, 0.0) + np.minimum(self._above - moved, 0.0)
        return np.asarray(np.sqrt(self._sums @ (missing * missing)))

    def unmet(self, visit: Visit) -> int:
        """The highest level of the hierarchy with a task of the goal that is not met there."""
        return self._levels[int(np.argmax(visit.squares > self._most))]

    def errors(self, visit: Visit) -> dict[str, dict[str, float]]:
        """The norms of the errors there: task -> unit -> norm."""
        errors: dict[str, dict[str, float]] = {}
        for (task, unit), square in zip(self._names, visit.squares.tolist(), strict=True):
            errors.setdefault(task, {})[unit] = square**0.5
        return errors


def _tolerance(unit: str, tolerance: Array) -> float:
    """The tolerance for a row in this unit: that of lengths or of angles, or the smaller one for a sum of both."""
    return float({"m": tolerance[0], "rad": tolerance[1]}.get(unit, tolerance.min()))


def _same(before: object, now: object) -> bool:
    """Whether a number is the same; of targets, whether they are the same object."""
    if before is now:
        return True
    if not (isinstance(before, np.ndarray) and isinstance(now, np.ndarray)):
        return type(before) is type(now) is float and before == now
    return before.shape == now.shape and before.tobytes() == now.tobytes()


def _shown(part: object) -> str:
    return repr(part) if isinstance(part, Part) else brief(part)


def _wanted(own: list[RowWriter], goal: Part | Iterable[Part] | None) -> list[RowWriter]:
    """The tasks that must be met.

    Raises
    ------
    InvalidInput
        If there is none, or one is not in the stack.
    """
    if goal is None:
        wanted = [part for part in own if not isinstance(_task(part), PostureTask)] or own
    else:
        parts = [goal] if isinstance(goal, Part) else listed(goal, "goal", "tasks of the stack")
        wanted = [part for part in own if any(part is one for one in parts)]
        for part in parts:
            if not any(part is one for one in wanted):
                raise InvalidInput(f"goal: {_shown(part)} is no task or inequality of the stack; name some of its own")
    if not wanted:
        raise InvalidInput("goal: there is nothing to be met; the stack needs a task or an inequality")
    return wanted


def _task(part: RowWriter) -> RowWriter:
    return part.task if isinstance(part, Inequality) else part
