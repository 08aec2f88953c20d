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
normals, then non-negative least squares over the signed ones. Nothing here knows a backend.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array, finite_vector
from .errors import InvalidInput
from .hierarchy import Hierarchy
from .rows import RowStates, Side, row_states
from .subspace import split

#: Rank decision among free normals: the weak choice, so that either answer to a near-singular one passes.
FREE_RANK = 1e-12
#: Stationarity asked of a level, relative to the sum of its forces ``||A_i|| d_i^2 |w_i|``.
STATIONARITY = 1e-8


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
    """

    x: Array
    levels: tuple[LevelCertificate, ...]
    unique: bool
    radius: float

    @property
    def ok(self) -> bool:
        """Whether every level is optimal."""
        return all(level.ok for level in self.levels)

    @property
    def failed(self) -> LevelCertificate | None:
        """The highest level that falls short, or None."""
        return next((level for level in self.levels if not level.ok), None)

    def __bool__(self) -> bool:
        return self.ok

    def __str__(self) -> str:
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
        If x or x_ref has the wrong shape or is not finite, or the hierarchy has a fault.
    """
    point = finite_vector(x, hierarchy.n, "x")
    reference = np.zeros(hierarchy.n) if x_ref is None else finite_vector(x_ref, hierarchy.n, "x_ref")
    if not tolerance > 0:
        raise InvalidInput(f"tolerance = {tolerance} must be positive")
    fault = hierarchy.find_fault()
    if fault:
        raise InvalidInput(fault)

    rows = row_states(hierarchy, point, tolerance)
    units = _unit_normals(hierarchy, rows.norms)
    reach = np.divide(np.abs(rows.slack), rows.norms, out=np.zeros(hierarchy.m), where=rows.norms > 0)
    radius = float(np.linalg.norm(point) + np.linalg.norm(reference) + reach.max(initial=0.0))

    levels = []
    for k, level in enumerate(hierarchy.levels):
        own = slice(hierarchy.pointers[k], hierarchy.pointers[k + 1])
        force = rows.norms[own] * level.weights**2
        push = np.where(rows.violated[own], force * rows.slack[own], 0.0)
        noise = float(force @ rows.tolerance[own])
        residual = float(np.linalg.norm(level.weights * rows.slack[own]))
        levels.append(
            _judge(
                k, level.name, residual, units[own].T @ push, np.abs(push).sum(), noise, units, rows, own.start, radius
            )
        )
    if unique:
        away = point - reference
        allowed = tolerance * (np.abs(point) + np.abs(reference) + np.linalg.norm(point))
        push = np.where(np.abs(away) > allowed, away, 0.0)
        levels.append(
            _judge(
                len(hierarchy.levels), "min ||x - x_ref||", float(np.linalg.norm(away)),
                push, np.abs(push).sum(), float(allowed.sum()), units, rows, hierarchy.m, radius,
            )
        )  # fmt: skip
    return Certificate(point, tuple(levels), unique, radius)


def _judge(
    level: int,
    name: str,
    residual: float,
    gradient: Array,
    scale: float,
    noise: float,
    units: Array,
    rows: RowStates,
    above: int,
    radius: float,
) -> LevelCertificate:
    """Balance the gradient of one level by the rows above it (the first `above` rows).

    scale is the sum of the forces in the gradient, noise what round-off in the slacks adds to it.
    """
    multipliers = np.zeros(above)
    if scale == 0.0:  # met exactly: nothing to improve, no multipliers
        return LevelCertificate(level, name, True, residual, 0.0, 0.0, 0.0, multipliers)

    free = np.flatnonzero((rows.sides[:above] == Side.EQUALITY) | rows.violated[:above])
    signed = np.flatnonzero(
        (rows.sides[:above] != Side.EQUALITY) & (rows.sides[:above] != Side.INACTIVE) & ~rows.violated[:above]
    )
    free, signed = free[rows.norms[free] > 0], signed[rows.norms[signed] > 0]
    basis, _ = split(units[free], np.ones(len(free)), FREE_RANK)

    force = gradient / scale
    outward = units[signed] * rows.sides[signed, None]
    left = force - basis @ (basis.T @ force)
    pull = _nonnegative(outward - (outward @ basis) @ basis.T, -left)
    left = left + (outward - (outward @ basis) @ basis.T).T @ pull
    stationarity = float(np.linalg.norm(left))

    along = force + outward.T @ pull
    multipliers[signed] = scale * pull * rows.sides[signed] / rows.norms[signed]
    multipliers[free] = scale * np.linalg.lstsq(units[free].T, -along, rcond=FREE_RANK)[0] / rows.norms[free]

    distance = np.abs(rows.slack[:above]) + rows.tolerance[:above]
    gap = scale * stationarity * radius + float(np.abs(multipliers[signed]) @ distance[signed])
    gap = min(gap, residual**2 / 2)
    shortfall = residual - float(np.sqrt(max(residual**2 - 2 * gap, 0.0)))
    ok = scale * stationarity <= STATIONARITY * scale + noise
    return LevelCertificate(level, name, bool(ok), residual, stationarity, gap, shortfall, multipliers)


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


def _unit_normals(hierarchy: Hierarchy, norms: Array) -> Array:
    """Every row divided by its norm, dense, shape (m, n)."""
    units = np.concatenate([hierarchy.matrix(k) for k in range(len(hierarchy.levels))] or [np.zeros((0, hierarchy.n))])
    return units / np.where(norms > 0, norms, 1.0)[:, None]


def _title(level: LevelCertificate) -> str:
    return f"level {level.level} ({level.name})" if level.name else f"level {level.level}"
