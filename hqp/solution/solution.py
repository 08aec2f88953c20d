"""The solution of a hierarchy: x, a status, and slacks, active rows, rank and multipliers of every level."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, length
from ..certificate import (
    Certificate,
    Explanation,
    LevelExplanation,
    RowStates,
    certify,
    excess,
    explain,
    row_space,
    row_states,
)
from ..hierarchy import Hierarchy, Side
from ..settings import Settings
from .relaxation import Relaxation
from .softening import Softened, in_words, softened


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


#: What is counted where nothing is.
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


@dataclass(frozen=True, eq=False)
class Stages:
    """What a solve with damped levels went through, see :mod:`hqp.damping.staged`.

    Attributes
    ----------
    solutions : tuple of Solution
        The plain hierarchies that were solved, in order; the last one gave x. Where its status is not
        OPTIMAL, those that should have come after it are missing.
    dampings : dict of int to float
        The lambda of every damped level that was reached; 0 where it was left strict.
    aims : dict of int to array
        What every damped level is damped towards; see :mod:`hqp.damping.staged`.
    frozen : Hierarchy
        The hierarchy with every damped level frozen at what it reached.
    solve : callable
        Solves a plain hierarchy, given x_ref.
    reached : dict of int to array
        What x was when a level was done, of levels that those below may move a little.
    singular : str
        What explanations say of a direction in which x hardly moves a level; empty: they tell the rows of damping.
    """

    solutions: tuple[Solution, ...]
    dampings: dict[int, float]
    aims: dict[int, Array]
    frozen: Hierarchy
    solve: Callable[[Hierarchy, Array], Solution]
    reached: dict[int, Array] = field(default_factory=dict)
    singular: str = ""


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
    staged : Stages, or None
        What led to x where levels are damped.
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
    staged: Stages | None = field(default_factory=lambda: None)

    def __getattr__(self, name: str) -> Any:
        # A control loop takes x and goes on; what else was noted down is looked up when it is asked for.
        noted = self.__dict__.get("_noted")
        if noted is None or name not in ("hierarchy", "x_ref", "backend", "settings", "staged"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        if name == "staged":
            points, tell = self.__dict__.get("_points"), noted[3][2]
            self.__dict__["staged"] = None if points is None else tell(self, points, self.__dict__.get("_aims"))
            return self.__dict__["staged"]
        template, numbers, x_ref, (backend, settings, _) = noted
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
        if self.staged is not None:
            return self.stages[-1].gap
        return self.certify().levels[self.level].shortfall

    @cached_property
    def levels(self) -> tuple[LevelSolution, ...]:
        """Slack, residual, rank, active rows and multipliers of every level."""
        if self.status is Status.INVALID:
            return ()
        h, rows = self.hierarchy, self._rows
        judged = certify(h, self.x, self.x_ref, unique=False).levels
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

    @property
    def stages(self) -> tuple[Solution, ...]:
        """The plain hierarchies that led to x: this one, or, where levels are damped, stage by stage."""
        return (self,) if self.staged is None else self.staged.solutions

    @property
    def dampings(self) -> dict[int, float]:
        """The lambda of every damped level that was reached, 0 where it was left strict."""
        return {} if self.staged is None else self.staged.dampings

    @property
    def aims(self) -> dict[int, Array]:
        """What every damped level is damped towards, by its index: x_ref, unless an aim was given."""
        return {} if self.staged is None else self.staged.aims

    @cached_property
    def relaxed(self) -> tuple[Relaxation, ...]:
        """Where strictness was relaxed, and by how much: one entry for each damped level, highest first."""
        h, names = self.hierarchy, [level.name for level in self.hierarchy.levels]
        return tuple(
            Relaxation(
                k,
                names[k],
                damping,
                self.aims[k],
                _residual_norm(h, k, self.x),
                self._moved(k),
                partial(self._strict_norm, k),
                partial(self._softened, k),
            )
            for k, damping in self.dampings.items()
        )

    def _moved(self, k: int) -> float:
        """How far the levels below k have moved its rows."""
        assert self.staged is not None
        reached, level = self.staged.reached.get(k), self.hierarchy.levels[k]
        return 0.0 if reached is None else length(level.weights * (self.hierarchy.matrix(k) @ (self.x - reached)))

    def _softened(self, k: int) -> tuple[Softened, ...]:
        """The directions in which level k gave way, by its stage."""
        for stage in self.stages:
            if len(stage.hierarchy.levels) == k + 1 and len(stage.hierarchy.levels[k]) > len(self.hierarchy.levels[k]):
                return softened(stage.hierarchy, len(self.hierarchy.levels[k]))
        return ()

    def _strict_norm(self, k: int) -> float:
        """The residual norm of level k without its damping, below what the levels above it reached."""
        assert self.staged is not None
        strict = Hierarchy([*self.staged.frozen.levels[:k], self.hierarchy.levels[k]], n=self.hierarchy.n)
        return _residual_norm(strict, k, self.staged.solve(strict, self.x_ref).x)

    def certify(self, *, unique: bool = True, tolerance: float = 1e-9) -> Certificate:
        """The proof of this answer, of every stage, or by how much it falls short; see :func:`hqp.certify`."""
        if self.staged is not None:
            *earlier, last = (stage.certify(unique=unique, tolerance=tolerance) for stage in self.stages)
            return replace(last, earlier=tuple(earlier))
        return certify(self.hierarchy, self.x, self.x_ref, unique=unique, tolerance=tolerance)

    def explain(self, *, tolerance: float = 1e-9) -> Explanation:
        """Which row stopped which level, in the words of its labels.

        A damped level is explained in its own stage, where its damping is one of its parts.

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
        if self.staged is not None:
            return self._explain_stages(tolerance)
        certificate = self.certify(unique=False, tolerance=tolerance)
        rows = row_states(self.hierarchy, self.x, self.x_ref, tolerance)
        ranks = [rank for rank, _ in self._ranks(rows)]
        with np.errstate(all="ignore"):  # as in the certificate: an x out of all bounds is judged, not warned about
            return Explanation(explain(self.hierarchy, certificate, rows, ranks), self.message)

    def _explain_stages(self, tolerance: float) -> Explanation:
        levels = list(self.stages[-1].explain(tolerance=tolerance).levels)
        for stage in self.stages[:-1]:
            k = len(stage.hierarchy.levels) - 1
            if k in self.dampings and stage.hierarchy.m > self.hierarchy.pointers[k + 1] and k < len(levels):
                levels[k] = stage.explain(tolerance=tolerance).levels[k]
        assert self.staged is not None
        if self.staged.singular:
            levels = [self._in_words(level) if level.level in self.dampings else level for level in levels]
        return Explanation(tuple(levels), self.message)

    def _in_words(self, told: LevelExplanation) -> LevelExplanation:
        """Of a level, as its stage explains it, what its own rows lack, and why it gave way."""
        assert self.staged is not None
        own, rows = self.levels[told.level], slice(*self.hierarchy.pointers[told.level : told.level + 2])
        labels = [self.hierarchy.label_of(row) for row in range(rows.start, rows.stop)]
        weakest, fixing = self._softened(told.level)[:1], self._rows.violated[rows] | (own.active == Side.EQUALITY)
        why = "".join(in_words(soft, labels, self.staged.singular) for soft in weakest)
        names = dict.fromkeys(label.part for label in labels)
        parts = tuple(part for part in told.parts if part.part in names)
        return replace(
            told, parts=parts, rank=own.rank, fixing=int(fixing.sum()), contradicts=False, inner=0.0, damped=why
        )

    def __repr__(self) -> str:
        stages = "" if self.staged is None else f"{len(self.stages)} stages, "
        head = f"Solution({self.status} by {self.backend}, {stages}x = "
        lines = [head + np.array2string(self.x, precision=6, threshold=8) + ")"]
        lines += [f"  {self.message}"] if self.message else []
        lines += [f"  {k}: {level!r}" for k, level in enumerate(self.levels)]
        return "\n".join(lines + [f"  {relaxation!r}" for relaxation in self.relaxed])


def _residual_norm(hierarchy: Hierarchy, k: int, x: Array) -> float:
    """``||D_k w_k||`` at x."""
    level = hierarchy.levels[k]
    return length(level.weights * excess(hierarchy.matrix(k) @ x, level.lower, level.upper))
