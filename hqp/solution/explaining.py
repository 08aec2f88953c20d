"""Explanations of levels that were damped: each in its own stage, by the labels of its own rows.

A stage has rows beside those of its level: of damping, and what levels above leave soft. What these push with is no
contradiction among the rows of the level. It is told as damping, and as the parts above that give way no further.
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
from .softening import SMOOTH, direction_in_words, in_words, strongest, unmoved
from .stages import Stages, softened_in, stage_of

#: Where a level gave way, what is missing counts from so much of what its rows ask for on, and from so much in their
#: unit: damping leaves a share of every wish undone, also of one that is round-off.
SHARE, LEAST = 1e-6, 1e-9


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
    """A level with rows of damping, as its stage explains it, without those."""
    h, told = solution.hierarchy, stage.explain(tolerance=tolerance).levels[k]
    level, own = h.levels[k], slice(*h.pointers[k : k + 2])
    labels, gave = [h.label_of(row) for row in range(own.start, own.stop)], k in staged.softened
    missing = np.where(rows.violated[own], -rows.slack[own], 0.0)
    if gave:
        asked = np.where(np.isfinite(level.lower) & np.isfinite(level.upper), np.abs(level.lower), 0.0)
        missing[np.abs(missing) <= SHARE * float(asked.max(initial=0.0)) + LEAST] = 0.0
    lacks = level.weights * missing
    stuck = unmoved(level.weights[:, None] * h.matrix(k), lacks) if gave and missing.any() else np.zeros(len(lacks))
    given_up = np.array([soft.direction @ lacks for soft in softened_in(solution, k)]) if stuck.any() else stuck
    no_way = length(stuck) > length(given_up)  # what nothing moves is not given up for calm
    gave = gave and not no_way
    fixing = (rows.sides[own] == Side.EQUALITY) | rows.violated[own]
    at_bound = (rows.sides[own] != Side.INACTIVE) & ~fixing
    soft = [] if not missing.any() else _soft(h, stage.hierarchy, stage.x, k)
    causes = _joined([*told.causes, *soft]) if missing.any() else []
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
        damped=_why(solution, staged, k, lacks, bool(causes)) if gave and missing.any() else "",
    )


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


def _why(solution: Answer, staged: Stages, k: int, lacks: Array, above: bool) -> str:
    """How a level was damped, or why, and in which direction it gave way most; `above`: whether that has causes too.

    `lacks` is what its rows lack, times their weights.
    """
    if not staged.singular:
        return f"lambda = {staged.dampings[k]:.3g}"
    labels = [solution.hierarchy.label_of(row) for row in range(*solution.hierarchy.pointers[k : k + 2])]
    most = strongest(softened_in(solution, k), lacks)
    return in_words(most, labels, staged.singular) if most is not None else "" if above else SMOOTH


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
