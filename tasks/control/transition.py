r"""Transition from one stack to another without a jump of the command.

Tasks that are inserted, removed or reordered change the answer of a hierarchy at once. Therefore both stacks are solved
during a change, and the command moves from one answer to the other:

.. math:: x = (1 - s)\, x_\text{old} + s\, x_\text{new}, \qquad s : 0 \to 1 \text{ by a timing law.}

Every task of either stack then follows an *intermediate value* between what it had and what it will have: where the
rows are equalities this is the intermediate desired value of J. Lee, N. Mansard and J. Park, IEEE Transactions on
Robotics 28(6), 2012, for all levels at once. Levels that both stacks begin with, such as the joint limits, are kept
exactly all the way: the points at which they are optimal form a convex set, and both answers lie in it. If the new
stack begins with limits that the old one does not have, the old answer may lie outside this set. The command is then
the point nearest to x among those that are optimal for these limits.
"""

from __future__ import annotations

from copy import deepcopy

from hqp import Hierarchy, Solver

from ..base.checks import Array, positive_scalar
from ..base.stopwatch import Stopwatch
from ..robots.robot import RobotState
from ..rows.levels import Levels
from ..rows.part import Stack
from ..targets.timing import Timing, as_timing
from .prepared import PreparedStack


class Limits:
    """The limits that a stack begins with, as a hierarchy of their own.

    Parameters
    ----------
    hierarchy : hqp.Hierarchy
        The hierarchy of the whole stack.
    count : int
        How many of its first levels contain only limits.
    backend : str
    """

    def __init__(self, hierarchy: Hierarchy, count: int, backend: str) -> None:
        self._own = Hierarchy([deepcopy(level) for level in hierarchy.levels[:count]], n=hierarchy.n)
        self._solver = Solver(backend)

    @classmethod
    def of(cls, levels: Levels, hierarchy: Hierarchy, backend: str) -> Limits | None:
        """The limits that these levels begin with; None if there are none."""
        kinds = [all(part.is_limit for part in level) for level in levels.parts]
        count = (*kinds, False).index(False)
        return cls(hierarchy, count, backend) if count else None

    def keep(self, hierarchy: Hierarchy, x: Array) -> Array:
        """The point nearest to x that meets these limits, with the numbers of this tick in the stack's hierarchy."""
        for own, level in zip(self._own.levels, hierarchy.levels, strict=False):
            own.lower[:], own.upper[:], own.weights[:] = level.lower, level.upper, level.weights
            if own.A is not None:
                own.A[:] = level.A
        solution = self._solver.solve(self._own, x)
        return solution.x if solution.ok else x


class Transition:
    """A transition from one stack to another, under way.

    Parameters
    ----------
    old : PreparedStack
        The stack before the change.
    before : Transition or None
        The transition to `old`, if that was still under way.
    duration : float
        How long it takes [s], from the first tick on.
    law : callable
        Timing law of s.

    Raises
    ------
    InvalidInput
        If the duration is not positive, or the law is not a timing law.
    """

    def __init__(self, old: PreparedStack, before: Transition | None, duration: float, law: Timing) -> None:
        self.old, self.before = old, before
        self.duration = positive_scalar(duration, "duration of a change", unit="s")
        self.law = as_timing(law, "law of a change")
        self.since = Stopwatch()

    def share(self, t: float) -> float:
        """How much of the new stack counts at time t [s], 0 at the first tick that asks."""
        return self.law(self.since.elapsed(t) / self.duration)[0]

    def history(self) -> list[tuple[Stack, float, Timing, Stopwatch]]:
        """The changes under way, oldest first: the previous stack, duration [s], law, and time since it began."""
        earlier = [] if self.before is None else self.before.history()
        return [*earlier, (self.old.stack, self.duration, self.law, deepcopy(self.since))]

    def blend(self, state: RobotState, t: float, new: Array, known: bool) -> tuple[Array, float]:
        """The command between the answers of both stacks, and the share of the new one.

        If the old stack has no answer, only the new one is used.
        """
        s = self.share(t)
        if s >= 1.0:
            return new, 1.0
        solution = self.old.solve(state, t, known)
        if not solution.ok:
            return new, 1.0
        old = solution.x if self.before is None else self.before.blend(state, t, solution.x, known)[0]
        return (1.0 - s) * old + s * new, s
