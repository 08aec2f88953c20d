r"""Is this x lexicographically optimal, whoever computed it?

With :math:`w_k = A_k x - \operatorname{clip}(A_k x, l_k, u_k)`, x is optimal **iff** every level k
has multipliers :math:`\lambda_{kj}` (j < k) with

.. math::

    A_k^T D_k^2 w_k + \sum_{j<k} A_j^T \lambda_{kj} = 0, \qquad
    \lambda_{kj,i} \begin{cases}
        \text{free}      & \text{row (j, i) is an equality, or } w_{j,i} \ne 0 \\
        \ge 0\;(\le 0)   & w_{j,i} = 0 \text{ and the row is at its upper (lower) bound} \\
        = 0              & \text{strictly inside.}
    \end{cases}

Each level is a convex QP with affine constraints, hence *iff*; and the multipliers of different
levels are independent, hence one sign-constrained least squares a level: project out the free
normals, then non-negative least squares over the signed ones. What that leaves must be round-off, or must
vanish when the slacks of the level shift within the tolerances of their rows. Nothing here knows a backend.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arrays import Array, finite_vector, length, lengths
from .checks import of_type, positive_number, truth
from .errors import InvalidInput
from .hierarchy import Hierarchy
from .rows import ROUND_OFF, RowStates, row_states
from .side import Side
from .subspace import row_space

#: Rank decision among free normals: the weak choice, so that either answer to a near-singular one passes.
FREE_RANK = 1e-12
#: The same, of what the rows of a level can still move: what a solver may have taken for zero, with a margin.
OWN_RANK = 4e-9
#: Beyond this x, squares of residuals overflow.
FURTHEST = 1e60
#: Stationarity asked of a level, relative to the sum of its forces ``||A_i|| d_i^2 |w_i|``, where the slacks of
#: its rows may shift within their tolerances.
STATIONARITY = 1e-10
#: What is asked at the least, however badly conditioned the rows are that hold the level back.
BLURRED = 1e-6


@dataclass(frozen=True, eq=False)
class LevelCertificate:
    """The proof, or the failure, of one level.

    Attributes
    ----------
    level, name
        Index and name; the implicit last level comes last, under the name ``min ||x - x_ref||``.
    ok
        Whether this level is optimal, given what the levels above it attain at x.
    residual_norm
        ``||D_k w_k||``.
    stationarity
        What no admissible multipliers balance, relative to the forces in the level; 0 is perfect.
    gap
        Bound on ``f_k(x) - f_k*`` with ``f = residual_norm^2 / 2``, for an optimum within `radius` of x.
    shortfall
        By how much the residual norm could at most still fall (from `gap`).
    multipliers : array
        Over all rows of the levels above, positive where an upper bound holds the level back.
    """

    level: int
    name: str
    ok: bool
    residual_norm: float
    stationarity: float
    gap: float
    shortfall: float
    multipliers: Array


@dataclass(frozen=True, eq=False)
class Certificate:
    """The verdict on x, level by level; ``bool(certificate)`` and ``.ok`` say it in one word.

    Attributes
    ----------
    x : array, shape (n,)
    levels : tuple of LevelCertificate
    unique
        Whether the implicit last level ``min ||x - x_ref||`` was judged too.
    radius
        The distance within which `gap` holds.
    earlier : tuple of Certificate
        Where levels are damped, the proofs of the stages before the last one, of which this is.
    """

    x: Array
    levels: tuple[LevelCertificate, ...]
    unique: bool
    radius: float
    earlier: tuple[Certificate, ...] = ()

    @property
    def stages(self) -> tuple[Certificate, ...]:
        """The proof of every stage by itself, in order."""
        return (*self.earlier, replace(self, earlier=()))

    @property
    def ok(self) -> bool:
        """Whether every level is optimal, in every stage."""
        return self.failed is None

    @property
    def failed(self) -> LevelCertificate | None:
        """The highest level that falls short, in the first stage that has one, or None."""
        judged = (level for stage in (*self.earlier, self) for level in stage.levels)
        return next((level for level in judged if not level.ok), None)

    def __bool__(self) -> bool:
        return self.ok

    def __str__(self) -> str:
        if self.earlier:
            return "\n".join(f"stage {i}: {stage}" for i, stage in enumerate(self.stages))
        failed = self.failed
        if failed is None:
            head = f"certified: lexicographically optimal at all {len(self.levels)} levels"
        else:
            head = (
                f"NOT optimal: {_title(failed)} falls short, its residual {failed.residual_norm:.6g}"
                f" could be lower by up to {failed.shortfall:.3g}"
            )
        rows = [
            f"  {'ok' if level.ok else '!!':2}  {_title(level):<34}  {level.residual_norm:>12.6g}"
            f"  {level.stationarity:>12.3g}  {level.gap:>10.3g}"
            for level in self.levels
        ]
        return "\n".join([head, f"      {'level':<34}  {'residual':>12}  {'stationarity':>12}  {'gap':>10}", *rows])

    __repr__ = __str__


def certify(
    hierarchy: Hierarchy,
    x: ArrayLike,
    x_ref: ArrayLike | None = None,
    *,
    unique: bool = True,
    tolerance: float = 1e-9,
) -> Certificate:
    """Prove, or refute, that x is the lexicographic optimum of the hierarchy.

    Parameters
    ----------
    hierarchy : Hierarchy
    x : array, shape (n,)
        The point to judge, from any source.
    x_ref : array, shape (n,), optional
        Reference of the implicit last level (default: zero).
    unique
        Whether to include the implicit last level ``min ||x - x_ref||``.
    tolerance
        Relative tolerance on rows, see :func:`hqp.rows.row_states`; answers that are exact to
        round-off pass at 1e-9, first-order ones need what they claim.

    Returns
    -------
    Certificate

    Raises
    ------
    InvalidInput
        If x or x_ref has the wrong shape or is not finite, x reaches beyond 1e60, the tolerance is
        not between 0 and 1, unique not True or False, or the hierarchy has a fault.
    """
    of_type(hierarchy, Hierarchy, "the hierarchy")
    point = finite_vector(x, hierarchy.n, "x")
    reference = np.zeros(hierarchy.n) if x_ref is None else finite_vector(x_ref, hierarchy.n, "x_ref")
    if np.abs(point).max(initial=0.0) > FURTHEST:
        raise InvalidInput(f"x reaches {np.abs(point).max():g}; nothing beyond {FURTHEST:g} can be judged")
    tolerance = positive_number(tolerance, "tolerance", below=1.0)
    unique = truth(unique, "unique")
    fault = hierarchy.find_fault()
    if fault:
        raise InvalidInput(fault)

    with np.errstate(all="ignore"):  # of what over- or underflows, the comparisons below make a refusal
        rows = row_states(hierarchy, point, tolerance)
        units = _unit_normals(hierarchy, rows.norms)
        reach = np.divide(np.abs(rows.slack), rows.norms, out=np.zeros(hierarchy.m), where=rows.norms > 0)
        radius = float(np.linalg.norm(point) + np.linalg.norm(reference) + reach.max(initial=0.0))
        levels = []
        for k, level in enumerate(hierarchy.levels):
            own = slice(hierarchy.pointers[k], hierarchy.pointers[k + 1])
            pull = _Pull(
                k, level.name, units[own], rows.norms[own] * level.weights**2, rows.slack[own],
                rows.tolerance[own], rows.sides[own], float(np.linalg.norm(level.weights * rows.slack[own])),
            )  # fmt: skip
            levels.append(_judge(pull, units[: own.start], rows, radius))
        if unique:
            away, n = point - reference, hierarchy.n
            allowed = tolerance * (np.abs(point) + np.abs(reference)) + ROUND_OFF * radius
            pull = _Pull(
                len(hierarchy.levels), "min ||x - x_ref||", np.eye(n), np.ones(n), away,
                allowed, np.full(n, Side.EQUALITY, dtype=np.int8), float(np.linalg.norm(away)),
            )  # fmt: skip
            levels.append(_judge(pull, units, rows, radius))
    return Certificate(point, tuple(levels), unique, radius)


@dataclass(frozen=True, eq=False)
class _Pull:
    """One level as forces on x: row i pulls with ``force_i * slack_i`` along its unit normal."""

    level: int
    name: str
    units: Array
    force: Array
    slack: Array
    tolerance: Array
    sides: NDArray[np.int8]
    residual: float


def _judge(pull: _Pull, units: Array, rows: RowStates, radius: float) -> LevelCertificate:
    """Balance the forces of one level by the rows above it, whose unit normals are `units`."""
    above = len(units)
    multipliers = np.zeros(above)
    violated = np.abs(pull.slack) > pull.tolerance
    push = np.where(violated, pull.force * pull.slack, 0.0)
    scale = float(np.abs(push).sum())
    if scale == 0.0:  # met: nothing to improve, no multipliers
        return LevelCertificate(pull.level, pull.name, True, pull.residual, 0.0, 0.0, 0.0, multipliers)

    sides, exceeded, movable = rows.sides[:above], rows.violated[:above], rows.norms[:above] > 0
    free = np.flatnonzero(movable & ((sides == Side.EQUALITY) | exceeded))
    signed = np.flatnonzero(movable & ((sides == Side.UPPER) | (sides == Side.LOWER)) & ~exceeded)
    basis, _, smallest = row_space(units[free], FREE_RANK)

    def project(vectors: Array) -> Array:
        """Each row less its part in the span of the free normals."""
        return vectors - (vectors @ basis) @ basis.T

    gradient = pull.units.T @ (push / scale)
    outward = units[signed] * sides[signed, None]
    held, normals = project(gradient[None])[0], project(outward)
    mu = _nonnegative(normals, -held)
    left = held + normals.T @ mu
    stationarity = float(np.linalg.norm(left))
    # What a perfect x leaves: round-off, magnified where the normals that balance the level are nearly dependent.
    pressing, kept = normals[mu > 0.0], np.zeros((len(held), 0))
    if len(pressing):
        sizes = lengths(pressing)
        kept, _, least = row_space(pressing / sizes[:, None], FREE_RANK)
        smallest = min(smallest, least, float(sizes.min()))
    exact = float(np.clip(16 * ROUND_OFF / smallest, STATIONARITY, BLURRED))
    ok = stationarity <= exact
    if not ok:
        carriers = np.flatnonzero(violated | (pull.sides != Side.INACTIVE))
        own = project(pull.units[carriers])
        # A direction in which the level hardly moves while those rows press may count as none: a rank decision that
        # could go either way.
        moves, _, _ = row_space(own - (own @ kept) @ kept.T, OWN_RANK)
        left = moves @ (moves.T @ left)
        capacity = (pull.force * pull.tolerance / scale)[carriers]
        side = np.where(violated, Side.EQUALITY, pull.sides)[carriers]
        ok = length(left) <= exact or _carried(left, normals, mu, own, capacity, side) <= exact

    force = gradient + outward.T @ mu
    multipliers[signed] = scale * mu * sides[signed] / rows.norms[signed]
    multipliers[free] = scale * np.linalg.lstsq(units[free].T, -force, rcond=FREE_RANK)[0] / rows.norms[free]
    distance = np.abs(rows.slack[:above]) + rows.tolerance[:above]
    gap = scale * stationarity * radius + float(np.abs(multipliers[signed]) @ distance[signed])
    gap = min(gap, pull.residual**2 / 2)
    shortfall = pull.residual - float(np.sqrt(max(pull.residual**2 - 2 * gap, 0.0)))
    return LevelCertificate(
        pull.level, pull.name, bool(ok), pull.residual, stationarity, gap, shortfall, multipliers
    )  # fmt: skip


def _nonnegative(rows: Array, target: Array) -> Array:
    """The mu >= 0 that minimises ``||rows^T mu - target||``."""
    if not len(rows):
        return np.zeros(0)
    from scipy.optimize import lsq_linear, nnls

    try:
        solution: Array = nnls(rows.T, target)[0]
    except RuntimeError:  # iteration limit: rows that are all but parallel
        solution = lsq_linear(rows.T, target, bounds=(0.0, np.inf), method="bvls", tol=1e-14).x
    return solution


def _carried(left: Array, normals: Array, mu: Array, own: Array, capacity: Array, sides: NDArray[np.int8]) -> float:
    """What remains of `left` when every row of the level may shift its slack within its tolerance.

    A backward error: is the point exact for slacks that round-off cannot tell from its own? A shift moves the balance
    along the row of `own`, by up to its `capacity` either way, at a bound one way; the multipliers may follow.
    """
    from scipy.optimize import lsq_linear

    unit = float(np.linalg.norm(left)) or 1.0
    sizes = np.maximum(lengths(own), 1e-300)  # directions of length one, whatever the rows are worth
    matrix = np.concatenate([own / sizes[:, None], normals]).T
    reach = np.minimum(capacity * sizes / unit, 1e6)
    low = np.concatenate([np.where(sides == Side.UPPER, 0.0, -reach), -mu / unit])
    high = np.concatenate([np.where(sides == Side.LOWER, 0.0, reach), np.full(len(mu), np.inf)])
    try:
        found = lsq_linear(matrix, -left / unit, bounds=(low, np.maximum(high, low + 1e-300)), method="bvls", tol=1e-13)
    except (np.linalg.LinAlgError, ValueError):
        return unit
    return unit * float(np.linalg.norm(matrix @ found.x + left / unit))


def _unit_normals(hierarchy: Hierarchy, norms: Array) -> Array:
    """Every row divided by its norm, dense, shape (m, n)."""
    return hierarchy.dense() / np.where(norms > 0, norms, 1.0)[:, None]


def _title(level: LevelCertificate) -> str:
    return f"level {level.level} ({level.name})" if level.name else f"level {level.level}"
