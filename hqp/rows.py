"""Where the rows of a hierarchy stand at a point x: slacks, sides, and how much round-off is forgiven."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .arrays import Array, length
from .hierarchy import Hierarchy
from .side import Side

#: Round-off of A x, in units of the largest length that takes part in it.
ROUND_OFF = 4 * np.finfo(np.float64).eps

#: What a long x may add to the tolerance of a row that it hardly moves.
LENGTH = 1e-1


@dataclass(frozen=True, eq=False)
class RowStates:
    """All rows of a hierarchy at x, arrays of shape (m,).

    Attributes
    ----------
    slack
        Raw ``w = A x - clip(A x, lower, upper)``.
    tolerance
        How far a row may be from a bound and still count as being on it.
    sides
        A :class:`hqp.Side` a row. Rows whose two bounds are closer than the tolerance are equalities.
    violated
        ``|slack| > tolerance``.
    norms
        Euclidean norms of the rows.
    """

    slack: Array
    tolerance: Array
    sides: NDArray[np.int8]
    violated: NDArray[np.bool_]
    norms: Array


def excess(value: Array, lower: Array, upper: Array) -> Array:
    """``value`` minus the nearest admissible value: the slack w of rows whose A x is `value`."""
    return value - np.minimum(np.maximum(value, lower), upper)


def allowance(
    value: Array, slack: Array | float, norms: Array | float, size: float, reach: float, tolerance: float
) -> Array:
    """How far each row may be from its bound and still count as on it.

    `size` is ``||x||``, and `reach` how far the slacks pull, see :func:`pull`: where x is itself the small
    difference of large targets, ||x|| says nothing of the round-off in it.
    """
    flat = tolerance * LENGTH * size + ROUND_OFF * max(size, reach)
    return tolerance * (np.abs(value) + np.abs(value - slack)) + flat * norms


def pull(slack: Array, norms: Array) -> float:
    """How far the slacks of one level, weighted like its norms, would take x, row by row: the largest step.

    A row that is short beside others of its level has little say in x, however far its own bound is away.
    """
    longest = float(norms.max(initial=0.0))
    return float((np.abs(slack) * norms).max(initial=0.0)) / (longest * longest) if longest > 0.0 else 0.0


def row_states(hierarchy: Hierarchy, x: Array, tolerance: float) -> RowStates:
    """Classify every row at x; `tolerance` is relative, see :class:`hqp.Settings`."""
    lower, upper = hierarchy.lower, hierarchy.upper
    with np.errstate(all="ignore"):  # an x out of all bounds is judged, not warned about
        value = hierarchy.product(x)
    slack = excess(value, lower, upper)
    norms = hierarchy.row_norms()
    weights, cuts = hierarchy.weights, hierarchy.pointers
    levels = [slice(*ends) for ends in pairwise(cuts)]
    reach = max((pull(weights[own] * slack[own], weights[own] * norms[own]) for own in levels), default=0.0)
    allowed = allowance(value, slack, norms, length(x), reach, tolerance)

    at_upper = value >= upper - allowed
    at_lower = value <= lower + allowed
    sides = np.zeros(hierarchy.m, dtype=np.int8)
    sides[at_upper] = Side.UPPER
    sides[at_lower] = Side.LOWER
    sides[(at_upper & at_lower) | (lower == upper)] = Side.EQUALITY
    return RowStates(slack, allowed, sides, np.abs(slack) > allowed, norms)
