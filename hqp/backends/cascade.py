"""One QP per level, through any flat QP solver (Kanoun 2011), with what it takes to be exact.

Level by level, from the highest: the equalities and the violated rows of the levels above are
*eliminated* by an orthonormal basis Z of their null space (passed on as constraints they would make
every next QP just-feasible), their satisfied inequalities stay as rows with their, if need be
relaxed, bounds. In the coordinates y of Z the named solver minimises

    1/2 ||D (A Z y - (b - A x))||^2 + 1/2 ||w||^2 + rho/2 ||y - y_prev||^2,

w being the slacks of the level's inequality rows, again and again, warm, until y stops moving: a few
proximal steps, which make rank-deficient levels strictly convex and cost no accuracy. Then one
equality least squares on the active rows (:mod:`.polish`), kept only if it is no worse.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import HqpError
from ..hierarchy import Array, Hierarchy, Level
from ..qp import FlatQP, FlatResult, FlatSolver, Sizes, make_flat_solver
from ..rows import ROUND_OFF
from ..settings import Settings
from ..solution import Counts, Status
from ..subspace import split
from .base import Answer
from .polish import LevelProblem, Polished, Signs, polish

#: Flat solvers kept for warm starts: sizes change with the active set, and come back.
MOST_SOLVERS = 64
#: What a QP solver's answer may miss, for rows of norm one and steps of order one, before it counts as wrong.
CREDIBLE = 1e-5


class LevelFailed(HqpError):
    """The named solver gave no usable answer to a level (never leaves this module)."""


@dataclass
class State:
    """Where the cascade stands between two levels.

    x is optimal for the levels done; ``x + Z y`` keeps their equalities; N, low, high are their
    satisfied inequalities, rows of norm one.
    """

    x: Array
    Z: Array
    N: Array
    low: Array
    high: Array


class Cascade:
    """The cascade through one named QP solver; keeps its persistent problems between calls."""

    def __init__(self, solver: str, settings: Settings) -> None:
        self.solver = solver
        self.settings = settings
        self.flat: dict[tuple[int, Sizes], FlatSolver] = {}
        make_flat_solver(solver, Sizes(1, 0, False), settings)  # a missing package shows now, not in the loop

    def reset(self) -> None:
        self.flat.clear()

    def solve(self, hierarchy: Hierarchy, x_ref: Array) -> Answer:
        n = hierarchy.n
        state = State(x_ref.copy(), np.eye(n), np.zeros((0, n)), np.zeros(0), np.zeros(0))
        counts = Counts()
        last = Level.bounds(x_ref, x_ref, indices=np.arange(n), name="min ||x - x_ref||")
        levels = [(level, hierarchy.matrix(k)) for k, level in enumerate(hierarchy.levels)] + [(last, np.eye(n))]
        for k, (level, A) in enumerate(levels):
            try:
                state, counts = self._level(k, level, A, state, counts)
            except LevelFailed as failure:
                label = hierarchy.label(k) if k < len(hierarchy.levels) else last.name
                message = f"{label}: {self.solver} failed ({failure}); x is optimal for the levels above"
                return Answer(state.x, Status.FAILED, message, k, counts)
        return Answer(state.x, counts=counts)

    def _level(self, k: int, level: Level, A: Array, state: State, counts: Counts) -> tuple[State, Counts]:
        """Solve one level from where the levels above left x, then freeze it."""
        rows = LevelRows.of(level, A, state.x, self.settings.tolerance)
        problem = rows.problem(state, self.settings)
        y, pressing = np.zeros(state.Z.shape[1]), np.zeros(len(state.N), dtype=np.int8)
        if self._nothing_to_do(problem):
            counts = replace(counts, levels_met=counts.levels_met + 1)
        else:
            y, pressing, counts = self._solve_level(k, problem, counts)
        return rows.freeze(state, y, pressing, self.settings), counts

    def _nothing_to_do(self, problem: LevelProblem) -> bool:
        """Whether y = 0 is optimal without asking anybody: no slack, no unknown, or no slope where nothing is hard."""
        if not problem.B.size:
            return True
        excess = problem.excess(np.zeros(problem.B.shape[1]))
        excess[np.abs(excess) <= problem.slack] = 0.0
        slope = np.abs(problem.B.T @ excess).max(initial=0.0)
        return bool(slope <= 1e-13 * float(problem.norms @ (np.abs(excess) + problem.slack)))

    def _solve_level(self, k: int, problem: LevelProblem, counts: Counts) -> tuple[Array, Signs, Counts]:
        """The proximal steps of the named solver, then the polish."""
        settings = self.settings
        scale = step_scale(problem)
        qp, sort = flat_qp(problem, scale, settings.proximal_weight)
        nz = problem.B.shape[1]
        solver = self._flat(k, qp.sizes)
        y_prev, result, steps = np.zeros(nz), self._ask(solver, qp), 0
        for steps in range(1, settings.proximal_steps + 1):
            y = result.y[:nz]
            if not result.solved or np.abs(y - y_prev).max() <= settings.qp_tolerance * max(1.0, np.abs(y).max()):
                break
            y_prev, g = y, qp.g.copy()
            g[:nz] -= settings.proximal_weight * y
            better = self._ask(solver, g)
            if not better.solved:
                break
            result = better
        counts = replace(
            counts, qp_solves=counts.qp_solves + 1 + steps, proximal_steps=counts.proximal_steps + steps
        )  # fmt: skip
        usable = bool(np.isfinite(result.y).all())
        y = scale * result.y[:nz] if usable else np.zeros(nz)
        pressing = sort.pressing(problem, y, result, scale)
        credible = (
            usable
            and problem.infeasibility(y) <= CREDIBLE * scale
            and problem.objective(y) <= problem.objective(np.zeros(nz)) + CREDIBLE * (scale * problem.norms.max()) ** 2
        )
        if not credible:
            raise LevelFailed(result.message if not result.solved else "its answer breaks the levels above")
        done = polish(problem, y, pressing, settings.rank_tolerance) if settings.polish else None
        if done is not None:
            counts = replace(counts, polishes=counts.polishes + done.rounds)
            if done.verified or _no_worse(problem, done, y):
                counts = replace(counts, levels_polished=counts.levels_polished + 1)
                y, pressing = done.y, done.pressing
        verified = done is not None and done.verified
        if not (result.solved or verified):
            raise LevelFailed(result.message)
        if not verified:
            pressing = np.zeros_like(pressing)  # too uncertain to freeze a row for good
        return y, pressing, replace(counts, levels_solved=counts.levels_solved + 1)

    def _flat(self, k: int, sizes: Sizes) -> FlatSolver:
        key = (k, sizes)
        if key not in self.flat:
            if len(self.flat) >= MOST_SOLVERS:
                self.flat.pop(next(iter(self.flat)))
            self.flat[key] = make_flat_solver(self.solver, sizes, self.settings)
        return self.flat[key]

    def _ask(self, solver: FlatSolver, load: FlatQP | Array) -> FlatResult:
        try:
            return solver.solve(load) if isinstance(load, FlatQP) else solver.move(load)
        except Exception as error:  # a solver's own exception is an outcome of its level, whatever its type
            raise LevelFailed(f"{type(error).__name__}: {error}") from error


@dataclass(frozen=True, eq=False)
class LevelRows:
    """The rows of a level that say anything, weighted; zero rows and free rows do not."""

    A: Array
    value: Array
    lower: Array
    upper: Array
    norms: Array
    tolerance: Array

    @classmethod
    def of(cls, level: Level, A: Array, x: Array, tolerance: float) -> LevelRows:
        norms = level.weights * np.sqrt(np.einsum("ij,ij->i", A, A))
        says = (norms > 0) & ((level.lower > -np.inf) | (level.upper < np.inf))
        norms, weights = norms[says], level.weights[says]
        rows = weights[:, None] * A[says]
        lower, upper = weights * level.lower[says], weights * level.upper[says]
        value = rows @ x
        return cls(rows, value, lower, upper, norms, _allowed(value, lower, upper, norms, x, tolerance))

    def problem(self, state: State, settings: Settings) -> LevelProblem:
        """The level in y: rows that y cannot move are left out, and the rest scaled by what y can move."""
        moved = self.A @ state.Z
        reach = np.sqrt(np.einsum("ij,ij->i", moved, moved))
        kept = reach > settings.rank_tolerance * self.norms
        unit = 1.0 / reach[kept].max(initial=1e-300)
        place = state.N @ state.x
        low, high = np.minimum(state.low, place), np.maximum(state.high, place)
        margin = _allowed(place, low, high, np.ones(len(place)), state.x, settings.tolerance)
        own = (unit * part[kept] for part in (moved, self.value, self.lower, self.upper, self.norms, self.tolerance))
        return LevelProblem(*own, state.N @ state.Z, place, low, high, margin)

    def freeze(self, state: State, y: Array, pressing: Signs, settings: Settings) -> State:
        """Equalities, violated rows and pressing hard rows shrink Z; satisfied inequalities become hard rows."""
        x = state.x + state.Z @ y
        value = self.A @ x
        slack = value - np.clip(value, self.lower, self.upper)
        allowed = _allowed(value, self.lower, self.upper, self.norms, x, settings.tolerance)
        if not settings.polish:
            allowed = np.maximum(allowed, 1e2 * settings.qp_tolerance * self.norms * (1.0 + np.linalg.norm(x)))
        frozen = (self.lower == self.upper) | (np.abs(slack) > allowed)
        unit = self.A / self.norms[:, None]
        fixed = np.concatenate([unit[frozen], state.N[pressing != 0]])
        _, null = split(fixed @ state.Z, np.ones(len(fixed)), settings.rank_tolerance)
        Z = state.Z @ null

        kept = ~frozen
        N = np.concatenate([state.N[pressing == 0], unit[kept]])
        low = np.concatenate([state.low[pressing == 0], self.lower[kept] / self.norms[kept]])
        high = np.concatenate([state.high[pressing == 0], self.upper[kept] / self.norms[kept]])
        movable = np.sqrt(np.einsum("ij,ij->i", N @ Z, N @ Z)) > settings.rank_tolerance
        return State(x, Z, N[movable], low[movable], high[movable])


@dataclass(frozen=True, eq=False)
class RowSorting:
    """Which hard rows went into the flat QP as rows, and which as bounds of which variable."""

    general: NDArray[np.intp]
    boxed: NDArray[np.intp]
    variable: NDArray[np.intp]
    sign: Array

    def pressing(self, problem: LevelProblem, y: Array, result: FlatResult, scale: float) -> Signs:
        """The hard rows that sit on a bound at y and, by the solver's duals, push there."""
        duals = np.zeros(len(problem.N))
        duals[self.general] = result.row_duals[: len(self.general)]
        duals[self.boxed] = result.box_duals[self.variable] * self.sign if len(self.boxed) else 0.0
        place = problem.place + problem.N @ y
        near = 1e-6 * scale + problem.margin
        signs = np.zeros(len(problem.N), dtype=np.int8)
        signs[(place >= problem.high - near) & (duals > 1e-7)] = 1
        signs[(place <= problem.low + near) & (duals < -1e-7)] = -1
        return signs


