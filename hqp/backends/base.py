"""The interface of a backend."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ..arrays import Array
from ..hierarchy import Hierarchy
from ..solution import NO_COUNTS, Counts, Status


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
