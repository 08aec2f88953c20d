"""A level as one flat QP, and what the solver's duals say of the rows that went into it.

In the coordinates y of the null space, with one slack a row for the inequality rows of the level,

    min 1/2 ||B_E y - r||^2 + 1/2 ||w||^2 + rho/2 ||y - y_prev||^2
    subject to   lower <= value + B_I y - w <= upper   and   low <= place + N y <= high,

everything divided by the length of the step that the level asks for, so that a solver's absolute
tolerances mean the same at every scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..qp import FlatQP, FlatResult
from .subproblem import LevelProblem, Signs


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


def step_scales(problem: LevelProblem) -> list[float]:
    """Lengths that y may be measured in: what the hard rows leave room for, and what the level asks for.

    A target far beyond a limit asks for a step that the limit does not allow; measured by that step,
    a solver's tolerance would swallow the limit. The other length helps where hard rows leave y free.
    """
    wish = asked(problem) or 1.0
    room = np.abs(np.concatenate([problem.high - problem.place, problem.low - problem.place]))
    longest = float(room[np.isfinite(room)].max(initial=0.0))
    return [longest, wish] if 0.0 < longest < wish else [wish]


def asked(problem: LevelProblem) -> float:
    """The longest step that a row of the level asks for on its own."""
    return float((np.abs(problem.slacks(np.zeros(problem.B.shape[1]))) / problem.norms).max(initial=0.0))


def flat_qp(problem: LevelProblem, scale: float, rho: float) -> tuple[FlatQP, RowSorting]:
    """The level as a QP in (y / scale, w / scale), with y_prev = 0."""
    nz = problem.B.shape[1]
    equal = problem.lower == problem.upper
    pulls, holds = problem.B[equal], problem.B[~equal]
    slacks = len(holds)
    H = np.zeros((nz + slacks, nz + slacks))
    # Where the level asks for far more than the step, its forces and not its curvature are of order one.
    force = max(1.0, asked(problem) / scale)
    H[:nz, :nz] = pulls.T @ pulls / force
    H.flat[:: nz + slacks + 1] += np.concatenate([np.full(nz, rho), np.full(slacks, 1.0 / force)])
    g = np.zeros(nz + slacks)
    g[:nz] = -pulls.T @ ((problem.lower - problem.value)[equal] / (scale * force))

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