def step_scale(problem: LevelProblem) -> float:
    """The length of the step that the level asks for: the unit of y in the flat QP."""
    excess = np.abs(problem.excess(np.zeros(problem.B.shape[1]))) / problem.norms
    return float(excess.max(initial=0.0)) or 1.0


def flat_qp(problem: LevelProblem, scale: float, rho: float) -> tuple[FlatQP, RowSorting]:
    """The level as a QP in (y / scale, w / scale), with y_prev = 0."""
    nz = problem.B.shape[1]
    equal = problem.lower == problem.upper
    pulls, holds = problem.B[equal], problem.B[~equal]
    slacks = len(holds)
    H = np.zeros((nz + slacks, nz + slacks))
    H[:nz, :nz] = pulls.T @ pulls
    H.flat[:: nz + slacks + 1] += np.concatenate([np.full(nz, rho), np.ones(slacks)])
    g = np.zeros(nz + slacks)
    g[:nz] = -pulls.T @ ((problem.lower - problem.value)[equal] / scale)

    sort, box_lower, box_upper = _sort(problem, nz, slacks, scale)
    general = sort.general
    C = np.zeros((len(general) + slacks, nz + slacks))
    C[: len(general), :nz] = problem.N[general]
    C[len(general) :, :nz] = holds
    C[len(general) :, nz:] = -np.eye(slacks)
    lower = np.concatenate([(problem.low - problem.place)[general], (problem.lower - problem.value)[~equal]]) / scale
    upper = np.concatenate([(problem.high - problem.place)[general], (problem.upper - problem.value)[~equal]]) / scale
    return FlatQP(H, g, C, lower, upper, box_lower, box_upper), sort


