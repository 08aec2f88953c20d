"""What came out of a solve: x, a status, and everything that can be said of every level."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .arrays import Array
from .certificate import Certificate, certify
from .explanation import Explanation, explain
from .hierarchy import Hierarchy
from .rows import RowStates, row_states
from .settings import Settings
from .side import Side
from .subspace import row_space


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
    """What the solve was made of.

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


NO_COUNTS = Counts()


@dataclass(frozen=True, eq=False)
class LevelSolution:
    """One level at the solution.

    Attributes
    ----------
    name : str
    slack : array, shape (m_k,)
        Raw slack ``w = A x - clip(A x, lower, upper)``, in the unit of the row.
    residual_norm : float
        Weighted: ``||D_k w_k||``.
    rank : int
        Directions of x which this level fixes among those that the levels above left open: the
        rank of its equality and violated rows in the null space of theirs.
    smallest : float
        How clearly: the smallest singular value of those rows there, in units of their norms; 1 if the rank is 0.
    active : array of int8, shape (m_k,)
        :class:`hqp.Side` of each row: -1 at (or below) its lower bound, 0 inside, 1 at (or
        above) its upper bound, 2 equality.
    multipliers : array
        What holds this level back: one number for every row of levels 0..k-1, positive at an
        upper bound. Their unit is that of ``D_k^2 w_k A_k`` divided by that of the row's A.
    """

    name: str
    slack: Array
    rank: int
    smallest: float
    active: NDArray[np.int8]
    residual_norm: float
    multipliers: Array

    def __repr__(self) -> str:
        active = int(np.count_nonzero((self.active == Side.LOWER) | (self.active == Side.UPPER)))
        return (
            f"LevelSolution({self.name!r}: residual_norm={self.residual_norm:.6g}, rank={self.rank},"
            f" {active} of {len(self.slack)} rows at a bound)"
        )


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """The answer of one backend to one hierarchy. Nothing but x is computed until it is asked for.

    Attributes
    ----------
    x : array, shape (n,)
        Always finite. Where a level failed: the last good x, optimal for the levels above it.
    status : Status
    message : str
        Why, where the status is not OPTIMAL.
    level : int or None
        The level at which a status other than OPTIMAL arose.
    backend : str
    counts : Counts
    hierarchy : Hierarchy
        Snapshot of the numbers that were solved.
    x_ref : array, shape (n,)
    settings : Settings
        By whose tolerances `levels` tells sides and ranks.
    """

    x: Array
    status: Status
    backend: str
    hierarchy: Hierarchy
    x_ref: Array
    settings: Settings
    message: str = ""
    level: int | None = None
    counts: Counts = NO_COUNTS

    def __getattr__(self, name: str) -> Any:
        # A control loop takes x and goes on; what else was noted down is looked up when it is asked for.
        noted = self.__dict__.get("_noted")
        if noted is None or name not in ("hierarchy", "x_ref", "backend", "settings"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        template, numbers, x_ref, (backend, settings) = noted
        self.__dict__.update(hierarchy=template.with_numbers(numbers), x_ref=x_ref, backend=backend, settings=settings)
        return self.__dict__[name]

    @property
    def ok(self) -> bool:
        """The backend's own claim. The proof is ``solution.certify().ok``."""
        return self.status is Status.OPTIMAL

    @cached_property
    def gap(self) -> float:
        """By how much the residual norm of ``level`` could at most still fall; 0 where the status is OPTIMAL.

        As ``certify().levels[level].shortfall``: a bound if an optimum is within ``certify().radius`` of x.
        """
        if self.level is None or self.status is Status.INVALID:
            return 0.0
        return self.certify().levels[self.level].shortfall

    @cached_property
    def levels(self) -> tuple[LevelSolution, ...]:
        """Slack, residual, rank, active rows and multipliers of every level."""
        if self.status is Status.INVALID:
            return ()
        h, rows, judged = self.hierarchy, self._rows, self.certify(unique=False).levels
        ranks = self._ranks(rows)
        return tuple(
            LevelSolution(
                name=level.name,
                slack=rows.slack[a:b],
                rank=ranks[k][0],
                smallest=ranks[k][1],
                active=rows.sides[a:b],
                residual_norm=judged[k].residual_norm,
                multipliers=judged[k].multipliers,
            )
            for k, (level, a, b) in enumerate(zip(h.levels, h.pointers[:-1], h.pointers[1:], strict=True))
        )

    @cached_property
    def _rows(self) -> RowStates:
        return row_states(self.hierarchy, self.x, self.x_ref, 10 * self.settings.tolerance)

    def _ranks(self, rows: RowStates) -> list[tuple[int, float]]:
        """Of every level, rank and smallest singular value of what it fixes, its rows in units of their norms."""
        h, ranks, Z = self.hierarchy, [], np.eye(self.hierarchy.n)
        for k in range(len(h.levels)):
            own = slice(h.pointers[k], h.pointers[k + 1])
            frozen = ((rows.sides[own] == Side.EQUALITY) | rows.violated[own]) & (rows.norms[own] > 0)
            units = h.matrix(k)[frozen] @ Z / rows.norms[own][frozen, None]
            range_, null, smallest = row_space(units, self.settings.rank_tolerance)
            ranks.append((range_.shape[1], smallest))
            Z = Z @ null
        return ranks

    def certify(self, *, unique: bool = True, tolerance: float = 1e-9) -> Certificate:
        """The proof of this answer, or by how much it falls short; see :func:`hqp.certify`."""
        return certify(self.hierarchy, self.x, self.x_ref, unique=unique, tolerance=tolerance)

    def explain(self, *, tolerance: float = 1e-9) -> Explanation:
        """Which row stopped which level, in the words of its labels.

        Parameters
        ----------
        tolerance
            As of :func:`hqp.certify`, whose multipliers these are: answers of first-order backends need what they
            claim.

        Returns
        -------
        Explanation
            Where no level was solved, the message alone.

        Examples
        --------
        >>> from hqp import Hierarchy, Level, solve
        >>> limits = Level.bounds([-1, -1], [1, 1], name="limits")
        >>> reach = Level.equality([[2, 1]], [4], name="reach")
        >>> print(solve(Hierarchy([limits, reach])).explain())
        limits met (2 of 2 rows at a bound)
        reach short by 1: x[0] limits (upper), then x[1] limits (upper)
        """
        if self.status in (Status.INVALID, Status.UNSUPPORTED):
            return Explanation((), self.message)
        certificate = self.certify(unique=False, tolerance=tolerance)
        rows = row_states(self.hierarchy, self.x, self.x_ref, tolerance)
        ranks = [rank for rank, _ in self._ranks(rows)]
        with np.errstate(all="ignore"):  # as in the certificate: an x out of all bounds is judged, not warned about
            return Explanation(explain(self.hierarchy, certificate, rows, ranks), self.message)

    def __repr__(self) -> str:
        head = f"Solution({self.status} by {self.backend}, x = {np.array2string(self.x, precision=6, threshold=8)})"
        lines = [head] + ([f"  {self.message}"] if self.message else [])
        return "\n".join(lines + [f"  {k}: {level!r}" for k, level in enumerate(self.levels)])
