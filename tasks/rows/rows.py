"""A stack at work on one robot: the hierarchy, and who writes which of its rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hqp import Hierarchy, InvalidInput, Label, Level
from hqp.checks import of_type

from .._checks import Array, per_row
from ..limits.envelope import Envelope
from ..limits.joint_limits import JointLimits
from ..limits.limit import JointLimit
from ..live import Live, reachable, watch
from ..part import Order, Part, Tick
from ..robots.robot import Robot, RobotState, neutral
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
    """

    def __init__(self, stack: Stack, robot: Robot, order: Order, dt: float | None) -> None:
        self._stack, self._robot, self._order, self._dt = stack, robot, order, dt
        for part in stack:
            part.check(robot, order, dt)
        self.hierarchy = Hierarchy([_empty_level(level, robot, order) for level in stack.levels], n=robot.nv)
        self._labels = self._named()
        self._take_up()
        for part in (robot, *stack):
            watch(part, self)

    def admit(self, part: Live, name: str) -> None:
        """Take up what was changed in a part, or refuse it; see :class:`tasks.live.Watcher`."""
        for own in self._stack:
            if part is self._robot or any(one is part for one in reachable(own)):
                own.check(self._robot, self._order, self._dt)
                watch(own, self)
                if self._named() != self._labels:
                    raise InvalidInput(f"{own.label()}: with another {name} it has other rows; {own._instead}")
        self._take_up()

    def _named(self) -> list[Label]:
        """What all rows are, which stays."""
        return [label for part in self._stack for label in part.labels(self._robot, self._order)]

    def _take_up(self) -> None:
        """Plan how all parts write their rows, with the numbers that they have now."""
        robot, order, dt = self._robot, self._order, self._dt
        shared = Workspace(robot, order, dt)
        views: list[tuple[Part, Site]] = []
        unweighted: list[tuple[Array, Array, NDArray[np.intp]]] = []  # rows that ask for nothing
        merged: list[tuple[Array, Array, list[tuple[Array, Array]]]] = []
        for view, parts in zip(self.hierarchy.levels, self._stack.levels, strict=True):
            row = 0
            for part in parts:
                own = slice(row, row + part.size(robot))
                row = own.stop
                site = Site(shared, None if view.A is None else view.A[own], view.lower[own], view.upper[own])
                views.append((part, site))
                view.weights[own] = weights = _weights(part, robot)
                without = weights == 0.0
                if without.any():
                    view.weights[own][without] = 1.0
                    unweighted.append((site.lower, site.upper, np.flatnonzero(without)))
                if isinstance(part, JointLimits):
                    alone = [(limit, Site(shared, None, *np.zeros((2, robot.nv)))) for limit in part.of(robot)]
                    views.extend(alone)
                    merged.append((site.lower, site.upper, [(site.lower, site.upper) for _, site in alone]))
        envelope = Envelope(((part, site.lower, site.upper) for part, site in views), robot, order)
        rest = Tick(robot, robot.at(neutral(robot), np.zeros(robot.nv)), 0.0, order, dt, envelope)
        with np.errstate(all="ignore"):  # what is infinite is refused in words
            for part in self._stack:
                part.check_beside(rest)
        if np.isfinite(envelope.acceleration).any():
            shared.braking[0] = 1.0
        shared.envelope = envelope
        self.plans: list[tuple[Part, Plan]] = [(part, plan_of(part, site)) for part, site in views]
        self._shared, self._views, self._envelope = shared, views, envelope
        self._unweighted, self._merged = unweighted, merged
        self._moves = [move for _, plan in self.plans for move in plan.moves]
        self._python = [plan.python for _, plan in self.plans if plan.python is not None]
        self._calls = [call.run for _, plan in self.plans for call in plan.calls]
        self.compiled = not self._python
        self._relaxed = any(isinstance(part, JointLimit) for part, _ in views)

    def bounds(self, part: Part) -> tuple[Array, Array] | None:
        """Lower and upper bounds that a part writes (views), or None if it is not in the stack."""
        return next(((site.lower, site.upper) for own, site in self._views if own is part), None)

    def fill(self, state: RobotState, t: float) -> Hierarchy:
        """Let every part write its rows for this state and time t [s]; the hierarchy, for convenience."""
        for move in self._moves:
            move(t)
        self._shared.update(state)
        if self._python or self._shared.braking[0] < np.inf:
            tick = Tick(self._robot, state, t, self._order, self._dt, self._envelope)
            self._shared.braking[0] = self._envelope.braking_rate(tick)
            for write in self._python:
                write(tick)
        for run in self._calls:
            run()
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
