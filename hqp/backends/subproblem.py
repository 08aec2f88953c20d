"""One level of a sequence of levels: what it may still move, what holds it, and what it leaves to the next."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..hierarchy import lengths
from ..level import Level
from ..rows import allowance, excess
from ..settings import Settings
from ..subspace import split

Signs = NDArray[np.int8]

#: Round-off of a row at the end of a step y, in units of ``||y||`` times the norm of the row.
REACH = 64 * np.finfo(np.float64).eps


@dataclass(frozen=True, eq=False)
class LevelProblem:
    """One level in coordinates y of the null space Z that the levels above left: x + Z y.

        min 1/2 sum_i dist(value_i + B_i y, [lower_i, upper_i])^2   subject to   low <= place + N y <= high

    Rows B belong to the level, rows N to the satisfied inequalities of the levels above.
    `value` is ``A x`` and `place` is ``N_x x`` at y = 0; `norms` are those of the rows before
    projection (the hard rows had norm one); `slack` and `margin` are the tolerances on both at y = 0.
    """

    B: Array
    value: Array
    lower: Array
    upper: Array
    norms: Array
    slack: Array
    N: Array
    place: Array
    low: Array
    high: Array
    margin: Array

    def reaching(self, y: Array) -> LevelProblem:
        """The same problem with the round-off of rows at y in its tolerances."""
        more = REACH * float(np.linalg.norm(y))
        return replace(self, slack=self.slack + more * self.norms, margin=self.margin + more)

    def slacks(self, y: Array) -> Array:
        """The slacks w of the level's rows at y."""
        return excess(self.value + self.B @ y, self.lower, self.upper)

    def objective(self, y: Array) -> float:
        """``1/2 ||w||^2``."""
        w = self.slacks(y)
        return 0.5 * float(w @ w)

    def infeasibility(self, y: Array) -> float:
        """How far the worst hard row is outside, beyond its tolerance; 0 if none is."""
        place = self.place + self.N @ y
        return float(np.maximum(np.maximum(place - self.high, self.low - place) - self.margin, 0.0).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class State:
    """Where the sequence stands between two levels.

    x is optimal for the levels done; ``x + Z y`` keeps their equalities and violated rows; N, low,
    high are their satisfied inequalities, as rows of norm one.
    """

    x: Array
    Z: Array
    N: Array
    low: Array
    high: Array

    @classmethod
    def start(cls, x: Array) -> State:
        """Before the first level: everything is free."""
        n = len(x)
        return cls(x, np.eye(n), np.zeros((0, n)), np.zeros(0), np.zeros(0))


@dataclass(frozen=True, eq=False)
class LevelRows:
    """The rows of a level that say anything, weighted; zero rows and free rows do not."""

    A: Array
    lower: Array
    upper: Array
    norms: Array

    @classmethod
    def of(cls, level: Level, A: Array) -> LevelRows:
        """Of a level whose dense rows are A."""
        norms = level.weights * lengths(A)
        says = (norms > 0) & ((level.lower > -np.inf) | (level.upper < np.inf))
        weights = level.weights[says]
        return cls(weights[:, None] * A[says], weights * level.lower[says], weights * level.upper[says], norms[says])

    def tolerances(self, x: Array, settings: Settings) -> Array:
        """How far each row may be from its bound at x."""
        value = self.A @ x
        length = float(np.linalg.norm(x))
        return allowance(value, excess(value, self.lower, self.upper), self.norms, length, settings.tolerance)

    def problem(self, state: State, settings: Settings) -> LevelProblem:
        """The level in y: rows that y cannot move are left out, and the rest scaled by what y can move."""
        length = float(np.linalg.norm(state.x))
        value = self.A @ state.x
        slack = self.tolerances(state.x, settings)
        moved = self.A @ state.Z
        reach = np.sqrt(np.einsum("ij,ij->i", moved, moved))
        kept = reach > settings.rank_tolerance * self.norms
        unit = 1.0 / reach[kept].max(initial=1e-300)
        B, value, lower, upper, norms, slack = (
            unit * part[kept] for part in (moved, value, self.lower, self.upper, self.norms, slack)
        )

        place = state.N @ state.x
        low, high = np.minimum(state.low, place), np.maximum(state.high, place)  # relaxed: y = 0 is feasible
        margin = allowance(place, np.zeros_like(place), np.ones_like(place), length, settings.tolerance)
        return LevelProblem(B, value, lower, upper, norms, slack, state.N @ state.Z, place, low, high, margin)

    def freeze(self, state: State, y: Array, pressing: Signs, settings: Settings) -> State:
        """Equalities, violated rows and pressing hard rows shrink Z; satisfied inequalities become hard rows."""
        x = state.x + state.Z @ y
        value = self.A @ x
        slack = excess(value, self.lower, self.upper)
        # What was close enough before the step, and what is now: the polish knows the former, certificates the latter.
        allowed = np.maximum(self.tolerances(state.x, settings), self.tolerances(x, settings))
        allowed += REACH * float(np.linalg.norm(y)) * self.norms
        if not settings.polish:  # a first-order point violates by what its solver leaves
            allowed = np.maximum(allowed, 1e2 * settings.qp_tolerance * self.norms * (1.0 + np.linalg.norm(x)))
        frozen = (self.lower == self.upper) | (np.abs(slack) > allowed)
        unit = self.A / self.norms[:, None]
        pressed = pressing != 0
        fixed = np.concatenate([unit[frozen], state.N[pressed]])
        Z = state.Z @ split(fixed @ state.Z, np.ones(len(fixed)), settings.rank_tolerance)[1] if len(fixed) else state.Z

        kept, stay = ~frozen, ~pressed
        N = np.concatenate([state.N[stay], unit[kept]])
        low = np.concatenate([state.low[stay], self.lower[kept] / self.norms[kept]])
        high = np.concatenate([state.high[stay], self.upper[kept] / self.norms[kept]])
        moved = N @ Z
        movable = np.sqrt(np.einsum("ij,ij->i", moved, moved)) > settings.rank_tolerance
        return State(x, Z, N[movable], low[movable], high[movable])
