"""The two ways to solve: :func:`solve` for one shot, :class:`Solver` for a control loop."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .arrays import finite_vector, real_array
from .backends.base import Answer
from .backends.registry import make_backend
from .checks import of_type
from .errors import InvalidInput, Unsupported
from .hierarchy import LARGEST, Hierarchy
from .settings import Settings
from .solution import Solution, Status

#: The backend used where none is named.
DEFAULT_BACKEND = "cascade:proxsuite"


class Solver:
    """Solves hierarchies of one structure again and again, each warm from the last.

    Parameters
    ----------
    backend : str
        A name from ``hqp.available_backends()``.
    settings : Settings, optional

    Raises
    ------
    UnknownBackend
        If no backend of that name can run here.
    InvalidInput
        If the settings are none.

    Notes
    -----
    A call never raises on *numbers*: a hierarchy that holds NaN, an infinite row or crossed bounds
    comes back with status INVALID and a message naming level and row, x_ref (or zero) in the place
    of an answer. When the structure (sizes, bounded variables) changes, the solver starts afresh.
    """

    def __init__(self, backend: str = DEFAULT_BACKEND, settings: Settings | None = None) -> None:
        self.backend = backend
        self.settings = Settings() if settings is None else of_type(settings, Settings, "settings")
        self._backend = make_backend(backend, self.settings)
        self._structure: tuple[Any, ...] | None = None

    def solve(self, hierarchy: Hierarchy, x_ref: ArrayLike | None = None) -> Solution:
        """Solve, warm if the last hierarchy had the same structure.

        Parameters
        ----------
        hierarchy : Hierarchy
        x_ref : array, shape (n,), optional
            Reference of the implicit last level ``min ||x - x_ref||`` (default: zero).

        Raises
        ------
        InvalidInput
            If x_ref is no array of real numbers, or has the wrong shape.
        """
        if not isinstance(hierarchy, Hierarchy):
            raise InvalidInput(f"solve takes a hqp.Hierarchy, not a {type(hierarchy).__name__}")
        reference = np.zeros(hierarchy.n) if x_ref is None else real_array(x_ref, "x_ref")
        if reference.shape != (hierarchy.n,):
            raise InvalidInput(f"x_ref has shape {reference.shape}; it must be ({hierarchy.n},)")

        fault = hierarchy.find_fault()
        if fault is None and x_ref is not None and not (np.abs(reference) <= LARGEST).all():
            fault = f"x_ref = {reference} must be finite, and at most {LARGEST:g} in size"
            reference = np.zeros(hierarchy.n)
        if fault is not None:
            answer = Answer(reference.copy(), Status.INVALID, fault)
        else:
            if hierarchy.structure != self._structure:
                self._backend.reset()
                self._structure = hierarchy.structure
            with np.errstate(all="ignore"):
                answer = self._backend.solve(hierarchy, reference)
        return Solution(
            x=answer.x,
            status=answer.status,
            message=answer.message,
            level=answer.level,
            backend=self.backend,
            counts=answer.counts,
            hierarchy=hierarchy.copy(),
            x_ref=reference,
            tolerance=10 * self.settings.tolerance,
            rank_tolerance=self.settings.rank_tolerance,
        )


def solve(
    hierarchy: Hierarchy,
    *,
    backend: str = DEFAULT_BACKEND,
    x_ref: ArrayLike | None = None,
    settings: Settings | None = None,
) -> Solution:
    """Solve a hierarchy once.

    Parameters
    ----------
    hierarchy : Hierarchy
    backend : str
        A name from ``hqp.available_backends()``.
    x_ref : array, shape (n,), optional
        Reference of the implicit last level ``min ||x - x_ref||`` (default: zero).
    settings : Settings, optional

    Returns
    -------
    Solution
        ``.x``, ``.status``, ``.levels[k]``; ``.certify().ok`` is the proof.

    Raises
    ------
    InvalidInput
        If a number of the hierarchy or of x_ref cannot mean anything; names level and row.
    UnknownBackend
        If no backend of that name can run here; lists those that can.
    Unsupported
        If the backend does not take such a hierarchy; names one that does.
    """
    if x_ref is not None and isinstance(hierarchy, Hierarchy):
        x_ref = finite_vector(x_ref, hierarchy.n, "x_ref")
    solution = Solver(backend, settings).solve(hierarchy, x_ref)
    if solution.status is Status.INVALID:
        raise InvalidInput(solution.message)
    if solution.status is Status.UNSUPPORTED:
        raise Unsupported(solution.message)
    return solution
