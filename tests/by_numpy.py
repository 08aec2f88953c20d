r"""The certificate once more, by singular values and least squares of SciPy: what the compiled one is held to.

Stationarity of one level: whether multipliers of the rows above balance its gradient.

Row i of a level acts on x with the force :math:`\|a_i\| d_i^2 w_i` along its unit normal. Rows of the levels above act
against it: equalities and violated rows with a multiplier of either sign (*free* rows), rows at a bound with one sign
only (*signed* rows). So the free normals are projected out, and the multipliers of the signed rows follow from a
non-negative least squares. If x is optimal, its residual is round-off, or it vanishes when the slacks of the level
shift within the tolerances of their rows.
"""

from __future__ import annotations

from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hqp import Hierarchy
from hqp.arrays import Array, length, lengths
from hqp.certificate import RowStates, row_space, row_states
from hqp.certificate.rows import ROUND_OFF
from hqp.hierarchy import Side

#: Rank tolerance of the free normals. It is small, so that an answer passes however its solver decided a doubtful rank.
FREE_RANK = 1e-12
#: Rank tolerance of the rows of the level itself, projected onto the null space of the free normals: the largest that a
#: solver may have used, with a margin.
OWN_RANK = 4e-9
#: Round-off of a sum of forces, relative to the forces.
BALANCED = 256 * float(np.finfo(np.float64).eps)
#: Largest residual of a level that passes, relative to the sum of its forces ``||A_i|| d_i^2 |w_i|``, after the slacks
#: of its rows were shifted within their tolerances.
STATIONARITY = 1e-10
#: Upper limit of that tolerance if the rows that hold the level back are badly conditioned.
BLURRED = 1e-6
#: A row whose tolerance can balance at most this share of the residual is ignored.
NEGLIGIBLE = 1e-15
#: A row at a bound *holds* a level if its multiplier is more than this share of the forces, see :class:`Above`.
HOLDS = 1e-8

#: The sides INACTIVE and EQUALITY, as entries of arrays.
INSIDE, EITHER_WAY = np.int8(Side.INACTIVE), np.int8(Side.EQUALITY)


class RowSpace:
    """The span of rows, each divided by its length."""

    def __init__(self, n: int, tolerance: float) -> None:
        self._tolerance, self.rows, self.basis = tolerance, np.zeros((0, n)), np.zeros((n, 0))

    def grow(self, units: Array) -> None:
        self.rows = np.concatenate([self.rows, units])
        self.basis, _, self._smallest = row_space(self.rows, self._tolerance)

    def project(self, vectors: Array) -> Array:
        """Onto the orthogonal complement."""
        return vectors - (vectors @ self.basis) @ self.basis.T

    def smallest(self) -> float:
        return self._smallest

    def combine(self, vector: Array) -> Array:
        """The shortest combination of the rows that is nearest to a vector."""
        if not len(self.rows):
            return np.zeros(0)
        return np.linalg.lstsq(self.rows.T, vector, rcond=self._tolerance)[0]


class Forces(NamedTuple):
    """One level as forces on x.

    Attributes
    ----------
    units : array, shape (m, n)
        Unit normals of the rows.
    push : array, shape (m,)
        Force of each row: ``norm_i d_i^2 w_i``, zero if its slack is within its tolerance.
    blur : array, shape (m,)
        How much that force could change with a slack within the tolerance.
    sides : array of int8, shape (m,)
        Side of each row. The force of an inequality at a bound can only change in the direction of that bound.
    """

    units: Array
    push: Array
    blur: Array
    sides: NDArray[np.int8]


class Balance(NamedTuple):
    """How the rows above balance one level.

    Attributes
    ----------
    exact : bool
        Whether the residual force is round-off.
    scale : float
        The sum of all forces in the level.
    stationarity : float
        Norm of the residual force, relative to `scale`.
    attempt : _Attempt or None
        How the forces were balanced, for :meth:`Above.multipliers`; None where the level is met.
    """

    exact: bool
    scale: float
    stationarity: float
    attempt: _Attempt | None


