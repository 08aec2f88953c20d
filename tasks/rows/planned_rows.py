"""The plans by which the parts of a stack write their rows on one robot, and the loops that run them every tick."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from hqp import Hierarchy

from ..base.checks import Array
from ..robots.answers import at_rest
from ..robots.robot import Robot
from .aims import Aims
from .components import Components, Work, one_component
from .description import Description, WrittenPart
from .empty import empty_level
from .envelope import Envelope
from .expansion import Expanded
from .places import Places
from .plan import Plan, plan_of
from .row_writer import RowWriter
from .site import Memory, Workspace
from .tick import Order, Tick


class PlannedRows:
    """How all parts of a stack write their rows on one robot.

    Parameters
    ----------
    expanded : Expanded
    robot : Robot
    order : {"velocity", "acceleration", "displacement"}
    dt : float, optional
        Tick [s].
    memory : Memory, optional
        What parts keep from tick to tick.
    bends : bool
        Whether the rows tell how they bend.

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
    planned, tuned : int
        How often rows have been planned: whoever knows plans by their addresses looks at them again. And how often the
        numbers of a law have changed since: whoever goes by gains looks at those.
    places : Places
        Where each part has its rows.
    aims : Aims
        What damped levels are damped towards at this tick; none is at other orders than that of accelerations, where it
        is zero.
    """

    planned = tuned = 0

    def __init__(
        self,
        expanded: Expanded,
        robot: Robot,
        order: Order,
        dt: float | None = None,
        memory: Memory | None = None,
        *,
        bends: bool = True,
    ) -> None:
        self._robot, self._order, self._dt, self._bends = robot, order, dt, bends
        levels, unknowns, _ = self._expanded = expanded
        self.levels, self.unknowns = levels, unknowns
        self._memory: Memory = Memory() if memory is None else memory
        self._check()
        self._rest = at_rest(robot)
        empty = [empty_level(level, robot, order, unknowns) for level in levels.parts]
        self.hierarchy = Hierarchy(empty, n=unknowns.n)
        self._ends = np.full(robot.nv, np.inf)
        together = one_component(robot.nv, self.hierarchy.m)
        self.aims = Aims(len(levels.parts), unknowns.n, robot.nv, together)
        self._aim(k for k, rule in enumerate(levels.damping) if rule)
        self._take_up()

    def brake(self, levels: Iterable[int], ends: Array, parted: Components) -> None:
        """Keep the aims of these levels up to date, too: somebody else damps them, component by component.

        And bring joints without an acceleration limit to rest at the ends of their ranges with `ends` [rad/s^2], (nv,).
        """
        self._ends, self.aims.components = ends, parted
        self._aim(levels)
        self._take_rates()
        self.shared.envelope.ease_ends(ends)
        self._chain()

    def _aim(self, damped: Iterable[int]) -> None:
        """Which levels are damped: at acceleration order they have aims."""
        if self._order == "acceleration":
            self.aims.damped = tuple(damped)

    def _check(self) -> None:
        for part in self.levels.all_parts:
            part.check(self._robot, self._order, self._dt)

    def _take_up(self) -> None:
        """Begin anew with the numbers that all parts and the robot have now."""
        robot, order, dt = self._robot, self._order, self._dt
        self.shared = shared = Workspace(robot, order, dt, self.unknowns, self._memory)
        shared.curvature = self._bends
        shared.aims = tuple((self.aims.by_level or {}).values())
        self.places = Places(self._expanded, self.hierarchy, shared, self.aims.rates)
        self._views = self.places.parts
        shared.envelope.ease_ends(self._ends)
        shared.envelope.close(shared)
        self._embed = self.places.embedding.calls()
        self.plans: list[tuple[RowWriter, Plan]] = [(part, Plan()) for part, _ in self._views]
        self._plan(range(len(self._views)))

    def _plan(self, which: Iterable[int]) -> None:
        """Plan how these parts write their rows."""
        self.planned += 1
        self._check_beside(which)
        for k in which:
            part, site = self._views[k]
            site.forget()
            self.plans[k] = part, plan_of(part, site)
        self._weigh(which)
        self.places.embedding.copy_plain()
        self._take_rates()
        self._moves = [move for _, plan in self.plans for move in plan.moves]
        self._python = [plan.python for _, plan in self.plans if plan.python is not None]
        self._chain()

    def _check_beside(self, which: Iterable[int]) -> None:
        """Ask parts whether they can work with the joint limits of the stack."""
        asked = [part for part in (self._views[k][0] for k in which) if part.stands_beside]
        if not asked:
            return
        rest = Tick(self._robot, self._rest, 0.0, self._order, self._dt, self.shared.envelope)
        with np.errstate(all="ignore"):  # what is infinite is refused in words
            for part in asked:
                part.check_beside(rest)

    def _weigh(self, which: Iterable[int]) -> None:
        """Take the weights of these parts."""
        self.places.weights.take(which)
        self._unbounded = self.places.weights.unbounded

    def _take_rates(self) -> None:
        """Take how fast the tasks of each level decay: at acceleration order what is damped goes by it."""
        if self._order == "acceleration":
            self.aims.take_rates(self.work)

    def _chain(self) -> None:
        """What runs all loops of a tick."""
        from ..base.loops import chained

        shared = self.shared
        own = [call for _, plan in self.plans for call in plan.calls]
        own += [*self._embed, *self.aims.calls(shared)]
        self.compiled = not self._python
        self._before = chained(shared.calls) if self._python else None  # what Python may ask for
        self._run = chained(own if self._python else [*shared.calls, *own])

    @property
    def envelope(self) -> Envelope:
        return self.shared.envelope

    @property
    def work(self) -> list[Work]:
        """Level, first row, part, plan and site of every part, from the highest level down."""
        places = self.places
        rows = zip(places.levels, places.first, self.plans, self._views, strict=True)
        return [(k, int(first), part, plan, site) for k, first, (_, plan), (part, site) in rows]

    def describe(self) -> Description:
        """Who writes the rows of each part, and why Python does where it does."""
        robot, order, envelope = self._robot, self._order, self.shared.envelope
        given = self.shared.given
        return Description(
            tuple(
                WrittenPart.of(
                    level,
                    part.full_name(),
                    tuple(part.labels(robot, order)),
                    plan,
                    envelope.loops(site),
                    given.get(id(part), ()),
                )
                for level, (part, plan), (_, site) in zip(self.places.levels, self.plans, self._views, strict=True)
            )
        )
