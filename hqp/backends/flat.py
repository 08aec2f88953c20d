"""A level as one flat QP, and the active rows from the duals of the solver.

In the coordinates y of the null space, with one slack a row for the inequality rows of the level,

    min 1/2 ||B_E y - r||^2 + 1/2 ||w||^2 + rho/2 ||y - y_prev||^2
    subject to   lower <= B_I y - w <= upper   and   low <= N y <= high,

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
        signs = np.zeros(len(problem.N), dtype=np.int8)
        if not len(signs):
            return signs
        duals = np.zeros(len(signs))
        duals[self.general] = result.row_duals[: len(self.general)]
        duals[self.boxed] = result.box_duals[self.variable] * self.sign if len(self.boxed) else 0.0
        place = problem.N @ y
        near = 1e-6 * scale + problem.margin
        signs[(place >= problem.high - near) & (duals > 1e-7)] = 1
        signs[(place <= problem.low + near) & (duals < -1e-7)] = -1
        return signs


def step_scales(problem: LevelProblem) -> list[float]:
    """Lengths that y may be measured in: what the hard rows leave room for, and what the level asks for.

    A target far beyond a limit asks for a step that the limit does not allow; measured by that step,
    a solver's tolerance would swallow the limit. The other length helps where hard rows leave y free.
    """
    wish = problem.asked or 1.0
    if not len(problem.N):
        return [wish]
    room = np.concatenate([problem.high, -problem.low])
    longest = float(room[np.isfinite(room)].max(initial=0.0))
    return [longest, wish] if 0.0 < longest < wish else [wish]


def flat_qp(problem: LevelProblem, scale: float, rho: float) -> tuple[FlatQP, RowSorting]:
    """The level as a QP in (y / scale, w / scale), with y_prev = 0."""
    nz = problem.B.shape[1]
    equality, between = problem.equality, ~problem.equality
    pulls, holds = (problem.B, problem.B[:0]) if problem.equations else (problem.B[equality], problem.B[between])
    slacks = len(holds)
    size = nz + slacks
    # Where the level asks for far more than the step, its forces and not its curvature are of order one.
    force = max(1.0, problem.asked / scale)
    H = np.zeros((size, size))
    H[:nz, :nz] = pulls.T @ pulls / force
    diagonal = H.reshape(-1)[:: size + 1]
    diagonal[:nz] += rho
    diagonal[nz:] = 1.0 / force
    g = np.zeros(size)
    g[:nz] = -pulls.T @ (problem.lower[equality] / (scale * force))

    sort, box_lower, box_upper = _sort(problem, size, scale)
    general = sort.general
    C = np.zeros((len(general) + slacks, size))
    C[: len(general), :nz] = problem.N[general]
    C[len(general) :, :nz] = holds
    C[len(general) :, nz:] = -np.eye(slacks)
    lower = np.concatenate([problem.low[general], problem.lower[between]]) / scale
    upper = np.concatenate([problem.high[general], problem.upper[between]]) / scale
    return FlatQP(H, g, C, lower, upper, box_lower, box_upper), sort


def _sort(problem: LevelProblem, size: int, scale: float) -> tuple[RowSorting, Array | None, Array | None]:
    """Hard rows that touch a single y are plain bounds on it; the rest stay rows."""
    if not len(problem.N):
        none = np.zeros(0, dtype=np.intp)
        return RowSorting(none, none, none, np.zeros(0)), None, None
    touches = problem.N != 0
    single = touches.sum(axis=1) == 1
    boxed, general = single.nonzero()[0], (~single).nonzero()[0]
    variable = touches[boxed].argmax(axis=1)
    entry = problem.N[boxed, variable]
    sort = RowSorting(general, boxed, variable, np.sign(entry))
    if not len(boxed):
        return sort, None, None
    ends = problem.low[boxed] / (entry * scale), problem.high[boxed] / (entry * scale)
    lower, upper = np.full(size, -np.inf), np.full(size, np.inf)
    np.maximum.at(lower, variable, np.minimum(*ends))
    np.minimum.at(upper, variable, np.maximum(*ends))
    return sort, lower, upper