class _Attempt(NamedTuple):
    """The forces of a level, balanced as far as the rows above can. All forces are relative to their sum.

    Attributes
    ----------
    span : RowSpace
        Span of the normals of `free`.
    free, pressing : array of int
        Free rows, and those signed rows that do not depend on them.
    normals : array, shape (pressing, n)
        Outward normals of `pressing`, projected onto the orthogonal complement of the span.
    mu : array, shape (pressing,)
        Multipliers of `pressing`, not negative.
    left : array, shape (n,)
        The residual force.
    pushed : array, shape (n,)
        The force that the free rows have to balance: gradient plus the forces of `pressing`.
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
        """Whether the residual force is within STATIONARITY."""
        return length(self.left) <= STATIONARITY


class Above:
    """The rows of the levels above the level at hand, and how they balance it, from the highest level down.

    A row at a bound that *holds* a level, with a positive multiplier, cannot leave its bound without making that level
    worse. So for all levels below it acts as an equality: its multiplier may have either sign. In exact arithmetic this
    follows from the optimality conditions: one can add a large multiple of the balance of the level that the row holds.
    In floating point that multiple would magnify round-off and rank errors of the balance. So a level that is not
    balanced otherwise is tried once more, with the rows that hold a level above as free rows.

    Parameters
    ----------
    units : array, shape (m, n)
        Unit normals of all rows of the hierarchy.
    rows : RowStates

    Attributes
    ----------
    free : array of int
        Rows above whose multipliers may have either sign: equalities and violated rows.
    signed : array of int
        Rows above whose multipliers have one sign: inequalities at a bound.
    """

    def __init__(self, units: Array, rows: RowStates) -> None:
        self._units, self._rows, able = units, rows, rows.norms > 0
        either = (rows.sides == EITHER_WAY) | rows.violated
        self._all_free = np.flatnonzero(able & either)
        self._all_signed = np.flatnonzero(able & ~either & (rows.sides != INSIDE))
        self._holds = np.zeros(len(units), dtype=bool)
        self.free, self.signed = self._all_free[:0], self._all_signed[:0]

    def balance(self, forces: Forces, count: int) -> Balance:
        """Balance the forces of a level by the `count` rows above it; `count` must not fall between calls."""
        if not forces.push.any():  # met: nothing to improve
            return Balance(True, 0.0, 0.0, None)

        self.free = self._all_free[: self._all_free.searchsorted(count)]
        self.signed = self._all_signed[: self._all_signed.searchsorted(count)]
        span = RowSpace(self._units.shape[1], FREE_RANK)
        span.grow(self._units[self.free])
        scale = float(np.abs(forces.push).sum())
        gradient = (forces.push / scale) @ forces.units
        attempts = [self._balance(gradient, span, self.free, self.signed)]
        holding = self._holds[self.signed]
        if not attempts[0].straight and holding.any():
            free = np.concatenate([self.free, self.signed[holding]])
            span = RowSpace(self._units.shape[1], FREE_RANK)
            span.grow(self._units[free])
            attempts.append(self._balance(gradient, span, free, self.signed[~holding]))
        straight = (one for one in attempts if one.straight)
        blurred = (one for one in attempts if _round_off(one, forces, scale))  # the slow test, so it comes second
        found = next(chain(straight, blurred), None)
        exact, best = found is not None, found or attempts[0]
        if exact:
            self._holds[best.pressing[best.mu > HOLDS]] = True
        return Balance(exact, scale, length(best.left), best)

    def _balance(self, gradient: Array, span: RowSpace, free: NDArray[np.intp], signed: NDArray[np.intp]) -> _Attempt:
        """Balance the gradient, relative to the sum of forces, by free rows, with their span, and by signed rows."""
        left = span.project(gradient)
        pressing, normals, mu = signed[:0], self._units[:0], np.zeros(0)
        if len(signed) and length(left) > BALANCED:
            outward = self._rows.sides[signed, None] * self._units[signed]
            normals = span.project(outward)
            able = lengths(normals) > FREE_RANK  # the others depend on free rows: their remainder is round-off
            pressing, normals = signed[able], normals[able]
            mu = _nonnegative(normals, -left)
            left = left + mu @ normals
            gradient = gradient + mu @ outward[able]
        return _Attempt(span, free, pressing, normals, mu, left, gradient)

    def multipliers(self, balance: Balance, count: int) -> Array:
        """The multipliers of all `count` rows above, of a level that was balanced."""
        norms, sides, attempt = self._rows.norms, self._rows.sides, balance.attempt
        multipliers = np.zeros(count)
        if attempt is not None:
            pressing, free = attempt.pressing, attempt.free
            multipliers[pressing] = balance.scale * attempt.mu * sides[pressing] / norms[pressing]
            multipliers[free] = -balance.scale * attempt.span.combine(attempt.pushed) / norms[free]
        return multipliers


def _round_off(attempt: _Attempt, forces: Forces, scale: float) -> bool:
    """Whether the residual force is round-off: an exact x could leave as much."""
    left, normals, mu, span = attempt.left, attempt.normals, attempt.mu, attempt.span
    pressing, kept, smallest = normals[mu > 0.0], np.zeros((len(left), 0)), 1.0
    if len(pressing):
        sizes = lengths(pressing)
        kept, _, smallest = row_space(pressing / sizes[:, None], FREE_RANK)
        smallest = min(smallest, float(sizes.min()))

    def exact(rest: float) -> bool:
        """Whether a residual is round-off, which nearly dependent normals magnify by one over their singular value."""
        if STATIONARITY < rest <= BLURRED:
            return rest * min(smallest, span.smallest()) <= BALANCED
        return rest <= STATIONARITY

    if exact(length(left)):
        return True
    carriers = forces.sides != INSIDE
    own = span.project(forces.units[carriers])
    # Only the residual in directions in which the rows of the level can still move counts. Directions in which they
    # hardly can are left out: a solver may have decided that rank either way.
    moves, _, _ = row_space(own - (own @ kept) @ kept.T, OWN_RANK)
    left = moves @ (moves.T @ left)
    if exact(length(left)):
        return True
    return exact(_carried(left, normals, mu, own, forces.blur[carriers] / scale, forces.sides[carriers]))


def _nonnegative(rows: Array, target: Array) -> Array:
    """The mu >= 0, shape (m,), that minimises ``||rows^T mu - target||``, for rows (m, n)."""
    if not len(rows):
        return np.zeros(0)
    from scipy.optimize import lsq_linear, nnls

    try:
        solution: Array = nnls(rows.T, target)[0]
    except RuntimeError:  # iteration limit: rows that are almost parallel
        solution = lsq_linear(rows.T, target, bounds=(0.0, np.inf), method="bvls", tol=1e-14).x
    return solution


def _carried(left: Array, normals: Array, mu: Array, own: Array, capacity: Array, sides: NDArray[np.int8]) -> float:
    """The norm of the residual force `left` if every slack of the level may shift within the tolerance of its row.

    This is a backward error: is the point exact for slacks that round-off cannot tell from its own? A shift of row i
    changes the residual along own[i], by up to capacity[i] in both directions, or in one for a row at a bound. The
    multipliers `mu` of `normals` may change with it.
    """
    from scipy.optimize import lsq_linear

    unit, sizes = length(left) or 1.0, lengths(own)
    # If no multiplier can reduce the residual by growing, the shifts alone must; return early if they cannot.
    if (normals @ left >= -BALANCED).all() and capacity @ np.abs(own @ left) < unit * (unit - STATIONARITY):
        return unit
    reach = np.minimum(capacity * sizes / unit, 1e6)
    able = reach > NEGLIGIBLE
    own, sides, sizes, reach = own[able], sides[able], sizes[able], reach[able]
    matrix = np.concatenate([own / sizes[:, None], normals]).T  # unit directions, so that the problem is well scaled
    low = np.concatenate([np.where(sides == Side.UPPER, 0.0, -reach), -mu / unit])
    high = np.concatenate([np.where(sides == Side.LOWER, 0.0, reach), np.full(len(mu), np.inf)])
    target = -left / unit
    try:
        # The shortest shift, relative to the capacity of each row, is mostly within the bounds.
        scales = np.concatenate([reach, np.minimum(mu / unit, 1e6)])
        shift = scales * np.linalg.lstsq(matrix * scales, target, rcond=FREE_RANK)[0]
        if not ((low <= shift) & (shift <= high)).all() or length(matrix @ shift - target) > STATIONARITY / unit:
            shift = lsq_linear(matrix, target, bounds=(low, high), method="bvls", tol=1e-13).x
    except (np.linalg.LinAlgError, ValueError):
        return unit
    return unit * length(matrix @ shift - target)


class Told(NamedTuple):
    """One level, as :class:`hqp.certificate.LevelCertificate` tells it."""

    ok: bool
    stationarity: float
    scale: float
    multipliers: Array


def judge(hierarchy: Hierarchy, x: Array, x_ref: Array, tolerance: float = 1e-9) -> list[Told]:
    """All levels of a hierarchy at x, the implicit last one included."""
    with np.errstate(all="ignore"):
        rows = row_states(hierarchy, x, x_ref, tolerance)
        norms, force, eye = rows.norms, rows.norms * hierarchy.weights**2, np.eye(hierarchy.n)
        units = hierarchy.dense() / np.where(norms > 0, norms, 1.0)[:, None]
        push, sides = np.where(rows.violated, force * rows.slack, 0.0), np.where(rows.violated, EITHER_WAY, rows.sides)
        above, told, forces = Above(units, rows), [], Forces(units, push, force * rows.tolerance, sides)
        for k in range(len(hierarchy.levels) + 1):
            if k < len(hierarchy.levels):
                count, end = hierarchy.pointers[k : k + 2]
                own = Forces._make(part[count:end] for part in forces)
            else:
                count, allowed = hierarchy.m, tolerance * (np.abs(x) + np.abs(x_ref)) + ROUND_OFF * rows.way
                away = np.where(np.abs(x - x_ref) > allowed, x - x_ref, 0.0)
                own = Forces(eye, away, allowed, np.full(hierarchy.n, EITHER_WAY))
            balance = above.balance(own, count)
            told.append(Told(balance.exact, balance.stationarity, balance.scale, above.multipliers(balance, count)))
    return told
