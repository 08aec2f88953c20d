"""A stack at work on one robot: the hierarchy, and who writes which of its rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hqp import Hierarchy, Level
from hqp.checks import of_type

from .._checks import Array, per_row
from ..live import Live, reachable, watch, watch_alone
from ..part import Order, Part, Tick
from ..robots.robot import Robot, RobotState, neutral
from .envelope import Envelope
from .own_limits import OwnLimits
from .plan import Plan, plan_of
from .site import Site, Workspace

if TYPE_CHECKING:
    from ..stack import Stack


class Rows:
    """A stack at work on one robot.

    Attributes
    ----------
    hierarchy : hqp.Hierarchy
        Refilled in place: nothing is stacked or copied per tick.
    plans : list of (Part, Plan)
        How every part writes its rows.
    compiled : bool
        Whether loops write all of them.
    envelope : Envelope
        The joint limits of the stack.
    """

    def __init__(self, stack: Stack, robot: Robot, order: Order, dt: float | None) -> None:
        self._stack, self._robot, self._order, self._dt = stack, robot, order, dt
        self._check()
        self.hierarchy = Hierarchy([_empty_level(level, robot, order) for level in stack.levels], n=robot.nv)
        self._own_limits = None if isinstance(robot, Live) else OwnLimits(robot)
        self._take_up()
        for part in stack:
            watch(part, self)
        if isinstance(robot, Live):
            watch_alone(robot, self)

    def admit(self, part: Live, name: str) -> None:
        """Take up what was changed in a part or the robot, or refuse it; see :class:`tasks.live.Watcher`."""
        for own in self._stack:
            if id(part) == id(self._robot) or any(one is part for one in reachable(own)):
                own.check(self._robot, self._order, self._dt)
                watch(own, self)
        self._take_up()

    def _check(self) -> None:
        for part in self._stack:
            part.check(self._robot, self._order, self._dt)

    def _take_up(self) -> None:
        """Plan how all parts write their rows, with the numbers that they have now."""
        robot, order, dt = self._robot, self._order, self._dt
        shared = Workspace(robot, order, dt)
        views: list[tuple[Part, Site]] = []
        unweighted: list[tuple[Array, Array, NDArray[np.intp]]] = []  # rows that ask for nothing
        for view, parts in zip(self.hierarchy.levels, self._stack.levels, strict=True):
            row = 0
            for part in parts:
                own = slice(row, row + part.size(robot))
                row = own.stop
                site = Site(shared, None if view.A is None else view.A[own], view.lower[own], view.upper[own])
                views.append((part, site))
                part.claim(site)
                view.weights[own] = weights = _weights(part, robot)
                without = weights == 0.0
                if without.any():
                    view.weights[own][without] = 1.0
                    unweighted.append((site.lower, site.upper, np.flatnonzero(without)))
        shared.envelope.close(shared)
        rest = Tick(robot, robot.at(neutral(robot), np.zeros(robot.nv)), 0.0, order, dt, shared.envelope)
        with np.errstate(all="ignore"):  # what is infinite is refused in words
            for part in self._stack:
                part.check_beside(rest)
        self.plans: list[tuple[Part, Plan]] = [(part, plan_of(part, site)) for part, site in views]
        self._shared, self._views, self._unweighted = shared, views, unweighted
        self._moves = [move for _, plan in self.plans for move in plan.moves]
        self._python = [plan.python for _, plan in self.plans if plan.python is not None]
        self._calls = [call.run for _, plan in self.plans for call in plan.calls]
        self.compiled = not self._python

    @property
    def envelope(self) -> Envelope:
        return self._shared.envelope

    def bounds(self, part: Part) -> tuple[Array, Array] | None:
        """Lower and upper bounds that a part writes (views), or None if it is not in the stack."""
        return next(((site.lower, site.upper) for own, site in self._views if own is part), None)

    def fill(self, state: RobotState, t: float) -> Hierarchy:
        """Let every part write its rows for this state and time t [s]; the hierarchy, for convenience."""
        if self._own_limits is not None and self._own_limits.changed():
            self._check()
            self._take_up()
            self._own_limits.note()
        for move in self._moves:
            move(t)
        self._shared.update(state)
        if self._python:
            tick = Tick(self._robot, state, t, self._order, self._dt, self._shared.envelope)
            for write in self._python:
                write(tick)
        for run in self._calls:
            run()
        for lower, upper, rows in self._unweighted:
            lower[rows], upper[rows] = -np.inf, np.inf
        return self.hierarchy


def _empty_level(parts: tuple[Part, ...], robot: Robot, order: Order) -> Level:
    """One level without numbers yet: plain bounds if all its parts are plain, rows otherwise."""
    name = " + ".join(of_type(part.name, str, f"name of a {type(part).__name__}") for part in parts)
    weights = np.ones(sum(part.size(robot) for part in parts))
    labels = [label for part in parts for label in part.labels(robot, order)]
    zeros = np.zeros(len(weights))
    if all(part.plain for part in parts):
        indices = np.concatenate([p.variables(robot) for p in parts])
        return Level.bounds(zeros, zeros, indices=indices, weights=weights, name=name, labels=labels)
    identity = np.eye(robot.nv)
    A = [identity[p.variables(robot)] if p.plain else np.zeros((p.size(robot), robot.nv)) for p in parts]
    return Level(np.concatenate(A), zeros, zeros, weights=weights, name=name, labels=labels)


def _weights(part: Part, robot: Robot) -> Array:
    return per_row(part.weight, part.size(robot), f"{part.label()}: weight")
