"""The native solver: one compiled kernel, exact and warm.

All numbers stay where they are: the kernel reads the buffer of the hierarchy, works in memory that is laid out once
a structure, and remembers in it which rows were active. What it does is told in :mod:`hqp.kernels.solver`.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..certificate import first_failed
from ..damping import DampingRule, ErrorDamping, FixedDamping, ManipulabilityDamping, SingularValueDamping
from ..hierarchy import Hierarchy
from ..kernels import builtin
from ..kernels import damped as kernel_damped
from ..kernels import damping_rules as kinds
from ..kernels import layout as at
from ..kernels import solver as kernel
from ..kernels.active_set import OPTIMAL, STALLED, SUBOPTIMAL
from ..kernels.builtin import runner
from ..kernels.call import address_of, is_ready
from ..kernels.doubt import MOST, SHARPEST
from ..kernels.judge import judge
from ..kernels.ready import SIGNATURE, door, make_ready
from ..kernels.safe_method import safe_method
from ..kernels.workspace import Workspace
from ..settings import Settings
from ..solution import Counts, Status
from .base import Answer, ShortWay
from .graded import gradings

#: What is compiled, as told when it is.
WHAT = "the native solver"
#: Tolerance on rows of the certificate, as the default of :func:`hqp.certify`.
JUDGED = 1e-9

#: Kernels that stand apart (:mod:`hqp.kernels.apart`), and where the solvers find their addresses.
APART = {at.CERTIFICATE: judge, at.SAFE_METHOD: safe_method}

STATUSES = {
    OPTIMAL: Status.OPTIMAL,
    SUBOPTIMAL: Status.SUBOPTIMAL,
    STALLED: Status.STALLED,  # these two until the certificate says better
    kernel.UNEVEN: Status.STALLED,
}


class Native:
    """The kernel, its memory, and the active rows of the last call."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._memory: Memory | None = None

    def prepare(self, structure: tuple[Any, ...]) -> ShortWay:
        """The short way for hierarchies of this structure; if it proves nothing, :meth:`solve` tells what came out."""
        memory = self._memory = Memory(structure, self._settings)
        return ShortWay(runner(memory, kernel.solve), memory.refer, len(memory.x))

    def prepare_damped(self, structure: tuple[Any, ...], rules: dict[int, DampingRule]) -> ShortWay | None:
        """The same where levels are damped, with the points of all stages; None if a rule is none that it knows."""
        numbers = [in_numbers(rule) for rule in rules.values()]
        if None in numbers:
            return None
        warm_up_damped()
        memory = self._memory = Memory(structure, self._settings, tuple(rules))
        memory.rules[:, : len(numbers[0] or ())] = numbers
        return ShortWay(runner(memory, kernel_damped.solve_damped), memory.refer, len(memory.x), memory.passed.copy)

    def solve(self, hierarchy: Hierarchy, x_ref: Array) -> Answer:
        """What the short way has just found, in full."""
        memory = self._memory
        assert memory is not None
        outcome = int(memory.head[at.OUTCOME])
        if outcome == kernel.SUSPECT:  # out of range, or a row so long that one of its entries could be
            fault = hierarchy.find_fault()
            if fault is not None:
                return Answer(x_ref.copy(), Status.INVALID, fault)
            memory.head[at.TRUSTED] = 1
            outcome = memory.run(hierarchy.address)
        if outcome == kernel.LACKING:  # a single solve, begun without the kernels that stand apart
            memory.complete()
            memory.forget()
            outcome = memory.run(hierarchy.address)
        memory.head[at.TRUSTED] = 0
        answer = self._told(hierarchy, x_ref, outcome)
        decided = self._settings.time_limit < math.inf or self._settings.rank_tolerance > MOST
        if answer.status is not Status.STALLED or decided:
            return answer
        memory.complete()
        again = (attempt(hierarchy, x_ref) for attempt in (self._sharper, self._graded))
        return next((found for found in again if found.status is Status.OPTIMAL), answer)

    def _told(self, hierarchy: Hierarchy, x_ref: Array, outcome: int) -> Answer:
        """What the last run says, judged."""
        assert self._memory is not None
        head = self._memory.head.tolist()
        counts = Counts(sweeps=head[at.SWEEPS], iterations=head[at.ITERATIONS])
        return judged(hierarchy, self._memory.x.copy(), x_ref, outcome, head[at.LEVEL], counts, head[at.FAILS])

    def _sharper(self, hierarchy: Hierarchy, x_ref: Array) -> Answer:
        """Once more from a cold start, taking all rows for independent that may be so: where ranks are in doubt."""
        memory = self._memory
        assert memory is not None
        memory.option[at.TAU], memory.head[at.WARM] = min(SHARPEST, self._settings.rank_tolerance), 0
        outcome = memory.run(hierarchy.address)
        memory.option[at.TAU] = self._settings.rank_tolerance
        return self._told(hierarchy, x_ref, kernel.UNEVEN if outcome == OPTIMAL else outcome)

    def _graded(self, hierarchy: Hierarchy, x_ref: Array) -> Answer:
        """Once more with the long rows of a level above its short ones; the certificate judges them as one level."""
        assert self._memory is not None
        sweeps, iterations = self._memory.head[[at.SWEEPS, at.ITERATIONS]].tolist()
        answer = Answer(x_ref, Status.STALLED)
        for graded in gradings(hierarchy):
            memory = Memory(graded.structure, self._settings)
            memory.x_ref[:], memory.head[at.TRUSTED] = x_ref, 1
            memory.run(graded.address)
            sweeps, iterations = sweeps + memory.head[at.SWEEPS], iterations + memory.head[at.ITERATIONS]
            counts = Counts(int(sweeps), int(iterations))
            answer = judged(hierarchy, memory.x.copy(), x_ref, kernel.UNEVEN, 0, counts)
            if answer.status is Status.OPTIMAL:
                break
        return answer

    def began(self, when: int) -> None:
        """The time limit of the next run counts from `when`, by ``time.monotonic_ns``."""
        if self._memory is not None:
            self._memory.head[at.BEGAN] = when

    def reset(self) -> None:
        self._memory = None

    def forget(self) -> None:
        """Forget which rows were active, and keep the memory."""
        if self._memory is not None:
            self._memory.forget()


