"""Settings of a solve: tolerances, iteration and time limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from .checks import positive_number, truth, whole_number


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Tolerances and limits, all relative to the data and therefore without units.

    Parameters
    ----------
    tolerance
        A row counts as satisfied within ``tolerance * (|A_i x| + |bound_i| + 0.1 ||A_i|| ||x||)``
        and round-off, see :func:`hqp.certificate.allowance`. What is solved to this tolerance is judged,
        by ``solution.levels`` and ``certify``, by one ten times as large.
    rank_tolerance
        A row direction counts as dependent on the levels above when what is left of it, after
        projection, is at most ``rank_tolerance`` times the norm of the *original* row.
    iterations
        The most iterations of the native solver: steps of its active sets. When they are spent, the levels
        that are finished are exact, and the status is SUBOPTIMAL.
    time_limit
        The longest [s] that the native solver may take, from the call on, before it ends in the same way; read in
        every loop. Infinite by default; kept where the system has POSIX clocks.
    proximal_weight
        The rho of the cascade: each level minimises ``1/2 ||A x - b||^2 + rho/2 ||y - y_prev||^2``,
        with the rows of the level scaled so that the largest has norm one.
    proximal_steps
        The most times a level is solved again, warm, from its own last answer.
    polish
        Whether each level of the cascade ends with an equality least squares on its active rows.
    qp_tolerance
        Tolerance of the flat QP solvers, for rows of unit norm and targets of order one.
    qp_iterations
        The most iterations that a flat QP solver may spend on one QP.

    Raises
    ------
    InvalidInput
        If a number is not positive and finite (the time limit may be infinite), a tolerance is not below 1, or a count
        is not a positive integer.

    Examples
    --------
    >>> from hqp import Hierarchy, Level, Settings, solve
    >>> hierarchy = Hierarchy([Level.equality([[1.0, 1e-7]], [1.0]), Level.equality([[1.0, 0.0]], [0.0])])
    >>> solve(hierarchy).x.round(3)
    array([       0., 10000000.])
    >>> solve(hierarchy, settings=Settings(rank_tolerance=1e-6)).x.round(3)  # the rows count as parallel
    array([1., 0.])
    """

    tolerance: float = 1e-10
    rank_tolerance: float = 1e-9
    iterations: int = 10_000
    time_limit: float = math.inf
    proximal_weight: float = 1e-7
    proximal_steps: int = 5
    polish: bool = True
    qp_tolerance: float = 1e-9
    qp_iterations: int = 4000

    def __post_init__(self) -> None:
        for field in fields(self):
            value, what = getattr(self, field.name), f"settings: {field.name}"
            if field.type == "bool":
                value = truth(value, what)
            elif field.type == "int":
                value = whole_number(value, what, least=1)
            else:
                below = 1.0 if "tolerance" in field.name else math.inf
                value = positive_number(value, what, below, endless=field.name == "time_limit")
            object.__setattr__(self, field.name, value)


#: The default settings.
DEFAULT = Settings()
