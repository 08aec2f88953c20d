"""A stack at work on one robot: the hierarchy, and who writes which of its rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hqp import Hierarchy, Level
from hqp.checks import of_type

from .._checks import Array, per_row
from ..limits.envelope import Envelope
from ..limits.joint_limits import JointLimits
from ..limits.limit import JointLimit
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
        self._robot, self._order, self._dt = robot, order, dt
        for part in stack:
            part.check(robot, order, dt)
        self.hierarchy = Hierarchy([_empty_level(level, robot, order) for level in stack.levels], n=robot.nv)
        self._shared = Workspace(robot, order, dt)
        self._views: list[tuple[Part, Site]] = []
        self._unweighted: list[tuple[Array, Array, NDArray[np.intp]]] = []  # rows that ask for nothing
        self._merged: list[tuple[Array, Array, list[tuple[Array, Array]]]] = []
        for view, parts in zip(self.hierarchy.levels, stack.levels, strict=True):
            row = 0
            for part in parts:
                own = slice(row, row + part.size(robot))
                row = own.stop
                A = None if view.A is None else view.A[own]
                self._views.append((part, Site(self._shared, A, view.lower[own], view.upper[own])))
                without = per_row(part.weight, part.size(robot), f"{part.label()}: weight") == 0.0
                if without.any():
                    self._unweighted.append((view.lower[own], view.upper[own], np.flatnonzero(without)))
                if isinstance(part, JointLimits):
                    alone = [(limit, Site(self._shared, None, *np.zeros((2, robot.nv)))) for limit in part.of(robot)]
                    self._views.extend(alone)
                    bounds = [(site.lower, site.upper) for _, site in alone]
                    self._merged.append((view.lower[own], view.upper[own], bounds))
        self._envelope = Envelope(((part, site.lower, site.upper) for part, site in self._views), robot, order)
        rest = Tick(robot, robot.at(neutral(robot), np.zeros(robot.nv)), 0.0, order, dt, self._envelope)
        with np.errstate(all="ignore"):  # what is infinite is refused in words
            for part in stack:
                part.check_beside(rest)
        if np.isfinite(self._envelope.acceleration).any():
            self._shared.braking[0] = 1.0
        self.plans: list[tuple[Part, Plan]] = [(part, plan_of(part, site)) for part, site in self._views]
        self._moves = [move for _, plan in self.plans for move in plan.moves]
        self._python = [plan.python for _, plan in self.plans if plan.python is not None]
        self._calls = [call.run for _, plan in self.plans for call in plan.calls]
        self.compiled = not self._python
        self._relaxed = any(isinstance(part, JointLimit) for part, _ in self._views)

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
