"""The stages of a solution with damped levels: the stages, how they relaxed strictness, and what they prove."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from ..arrays import Array, length
from ..certificate import Certificate, Handed, RowStates, left_alone, row_states
from ..hierarchy import Hierarchy, Side
from .answer import Answer
from .level import residual_norm
from .relaxation import Relaxation
from .softening import Softened, softened


@dataclass(frozen=True, eq=False)
class Stages:
    """The stages of a solve with damped levels, see :mod:`hqp.damping.staged` and :mod:`hqp.solver.curved`.

    Attributes
    ----------
    solutions : tuple of Solution
        The plain hierarchies that were solved, in order; the last one gave x. Where its status is not
        OPTIMAL, those that should have come after it are missing.
    dampings : dict of int to float
        The lambda of every damped level that was reached; 0 where it was left strict.
    aims : dict of int to array
        What every damped level is damped towards; see :mod:`hqp.damping.staged`.
    solve : callable
        Solves a plain hierarchy, given x_ref.
    reached : dict of int to array
        The x at the end of the stage of a level, for levels that those below may move a little.
    singular : str
        Text in explanations for a direction in which x hardly moves a level; empty if a rule has chosen lambda.
    softened : tuple of int
        The levels that were softened.
    handed : tuple of Handed
        The rows of softened levels that hold against those below, if they are not in the last stage.
    """

    solutions: tuple[Any, ...]  # of Solution, which is made of this
    dampings: dict[int, float]
    aims: dict[int, Array]
    solve: Callable[[Hierarchy, Array], Answer]
    reached: dict[int, Array] = field(default_factory=dict)
    singular: str = ""
    softened: tuple[int, ...] = ()
    handed: tuple[Handed, ...] = ()


def relaxations(solution: Answer, staged: Stages) -> tuple[Relaxation, ...]:
    """One entry for each damped level, highest first."""
    h, names = solution.hierarchy, [level.name for level in solution.hierarchy.levels]
    return tuple(
        Relaxation(
            k,
            names[k],
            damping,
            staged.aims[k],
            residual_norm(h, k, solution.x),
            _moved(solution, staged, k),
            partial(_strict_norm, solution, staged, k),
            partial(softened_in, solution, k),
        )
        for k, damping in staged.dampings.items()
    )


def _moved(solution: Answer, staged: Stages, k: int) -> float:
    """How far the levels below k have moved its rows."""
    reached, level = staged.reached.get(k), solution.hierarchy.levels[k]
    moved = 0.0 if reached is None else solution.x - reached
    return 0.0 if reached is None else length(level.weights * (solution.hierarchy.matrix(k) @ moved))


def undamped(solution: Answer, staged: Stages, rows: RowStates, k: int) -> Hierarchy:
    """The levels down to k as they were given, those above it that are damped held at what they reached at x."""
    h = solution.hierarchy.copy()
    reached = h.product(solution.x)
    for j in (j for j in staged.dampings if j < k):
        own, level = slice(*h.pointers[j : j + 2]), h.levels[j]
        held = (rows.sides[own] == Side.EQUALITY) | rows.violated[own]
        level.lower[held] = level.upper[held] = reached[own][held]
    return Hierarchy(h.levels[: k + 1], n=h.n)


def _strict_norm(solution: Answer, staged: Stages, k: int) -> float:
    """The residual norm of level k without its damping, below what the levels above it reached."""
    h = solution.hierarchy
    if stage_of(solution, k) is None:  # nothing beside its own rows
        return residual_norm(h, k, solution.x)
    rows = row_states(h, solution.x, solution.x_ref, solution.settings.tolerance)
    return residual_norm(h, k, staged.solve(undamped(solution, staged, rows, k), solution.x_ref).x)


def stage_of(solution: Answer, k: int) -> Answer | None:
    """The stage in which level k has rows of damping beside its own."""
    own = len(solution.hierarchy.levels[k])
    stages = (stage for stage in solution.stages if len(stage.hierarchy.levels) == k + 1)
    return next((stage for stage in stages if len(stage.hierarchy.levels[k]) > own), None)


def softened_in(solution: Answer, k: int) -> tuple[Softened, ...]:
    """The directions in which level k was softened, by its stage."""
    stage = stage_of(solution, k)
    return () if stage is None else softened(stage.hierarchy, len(solution.hierarchy.levels[k]))


def proof(solution: Answer, staged: Stages, unique: bool, tolerance: float) -> Certificate:
    """The proof that every stage is optimal, and that levels below did not move the rows held above."""
    stages: Sequence[Answer] = staged.solutions
    *earlier, last = (stage.certify(unique=unique, tolerance=tolerance) for stage in stages)
    names = [level.name for level in solution.hierarchy.levels]
    handed = [left_alone(of, names[of.level], solution.x, tolerance) for of in staged.handed]
    return replace(last, earlier=tuple(earlier), softened=staged.softened, handed=tuple(handed))