def _sort(problem: LevelProblem, nz: int, slacks: int, scale: float) -> tuple[RowSorting, Array | None, Array | None]:
    """Hard rows that touch a single y are plain bounds on it; the rest stay rows."""
    single = np.count_nonzero(problem.N, axis=1) == 1
    boxed, general = np.flatnonzero(single), np.flatnonzero(~single)
    variable = np.argmax(problem.N[boxed] != 0, axis=1) if len(boxed) else np.zeros(0, dtype=np.intp)
    entry = problem.N[boxed, variable]
    sort = RowSorting(general, boxed, variable, np.sign(entry))
    if not len(boxed):
        return sort, None, None
    ends = np.stack([problem.low - problem.place, problem.high - problem.place])[:, boxed] / (entry * scale)
    lower, upper = np.full(nz + slacks, -np.inf), np.full(nz + slacks, np.inf)
    np.maximum.at(lower, variable, ends.min(axis=0))
    np.minimum.at(upper, variable, ends.max(axis=0))
    return sort, lower, upper


def _no_worse(problem: LevelProblem, done: Polished, y: Array) -> bool:
    """Whether an unverified polish still beats the QP solver's point at its own level and leaks no more upwards."""
    return problem.infeasibility(done.y) <= problem.infeasibility(y) and problem.objective(done.y) <= problem.objective(y)


def _allowed(value: Array, lower: Array, upper: Array, norms: Array, x: Array, tolerance: float) -> Array:
    """Row tolerances at x, as in :func:`hqp.rows.row_states`."""
    target = np.clip(value, lower, upper)
    length = float(np.linalg.norm(x))
    reach = float((np.abs(value - target) / norms).max(initial=0.0)) if len(norms) else 0.0
    allowed: Array = tolerance * (np.abs(value) + np.abs(target) + norms * length)
    return allowed + ROUND_OFF * norms * max(length, reach)


def make(name: str, settings: Settings) -> Cascade:
    """The cascade through the solver named after the colon."""
    return Cascade(name.partition(":")[2], settings)
