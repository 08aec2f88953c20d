r"""Stationarity of one level: whether multipliers of the rows above balance its gradient.

Row i of a level pulls at x with the force :math:`\|a_i\| d_i^2 w_i` along its unit normal. Rows of the levels above
push back: equalities and violated rows either way, rows at a bound only inward. So the free normals are projected
out, and the multipliers of the others follow from a non-negative least squares. Its residual is round-off where x is
optimal, or vanishes when the slacks of the level shift within the tolerances of their rows.
"""

from __future__ import annotations

from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, length, lengths
from ..hierarchy import Side
from .rows import RowStates
from .subspace import RowSpace, row_space

#: Rank decision among normals: the weak choice, so that either answer to a near-singular one passes.
FREE_RANK = 1e-12
#: The same, of what the rows of a level can still move: what a solver may have taken for zero, with a margin.
OWN_RANK = 4e-9
#: Round-off of a sum of forces, relative to the forces.
BALANCED = 64 * float(np.finfo(np.float64).eps)
#: Stationarity asked of a level, relative to the sum of its forces ``||A_i|| d_i^2 |w_i|``, where the slacks of
#: its rows may shift within their tolerances.
STATIONARITY = 1e-10
#: Upper limit of that tolerance, however badly conditioned the rows are that hold the level back.
BLURRED = 1e-6
#: A row that can carry at most this share of the remaining force is ignored.
NEGLIGIBLE = 1e-15
#: A row at a bound whose multiplier is more than this share of the forces in a level holds it back: see :class:`Above`.
HOLDS = 1e-8

#: Sides as the numbers that arrays of them hold.
INSIDE, EITHER_WAY = np.int8(Side.INACTIVE), np.int8(Side.EQUALITY)


class Forces(NamedTuple):
    """One level as forces on x.

    Attributes
    ----------
    units : array, shape (m, n)
        Unit vectors along which the rows pull.
    push : array, shape (m,)
        Force of each row: ``norm_i d_i^2 w_i``, zero if its slack is within its tolerance.
    blur : array, shape (m,)
        The part of that force that the tolerance may hide.
    sides : array of int8
        Side of each row: at a bound it pulls in one direction only, out of what the row allows.
    """

    units: Array
    push: Array
    blur: Array
    sides: NDArray[np.int8]


class Balance(NamedTuple):
    """How the rows above balance one level.

    Attributes
    ----------
    exact
        Whether the remaining force is round-off.
    scale
        The sum of all forces in the level.
    stationarity
        The remaining force, relative to `scale`.
    attempt
        How: what :meth:`Above.multipliers` takes. None where the level is met.
    """

    exact: bool
    scale: float
    stationarity: float
    attempt: _Attempt | None


class _Attempt(NamedTuple):
    """The forces of a level, balanced as well as the rows above it can.

    Attributes
    ----------
    span : RowSpace
        Of the normals of `free`.
    free, pressing : array of int
        Rows that push either way, and that push inward.
    normals, mu : array
        Normals of rows that push inward, less their part in the span; and their multipliers, relative to all forces.
    left : array, shape (n,)
        The force that is not balanced.
    pushed : array, shape (n,)
        The force that the free rows have to balance.
    """

    span: RowSpace
    free: NDArray[np.intp]
    pressing: NDArray[np.intp]
    normals: Array
    mu: Array
    left: Array
    pushed: Array

    @property
    def straight(self) -> bool:
        """Whether almost no force is left."""
        return length(self.left) <= STATIONARITY


class Above:
    """The rows of the levels above one level, as one goes down the levels.

    A row at a bound that *holds* a level, with a positive multiplier, cannot leave its bound without loss for that
    level: for all levels below it is as good as an equality, and may push either way. In exact arithmetic that follows
    from the conditions alone, by adding a large multiple of what balances the level that it holds. In floating point
    the multiple would magnify what round-off, or a rank decision, has left of that balance. So a level that is not
    balanced otherwise is asked once more, rows that hold a level above it being free.

    Parameters
    ----------
    units : array, shape (m, n)
        Unit normals of all rows of the hierarchy.
    rows : RowStates

    Attributes
    ----------
    free : array of int
        Rows above that push either way: equalities and violated rows.
    signed : array of int
        Rows above that push one way, inward: those at a bound.
    """

    def __init__(self, units: Array, rows: RowStates) -> None:
        self._units, self._rows, able = units, rows, rows.norms > 0
        either = (rows.sides == EITHER_WAY) | rows.violated
        self._all_free = np.flatnonzero(able & either)
        self._all_signed = np.flatnonzero(able & ~either & (rows.sides != INSIDE))
        self._holds = np.zeros(len(units), dtype=bool)
        self._span = RowSpace(units.shape[1], FREE_RANK)
        self.free, self.signed = self._all_free[:0], self._all_signed[:0]

    def balance(self, forces: Forces, count: int) -> Balance:
        """Balance the forces of a level by the `count` rows that are above it, no fewer than the last time."""
        if not forces.push.any():  # met: nothing to improve
            return Balance(True, 0.0, 0.0, None)

        known, self.free = len(self.free), self._all_free[: self._all_free.searchsorted(count)]
        self.signed = self._all_signed[: self._all_signed.searchsorted(count)]
        self._span.grow(self._units[self.free[known:]])
        scale = float(np.abs(forces.push).sum())
        gradient = (forces.push / scale) @ forces.units
        attempts = [self._balance(gradient, self._span, self.free, self.signed)]
        holding = self._holds[self.signed]
        if not attempts[0].straight and holding.any():
            free = np.concatenate([self.free, self.signed[holding]])
            span = RowSpace(self._units.shape[1], FREE_RANK)
            span.grow(self._units[free])
            attempts.append(self._balance(gradient, span, free, self.signed[~holding]))
        straight = (one for one in attempts if one.straight)
        blurred = (one for one in attempts if _round_off(one, forces, scale))  # takes most of the time
        found = next(chain(straight, blurred), None)
        exact, best = found is not None, found or attempts[0]
        if exact:
            self._holds[best.pressing[best.mu > HOLDS]] = True
        return Balance(exact, scale, length(best.left), best)

    def _balance(self, gradient: Array, span: RowSpace, free: NDArray[np.intp], signed: NDArray[np.intp]) -> _Attempt:
        """Balance the forces by free rows, with their span, and signed ones."""
        left = span.project(gradient)
        pressing, normals, mu = signed[:0], self._units[:0], np.zeros(0)
        if len(signed) and length(left) > BALANCED:
            outward = self._rows.sides[signed, None] * self._units[signed]
            normals = span.project(outward)
            able = lengths(normals) > FREE_RANK  # the others depend on free ones: what is left of them is round-off
            pressing, normals = signed[able], normals[able]
            mu = _nonnegative(normals, -left)
            left = left + mu @ normals
            gradient = gradient + mu @ outward[able]
        return _Attempt(span, free, pressing, normals, mu, left, gradient)

    def multipliers(self, balance: Balance, count: int) -> Array:
        """The multipliers of all `count` rows above, before any other level is balanced."""
        norms, sides, attempt = self._rows.norms, self._rows.sides, balance.attempt
        multipliers = np.zeros(count)
        if attempt is not None:
            pressing, free = attempt.pressing, attempt.free
            multipliers[pressing] = balance.scale * attempt.mu * sides[pressing] / norms[pressing]
            multipliers[free] = -balance.scale * attempt.span.combine(attempt.pushed) / norms[free]
        return multipliers


