"""One QP per level, through any flat QP solver (Kanoun 2011), with what it takes to be exact.

Level by level, from the highest: the equalities and the violated rows of the levels above are
*eliminated* by an orthonormal basis Z of their null space (passed on as constraints they would make
every next QP just-feasible), their satisfied inequalities stay as rows, their bounds
widened where need be. In the coordinates y of Z the named solver minimises

    1/2 ||D (A (x + Z y) - b)||^2 + 1/2 ||w||^2 + rho/2 ||y - y_prev||^2

with y_prev = 0, which makes rank-deficient levels strictly convex. Then one equality least squares on the
active rows (:mod:`.polish`) takes rho out again, and its answer is checked against the optimality
conditions. If it does not meet them, the solver is called again and again, warm, until y stops moving
(a few proximal steps, which cost no accuracy), and the polish of that is kept only if no level gets worse.
In the end the certificate decides the status of x.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..arrays import Array, length
from ..errors import HqpError
from ..hierarchy import Hierarchy
from ..qp import FlatQP, FlatResult, FlatSolver, Sizes, make_flat_solver
from ..settings import Settings
from ..solution import Counts, Status
from .base import EXACT_ABOVE, Answer, certified, level_name
from .flat import RowSorting, flat_qp, step_scales
from .polish import polish
from .subproblem import LevelProblem, LevelRows, Signs, Standing, State, objective

#: Flat solvers kept for warm starts: sizes change with the active set, and come back.
MOST_SOLVERS = 64
#: What a QP solver's answer may miss, for rows of norm one and steps of order one, before it counts as wrong.
CREDIBLE = 1e-5
#: What an answer that polish could not verify may leak into the levels above, in units of the QP tolerance.
LEAK = 1e2
#: If a solver gives up on a level, it is called again with rho larger by these factors.
RETREAT = (1e3, 1e6)


#: The running :class:`hqp.solution.Counts` of one solve, by the names of its fields.
Tally = defaultdict[str, int]


class LevelFailed(HqpError):
    """The named solver gave no usable answer to a level (never leaves this module)."""


class LevelAnswer(NamedTuple):
    """What the named solver says of a level: its result, the step y, and the hard rows that press against it."""

    result: FlatResult
    y: Array
    pressing: Signs

    @classmethod
    def of(cls, problem: LevelProblem, result: FlatResult, sort: RowSorting, scale: float) -> LevelAnswer:
        """Out of the coordinates of the flat QP."""
        y = scale * result.y[: problem.B.shape[1]]
        return cls(result, y, sort.pressing(problem, y, result, scale))


class Settled(NamedTuple):
    """An answer after the polish: proved optimal for its level, polished, good enough without the proof, or why not."""

    y: Array
    pressing: Signs
    verified: bool = False
    polished: bool = False
    usable: bool = False
    said: str = ""


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
        answer = self._descend(hierarchy, x_ref)
        # Without polish nothing is exact, by choice: then the claim is the named solver's own.
        return certified(answer, hierarchy, x_ref, self.solver) if self.settings.polish else answer

    def _descend(self, hierarchy: Hierarchy, x_ref: Array) -> Answer:
        """Level by level."""
        state, tally = State.start(x_ref.copy()), Tally(int)
        last = len(hierarchy.levels)
        for k, rows in enumerate(LevelRows.of(hierarchy, x_ref)):
            try:
                here = rows.at(state.x, self.settings)
                if (np.abs(here.slack) <= here.tolerance).all():
                    tally["levels_met"] += 1
                    y, pressing = np.zeros(state.Z.shape[1]), np.zeros(len(state.hard), dtype=np.int8)
                else:
                    settled = self._solve_level(k, rows.problem(state, here, self.settings), tally)
                    y, pressing = self._landed(rows, state, here, settled)
                if k == last:
                    return Answer(state.x + state.Z @ y, counts=Counts(**tally))
                state = rows.freeze(state, here, y, pressing, self.settings)
            except (LevelFailed, np.linalg.LinAlgError) as failure:
                message = f"{level_name(hierarchy, k)}: {self.solver} failed ({failure}); {EXACT_ABOVE}"
                return Answer(state.x, Status.FAILED, message, k, Counts(**tally))
            if not state.Z.size:  # nothing is left to move
                tally["levels_met"] += last - k
                return Answer(state.x, counts=Counts(**tally))
        raise AssertionError("the implicit last level always comes last")

    def _solve_level(self, k: int, problem: LevelProblem, tally: Tally) -> Settled:
        """The step y of one level, and the hard rows that press against it."""
        if _nothing_to_do(problem):
            tally["levels_met"] += 1
            return Settled(np.zeros(problem.N.shape[1]), np.zeros(len(problem.N), dtype=np.int8), verified=True)
        said = ""
        scales = step_scales(problem)
        for rho, scale in [(1.0, scale) for scale in scales] + [(rho, scales[0]) for rho in RETREAT]:
            for answer in self._answers(k, problem, rho * self.settings.proximal_weight, scale, tally):
                settled = self._settle(problem, answer, scale, tally)
                if settled.verified:
                    break
            if settled.verified or (settled.usable and rho == 1.0):
                tally["levels_solved"] += 1
                tally["levels_polished"] += settled.polished
                # Without the proof that they press, no rows are frozen for good.
                return settled if settled.verified else settled._replace(pressing=np.zeros_like(settled.pressing))
            said = settled.said
        raise LevelFailed(said)

    def _landed(self, rows: LevelRows, state: State, here: Standing, settled: Settled) -> tuple[Array, Signs]:
        """The step and what presses, polished once more where slacks are round-off to where x was, not to where it is.

        As with a far x_ref: a first-order solver stops so far outside of a bound that ends its step.
        """
        there = rows.at(state.x + state.Z @ settled.y, self.settings)
        finer = np.minimum(here.tolerance, there.tolerance)
        unseen = (np.abs(there.slack) > finer) & (np.abs(there.slack) <= here.tolerance)
        if settled.verified and settled.polished and unseen.any():
            problem = rows.problem(state, here._replace(tolerance=finer), self.settings)
            done = polish(problem, settled.y, settled.pressing, self.settings.rank_tolerance)
            if done.verified:
                return done.y, done.pressing
        return settled.y, settled.pressing

    def _answers(self, k: int, problem: LevelProblem, rho: float, scale: float, tally: Tally) -> Iterator[LevelAnswer]:
        """The named solver's first answer, for the polish to verify, and then that at which y stops moving.

        The first nearly always shows the active rows, which is all that the polish needs. To get to the other,
        the solver is asked again and again, warm from its own last answer: the proximal steps.
        """
        qp, sort = flat_qp(problem, scale, rho)
        nz = problem.B.shape[1]
        solver = self._flat(k, qp.sizes)
        first = result = self._ask(solver, qp, tally)
        y_prev = np.zeros(nz)
        if self.settings.polish:
            yield LevelAnswer.of(problem, result, sort, scale)
        for _ in range(self.settings.proximal_steps):
            y = result.y[:nz]
            if not result.solved or length(y - y_prev) <= self.settings.qp_tolerance * max(1.0, length(y)):
                break
            g = qp.g.copy()
            g[:nz] -= rho * y
            tally["proximal_steps"] += 1
            again = self._ask(solver, g, tally)
            if not again.solved:
                break
            y_prev, result = y, again
        if result is not first or not self.settings.polish:
            yield LevelAnswer.of(problem, result, sort, scale)

    def _settle(self, problem: LevelProblem, answer: LevelAnswer, scale: float, tally: Tally) -> Settled:
        """An answer, polished where that is verified or at least no worse; whether and how far it can be trusted."""
        result, y, pressing = answer
        if not _credible(problem, y, scale):  # the polish could mend it, but then it would be the solver
            return Settled(y, pressing, said="its answer breaks the levels above" if result.solved else result.message)
        polished = False
        if self.settings.polish:
            done = polish(problem, y, pressing, self.settings.rank_tolerance)
            tally["polishes"] += done.rounds
            if done.verified:
                return Settled(done.y, done.pressing, verified=True, polished=True)
            polished = _no_worse(problem, done.y, y)
            if polished:
                y, pressing = done.y, done.pressing
        leak = LEAK * self.settings.qp_tolerance * scale
        usable = result.solved and problem.infeasibility(y) <= leak
        said = "its answer leaks into the levels above" if result.solved else result.message
        return Settled(y, pressing, polished=polished, usable=usable, said=said)

    def _ask(self, solver: FlatSolver, load: FlatQP | Array, tally: Tally) -> FlatResult:
        tally["qp_solves"] += 1
        try:
            return solver.solve(load) if isinstance(load, FlatQP) else solver.move(load)
        except Exception as error:  # an exception of any type in the solver is an outcome of its level
            raise LevelFailed(f"{type(error).__name__}: {error}") from error

    def _flat(self, k: int, sizes: Sizes) -> FlatSolver:
        key = (k, sizes)
        if key not in self.flat:
            if len(self.flat) >= MOST_SOLVERS:
                self.flat.pop(next(iter(self.flat)))
            self.flat[key] = make_flat_solver(self.solver, sizes, self.settings)
        return self.flat[key]


def _nothing_to_do(problem: LevelProblem) -> bool:
    """Whether y = 0 is optimal without a QP: no unknown, or no slope."""
    if not problem.B.size:
        return True
    w = np.where(np.abs(problem.still) > problem.slack, problem.still, 0.0)
    slope = np.abs(problem.B.T @ w).max()
    return bool(slope <= 1e-13 * float(problem.norms @ (np.abs(w) + problem.slack)))


def _credible(problem: LevelProblem, y: Array, scale: float) -> bool:
    """Whether y is finite, keeps the levels above and is not worse than doing nothing, all roughly."""
    if not np.isfinite(y).all():
        return False
    slop = CREDIBLE * scale * float(problem.norms.max())
    enough = objective(problem.still) * (1.0 + CREDIBLE) + slop * slop
    return problem.infeasibility(y) <= CREDIBLE * scale and objective(problem.slacks(y)) <= enough


def _no_worse(problem: LevelProblem, polished: Array, y: Array) -> bool:
    """Whether an unverified polish is lexicographically no worse than y: the levels above first, then this one."""
    problem = problem.reaching(y)
    ranked = [(problem.infeasibility(point), objective(problem.slacks(point))) for point in (polished, y)]
    return ranked[0] <= ranked[1] and ranked[0][1] <= objective(problem.still)


def make(name: str, settings: Settings) -> Cascade:
    """The cascade through the solver named after the colon."""
    return Cascade(name.partition(":")[2], settings)
