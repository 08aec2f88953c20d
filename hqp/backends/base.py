"""The interface of a backend."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from ..arrays import Array
from ..certificate import first_failed
from ..hierarchy import Hierarchy
from ..solution import NO_COUNTS, Counts, Status

#: What is said of x where a level failed, or stalled.
EXACT_ABOVE = "x is optimal for the levels above"


@dataclass(slots=True, eq=False)
class Answer:
    """The result of a backend: x, the claimed status, and the work done.

    Parameters
    ----------
    x : array, shape (n,)
        The answer.
    status : Status
        How it was reached.
    message : str
        What is wrong with it, where something is.
    level : int, optional
        The level at which the backend fell short.
    counts : Counts
        The work of the solve.
    """

    x: Array
    status: Status = Status.OPTIMAL
    message: str = ""
    level: int | None = None
    counts: Counts = NO_COUNTS


def _unproved(numbers: Array, x: Array) -> int:
    """A run that proves nothing."""
    return -1


def _unread(x_ref: Array | None, aims: Array | None) -> None:
    """Write x_ref and aims nowhere."""


@dataclass(slots=True, eq=False)
class ShortWay:
    """The parts of a tick where the kernel itself proves the optimum, as nearly always: for a solver to put together.

    A function that did would cost as much as solving some rows. Without arguments: a short way that nothing takes, so
    that :meth:`Backend.solve` is asked.

    Parameters
    ----------
    run : callable
        Solves the hierarchy of these numbers, and writes x where it has proved the optimum; what this took, as
        :data:`hqp.kernels.layout.ITERATION` tells, or -1.
    refer : callable
        Takes x_ref and the aims of damped levels, None for zero and for x_ref, for the runs to come.
    n : int
        Unknowns.
    points : callable, optional
        Where levels are damped: a copy of what led to x.
    plain : tuple, optional
        The structure, while x_ref is zero, no level has an aim of its own and no time is limited: only numbers change
        from run to run.
    """

    run: Callable[[Array, Array], int] = _unproved
    refer: Callable[[Array | None, Array | None], None] = _unread
    n: int = 0
    points: Callable[[], Array] | None = None
    plain: tuple[Any, ...] | None = None


def certified(answer: Answer, hierarchy: Hierarchy, x_ref: Array, who: str) -> Answer:
    """The answer, with its status by the certificate: an optimum that this refutes is STALLED, at the level that fails.

    Where the answer of `who` was none, and already a level above the one that it names is refuted, both are told.
    """
    failed = first_failed(hierarchy, answer.x, x_ref)
    if failed is None or (answer.level is not None and answer.level <= failed):
        return answer
    message = f"{level_name(hierarchy, failed)}: the certificate refutes the answer of {who}; {EXACT_ABOVE}"
    if answer.message:
        message = f"{answer.message.removesuffix(f'; {EXACT_ABOVE}')}; {message}"
    status = Status.STALLED if answer.status is Status.OPTIMAL else answer.status
    return Answer(answer.x, status, message, failed, answer.counts)


def level_name(hierarchy: Hierarchy, k: int) -> str:
    """Of a level, the implicit last one included."""
    return hierarchy.level_name(k) if k < len(hierarchy.levels) else "min ||x - x_ref||"


class Backend(Protocol):
    """A way to solve hierarchies. Made once a :class:`hqp.Solver`, so it may keep a workspace.

    The hierarchy that arrives has valid numbers; a backend never raises on them and answers with a
    status instead.
    """

    def solve(self, hierarchy: Hierarchy, x_ref: Array) -> Answer:
        """Solve, warm from the last call with the same structure; x_ref has shape (n,)."""
        ...

    def reset(self) -> None:
        """Forget what the last call left behind (called when the structure changes)."""
        ...
