"""One level of a sequence of levels: its subspace, the hard rows that bound it, and the state for the next level."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, length, lengths
from ..certificate import allowance, excess, pull
from ..hierarchy import Hierarchy
from ..settings import Settings
from .lapack import row_space

Signs = NDArray[np.int8]

#: Round-off of a row at the end of a step y, in units of ``||y||`` times the norm of the row.
REACH = 64 * np.finfo(np.float64).eps


class LevelProblem(NamedTuple):
    """One level in coordinates y of the null space Z that the levels above left: x + Z y.

        min 1/2 sum_i dist(B_i y, [lower_i, upper_i])^2   subject to   low <= N y <= high

    Rows B belong to the level, rows N to the satisfied inequalities of the levels above. All bounds are
    seen from x: at y = 0 a row is 0 and the slacks of the level are `still`. `equality` marks the rows whose
    bounds are one, and `equations` is true where all are; `norms` are those of the rows before projection (the
    hard rows had norm one); `slack` and `margin` are the tolerances on both at y = 0; `asked` is the longest
    step that a row asks for on its own.
    """

    B: Array
    lower: Array
    upper: Array
    equality: NDArray[np.bool_]
    equations: bool
    norms: Array
    still: Array
    slack: Array
    N: Array
    low: Array
    high: Array
    margin: Array
    asked: float

    def reaching(self, y: Array) -> LevelProblem:
        """The subproblem with the round-off of rows at y in its tolerances."""
        more = REACH * length(y)
        return self._replace(slack=self.slack + more * self.norms, margin=self.margin + more)

    def slacks(self, y: Array) -> Array:
        """The slacks w of the level's rows at y."""
        value = self.B @ y
        return value - self.lower if self.equations else excess(value, self.lower, self.upper)

    def infeasibility(self, y: Array) -> float:
        """How far the worst hard row is outside, beyond its tolerance; 0 if none is."""
        if not len(self.N):
            return 0.0
        place = self.N @ y
        return float((np.maximum(place - self.high, self.low - place) - self.margin).max(initial=0.0))


def objective(w: Array) -> float:
    """``1/2 ||w||^2`` of the slacks w of a level."""
    return 0.5 * float(w @ w)


class Standing(NamedTuple):
    """Where rows stand at an x: ``A x``, its slack, and the slack that is none."""

    value: Array
    slack: Array
    tolerance: Array


class State(NamedTuple):
    """Where the sequence stands between two levels.

    x is optimal for the levels done; ``x + Z y`` keeps their equalities and violated rows. Their satisfied
    inequalities are `hard`, shape (h, n + 2): rows N of norm one, with lower and upper bound in the last two
    columns. `moved` is ``N Z``.
    """

    x: Array
    Z: Array
    hard: Array
    moved: Array

    @staticmethod
    def start(x: Array) -> State:
        """Before the first level: everything is free."""
        n = len(x)
        return State(x, np.eye(n), np.zeros((0, n + 2)), np.zeros((0, n)))

    def room(self, settings: Settings) -> tuple[Array, Array, Array]:
        """How far down and up from x the hard rows may go, x itself being allowed, and their tolerances."""
        rows, low, high = self.hard[:, :-2], self.hard[:, -2], self.hard[:, -1]
        if not len(rows):
            return low, high, low
        place = rows @ self.x
        margin = allowance(place, 0.0, 1.0, length(self.x), 0.0, settings.tolerance)
        return np.minimum(low - place, 0.0), np.maximum(high - place, 0.0), margin


