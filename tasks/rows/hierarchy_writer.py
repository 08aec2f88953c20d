"""The hierarchy of a stack on one robot, and the loops or functions that write its rows every tick."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite

import numpy as np

from hqp import Hierarchy, InvalidInput

from ..base.checks import Array
from ..base.live import Live, watch_alone
from ..robots.answers import at_rest
from ..robots.robot import Quantity, Robot, RobotState
from .aims import Aims
from .components import Components, Work, one_component
from .description import Description, WrittenPart
from .empty import empty_level, row_names
from .envelope import QUANTITIES, Envelope
from .expansion import Expanded
from .ledger import Ledger
from .own_limits import OwnLimits
from .places import Places
from .plan import Plan, check_numbers, overridden, plan_of
from .row_writer import RowWriter
from .site import Memory, Workspace
from .tick import Order, Tick

#: What a part is asked when it is planned, beside its plan.
ASKED = ("check", "check_beside", "labels", "row_names", "size", "variables", "weights", "decay_rate")

#: What says how the rows of a limit are called.
NAMES = ("labels", "row_names", "size", "variables")
#: That of a part whose rows others write.
NO_PLAN = Plan()
#: The limits of a robot, which may be set while it is at work.
LIMITS = frozenset({"position_limit", "velocity_limit", "acceleration_limit", "torque_limit"})


class HierarchyWriter:
    """Writes the hierarchy of a stack on one robot, every tick.

    Parameters
    ----------
    expanded : Expanded
    robot : Robot
    order : {"velocity", "acceleration", "displacement"}
    dt : float, optional
        Tick [s].
    memory : Memory, optional
        What parts keep from tick to tick.
    live : bool
        Whether it takes up what changes in the parts and the robot, and tells how rows bend. Without, it is made
        faster: for one call, in which nothing changes.

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
        live: bool = True,
    ) -> None:
        self._robot, self._order, self._dt = robot, order, dt
        levels, unknowns, _ = self._expanded = expanded
        self.levels, self.unknowns = levels, unknowns
        self._memory: Memory = Memory() if memory is None else memory
        self._check()
        self._rest = at_rest(robot)
        empty = [empty_level(level, robot, order, unknowns) for level in levels.parts]
        self.hierarchy = Hierarchy(empty, n=unknowns.n)
        self._own_limits = None if isinstance(robot, Live) or not live else OwnLimits(robot)
        self._live, self._ends = live, np.full(robot.nv, np.inf)
        self._names = [row_names(part, robot, order) for part in levels.all_parts] if live else []
        together = one_component(robot.nv, self.hierarchy.m)
        self.aims = Aims(len(levels.parts), unknowns.n, robot.nv, together)
        self._aim(k for k, rule in enumerate(levels.damping) if rule)
        self._take_up()
        if isinstance(robot, Live) and live:
            watch_alone(robot, self)

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

    def admit(self, part: Live, name: str) -> None:
        """Take up what was changed in a part or the robot, or refuse it; see :class:`tasks.base.live.Watcher`."""
        if id(part) == id(self._robot):
            self._take_robot(name)
            return
        own, changed = self._ledger.owners(part), self._ledger.changes(part)
        if changed and self.renumber(part, changed, own):
            self._ledger.keep(part)
            return
        limits = self.places.claiming(own)
        for k in own:
            view = self._views[k][0]
            if k in limits:  # which refuses when it claims
                check_numbers(view, self._robot, self._order, self._dt)
                if not overridden(type(view), NAMES, "claim"):
                    continue
            else:
                view.check(self._robot, self._order, self._dt)
            if row_names(view, self._robot, self._order) != self._names[k]:
                raise InvalidInput(f"{view.full_name()}: with another {name} it has other rows; {view._instead}")
        if not limits:
            self._plan(own)
        elif not self._reclaim(part, changed, own):  # by which others go
            self._take_up()

    def renumber(self, part: Live, changed: Sequence[str], own: Sequence[int]) -> bool:
        """Write numbers of a part that have changed where its plans have put them; False where it takes new plans.

        It does if more has changed than its plans know the places of, if Python writes its rows, or if a subclass has
        its own say in what a plan is asked for.

        Parameters
        ----------
        part : Live
        changed : sequence of str
            Their names.
        own : sequence of int
            The numbers of the parts of the stack that it can be reached from.
        """
        keys, tunes = [(id(part), name) for name in changed], False
        for k in own:
            view, site = self._views[k]
            if not all(key in site.targets or key in site.numbers for key in keys):
                return False
            if self.plans[k][1].python or overridden(type(view), ASKED) or overridden(type(part), ASKED):
                return False
            tunes = tunes or any(key in site.numbers for key in keys if key[1] != "weight")
            if tunes or view is not part:
                check_numbers(view, self._robot, self._order, self._dt)
        for k in own:
            site = self._views[k][1]
            if not all(write() for write in {site.targets.get(key) or site.numbers[key] for key in keys}):
                return False
        if tunes:
            self.tuned += 1
            self._take_rates()
        if "weight" in changed:
            self._weigh(own)
        return True

    @property
    def stands_still(self) -> bool:
        """Whether rows go by their plans and the state alone: loops write them, no target moves, no part has memory."""
        return self.compiled and not self._moves and not self._memory

    def _take_robot(self, name: str | None = None) -> None:
        """Take up the robot as it is now; name tells what has changed, None that it is one of its limits."""
        claims = self.places.claiming()
        if (name is None or name in LIMITS) and not self._reads_limits(claims):
            for k in claims:
                check_numbers(self._views[k][0], self._robot, self._order, self._dt)
            if not claims or self._renew_limits(claims, QUANTITIES):
                return
        self._check()
        self._take_up()

    def _reads_limits(self, claims: Sequence[int]) -> bool:
        """Whether somebody may go by the limits of the robot, beside those who claim them."""
        parts = [kind for kind in self._ledger.kinds if issubclass(kind, RowWriter)]
        others = [kind for kind in parts if kind.claim is RowWriter.claim]
        if any(kind.reads_limits for kind in parts) or any(overridden(kind, ASKED) for kind in others):
            return True
        return any(overridden(type(self._views[k][0]), NAMES, "claim") for k in claims)

    def _reclaim(self, part: Live, changed: list[str], own: list[int]) -> bool:
        """Have the envelope take the limits of these parts as they are now; False if more than numbers has changed."""
        if not self._renew_limits(own):
            return False
        if not changed or "weight" in changed:
            self._weigh(own)
        self._ledger.keep(part)
        if self._ledger.holds_others(part, changed):
            for k in own:
                self._ledger.enter(k, self._views[k][0], self)
        return True

    def _renew_limits(self, own: Sequence[int], kinds: Sequence[Quantity] = ()) -> bool:
        """Have these parts claim their limits as they are now; False if more than numbers has changed.

        Limits of the robot may have changed, too, of the given kinds.
        """
        shared, views = self.shared, [self._views[k] for k in own]
        braked = isfinite(shared.braking[0])

        def ask() -> None:
            for view, site in views:
                view.claim(site)

        if any(self.plans[k][1] != NO_PLAN for k in own):
            return False
        if not shared.envelope.renew(shared, [site for _, site in views], ask, kinds):
            return False
        if isfinite(shared.braking[0]) != braked:  # by which plans differ
            return False
        self._check_beside(range(len(self._views)))
        return True

    def _check(self) -> None:
        for part in self.levels.all_parts:
            part.check(self._robot, self._order, self._dt)

    def _take_up(self) -> None:
        """Begin anew with the numbers that all parts and the robot have now."""
        robot, order, dt = self._robot, self._order, self._dt
        self.shared = shared = Workspace(robot, order, dt, self.unknowns, self._memory)
        shared.curvature = self._live
        shared.aims = tuple((self.aims.by_level or {}).values())
        self.places = Places(self._expanded, self.hierarchy, shared, self.aims.rates)
        self._views, self._ledger = self.places.parts, Ledger()
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
            if self._live:
                self._ledger.enter(k, part, self)
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

    def fill(self, state: RobotState, t: float) -> Hierarchy:
        """Let every part write its rows for this state and time t [s]; the hierarchy, for convenience."""
        if self._own_limits is not None and self._own_limits.changed():
            self._take_robot()
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
        for lower, upper, rows in self._unbounded:
            lower[rows], upper[rows] = -np.inf, np.inf
        return self.hierarchy
