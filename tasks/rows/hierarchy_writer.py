"""The hierarchy of a stack on one robot: written every tick, and kept up to date where parts or the robot change."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite

import numpy as np

from hqp import Hierarchy, InvalidInput, Label

from ..base.live import Live, watch_alone
from ..robots.robot import Quantity, Robot, RobotState
from .envelope import QUANTITIES
from .expansion import Expanded
from .ledger import Ledger
from .own_limits import OwnLimits
from .plan import Plan, check_numbers, overridden
from .planned_rows import PlannedRows
from .row_writer import RowWriter
from .site import Memory
from .tick import Order, Tick

#: What a part is asked when it is planned, beside its plan.
ASKED = ("check", "check_beside", "labels", "row_names", "size", "variables", "weights", "decay_rate")

#: What says how the rows of a limit are called.
NAMES = ("labels", "row_names", "size", "variables")
#: That of a part whose rows others write.
NO_PLAN = Plan()
#: The limits of a robot, which may be set while it is at work.
LIMITS = frozenset({"position_limit", "velocity_limit", "acceleration_limit", "torque_limit"})


class HierarchyWriter(PlannedRows):
    """Writes the hierarchy of a stack on one robot, every tick.

    Parameters
    ----------
    expanded, robot, order, dt, memory
        As of :class:`PlannedRows`.
    live : bool
        Whether it takes up what changes in the parts and the robot, and tells how rows bend. Without, it is made
        faster: for one call, in which nothing changes.
    """

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
        self._live = live
        super().__init__(expanded, robot, order, dt, memory, bends=live)
        self._own_limits = None if isinstance(robot, Live) or not live else OwnLimits(robot)
        self._labels: dict[int, list[Label]] = {k: [] for k in range(len(self._views))}
        if live:
            self._label(range(len(self._views)))
        if isinstance(robot, Live) and live:
            watch_alone(robot, self)

    def _take_up(self) -> None:
        self._ledger = Ledger()
        super()._take_up()

    def _plan(self, which: Iterable[int]) -> None:
        """Plan how these parts write their rows, and watch them."""
        super()._plan(which)
        for k in which if self._live else ():
            self._ledger.enter(k, self._views[k][0], self)

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
            if names(view.labels(self._robot, self._order)) != names(self._labels[k]):
                raise InvalidInput(f"{view.full_name()}: with another {name} it has other rows; {view._instead}")
        if not limits:
            self._plan(own)
        elif not self._reclaim(part, changed, own):  # by which others go
            self._take_up()
        self._label(own)

    def _label(self, which: Iterable[int]) -> None:
        """Call rows by what these parts are now, in another hierarchy: earlier answers keep the words of their tick."""
        said = {k: self._views[k][0].labels(self._robot, self._order) for k in which}
        said = {k: labels for k, labels in said.items() if labels != self._labels[k]}
        if not said:
            return
        self._labels |= said
        changed = {self.places.levels[k]: list[Label]() for k in said}
        for k, level in enumerate(self.places.levels):
            if level in changed:
                changed[level] += self._labels[k]
        self.hierarchy = self.hierarchy.with_labels(changed)

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
                self._label(claims)
                return
        self._check()
        self._take_up()
        self._label(range(len(self._views)))

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


def names(labels: Iterable[Label]) -> list[str]:
    """What labels call rows."""
    return [label.row for label in labels]