class LevelRows(NamedTuple):
    """The rows of a level that constrain anything, weighted: without zero rows and free rows.

    `unit`, shape (m, n + 2), holds A, lower and upper divided by the norms.
    """

    A: Array
    lower: Array
    upper: Array
    equality: NDArray[np.bool_]
    norms: Array
    unit: Array

    @classmethod
    def of(cls, hierarchy: Hierarchy, x_ref: Array) -> Iterator[LevelRows]:
        """The rows of the levels of a hierarchy, the highest first, the implicit last level at the end."""
        n, weights = hierarchy.n, hierarchy.weights
        norms = weights * hierarchy.row_norms()
        says = (norms > 0) & ((hierarchy.lower > -np.inf) | (hierarchy.upper < np.inf))
        weighted = weights[:, None] * hierarchy.dense(), weights * hierarchy.lower, weights * hierarchy.upper, norms
        cuts: Sequence[int] = hierarchy.pointers
        A, lower, upper, norms = weighted
        if not says.all():
            cuts = [int(np.count_nonzero(says[:end])) for end in cuts]
            A, lower, upper, norms = (part[says] for part in weighted)
        unit = np.concatenate([A, lower[:, None], upper[:, None]], axis=1) / norms[:, None]
        whole = cls(A, lower, upper, lower == upper, norms, unit)
        for begin, end in pairwise(cuts):
            yield cls._make(part[begin:end] for part in whole)
        yield cls(np.eye(n), x_ref, x_ref, np.ones(n, dtype=np.bool_), np.ones(n), np.zeros((0, n + 2)))

    def at(self, x: Array, settings: Settings) -> Standing:
        """Where the rows stand at x."""
        value = self.A @ x
        slack = excess(value, self.lower, self.upper)
        allowed = allowance(value, slack, self.norms, length(x), pull(slack, self.norms), settings.tolerance)
        return Standing(value, slack, allowed)

    def problem(self, state: State, here: Standing, settings: Settings) -> LevelProblem:
        """The level in y: rows that y cannot move are left out, and the rest scaled by what y can move."""
        moved = self.A @ state.Z
        reach = lengths(moved)
        kept = reach > settings.rank_tolerance * self.norms
        unit = 1.0 / float(reach[kept].max(initial=1e-300))
        lower, upper = self.lower - here.value, self.upper - here.value
        B, lower, upper, norms, still, slack = (
            unit * part[kept] for part in (moved, lower, upper, self.norms, here.slack, here.tolerance)
        )
        asked = float((np.abs(still) / norms).max(initial=0.0))
        equality = self.equality[kept]
        hard = state.moved, *state.room(settings)
        return LevelProblem(B, lower, upper, equality, bool(equality.all()), norms, still, slack, *hard, asked)

    def freeze(self, state: State, here: Standing, y: Array, pressing: Signs, settings: Settings) -> State:
        """Equalities, violated rows and pressing hard rows shrink Z; satisfied inequalities become hard rows."""
        x = state.x + state.Z @ y
        frozen = self.equality
        if frozen.all():
            if not len(state.hard):
                _, null = row_space(self.unit[:, :-2] @ state.Z, settings.rank_tolerance)
                return State(x, state.Z @ null, state.hard, state.moved @ null)
        else:
            frozen = frozen | self._violated(x, here, y, settings)
        frozen = np.concatenate([pressing != 0, frozen])
        rows = np.concatenate([state.hard, self.unit])
        fixed, hard, Z = rows[frozen][:, :-2], rows[~frozen], state.Z
        if len(fixed):
            _, null = row_space(fixed @ Z, settings.rank_tolerance)
            Z = Z @ null
        moved = hard[:, :-2] @ Z
        movable = lengths(moved) > settings.rank_tolerance
        return State(x, Z, hard[movable], moved[movable])

    def _violated(self, x: Array, here: Standing, y: Array, settings: Settings) -> NDArray[np.bool_]:
        """The rows beyond a bound at x, the end of the step y."""
        there = self.at(x, settings) if y.any() else here
        # What was close enough before the step, and what is now: the polish knows the former, certificates the latter.
        allowed = np.maximum(here.tolerance, there.tolerance) + REACH * length(y) * self.norms
        if not settings.polish:  # a first-order point violates by what its solver leaves
            allowed = np.maximum(allowed, 1e2 * settings.qp_tolerance * self.norms * (1.0 + length(x)))
        return np.abs(there.slack) > allowed