def _round_off(attempt: _Attempt, forces: Forces, scale: float) -> bool:
    """Whether the remaining force is the round-off that a perfect x would leave."""
    left, normals, mu, span = attempt.left, attempt.normals, attempt.mu, attempt.span
    pressing, kept, smallest = normals[mu > 0.0], np.zeros((len(left), 0)), 1.0
    if len(pressing):
        sizes = lengths(pressing)
        kept, _, smallest = row_space(pressing / sizes[:, None], FREE_RANK)
        smallest = min(smallest, float(sizes.min()))

    def exact(rest: float) -> bool:
        """Round-off, magnified where the normals that balance the level are nearly dependent."""
        if STATIONARITY < rest <= BLURRED:
            return rest * min(smallest, span.smallest()) <= BALANCED
        return rest <= STATIONARITY

    if exact(length(left)):
        return True
    carriers = forces.sides != INSIDE
    own = span.project(forces.units[carriers])
    # A direction in which the level hardly moves while those rows press may count as none: a rank decision that
    # could go either way.
    moves, _, _ = row_space(own - (own @ kept) @ kept.T, OWN_RANK)
    left = moves @ (moves.T @ left)
    if exact(length(left)):
        return True
    return exact(_carried(left, normals, mu, own, forces.blur[carriers] / scale, forces.sides[carriers]))


def _nonnegative(rows: Array, target: Array) -> Array:
    """The mu >= 0 that minimises ``||rows^T mu - target||``."""
    if not len(rows):
        return np.zeros(0)
    from scipy.optimize import lsq_linear, nnls

    try:
        solution: Array = nnls(rows.T, target)[0]
    except RuntimeError:  # iteration limit: rows that are almost parallel
        solution = lsq_linear(rows.T, target, bounds=(0.0, np.inf), method="bvls", tol=1e-14).x
    return solution


def _carried(left: Array, normals: Array, mu: Array, own: Array, capacity: Array, sides: NDArray[np.int8]) -> float:
    """What remains of `left` when every row of the level may shift its slack within its tolerance.

    A backward error: is the point exact for slacks that round-off cannot tell from its own? A shift moves the balance
    along the row of `own`, by up to its `capacity` either way, at a bound one way; the multipliers may follow.
    """
    from scipy.optimize import lsq_linear

    unit, sizes = length(left) or 1.0, lengths(own)
    # Of a multiplier that may grow, the normal leads away from what is left: then all shifts together have to reach it.
    if (normals @ left >= -BALANCED).all() and capacity @ np.abs(own @ left) < unit * (unit - STATIONARITY):
        return unit
    reach = np.minimum(capacity * sizes / unit, 1e6)
    able = reach > NEGLIGIBLE
    own, sides, sizes, reach = own[able], sides[able], sizes[able], reach[able]
    matrix = np.concatenate([own / sizes[:, None], normals]).T  # directions of length one, whatever the rows are worth
    low = np.concatenate([np.where(sides == Side.UPPER, 0.0, -reach), -mu / unit])
    high = np.concatenate([np.where(sides == Side.LOWER, 0.0, reach), np.full(len(mu), np.inf)])
    target = -left / unit
    try:
        # The shortest shift, in units of what each row can, mostly is within the bounds.
        scales = np.concatenate([reach, np.minimum(mu / unit, 1e6)])
        shift = scales * np.linalg.lstsq(matrix * scales, target, rcond=FREE_RANK)[0]
        if not ((low <= shift) & (shift <= high)).all() or length(matrix @ shift - target) > STATIONARITY / unit:
            shift = lsq_linear(matrix, target, bounds=(low, high), method="bvls", tol=1e-13).x
    except (np.linalg.LinAlgError, ValueError):
        return unit
    return unit * length(matrix @ shift - target)
