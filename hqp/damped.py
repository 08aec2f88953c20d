r"""One damped level as plain ones: with the rows of damping joined to it, and frozen at what it reached.

All functions take the levels down to the damped one, which is the last of them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .arrays import Array
from .errors import InvalidInput
from .hierarchy import Hierarchy
from .level import Level
from .rows import row_states
from .settings import Settings
from .side import Side
from .subspace import split


def project(levels: Hierarchy, x: Array, settings: Settings) -> tuple[Array, NDArray[np.bool_]]:
    """The rows of the last level that are active at x, weighted, in the null space of those above.

    Returns
    -------
    J : array, shape (rows, unknowns left)
    own : array of bool, shape (m_k,)
        Which rows of the level these are.
    """
    states, first = row_states(levels, x, tolerance(settings)), levels.pointers[-2]
    rows, active = levels.dense(), (states.sides != Side.INACTIVE) & (states.norms > 0)
    above, own = active[:first], active[first:]
    _, null_space = split(rows[:first][above], states.norms[:first][above], settings.rank_tolerance)
    J: Array = levels.weights[first:][own, None] * rows[first:][own] @ null_space
    return J, own


def left_singular(J: Array) -> tuple[Array, Array]:
    """Left singular vectors, and as many singular values as there are rows, largest first."""
    vectors, singular, _ = np.linalg.svd(J)
    return vectors, np.pad(singular, (0, len(J) - len(singular)))


def damped(levels: Hierarchy, damping: float, x_ref: Array) -> Level:
    """The last level with the rows of damping, ``x = x_ref`` of weight lambda, joined to it."""
    level = levels.levels[-1]
    return _joined(_rows(levels), level.lower, level.upper, level.weights, damping, x_ref, level.name)


def filtered(
    levels: Hierarchy, own: NDArray[np.bool_], u: Array, damping: float, filtering: float, x_ref: Array
) -> Level:
    r"""The last level, of equality rows `own`, damped, and the combination u of its rows weakened.

    :math:`J^T (J J^T + \lambda^2 I + \beta^2 u u^T)^{-1} r` minimises :math:`\|F (J x - r)\|^2 + \lambda^2 \|x\|^2`
    for :math:`F = \lambda (\lambda^2 I + \beta^2 u u^T)^{-1/2} = I - (1 - \lambda / \sqrt{\lambda^2 + \beta^2}) u u^T`.
    """
    level = levels.levels[-1]
    F = np.eye(len(u)) - (1.0 - damping / math.hypot(damping, filtering)) * np.outer(u, u)
    rows = F * level.weights[own]
    b = rows @ level.lower[own]
    return _joined(rows @ _rows(levels)[own], b, b, np.ones(len(b)), damping, x_ref, level.name)


def _joined(A: Array, lower: Array, upper: Array, weights: Array, damping: float, x_ref: Array, name: str) -> Level:
    n = len(x_ref)
    return Level(
        np.concatenate([A, np.eye(n)]),
        np.concatenate([lower, x_ref]),
        np.concatenate([upper, x_ref]),
        weights=np.concatenate([weights, np.full(n, damping)]),
        name=name,
    )


def frozen(levels: Hierarchy, x: Array, settings: Settings) -> tuple[Array, Array]:
    """Bounds of the last level that hold its equality and violated rows where they are at x, and no others."""
    level, first = levels.levels[-1], levels.pointers[-2]
    states = row_states(levels, x, tolerance(settings))
    held = (states.sides[first:] == Side.EQUALITY) | states.violated[first:]
    reached = _rows(levels) @ x
    return np.where(held, reached, level.lower), np.where(held, reached, level.upper)


def tolerance(settings: Settings) -> float:
    """By which rows count as satisfied or active: as `levels` of a solution tells it."""
    return 10 * settings.tolerance


def has_inequalities(levels: Hierarchy) -> bool:
    """Whether it matters to the active rows where x is."""
    return bool(_inequalities(levels.lower, levels.upper).any())


def refuse_inequalities(levels: Hierarchy) -> None:
    """Raise InvalidInput at the first row of the last level that is an inequality."""
    level = levels.levels[-1]
    wrong = _inequalities(level.lower, level.upper)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise InvalidInput(
            f"{levels.label(len(levels.levels) - 1)}, row {row} is an inequality"
            f" ({level.lower[row]:g} <= A x <= {level.upper[row]:g}); numerical filtering takes equality rows only"
        )


def _rows(levels: Hierarchy) -> Array:
    return levels.matrix(len(levels.levels) - 1)


def _inequalities(lower: Array, upper: Array) -> NDArray[np.bool_]:
    """Rows that are neither equalities nor free."""
    wanted: NDArray[np.bool_] = (lower != upper) & (np.isfinite(lower) | np.isfinite(upper))
    return wanted
