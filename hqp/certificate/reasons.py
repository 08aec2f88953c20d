r"""Explains which rows hold each level back, from the multipliers of the certificate, in the words of the labels.

A level k that is not met has the gradient :math:`A_k^T D_k^2 w_k`. If x is optimal, rows of the levels above balance
it: row i with the force :math:`\lambda_i a_i`, and all these forces sum to minus the gradient. These rows are the
causes: each inequality row by itself, the equality rows of one part together. If the forces of the level's own rows
cancel, no row above is needed, and the level contradicts itself. If rows depend on each other, the multipliers are not
unique; those of the certificate are valid ones.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..arrays import Array, length
from ..hierarchy import Hierarchy, Label, Side
from .causes import causes_of
from .certificate import Certificate
from .explanation import LevelExplanation
from .parts import parts_of
from .rows import RowStates

#: Forces that sum to no more than this share of their sum are balanced, as in the certificate.
STATIONARITY = 1e-10


def explain(
    hierarchy: Hierarchy, certificate: Certificate, rows: RowStates, ranks: Iterable[int]
) -> tuple[LevelExplanation, ...]:
    """Explain every level of a hierarchy at a solution.

    Parameters
    ----------
    hierarchy : Hierarchy
    certificate : Certificate
        The certificate of the solution, which has the multipliers.
    rows : RowStates
        The rows at the same x, with the same tolerance.
    ranks : iterable of int
        The rank of every level.
    """
    labels = [hierarchy.label_of(row) for row in range(hierarchy.m)]
    dense, missing = hierarchy.dense(), np.where(rows.violated, -rows.slack, 0.0)
    levels = []
    for k, (level, rank) in enumerate(zip(hierarchy.levels, ranks, strict=True)):
        own, judged = slice(*hierarchy.pointers[k : k + 2]), certificate.levels[k]
        contradicts = _cancels(dense[own], rows.norms[own], level.weights, missing[own], rows.tolerance[own])
        sides, fixing = rows.sides[own], (rows.sides[own] == Side.EQUALITY) | rows.violated[own]
        levels.append(
            LevelExplanation(
                level=k,
                name=level.name,
                proved=judged.ok,
                contradicts=contradicts,
                zero=contradicts and not rows.norms[own][missing[own] != 0.0].any(),
                rank=rank,
                fixing=int(fixing.sum()),
                at_bound=int(((sides != Side.INACTIVE) & ~fixing).sum()),
                parts=parts_of(labels[own], missing[own], level.weights),
                causes=() if contradicts else causes_of(hierarchy, labels, rows, dense, judged.multipliers),
                inner=_inner(dense[own], level.weights**2 * missing[own], labels[own]),
            )
        )
    return tuple(levels)


def _cancels(A: Array, norms: Array, weights: Array, missing: Array, tolerance: Array) -> bool:
    """Whether the forces of the violated rows sum to zero, up to round-off and the tolerances of the rows."""
    if not missing.any():
        return False
    force = norms * weights**2
    blur = length((force * tolerance)[missing != 0.0])
    gradient = length(A.T @ np.where(norms > 0.0, weights**2 * missing, 0.0))
    return gradient <= STATIONARITY * float(force @ np.abs(missing)) + blur


def _inner(A: Array, pull: Array, labels: list[Label]) -> float:
    """How far the forces of the parts of a level cancel: the sum of their norms less the norm of their sum."""
    if not pull.any():
        return 0.0
    parts = np.array([label.part for label in labels])
    pulls = [A[parts == part].T @ pull[parts == part] for part in dict.fromkeys(parts.tolist())]
    lengths = sum(map(length, pulls))
    left = lengths - length(np.sum(pulls, axis=0)) if pulls else 0.0
    return left if left > STATIONARITY * lengths else 0.0
