"""Explanations of levels that were damped: each by the problem that explains what it lacks at the x of the answer.

That is the level without damping, below what the levels above reached, wherever it would lack as much: then x is among
its optima, and a row with a multiplier is at its bound at every one of these. Only elsewhere has damping cost
something, and the level is explained in its own stage. That has rows beside those of the level: of damping, and what
levels above leave soft. What these push with is no contradiction among the rows of the level. It is told as damping,
and as the parts above that give way no further. Levels below may have left bounds that stopped it there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import Array, length
from ..certificate import Cause, Explanation, LevelExplanation, RowStates, row_states
from ..certificate.causes import LEAST_SHARE, by_share
from ..certificate.parts import parts_of
from ..hierarchy import Hierarchy, Side
from .answer import Answer
from .level import residual_norm
from .softening import SMOOTH, direction_in_words, in_words, strongest, unmoved
from .stages import Stages, softened_in, stage_of, undamped

#: Where a level gave way, what is missing counts from so much of what its rows ask for on, and from so much in their
#: unit: damping leaves a share of every wish undone, also of one that is round-off.
SHARE, LEAST = 1e-6, 1e-9
#: It also counts only from so much of ||a_i|| ||x|| on, how fast x could move the row: a level whose rows stand still
#: that well beside the motion is held, not short, and a bound that is as near is not left.
STILL = 1e-5
#: A level that lacks more than without damping by at most this share has lost nothing by it.
COST = 1e-3


def explained(solution: Answer, staged: Stages, tolerance: float) -> Explanation:
    """Every level in the stage that decided it; what it lacks, at the x of the answer."""
    levels = list(staged.solutions[-1].explain(tolerance=tolerance).levels)
    with np.errstate(all="ignore"):  # an x out of all bounds is judged, not warned about
        rows = row_states(solution.hierarchy, solution.x, solution.x_ref, tolerance)
    for k in range(len(levels)):
        stage = stage_of(solution, k)
        if stage is not None:
            levels[k] = _own(solution, staged, rows, stage, k, tolerance)
    return Explanation(tuple(levels), solution.message)


def _own(
    solution: Answer, staged: Stages, rows: RowStates, stage: Answer, k: int, tolerance: float
) -> LevelExplanation:
    """A level with rows of damping, without those."""
    h, told = solution.hierarchy, stage.explain(tolerance=tolerance).levels[k]
    level, own = h.levels[k], slice(*h.pointers[k : k + 2])
    labels, gave = [h.label_of(row) for row in range(own.start, own.stop)], k in staged.softened
    missing = np.where(rows.violated[own], -rows.slack[own], 0.0)
    if gave:
        asked = np.where(np.isfinite(level.lower) & np.isfinite(level.upper), np.abs(level.lower), 0.0)
        still = STILL * rows.norms[own] * length(solution.x)
        missing[np.abs(missing) <= np.maximum(still, SHARE * float(asked.max(initial=0.0)) + LEAST)] = 0.0
    lacks = level.weights * missing
    stuck = unmoved(level.weights[:, None] * h.matrix(k), lacks) if gave and missing.any() else np.zeros(len(lacks))
    given_up = np.array([soft.direction @ lacks for soft in softened_in(solution, k)]) if stuck.any() else stuck
    no_way = length(stuck) > length(given_up)  # what nothing moves is not given up for calm
    strict = _without(solution, staged, rows, k, tolerance) if missing.any() else None
    told = told if strict is None else replace(strict, proved=told.proved and strict.proved)
    gave = gave and not no_way and strict is None
    fixing = (rows.sides[own] == Side.EQUALITY) | rows.violated[own]
    at_bound = (rows.sides[own] != Side.INACTIVE) & ~fixing
    soft = _soft(h, stage.hierarchy, stage.x, k) if missing.any() and strict is None else []
    causes = _joined([*told.causes, *soft]) if missing.any() else []
    causes = [replace(cause, left=_left(solution, cause, rows)) for cause in causes]
    total = sum(cause.strength for cause in causes)
    return replace(
        told,
        parts=parts_of(labels, missing, level.weights),
        causes=by_share(replace(cause, share=cause.strength / total) for cause in causes),
        contradicts=no_way or (told.contradicts and not gave and not soft),
        unmoved=direction_in_words(stuck / length(stuck), labels) if no_way else "",
        rank=solution.levels[k].rank,
        fixing=int(fixing.sum()),
        at_bound=int(at_bound.sum()),
        inner=0.0 if gave or soft else told.inner,
        damped=_why(solution, staged, k, lacks) if gave and missing.any() else "",
    )


def _without(solution: Answer, staged: Stages, rows: RowStates, k: int, tolerance: float) -> LevelExplanation | None:
    """Level k without damping, below what the damped levels above reached at x; None if x is none of its optima."""
    h, strict = solution.hierarchy, staged.solve(undamped(solution, staged, rows, k), solution.x_ref)
    lacked, least = residual_norm(h, k, solution.x), residual_norm(h, k, strict.x)
    if not strict.ok or abs(lacked - least) > COST * lacked:
        return None
    told = strict.explain(tolerance=tolerance).levels[k]
    return None if any(_left(solution, cause, rows) for cause in told.causes) else told


def _left(solution: Answer, cause: Cause, rows: RowStates) -> bool:
    """Whether x is at the bound of none of the rows of a cause, all inequalities, by more than counts as still."""
    if cause.side not in (Side.LOWER, Side.UPPER):
        return False
    h, own = solution.hierarchy, list(cause.rows)
    value = h.product(solution.x)[own]
    room = value - h.lower[own] if cause.side is Side.LOWER else h.upper[own] - value
    near = np.maximum(rows.tolerance[own], STILL * rows.norms[own] * length(solution.x))
    return bool((room > near).all())


def _joined(causes: list[Cause]) -> list[Cause]:
    """Those of one name as one: what a part holds, and what it pushes with where it is soft."""
    found: dict[tuple[int, str, str, Side], Cause] = {}
    for cause in causes:
        name = cause.level, cause.part, cause.row, cause.side
        other = found.get(name)
        if other is not None:
            force, rows = other.force + cause.force, tuple(sorted({*other.rows, *cause.rows}))
            cause = replace(other, force=force, strength=length(force), rows=rows)
        found[name] = cause
    return list(found.values())


def _why(solution: Answer, staged: Stages, k: int, lacks: Array) -> str:
    """How a level was damped, or why, and in which direction it gave way most; its rows lack `lacks`, weighted."""
    if not staged.singular:
        return f"lambda = {staged.dampings[k]:.3g}"
    labels = [solution.hierarchy.label_of(row) for row in range(*solution.hierarchy.pointers[k : k + 2])]
    most = strongest(softened_in(solution, k), lacks)
    return in_words(most, labels, staged.singular) if most is not None else SMOOTH


def _soft(given: Hierarchy, stage: Hierarchy, x: Array, k: int) -> list[Cause]:
    """The forces of the softened levels above in the stage of level k: each level separately."""
    level, A, found = stage.levels[k], stage.matrix(k), list[Cause]()
    end, first = len(level) - given.n, len(given.levels[k])
    for j in range(k - 1, -1, -1):
        own, end = slice(end - len(given.levels[j]), end), end - len(given.levels[j])
        if end < first:
            break
        slack = A[own] @ x - np.clip(A[own] @ x, level.lower[own], level.upper[own])
        force = A[own].T @ (level.weights[own] ** 2 * slack)
        parts = dict.fromkeys(given.label_of(row).part for row in range(*given.pointers[j : j + 2]))
        if length(force) > 0.0:
            rows = tuple(range(*given.pointers[j : j + 2]))
            found.append(Cause(j, " and ".join(parts), "", Side.EQUALITY, rows, force, length(force), 0.0))
    most = max((cause.strength for cause in found), default=0.0)
    return [cause for cause in found if cause.strength > LEAST_SHARE * most]
