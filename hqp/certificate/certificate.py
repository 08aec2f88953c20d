r"""The certificate: proves or refutes that an x is lexicographically optimal, from whatever solver it comes.

With :math:`w_k = A_k x - \operatorname{clip}(A_k x, l_k, u_k)`, x is optimal **iff** every level k
has multipliers :math:`\lambda_{kj}` (j < k) with

.. math::

    A_k^T D_k^2 w_k + \sum_{j<k} A_j^T \lambda_{kj} = 0, \qquad
    \lambda_{kj,i} \begin{cases}
        \text{free}      & \text{row (j, i) is an equality, or } w_{j,i} \ne 0 \\
        \ge 0\;(\le 0)   & w_{j,i} = 0 \text{ and the row is at its upper (lower) bound} \\
        = 0              & \text{strictly inside.}
    \end{cases}

Each level is a convex QP with affine constraints, hence *iff*. The multipliers of different levels are independent,
so that each level is one sign-constrained least squares: free normals are projected out, then a non-negative least
squares over the signed ones follows. Its residual must be round-off, or must vanish when the slacks of the level shift
within the tolerances of their rows. A compiled kernel decides this, :mod:`hqp.kernels.proof`, from x and the numbers of
the hierarchy alone, whatever backend x comes from.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, finite_vector, length
from ..checks import of_type, positive_number, truth
from ..errors import InvalidInput
from ..hierarchy import Hierarchy

#: Largest entry of x, and of x_ref, that is judged: beyond it, squares of residuals overflow.
FURTHEST = 1e60


@dataclass(frozen=True, eq=False)
class LevelCertificate:
    """The proof, or the failure, of one level.

    Attributes
    ----------
    level, name
        Number and name; the implicit last level comes last, with the name ``min ||x - x_ref||``.
    ok
        Whether this level is optimal, given what the levels above it attain at x.
    residual_norm
        ``||D_k w_k||``.
    stationarity
        Norm of the part of the gradient that no admissible multipliers balance, relative to the sum of the forces of
        the level; 0 is perfect.
    gap
        Upper bound of ``f_k(x) - f_k*``, with ``f = residual_norm^2 / 2``, for an optimum within `radius` of x.
    shortfall
        The most by which the residual norm could still be reduced, computed from `gap`.
    multipliers : array, shape (rows above,)
        Of all rows of the levels above, positive where an upper bound holds the level back.
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
    """The verdict on x, level by level; ``bool(certificate)`` and ``.ok`` tell whether x is optimal.

    Attributes
    ----------
    x : array, shape (n,)
    levels : tuple of LevelCertificate
    unique
        Whether the implicit last level ``min ||x - x_ref||`` was judged too.
    radius
        The `gap` of each level holds for optima within this distance of x.
    earlier : tuple of Certificate
        If levels are damped: the proofs of all stages but the last. This certificate is the proof of the last one.
    softened : tuple of int
        The softened levels. All others are strictly optimal in the null space that these leave.
    handed : tuple of LevelCertificate
        For each level softened because of curvature: whether lower levels kept its rows that are not declared soft.

    Notes
    -----
    Stages are proved on the numbers of the given hierarchy, copied before it was solved, never on the numbers that the
    solver used. The declared softening is added to these (``solution.relaxed``): lambda and aim, or directions and
    stiffness. It is not proved that the softening was necessary, or no larger than necessary; that the given rows are
    those of the robot; and what a controller computes from x, such as torques, or a blend during a change.
    """

    x: Array
    levels: tuple[LevelCertificate, ...]
    unique: bool
    radius: float
    earlier: tuple[Certificate, ...] = ()
    softened: tuple[int, ...] = ()
    handed: tuple[LevelCertificate, ...] = ()

    @property
    def stages(self) -> tuple[Certificate, ...]:
        """The certificates of all stages, each by itself, in the order in which they were solved."""
        return (*self.earlier, replace(self, earlier=(), softened=(), handed=()))

    @property
    def ok(self) -> bool:
        """Whether every level is optimal, in every stage."""
        return self.failed is None

    @property
    def failed(self) -> LevelCertificate | None:
        """The first level that is not optimal, stage by stage from the highest level down, or None."""
        judged = (level for stage in (*self.earlier, self) for level in stage.levels)
        return next((level for level in (*judged, *self.handed) if not level.ok), None)

    def __bool__(self) -> bool:
        return self.ok

    def __str__(self) -> str:
        told = [f"      {'level':<34}  {'residual':>12}  {'stationarity':>12}  {'gap':>10}"]
        told += [
            f"  {'ok' if level.ok else '!!':2}  {_title(level):<34}  {level.residual_norm:>12.6g}"
            f"  {level.stationarity:>12.3g}  {level.gap:>10.3g}"
            for level in self.levels
        ]
        if self.earlier or self.softened:
            told = [f"stage {i}: {stage}" for i, stage in enumerate(self.stages)]
            told += [f"  {'ok' if level.ok else '!!':2}  {_title(level)}" for level in self.handed]
        return "\n".join([self._head(), *told])

    def _head(self) -> str:
        """One line: what is proved, or which level fails and by how much."""
        failed = self.failed
        if failed is not None and failed in self.handed:
            return f"NOT optimal: {_title(failed)}: levels below have moved by {failed.residual_norm:.3g} what it held"
        if failed is not None:
            return (
                f"NOT optimal: {_title(failed)} falls short, its residual {failed.residual_norm:.6g}"
                f" could be lower by up to {failed.shortfall:.3g}"
            )
        if not self.softened:
            return f"certified: lexicographically optimal at all {len(self.levels)} levels"
        given = self.levels[:-1] if self.unique else self.levels
        strict = ", ".join(_title(level) for level in given if level.level not in self.softened)
        gave = ", ".join(_title(level) for level in given if level.level in self.softened)
        return f"certified, on the rows that were given: strict: {strict or 'none'}; softened as declared: {gave}"

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
        The point to judge, from any solver.
    x_ref : array, shape (n,), optional
        Reference of the implicit last level (default: zero).
    unique
        Whether to include the implicit last level ``min ||x - x_ref||``.
    tolerance
        Relative tolerance on rows, see :func:`hqp.certificate.row_states`. Answers that are exact to round-off pass at
        1e-9; for answers of first-order solvers, pass the accuracy that these claim.

    Returns
    -------
    Certificate

    Raises
    ------
    InvalidInput
        If x or x_ref has the wrong shape or is not finite, an entry of them is larger than 1e60, the tolerance is not
        between 0 and 1, unique is not True or False, or the hierarchy has a fault.

    Examples
    --------
    >>> from hqp import Hierarchy, Level, certify
    >>> limits = Level.bounds([-1.0, -1.0], [1.0, 1.0], name="limits")
    >>> hierarchy = Hierarchy([limits, Level.equality([[1.0, 1.0]], [3.0], name="sum")])
    >>> certify(hierarchy, [1.0, 1.0]).ok, certify(hierarchy, [1.0, 0.9]).ok
    (True, False)
    >>> print(certify(hierarchy, [1.0, 0.9]))
    NOT optimal: level 1 (sum) falls short, its residual 1.1 could be lower by up to 1.1
          level                                   residual  stationarity         gap
      ok  level 0 (limits)                               0             0           0
      !!  level 1 (sum)                                1.1         0.707       0.605
      !!  level 2 (min ||x - x_ref||)              1.34536        0.0372        0.15
    """
    unique = truth(unique, "unique")
    point, reference = _checked(hierarchy, x, x_ref)
    tolerance = positive_number(tolerance, "tolerance", below=1.0)
    from .judging import judged  # a package that compiles loops: whoever only solves need not wait for it

    _, told, multipliers = judged(hierarchy, point, reference, tolerance)
    radius = length(point) + length(reference) + max(reach for *_, reach in told)
    names = [*(level.name for level in hierarchy.levels), "min ||x - x_ref||"]
    levels = tuple(
        _level(k, names[k], told[k], radius, multipliers[k, : hierarchy.pointers[k]])
        for k in range(len(hierarchy.levels) + unique)
    )
    return Certificate(point, levels, unique, radius)


def first_failed(hierarchy: Hierarchy, x: ArrayLike, x_ref: ArrayLike) -> int | None:
    """The verdict alone: the level at which :func:`certify` first fails, the implicit last one included, or None.

    Parameters
    ----------
    hierarchy, x, x_ref
        See :func:`certify`.

    Raises
    ------
    InvalidInput
        As :func:`certify` does.
    """
    from .judging import judged

    return judged(hierarchy, *_checked(hierarchy, x, x_ref), 1e-9, every=False)[0]


def _checked(hierarchy: Hierarchy, x: ArrayLike, x_ref: ArrayLike | None) -> tuple[Array, Array]:
    """x and x_ref as vectors, if they and the hierarchy can be judged."""
    of_type(hierarchy, Hierarchy, "the hierarchy")
    point = finite_vector(x, hierarchy.n, "x")
    reference = np.zeros(hierarchy.n) if x_ref is None else finite_vector(x_ref, hierarchy.n, "x_ref")
    for what, vector in (("x", point), ("x_ref", reference)):
        if np.abs(vector).max(initial=0.0) > FURTHEST:
            raise InvalidInput(f"{what} reaches {np.abs(vector).max():g}; nothing beyond {FURTHEST:g} can be judged")
    fault = hierarchy.find_fault()
    if fault:
        raise InvalidInput(fault)
    return point, reference


def _level(k: int, name: str, told: list[float], radius: float, multipliers: Array) -> LevelCertificate:
    """Level k in full, of what the kernel has told; numbers that over- or underflow are refused there."""
    accepted, residual, scale, stationarity, gives, _ = told
    gap = min(scale * stationarity * radius + gives, residual * residual / 2) if scale > 0.0 else 0.0
    shortfall = residual - math.sqrt(max(residual * residual - 2 * gap, 0.0)) if scale > 0.0 else 0.0
    return LevelCertificate(k, name, bool(accepted), residual, stationarity, gap, shortfall, multipliers)


def _title(level: LevelCertificate) -> str:
    return f"level {level.level} ({level.name})" if level.name else f"level {level.level}"
