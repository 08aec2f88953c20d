"""Evaluates one part by itself, outside a controller: what it measures, or its rows, at one state."""

from __future__ import annotations

import threading
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..base.checks import Array
from ..robots.robot import Robot, RobotState
from ..robots.robot import robot_of as owner
from .site import Site, Workspace
from .tick import Tick

if TYPE_CHECKING:
    from .part import Part
    from .task import Task


class Measured(NamedTuple):
    """What a task measures at one state.

    Attributes
    ----------
    error, rate, change, drift : array, shape (rows,)
        Its error, the velocity and acceleration of its target as the rows have them, and ``Jdot v``.
    jacobian : array, shape (rows, nv)
    """

    error: Array
    rate: Array
    change: Array
    drift: Array
    jacobian: Array


def measured_alone(task: Task, state: RobotState, t: float = 0.0, *, drifts: bool = False) -> Measured:
    """What a task measures at this state and time t [s], by its own loops.

    Parameters
    ----------
    task : Task
    state : RobotState
    t : float
    drifts : bool
        Whether `change` and `drift` are asked for too.
    """
    return _at_work(task, robot_of(state), drifts).at(state, t)


class _Alone:
    """The loops of one task, with a workspace of their own."""

    def __init__(self, task: Task, robot: Robot, drifts: bool) -> None:
        rows = task.size(robot)
        self._shared = Workspace(robot, "acceleration" if drifts else "velocity", None)
        self._site = Site(self._shared, np.zeros((rows, robot.nv)), *np.zeros((2, rows)))
        self._site.shortens = False
        self._plan = task.plan(self._site)  # of its own loops, also where a subclass says something else
        self._robot, self._numbers = robot, _numbers(task)

    def suits(self, task: Task, robot: Robot) -> bool:
        """Whether these loops are made for this robot and for the present settings of the task."""
        now = _numbers(task)
        return (
            self._robot is robot
            and now.keys() == self._numbers.keys()
            and all(now[name] is value for name, value in self._numbers.items())
        )

    def at(self, state: RobotState, t: float) -> Measured:
        for move in self._plan.moves:
            move(t)
        self._shared.update(state)
        if self._plan.python is not None:
            self._plan.python(Tick(self._robot, state, t, self._shared.order, None))
        for call in self._plan.calls:
            call.run()
        assert self._site.A is not None
        error, rate, change, drift, _ = self._site.measured.copy()
        return Measured(error, rate, change, drift, self._site.A.copy())


def _numbers(task: Task) -> dict[str, object]:
    """The attributes of a task: declared ones are never changed in place, only replaced."""
    return {name: value for name, value in vars(task).items() if name[0] != "_"}


class _Kept(threading.local):
    """The evaluators of this thread."""

    def __init__(self) -> None:
        self.of: WeakKeyDictionary[Task, dict[bool, _Alone]] = WeakKeyDictionary()


_kept = _Kept()


def _at_work(task: Task, robot: Robot, drifts: bool) -> _Alone:
    own = _kept.of.setdefault(task, {})
    found = own.get(drifts)
    if found is None or not found.suits(task, robot):
        found = own[drifts] = _Alone(task, robot, drifts)
    return found


class Unknown:
    """A placeholder for the robot of a state that does not name it: only its sizes."""

    def __init__(self, nq: int, nv: int) -> None:
        self.nq, self.nv = nq, nv
        self.position_limit = self.velocity_limit = self.acceleration_limit = None

    def at(self, q: Array, v: Array) -> RobotState:
        raise NotImplementedError


def robot_of(state: RobotState) -> Robot:
    """The robot of a state."""
    robot = owner(state)
    return _unknown(len(state.q), len(state.v)) if robot is None else robot


_unknown = lru_cache(maxsize=16)(Unknown)


def write_alone(part: Part, tick: Tick, A: Array, lower: Array, upper: Array) -> None:
    """Write the rows of a part for one tick by its own loops, in a workspace of its own.

    Parameters
    ----------
    part : Part
    tick : Tick
    A : array, shape (rows, nv)
    lower, upper : array, shape (rows,)
    """
    from ..base.loops import run_all

    shared = Workspace(tick.robot, tick.order, tick.dt)
    if tick.envelope is not None:
        shared.envelope, shared.braking[0] = tick.envelope, tick.envelope.braking_rate()
    plan = part.plan(Site(shared, A, lower, upper))
    for move in plan.moves:
        move(tick.t)
    shared.update(tick.state)
    if plan.python is not None:
        plan.python(tick)
    run_all(plan.calls)