def judged(
    hierarchy: Hierarchy,
    x: Array,
    x_ref: Array,
    outcome: int,
    level: int,
    counts: Counts,
    fails: int = at.UNJUDGED,
) -> Answer:
    """What is claimed of x. What the kernel has not proved, nor judged, `fails`, is for the certificate."""
    status = STATUSES[outcome]
    if status is Status.STALLED:
        failed = first_failed(hierarchy, x, x_ref) if fails == at.UNJUDGED else fails if fails != at.PASSES else None
        status, level = (Status.OPTIMAL, level) if failed is None else (status, failed)
    if status is Status.OPTIMAL:
        return Answer(x, counts=counts)
    where = hierarchy.level_name(level) if level < len(hierarchy.levels) else "min ||x - x_ref||"
    what = "the budget ran out" if status is Status.SUBOPTIMAL else "no more progress"
    message = f"{what} at {where}, after {counts.iterations} iterations; the levels above are exact"
    return Answer(x, status, message, level, counts)


class Memory(Workspace):
    """What the kernel works in: one structure, and the active rows of the last hierarchy."""

    def __init__(
        self, structure: tuple[Any, ...], settings: Settings, damped: tuple[int, ...] = (), rows: bool = False
    ) -> None:
        super().__init__(structure, damped, rows)
        self._twin: Memory | None = None
        self._stages = self.ints(at.STAGES)
        self.x_ref[:] = 0.0
        self.option[: at.BLUR] = (
            settings.rank_tolerance,
            settings.tolerance,
            settings.iterations,
            settings.time_limit,
            JUDGED,
        )
        self.rules, self.passed, self.aims = (self.floats(place) for place in (at.RULES, at.PASSED, at.AIMS))
        if rows:  # of damping, which the caller has no numbers for
            self._bounds = np.empty((3, int(self.head[at.ROWS])))
            self._entries[[at.LOWER, at.UPPER, at.WEIGHTS], 0] = [array.ctypes.data for array in self._bounds]
        elif damped:
            self._twin = Memory(structure, settings, damped, rows=True)
            self.head[at.TWIN] = self._twin.share(self._entries)
        self._find_apart()
        self.forget()
        # The compiled function itself: there is one, and nothing to dispatch.
        self.run = partial(door(kernel_damped.solve_damped if damped else kernel.solve), self.address)

    def refer(self, x_ref: Array | None, aims: Array | None) -> None:
        """Use this x_ref, and these aims of the damped levels, in the runs to come; None: zero, and x_ref."""
        self.x_ref[:] = 0.0 if x_ref is None else x_ref
        self.head[at.AIMED] = aims is not None
        if aims is not None:
            self.aims[:] = aims

    def complete(self) -> None:
        """Have all kernels ready that may be needed, and known to the solver."""
        warm_up()
        self._find_apart()

    def _find_apart(self) -> None:
        """Write the addresses of the kernels that stand apart, as far as they are ready."""
        for place, apart in APART.items():
            self.head[place] = address_of(apart, SIGNATURE) if is_ready(apart) else 0

    def forget(self) -> None:
        """Be as new for the calls to come: no guess, no sides at the ends of levels, nor of stages."""
        self.head[at.WARM] = self.head[at.HISTORY] = 0
        self._stages[:] = 0  # where no solve comes to a stage, its sides are read all the same
        if self._twin is not None:
            self._twin.forget()

    def share(self, entries: NDArray[np.int64]) -> int:
        """Have the weighted rows where they are in another directory; the address of this one."""
        self._entries[at.B] = entries[at.B]
        return self.address

    def run_many(
        self,
        ends: tuple[int, int],
        numbers: Array,
        references: Array | None,
        x: Array,
        sides: NDArray[np.int64],
        said: NDArray[np.int64],
        warm: bool,
    ) -> None:
        """Solve rows ends[0] .. ends[1] of `numbers`; arrays have a row a hierarchy (:mod:`hqp.solver.batch`)."""
        first, end = ends
        self.head[at.COUNT], self.head[at.STRIDE], self.head[at.WARM] = end - first, numbers.shape[1], warm
        self.head[at.REFERENCES] = 0 if references is None else references[first:end].ctypes.data
        for place, array in ((at.POINTS, x), (at.SIDES, sides), (at.OUTCOMES, said)):
            self.head[place] = array[first:end].ctypes.data
        self.run(numbers[first:end].ctypes.data)
        self.head[at.COUNT] = self.head[at.WARM] = 0


