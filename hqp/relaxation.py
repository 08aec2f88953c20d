"""What came out of a regularised solve, and where strictness was relaxed, by how much."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from .arrays import Array, length
from .certificate import Certificate
from .explanation import Explanation
from .hierarchy import Hierarchy
from .rows import excess
from .settings import Settings
from .solution import Counts, LevelSolution, Solution, Status
from .solve import Solver


@dataclass(frozen=True, eq=False)
class Relaxation:
    """One damped level: what its damping costs it.

    Attributes
    ----------
    level, name
        Index and name in the hierarchy.
    damping : float
        The lambda that the rule chose; 0 where the level was left strict.
    residual_norm : float
        ``||D_k w_k||`` as it came out.
    """

    level: int
    name: str
    damping: float
    residual_norm: float
    _strict: Callable[[], Solution] = field(repr=False)

    @cached_property
    def strict_norm(self) -> float:
        """The residual norm without the damping of this level, below the same levels; solved when first asked for."""
        if self.damping == 0.0:
            return self.residual_norm
        strict = self._strict()
        return _residual_norm(strict.hierarchy, self.level, strict.x)

    @property
    def excess(self) -> float:
        """By how much the damping makes the residual norm larger."""
        return self.residual_norm - self.strict_norm


@dataclass(frozen=True, eq=False)
class StageCertificates:
    """The proofs of all stages; ``bool(certificates)`` and ``.ok`` say it in one word."""

    stages: tuple[Certificate, ...]

    @property
    def ok(self) -> bool:
        """Whether every stage is lexicographically optimal."""
        return all(stage.ok for stage in self.stages)

    @property
    def failed(self) -> Certificate | None:
        """That of the first stage which falls short, or None."""
        return next((stage for stage in self.stages if not stage.ok), None)

    def __bool__(self) -> bool:
        return self.ok

    def __str__(self) -> str:
        return "\n".join(f"stage {i}: {stage}" for i, stage in enumerate(self.stages))

    __repr__ = __str__


@dataclass(frozen=True, eq=False, repr=False)
class RegularisedSolution:
    """The answer to a hierarchy with damped levels.

    Attributes
    ----------
    plain : Solution
        x as an answer to the hierarchy as given. Its certificate tells at which level damping shows.
    frozen : Hierarchy
        The hierarchy with every damped level frozen at what it reached.
    stages : tuple of Solution
        The plain hierarchies that were solved, in order; the last one gave x. Where its status is not
        OPTIMAL, those that should have come after it are missing.
    dampings : dict of int to float
        The lambda of every damped level that was reached.
    settings : Settings
    """

    plain: Solution
    frozen: Hierarchy
    stages: tuple[Solution, ...]
    dampings: dict[int, float]
    settings: Settings

    @property
    def x(self) -> Array:
        """The answer, shape (n,); always finite."""
        return self.plain.x

    @property
    def status(self) -> Status:
        """That of the last stage."""
        return self.plain.status

    @property
    def ok(self) -> bool:
        """The backend's own claim. The proof is ``solution.certify().ok``."""
        return self.plain.ok

    @property
    def message(self) -> str:
        """Why, where the status is not OPTIMAL."""
        return self.plain.message

    @property
    def level(self) -> int | None:
        """The level at which a status other than OPTIMAL arose."""
        return self.plain.level

    @property
    def hierarchy(self) -> Hierarchy:
        """Snapshot of the hierarchy as given."""
        return self.plain.hierarchy

    @property
    def backend(self) -> str:
        """Name of the backend."""
        return self.plain.backend

    @property
    def counts(self) -> Counts:
        """Of all stages together."""
        return self.plain.counts

    @property
    def gap(self) -> float:
        """That of the last stage, see :attr:`hqp.Solution.gap`."""
        return self.stages[-1].gap

    @property
    def x_ref(self) -> Array:
        """Reference of the damping and of the implicit last level."""
        return self.plain.x_ref

    @property
    def levels(self) -> tuple[LevelSolution, ...]:
        """Slack, residual, rank and active rows of every level as given."""
        return self.plain.levels

    @cached_property
    def relaxed(self) -> tuple[Relaxation, ...]:
        """Where strictness was relaxed, and by how much: one entry for each damped level, highest first."""
        names = [level.name for level in self.hierarchy.levels]
        return tuple(
            Relaxation(k, names[k], damping, _residual_norm(self.hierarchy, k, self.x), partial(self._strict, k))
            for k, damping in self.dampings.items()
        )

    def _strict(self, k: int) -> Solution:
        """Level k without its damping, below what the levels above it reached."""
        levels = [*self.frozen.levels[:k], self.hierarchy.levels[k]]
        return Solver(self.plain.backend, self.settings).solve(Hierarchy(levels, n=self.hierarchy.n), self.x_ref)

    def certify(self, *, unique: bool = True, tolerance: float = 1e-9) -> StageCertificates:
        """The proof of every stage, see :func:`hqp.certify`."""
        return StageCertificates(tuple(stage.certify(unique=unique, tolerance=tolerance) for stage in self.stages))

    def explain(self, *, tolerance: float = 1e-9) -> Explanation:
        """Which row stopped which level: a damped one in its own stage, where its damping is one of its parts.

        See :meth:`hqp.Solution.explain`.
        """
        last = self.stages[-1].explain(tolerance=tolerance)
        levels = list(last.levels)
        for stage in self.stages[:-1]:
            k = len(stage.hierarchy.levels) - 1
            if k in self.dampings and stage.hierarchy.m > self.hierarchy.pointers[k + 1] and k < len(levels):
                levels[k] = stage.explain(tolerance=tolerance).levels[k]
        return Explanation(tuple(levels), self.message)

    def __repr__(self) -> str:
        head = f"RegularisedSolution({self.status} by {self.plain.backend}, {len(self.stages)} stages, x = "
        lines = [head + np.array2string(self.x, precision=6, threshold=8) + ")"]
        lines += [f"  {self.message}"] if self.message else []
        lines += [f"  {k}: {level!r}" for k, level in enumerate(self.levels)]
        return "\n".join(lines + [f"  {relaxation!r}" for relaxation in self.relaxed])


def _residual_norm(hierarchy: Hierarchy, k: int, x: Array) -> float:
    """``||D_k w_k||`` at x."""
    level = hierarchy.levels[k]
    return length(level.weights * excess(hierarchy.matrix(k) @ x, level.lower, level.upper))
