r"""One flat QP, its result, and the protocol of its solvers.

.. math::

    \min_y \tfrac12 y^T H y + g^T y \quad \text{subject to} \quad
    l \le C y \le u, \quad l_\text{box} \le y \le u_\text{box}
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

from ..arrays import Array


class Sizes(NamedTuple):
    """What a persistent solver is set up for: variables, general rows, and whether there are box bounds.

    Parameters
    ----------
    variables, rows : int
        N and M.
    box : bool
        Whether there are bounds on y itself.
    """

    variables: int
    rows: int
    box: bool


@dataclass(frozen=True, eq=False)
class FlatQP:
    """The numbers of one QP; H (N, N) positive definite, C (M, N), box bounds (N,) or None.

    Parameters
    ----------
    H : array, shape (N, N)
        Symmetric and positive definite.
    g : array, shape (N,)
    C : array, shape (M, N)
    lower, upper : array, shape (M,)
        Bounds on C y; infinite ones leave a side free.
    box_lower, box_upper : array, shape (N,), optional
        Bounds on y.
    """

    H: Array
    g: Array
    C: Array
    lower: Array
    upper: Array
    box_lower: Array | None = None
    box_upper: Array | None = None

    @property
    def sizes(self) -> Sizes:
        """The key under which a persistent solver for this QP is kept."""
        return Sizes(len(self.g), len(self.lower), self.box_lower is not None)


@dataclass(frozen=True, eq=False)
class FlatResult:
    """The solver's y, its own verdict, and its duals, positive at an upper bound, of the rows of C and of the box.

    Parameters
    ----------
    y : array, shape (N,)
    solved : bool
        What the solver claims.
    message : str
        What it says where it does not.
    row_duals : array, shape (M,)
    box_duals : array, shape (N,)
        Duals of the rows of C and of the box, positive at an upper bound.
    """

    y: Array
    solved: bool
    message: str
    row_duals: Array
    box_duals: Array


class FlatSolver(Protocol):
    """A solver set up for QPs of one size; keeps its factorisations and its last answer."""

    def solve(self, qp: FlatQP) -> FlatResult:
        """Load new numbers and solve, warm from the last answer."""
        ...

    def move(self, g: Array) -> FlatResult:
        """Solve again with another g and everything else as it was: a proximal step."""
        ...
