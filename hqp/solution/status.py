"""The status of an answer, and how much work it took."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class Status(Enum):
    """How an answer was reached. Every hierarchy of valid numbers has an answer.

    OPTIMAL
        As far as the backend can tell; ``solution.certify()`` proves it.
    SUBOPTIMAL, STALLED
        The budget ran out, or round-off stopped all progress, at ``solution.level``: the levels
        above it are exact, it and those below are feasible for them. See ``solution.gap``. Where a
        stalled solver had no proof, the certificate found that level.
    FAILED
        No usable answer from there on.
    UNSUPPORTED
        Not a hierarchy that this backend takes.
    INVALID
        Numbers that mean nothing; the message names level and row.
    """

    OPTIMAL = "optimal"
    SUBOPTIMAL = "suboptimal"
    STALLED = "stalled"
    FAILED = "failed"
    UNSUPPORTED = "unsupported"
    INVALID = "invalid"

    def __str__(self) -> str:
        return self.value


class Counts(NamedTuple):
    """The work of a solve: sweeps, iterations, QPs.

    Attributes
    ----------
    sweeps
        Times that the native solver went through all levels: guesses of the active rows that it solved and verified,
        or level by level.
    iterations
        Steps of its active sets, where the rows that were active the last time are no longer the right ones.
    qp_solves
        QPs handed to the named solver, proximal steps included.
    proximal_steps
        Those of them that solved a level again from its own last answer.
    polishes
        Equality least squares on active rows, kept or not.
    levels_solved
        Levels, the implicit last one included, that the named solver solved.
    levels_met
        Levels that needed no solver: already met, without slack, by what the levels above
        left them, or no unknown left to move.
    levels_polished
        Levels whose polish was kept.
    """

    sweeps: int = 0
    iterations: int = 0
    qp_solves: int = 0
    proximal_steps: int = 0
    polishes: int = 0
    levels_solved: int = 0
    levels_met: int = 0
    levels_polished: int = 0


#: The counts of a backend that counts nothing.
NO_COUNTS = Counts()


def counted(told: int) -> Counts:
    """The counts of a run of the native solver, of which it tells in one number."""
    from ..kernels.layout import ITERATION  # not before there has been a run

    return Counts(told % ITERATION, told // ITERATION)
