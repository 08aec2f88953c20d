"""The hierarchy of a stack on one robot, and the loops or functions that write its rows every tick."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hqp import Hierarchy, InvalidInput, Label, Level
from hqp.checks import of_type

from ..base.checks import Array
from ..base.live import Live, reachable, watch_alone
from ..robots.answers import at_rest
from ..robots.robot import Robot, RobotState
from .description import Description, WrittenPart
from .envelope import Envelope
from .expansion import Expanded
from .own_limits import OwnLimits
from .plan import Plan, plan_of
from .row_writer import RowWriter
from .site import Memory, Site, Workspace
from .tick import Order, Tick
from .unknowns import Unknowns

if TYPE_CHECKING:
    from ..base.loops import Call


class HierarchyWriter:
    """Writes the hierarchy of a stack on one robot, every tick.

    Attributes
    ----------
    levels : Levels
        All that is solved.
    unknowns : Unknowns
        What x is made of.
    hierarchy : hqp.Hierarchy
        Refilled in place: nothing is stacked or copied per tick.
    plans : list of (Part, Plan)
        How every part writes its rows, from the highest level down.
    compiled : bool
        Whether loops write all of them.
    envelope : Envelope
        The joint limits of the stack.
    planned : int
        How often rows have been planned: whoever knows plans by their addresses looks at them again.
    aims : dict of int to array, shape (nv,), or None
        What each damped level is damped towards at this tick, ``-2 zeta K v`` by the fastest of its tasks; None at
        other orders than that of accelerations, where it is zero, and where no level is damped.
    every_aim : array, shape (levels, nv)
        The same of all levels, zero where there is none.
    """

    planned = 0

    def __init__(
        self,
        expanded: Expanded,
        robot: Robot,
        order: Order,
        dt: float | None = None,
        memory: Memory | None = None,
    ) -> None:
        self._robot, self._order, self._dt = robot, order, dt
        levels, unknowns, self._meant = expanded
        self.levels, self.unknowns = levels, unknowns
        self._memory: Memory = {} if memory is None else memory
        self._check()
        self._rest = at_rest(robot)
        empty = [_empty_level(level, robot, order, unknowns) for level in levels.parts]
        self.hierarchy = Hierarchy(empty, n=unknowns.n)
        self._own_limits = None if isinstance(robot, Live) else OwnLimits(robot)
        self._names = [_row_names(part, robot, order) for part in levels.all_parts]
        self._rates = np.zeros(len(levels.parts))
        self.every_aim = np.zeros((len(levels.parts), unknowns.n))
        self._take_note([k for k, rule in enumerate(levels.damping) if rule])
        self._take_up()
        if isinstance(robot, Live):
            watch_alone(robot, self)

    def brake(self, levels: Iterable[int]) -> None:
        """Keep the aims of these levels up to date, too: somebody else damps them."""
        self._take_note(levels)
        self._chain()

    def _take_note(self, damped: Iterable[int]) -> None:
        """Which levels are damped: at acceleration order they have aims."""
        self._braked = list(damped) if self._order == "acceleration" else []
        self.aims: Mapping[int | str, Array] | None = {k: self.every_aim[k] for k in self._braked} or None

    def admit(self, part: Live, name: str) -> None:
        """Take up what was changed in a part or the robot, or refuse it; see :class:`tasks.base.live.Watcher`."""
        if id(part) == id(self._robot):
            self._check()
            self._take_up()
            return
        own = self._owners.get(id(part), [])
        for k in own:
            changed = self._views[k][0]
            changed.check(self._robot, self._order, self._dt)
            if _row_names(changed, self._robot, self._order) != self._names[k]:
                raise InvalidInput(f"{changed.full_name()}: with another {name} it has other rows; {changed._instead}")
        if any(type(self._views[k][0]).claim is not RowWriter.claim for k in own):
            self._take_up()  # which others go by
        else:
            self._plan(own)

    def _check(self) -> None:
        for part in self.levels.all_parts:
            part.check(self._robot, self._order, self._dt)

    def _take_up(self) -> None:
        """Begin anew with the numbers that all parts and the robot have now."""
        robot, order, dt = self._robot, self._order, self._dt
        self.shared = shared = Workspace(robot, order, dt, self.unknowns, self._memory)
        self._joints: list[tuple[RowWriter, Array, Array]] = []  # of wide rows: the joints' part
        self._views: list[tuple[RowWriter, Site]] = []
        self._weights: list[tuple[Array, NDArray[np.intp]]] = []  # and which rows ask for nothing
        self._owners: dict[int, list[int]] = {}  # of all that is reachable from a part: the parts
        for level, (view, parts) in enumerate(zip(self.hierarchy.levels, self.levels.parts, strict=True)):
            row, rate = 0, self._rates[level : level + 1]
            for part in parts:
                own = slice(row, row + part.size(robot))
                row = own.stop
                site = Site(shared, self._matrix(part, view, own), view.lower[own], view.upper[own], rate)
                part.claim(site)
                self._views.append((part, site))
                self._weights.append((view.weights[own], np.zeros(0, dtype=np.intp)))
        shared.envelope.close(shared)
        self._embed = self._embedding()
        self.plans: list[tuple[RowWriter, Plan]] = [(part, Plan()) for part, _ in self._views]
        self._plan(range(len(self._views)))

    def _matrix(self, part: RowWriter, view: Level, own: slice) -> Array | None:
        """Where a part writes its rows: in the hierarchy, or, where it has more unknowns, beside it."""
        if view.A is None:
            return None
        rows = view.A[own]
        if part.wide or self.unknowns.n == self.unknowns.nv:
            return rows
        joints = rows[:, : self.unknowns.nv].copy()
        self._joints.append((part, joints, rows))
        return joints

    def _embedding(self) -> list[Call]:
        """The loop that copies rows of the joint motion into rows of all unknowns, every tick."""
        moving = [(joints, rows) for part, joints, rows in self._joints if not part.plain]
        if not moving:
            return []
        from ..base.loops import Call, Table
        from .kernels.embedding import embed_joints

        told = [entry for joints, rows in moving for entry in (joints, rows, len(rows))]
        return [Call(embed_joints, len(moving), self.unknowns.nv, self.unknowns.n, Table(*told))]

    def _plan(self, which: Iterable[int]) -> None:
        """Plan how these parts write their rows."""

        robot, shared = self._robot, self.shared
        self.planned += 1
        rest = Tick(robot, self._rest, 0.0, self._order, self._dt, shared.envelope)
        for k in which:
            part, site = self._views[k]
            with np.errstate(all="ignore"):  # what is infinite is refused in words
                part.check_beside(rest)
            site.off.clear()
            self.plans[k] = part, plan_of(part, site)
            weights = part.weights(robot)
            without = np.flatnonzero(weights == 0.0)
            view, _ = self._weights[k]
            view[:], view[without] = weights, 1.0
            self._weights[k] = view, without
            for held in reachable(part):  # also what came with the change
                watch_alone(held, self)
                owners = self._owners.setdefault(id(held), [])
                if k not in owners:
                    owners.append(k)
        for part, joints, rows in self._joints:
            if part.plain:  # whose rows stay as they are
                rows[:, : self.unknowns.nv] = joints
        if self._order == "acceleration":
            self._rates[:] = [max(part.decay_rate() for part in level) for level in self.levels.parts]
        pairs = zip(self._views, self._weights, strict=True)
        self._unweighted = [(site.lower, site.upper, without) for (_, site), (_, without) in pairs if without.size]
        self._moves = [move for _, plan in self.plans for move in plan.moves]
        self._python = [plan.python for _, plan in self.plans if plan.python is not None]
        self._chain()

    def _chain(self) -> None:
        """What runs all loops of a tick."""
        from ..base.loops import chained

        shared = self.shared
        own = [call for _, plan in self.plans for call in plan.calls]
        own += [*self._embed, *self._aiming()]
        self.compiled = not self._python
        self._before = chained(shared.calls) if self._python else None  # what Python may ask for
        self._run = chained(own if self._python else [*shared.calls, *own])

    def _aiming(self) -> list[Call]:
        """What keeps the aims of damped levels up to date."""
        if self.aims is None:
            return []
        from ..base.loops import Call
        from .kernels.braking import write_damping

        n, v, rates = self.shared.n, self.shared.v, self._rates
        return [Call(write_damping, n, rates[k : k + 1], v, self.aims[k], self.aims[k]) for k in self._braked]

    @property
    def envelope(self) -> Envelope:
        return self.shared.envelope

    @property
    def work(self) -> list[tuple[int, int, RowWriter, Plan, Site]]:
        """Level, first row, part, plan and site of every part, from the highest level down."""
        levels = [k for k, parts in enumerate(self.levels.parts) for _ in parts]
        first = np.cumsum([0, *(site.rows for _, site in self._views)])
        plans = (plan for _, plan in self.plans)
        return [
            (k, int(row), part, plan, site)
            for k, row, plan, (part, site) in zip(levels, first, plans, self._views, strict=False)
        ]

    def bounds(self, part: RowWriter) -> tuple[Array, Array] | None:
        """Lower and upper bounds of a part (views; of one that stands for several, a copy), None if it is not here."""
        meant = self._meant.get(id(part), (part,))
        sites = [site for own, site in self._views if any(own is each for each in meant)]
        if not sites and id(part) not in self._meant:
            return None
        if len(sites) == 1:
            return sites[0].lower, sites[0].upper
        none = np.zeros(0)
        lower, upper = ([getattr(site, side) for site in sites] for side in ("lower", "upper"))
        return np.concatenate([none, *lower]), np.concatenate([none, *upper])

    def describe(self) -> Description:
        """Who writes the rows of each part, and why Python does where it does."""
        robot, order, envelope = self._robot, self._order, self.shared.envelope
        levels = (k for k, parts in enumerate(self.levels.parts) for _ in parts)
        return Description(
            tuple(
                WrittenPart.of(level, part.full_name(), tuple(part.labels(robot, order)), plan, envelope.loops(site))
                for level, (part, plan), (_, site) in zip(levels, self.plans, self._views, strict=True)
            )
        )

    def fill(self, state: RobotState, t: float) -> Hierarchy:
        """Let every part write its rows for this state and time t [s]; the hierarchy, for convenience."""
        if self._own_limits is not None and self._own_limits.changed():
            self._check()
            self._take_up()
            self._own_limits.note()
        for move in self._moves:
            move(t)
        self.shared.come_to(state)
        if self._before is not None:
            self._before()
            tick = Tick(self._robot, state, t, self._order, self._dt, self.shared.envelope)
            for write in self._python:
                write(tick)
        self._run()
        for lower, upper, rows in self._unweighted:
            lower[rows], upper[rows] = -np.inf, np.inf
        return self.hierarchy


def _empty_level(parts: tuple[RowWriter, ...], robot: Robot, order: Order, unknowns: Unknowns) -> Level:
    """One level without numbers yet: plain bounds if all its parts are plain, rows otherwise."""
    name = " + ".join(of_type(part.name, str, f"name of a {type(part).__name__}") for part in parts)
    weights = np.ones(sum(part.size(robot) for part in parts))

    def labels() -> list[Label]:
        return [label for part in parts for label in part.labels(robot, order)]

    zeros = np.zeros(len(weights))
    if all(part.plain for part in parts):
        indices = np.concatenate([p.columns(unknowns, robot) for p in parts])
        return Level.bounds(zeros, zeros, indices=indices, weights=weights, name=name, labels=labels)
    identity = np.eye(unknowns.n)
    A = [identity[p.columns(unknowns, robot)] if p.plain else np.zeros((p.size(robot), unknowns.n)) for p in parts]
    return Level(np.concatenate(A), zeros, zeros, weights=weights, name=name, labels=labels)


def _row_names(part: RowWriter, robot: Robot, order: Order) -> list[str]:
    return [label.row for label in part.labels(robot, order)]
