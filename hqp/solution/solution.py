"""The solution of a hierarchy: x and a status; levels, proof and explanation are computed on request."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from ..arrays import Array
from ..certificate import Certificate, Explanation, RowStates, certify, explain, row_states
from ..checks import positive_number, truth
from ..hierarchy import Hierarchy
from ..settings import Settings
from .explaining import explained
from .level import LevelSolution, levels_at, ranks_of
from .relaxation import Relaxation
from .stages import Stages, proof, relaxations
from .status import NO_COUNTS, Counts, Status, counted

Made = TypeVar("Made")

#: What fields are computed from when they are first read, and the numbers of what was computed.
PENDING = ("_noted", "_points", "_aims", "_made")


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """The answer of one backend to one hierarchy. Everything but x is computed when it is first read.

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
        The tolerances by which `levels` decides sides and ranks.
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
    counts: Counts = field(default_factory=lambda: NO_COUNTS)
    staged: Stages | None = field(default_factory=lambda: None)

    def __getattr__(self, name: str) -> Any:
        # A control loop only reads x; everything else is computed when it is first read.
        noted = self.__dict__.get("_noted")
        if noted is None or name not in ("hierarchy", "x_ref", "backend", "settings", "counts", "staged"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        if name == "staged":
            points, tell = self.__dict__.get("_points"), noted[3][2]
            self.__dict__["staged"] = None if points is None else tell(self, points, self.__dict__.get("_aims"))
            return self.__dict__["staged"]
        template, numbers, x_ref, (backend, settings, _), counts = noted
        if name == "counts":
            self.__dict__["counts"] = counts if isinstance(counts, Counts) else counted(counts)
        else:
            given = template.with_numbers(np.frombuffer(numbers))
            self.__dict__.update(hierarchy=given, x_ref=x_ref, backend=backend, settings=settings)
        return self.__dict__[name]

    def __getstate__(self) -> dict[str, Any]:
        """All fields, computed now: what they are computed from is memory of a solver, which no copy takes along."""
        made = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in vars(self).items() if name not in PENDING} | made

    @property
    def ok(self) -> bool:
        """The backend's own claim. The proof is ``solution.certify().ok``."""
        return self.status is Status.OPTIMAL

    @cached_property
    def gap(self) -> float:
        """Bound on how much the residual norm of ``level`` could still fall; 0 if the status is OPTIMAL.

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
        tolerance = 10 * self.settings.tolerance
        return levels_at(self.hierarchy, self._proof(1e-9), self._rows(tolerance), self._ranks(tolerance))

    def _proof(self, tolerance: float) -> Certificate:
        return self._once("proof", tolerance, lambda: certify(self.hierarchy, self.x, self.x_ref, tolerance=tolerance))

    def _rows(self, tolerance: float) -> RowStates:
        return self._once("rows", tolerance, lambda: row_states(self.hierarchy, self.x, self.x_ref, tolerance))

    def _ranks(self, tolerance: float) -> list[tuple[int, float]]:
        rows, least = self._rows(tolerance), self.settings.rank_tolerance
        return self._once("ranks", tolerance, lambda: ranks_of(self.hierarchy, rows, least))

    def _once(self, what: str, tolerance: float, make: Callable[[], Made]) -> Made:
        """What was made before of these very numbers, or is now: whoever wrote into x or a level is judged anew."""
        numbers = self.x.tobytes(), self.x_ref.tobytes(), self.hierarchy.numbers.tobytes()
        of, found = self.__dict__.get("_made", (None, {}))
        if of != numbers:
            _, found = self.__dict__["_made"] = numbers, {}
        if (what, tolerance) not in found:
            found[what, tolerance] = make()
        made: Made = found[what, tolerance]
        return made

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
        return () if self.staged is None else relaxations(self, self.staged)

    def certify(self, *, unique: bool = True, tolerance: float = 1e-9) -> Certificate:
        """The proof of this answer, of every stage, or by how much it falls short; see :func:`hqp.certify`."""
        if self.staged is not None:
            return proof(self, self.staged, unique, tolerance)
        unique, tolerance = truth(unique, "unique"), positive_number(tolerance, "tolerance", below=1.0)
        found = self._proof(tolerance)
        return found if unique else replace(found, levels=found.levels[:-1], unique=False)

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
            return explained(self, self.staged, tolerance)
        certificate = self.certify(unique=False, tolerance=tolerance)
        rows, ranks = self._rows(tolerance), [rank for rank, _ in self._ranks(tolerance)]
        with np.errstate(all="ignore"):  # as in the certificate: an x out of all bounds is judged, not warned about
            return Explanation(explain(self.hierarchy, certificate, rows, ranks), self.message)

    def __repr__(self) -> str:
        stages = "" if self.staged is None else f"{len(self.stages)} stages, "
        head = f"Solution({self.status} by {self.backend}, {stages}x = "
        lines = [head + np.array2string(self.x, precision=6, threshold=8) + ")"]
        lines += [f"  {self.message}"] if self.message else []
        lines += [f"  {k}: {level!r}" for k, level in enumerate(self.levels)]
        return "\n".join(lines + [f"  {relaxation!r}" for relaxation in self.relaxed])
