"""The rows of a hierarchy at a point x: slacks, sides, and the tolerance of each row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, length
from ..hierarchy import Hierarchy, Side

#: Round-off of A x, relative to the length of the row and the distance T of :func:`travel`.
ROUND_OFF = 256 * np.finfo(np.float64).eps

#: Share of ``||a_i|| ||x||`` in the tolerance of a row.
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
        A :class:`hqp.Side` per row. Rows whose two bounds are closer than the tolerance are equalities.
    violated
        ``|slack| > tolerance``.
    norms
        Euclidean norms of the rows.
    way
        The distance T that x has travelled, see :func:`travel`.
    """

    slack: Array
    tolerance: Array
    sides: NDArray[np.int8]
    violated: NDArray[np.bool_]
    norms: Array
    way: float


def excess(value: Array, lower: Array, upper: Array) -> Array:
    """The slack w of rows: their `value` minus the nearest admissible value.

    Parameters
    ----------
    value : array, shape (m,)
        A x.
    lower, upper : array, shape (m,)
        Bounds of the rows, in the unit of each.
    """
    return value - np.minimum(np.maximum(value, lower), upper)


def allowance(
    value: Array, slack: Array | float, norms: Array | float, size: float, way: float, tolerance: float
) -> Array:
    r"""How far each row may be from its bound and still count as on it.

    With the bound :math:`b_i` nearest to :math:`a_i x`, the tolerance :math:`\tau`, and the distance :math:`T`,

    .. math:: t_i = \tau (|a_i x| + |b_i| + 0.1 \|a_i\| \|x\|) + 256 \varepsilon \|a_i\| T.

    A solver whose answers are to be certified must allow no more: the same with its own, smaller tolerance. If that is
    a tenth of the certificate's, :math:`\tau (|b_i| + \|a_i\| \|x\|) + 256 \varepsilon \|a_i\| T` is small enough.

    Parameters
    ----------
    value, slack, norms : array, shape (m,)
        A x, the slacks w, and the norms of the rows of A; the latter two may be one number for all rows.
    size, way : float
        ``||x||``, and the distance T of :func:`travel`, as far as it is known. ``||x||`` alone does not tell the
        round-off of an x that is a small difference of large numbers.
    tolerance : float
        Relative to the data.

    Returns
    -------
    array, shape (m,)
        The t_i, in the unit of each row.
    """
    flat = tolerance * LENGTH * size + ROUND_OFF * max(size, way)
    return tolerance * (np.abs(value) + np.abs(value - slack)) + flat * norms


def pull(slack: Array, norms: Array, cuts: Sequence[int] = (0,)) -> float:
    r"""The longest step of x that the slacks of any level ask for: :math:`\max |w_i| \|a_i\| / \max \|a_j\|^2`.

    It is relative to the longest row of the level, because a shorter one has little influence on x, however large its
    slack is. Levels of a single row, but for zero rows, do not count: such a row is met, or cannot move x at all.

    Parameters
    ----------
    slack, norms : array, shape (m,)
        Slacks and norms of all rows, both times the weights of the rows.
    cuts : sequence of int
        The first row of each level that has rows.
    """
    if not len(norms):
        return 0.0
    longest = np.maximum.reduceat(norms, cuts)
    steps = np.maximum.reduceat(np.abs(slack) * norms, cuts)
    counts = np.add.reduceat(norms > 0.0, cuts, dtype=np.intp) > 1
    return float(np.divide(steps, longest * longest, out=np.zeros(len(steps)), where=counts).max())


def travel(hierarchy: Hierarchy, x: Array, x_ref: Array, slack: Array, norms: Array) -> float:
    r"""The distance T that x has travelled, to which its round-off is relative.

    A solver starts from zero or from x_ref, and goes where its levels ask. Round-off relative to that distance stays in
    x even if x itself is tiny: if a level that holds the robot still is above a posture, or if the rows lead from a far
    x_ref to zero. So

    .. math:: T = \max\Bigl(\|x\|, \; \|x - x_\text{ref}\|, \;
        \max_{k,\, i \in k} \frac{d_i^2 |w_i| \|a_i\|}{\max_{j \in k} d_j^2 \|a_j\|^2}\Bigr).

    The last term is the step that a level asks for and does not get, see :func:`pull`: an unreachable posture counts
    like an x_ref. What a level does get is part of x. Two kinds of rows are left out, as their slack tells nothing of
    x: those that are alone in their level, and those shorter than the round-off of the longest row of all, which are
    round-off themselves, as the rows of a task in a direction in which nothing moves.
    """
    cuts = [a for a, b in pairwise(hierarchy.pointers) if a < b]
    asking = np.where(norms > ROUND_OFF * norms.max(initial=0.0), hierarchy.weights * slack, 0.0)
    asked = pull(asking, hierarchy.weights * norms, cuts)
    return max(length(x), length(x - x_ref), asked)


def row_states(hierarchy: Hierarchy, x: Array, x_ref: Array, tolerance: float) -> RowStates:
    """Classify every row at x: slack, tolerance, side, and whether it is violated.

    Parameters
    ----------
    hierarchy : Hierarchy
    x, x_ref : array, shape (n,)
        The point, and the reference of the implicit last level.
    tolerance : float
        Relative to the data, see :class:`hqp.Settings`.
    """
    lower, upper = hierarchy.lower, hierarchy.upper
    with np.errstate(all="ignore"):  # a huge x is judged without warnings
        value = hierarchy.product(x)
        slack, norms = excess(value, lower, upper), hierarchy.row_norms()
        way = travel(hierarchy, x, x_ref, slack, norms)
        allowed = allowance(value, slack, norms, length(x), way, tolerance)

    at_upper = value >= upper - allowed
    at_lower = value <= lower + allowed
    sides = np.zeros(hierarchy.m, dtype=np.int8)
    sides[at_upper] = Side.UPPER
    sides[at_lower] = Side.LOWER
    sides[(at_upper & at_lower) | (lower == upper)] = Side.EQUALITY
    return RowStates(slack, allowed, sides, np.abs(slack) > allowed, norms, way)