def in_numbers(rule: DampingRule) -> tuple[float, ...] | None:
    """Kind and parameters of a rule that the kernel knows; a rule of one's own it does not."""
    match rule:
        case FixedDamping() if type(rule) is FixedDamping:
            return kinds.FIXED, rule.factor, 0.0
        case ManipulabilityDamping() if type(rule) is ManipulabilityDamping:
            return kinds.MANIPULABILITY, rule.largest, rule.threshold
        case SingularValueDamping() if type(rule) is SingularValueDamping:
            return kinds.SINGULAR_VALUE, rule.largest, rule.threshold
        case ErrorDamping() if type(rule) is ErrorDamping:
            return kinds.ERROR, rule.bound, rule.least
    return None


def warm_up() -> bool:
    """Have the solver ready: from disk, or compiled now. True if it had to be compiled."""
    return sum([warm_up_once(), *(make_ready(apart, WHAT) for apart in APART.values())]) > 0


def warm_up_once() -> bool:
    """The same for what every solve needs."""
    return sum([make_ready(kernel.solve, WHAT), make_ready(builtin.run, WHAT, builtin.SIGNATURE)]) > 0


def warm_up_damped() -> bool:
    """The same for damped levels, which those that have none need not wait for."""
    return make_ready(kernel_damped.solve_damped, "damped levels")


def make(name: str, settings: Settings) -> Native:
    """The backend, ready to run."""
    warm_up()
    return Native(settings)


def make_once(name: str, settings: Settings) -> Native:
    """The backend for a single solve: only what every solve needs is ready."""
    warm_up_once()
    return Native(settings)
