r"""The thesis's closed forms, for equalities only: short and slow, to compare with.

Eq. 3.17, for tasks :math:`J_1 \dot\theta = \dot r_1` before :math:`J_2 \dot\theta = \dot r_2`:

.. math::

    \dot\theta = J_1^\# \dot r_1 + \hat J_2^\# (\dot r_2 - J_2 J_1^\# \dot r_1)
                 + (I - J_1^\# J_1)(I - \hat J_2^\# \hat J_2) z,
    \qquad \hat J_2 = J_2 (I - J_1^\# J_1).

It is the lexicographic optimum in every rank case, provided that the pseudoinverses are truncated
relative to the *original* J: a task that lies inside the one above leaves :math:`\hat J_2 \approx 10^{-16}`,
which relative to itself would have full rank.

Eq. 4.8 (and 3.18), :math:`\ddot\theta = J_1^\# h_1 + (I - J_1^\# J_1) J_2^\# h_2`, projects the motion that
the second task would make *alone*. It has no algorithmic singularities, and it is not the optimum of
{J1} > {J2} but of {J1} > {theta'' = J2# h2}: see :func:`joint_form`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, length
from ..errors import InvalidInput, Unsupported
from ..hierarchy import Hierarchy, Level
from ..settings import Settings
from ..solution import Status
from .base import Answer, certified

INEQUALITIES_GO_TO = "native"
#: Singular values, relative to their scale, between which the rank or the answer may be round-off: below, they are zero
#: in double precision; above, they magnify errors a thousand times at most.
ZERO, CLEAR = 1e-13, 1e-3


class Inverse(NamedTuple):
    """A pseudoinverse, and whether round-off may have decided its rank or its numbers."""

    matrix: Array
    doubtful: bool


def prioritized(tasks: list[tuple[Array, Array]], z: Array, cut: float) -> tuple[Array, bool]:
    """Eq. 3.17 for any number of tasks (J, r), with z as the last level; and whether an inverse is doubtful."""
    x, doubtful = np.zeros_like(z), False
    N = np.eye(len(z))
    for k, (J, r) in enumerate(tasks):
        J_hat = J @ N if k else J  # the first task is not projected
        inverse = pinv(J_hat, cut, scale=norm(J) if k else None)
        x = x + inverse.matrix @ (r - J @ x)
        N = N - inverse.matrix @ J_hat
        doubtful = doubtful or inverse.doubtful
    return x + N @ z, doubtful


def joint_space(tasks: list[tuple[Array, Array]], z: Array, cut: float) -> Array:
    """Eq. 4.8 for any number of tasks (J, h): each corrects the motion that all below it would make alone."""
    x = z
    for J, h in reversed(tasks):
        x = x + pinv(J, cut).matrix @ (h - J @ x)
    return x


def pinv(J: Array, cut: float, scale: float | None = None) -> Inverse:
    """Pseudoinverse with singular values up to ``cut * scale`` taken for zero; the scale of J is its own norm."""
    if len(J) == 1:  # of one row, J^T / |J|^2
        size = norm(J)
        whole = size if scale is None else scale
        inverse = J.T / size / size if size > cut * whole else np.zeros_like(J.T)
        return Inverse(inverse, ZERO * whole < size < CLEAR * whole)
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    whole = s.max(initial=0.0) if scale is None else scale
    doubtful = bool(((s > ZERO * whole) & (s < CLEAR * whole)).any())
    kept = s > cut * whole
    if not kept.all():
        U, s, Vt = U[:, kept], s[kept], Vt[kept]
    return Inverse((Vt.T / s) @ U.T, doubtful)


def norm(J: Array) -> float:
    """Largest singular value of J, the scale of its rank decision."""
    if len(J) == 1:
        return length(J[0])
    return float(np.linalg.svd(J, compute_uv=False).max(initial=0.0))


def equality_tasks(hierarchy: Hierarchy) -> list[tuple[Array, Array]]:
    """The levels as weighted tasks (J, r); free rows and zero rows constrain nothing and are left out.

    Raises
    ------
    Unsupported
        At the first inequality row, with its level and row and a backend which takes it.
    """
    equal = hierarchy.lower == hierarchy.upper
    if not equal.all():
        _refuse_inequalities(hierarchy, equal)
    says = equal & (hierarchy.row_norms() > 0.0)
    tasks, every = [], says.all()
    for k, level in enumerate(hierarchy.levels):
        A, r, weights = hierarchy.matrix(k), level.lower, level.weights
        if not every:
            own = says[hierarchy.pointers[k] : hierarchy.pointers[k + 1]]
            A, r, weights = A[own], r[own], weights[own]
        tasks.append((weights[:, None] * A, weights * r))
    return tasks


def _refuse_inequalities(hierarchy: Hierarchy, equal: NDArray[np.bool_]) -> None:
    known = equal | (np.isinf(hierarchy.lower) & np.isinf(hierarchy.upper))
    if known.all():
        return
    k, row = hierarchy.locate(int(np.argmin(known)))
    level = hierarchy.levels[k]
    raise Unsupported(
        f"{hierarchy.level_name(k)}, row {row} is an inequality"
        f" ({level.lower[row]:g} <= A x <= {level.upper[row]:g});"
        f' the closed form takes equality rows only: use backend="{INEQUALITIES_GO_TO}"'
    )


def joint_form(hierarchy: Hierarchy, x_ref: Array | None = None, settings: Settings | None = None) -> Hierarchy:
    """The hierarchy which Eq. 4.8 really solves: {J1 x = h1} > {x = what the lower tasks would do alone}."""
    cut = (settings or Settings()).rank_tolerance
    z = np.zeros(hierarchy.n) if x_ref is None else x_ref
    if not hierarchy.levels:
        raise InvalidInput("a hierarchy without levels has no joint form")
    first, *rest = equality_tasks(hierarchy)
    alone = joint_space(rest, z, cut)
    name = hierarchy.levels[0].name
    return Hierarchy(
        [Level.equality(*first, name=name), Level.bounds(alone, alone, name="joint motion")], n=hierarchy.n
    )


class Pseudoinverse:
    """Eq. 3.17 as a backend. Where an inverse is doubtful, the certificate decides the status."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings

    def solve(self, hierarchy: Hierarchy, x_ref: Array) -> Answer:
        try:
            tasks = equality_tasks(hierarchy)
        except Unsupported as refusal:
            return Answer(x_ref.copy(), Status.UNSUPPORTED, str(refusal))
        return self.evaluated(tasks, hierarchy, x_ref)

    def evaluated(self, tasks: list[tuple[Array, Array]], hierarchy: Hierarchy, x_ref: Array) -> Answer:
        """What the formula makes of these tasks, all that the hierarchy has."""
        x, doubtful = prioritized(tasks, x_ref, self.settings.rank_tolerance)
        return certified(Answer(x), hierarchy, x_ref, "the closed form") if doubtful else Answer(x)

    def reset(self) -> None:
        """No effect: nothing is kept between calls."""


class JointSpacePseudoinverse(Pseudoinverse):
    """Eq. 4.8 as a backend. Its answer is optimal for :func:`joint_form` of the hierarchy, not for the hierarchy."""

    def evaluated(self, tasks: list[tuple[Array, Array]], hierarchy: Hierarchy, x_ref: Array) -> Answer:
        """What the formula makes of these tasks; no certificate of the hierarchy is asked about it."""
        return Answer(joint_space(tasks, x_ref, self.settings.rank_tolerance))


def make(name: str, settings: Settings) -> Pseudoinverse:
    """The backend of that name."""
    return JointSpacePseudoinverse(settings) if name == "pseudoinverse:joint" else Pseudoinverse(settings)
