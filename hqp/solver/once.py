"""One hierarchy, solved once: by a cold solver, with memory that is kept from the last of its structure."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Mapping
from typing import Any

from numpy.typing import ArrayLike

from ..arrays import finite_vector
from ..backends.base import Backend
from ..backends.registry import make_backend
from ..checks import of_type
from ..damping import DampingRule
from ..errors import InvalidInput, Unsupported
from ..hierarchy import Hierarchy
from ..settings import DEFAULT, Settings
from ..solution import Solution, Status
from .solver import DEFAULT_BACKEND, Solver


def solve(
    hierarchy: Hierarchy,
    *,
    backend: str = DEFAULT_BACKEND,
    x_ref: ArrayLike | None = None,
    settings: Settings | None = None,
    damping: Mapping[int | str, DampingRule | float] | None = None,
    aims: Mapping[int | str, ArrayLike] | None = None,
) -> Solution:
    """Solve a hierarchy once.

    Parameters
    ----------
    hierarchy : Hierarchy
    backend : str
        A name from ``hqp.available_backends()``.
    x_ref : array, shape (n,), optional
        Reference of the implicit last level ``min ||x - x_ref||``, and of the damping (default: zero).
    settings : Settings, optional
    damping : mapping of int or str to DampingRule or float, optional
        The levels to damp, by index or by name, each with its rule; a number is a :class:`FixedDamping`.
    aims : mapping of int or str to array, shape (n,), optional
        What damped levels are damped towards, ``lambda (x - aim) = 0``, in place of x_ref.

    Returns
    -------
    Solution
        ``.x``, ``.status``, ``.levels[k]``, ``.relaxed``; ``.certify().ok`` is the proof.

    Raises
    ------
    InvalidInput
        If a number of the hierarchy, of x_ref or of an aim cannot mean anything, names level and row; if a rule is
        none, its level not in the hierarchy, or a level with an aim not damped.
    UnknownBackend
        If no backend of that name can run here; lists those that can.
    Unsupported
        If the backend does not take such a hierarchy; names one that does.

    Notes
    -----
    A solve waits, once for a version and a machine, until the parts of the native solver that it comes to are compiled;
    one that first comes to a rare part waits for that, too. A :class:`Solver` has all of them ready when it is made.

    Examples
    --------
    >>> from hqp import Hierarchy, Level, solve
    >>> limits, total = Level.bounds([-1.0, -1.0], [1.0, 1.0]), Level.equality([[1.0, 1.0]], [3.0])
    >>> solution = solve(Hierarchy([limits, total]))
    >>> solution.x, solution.levels[1].residual_norm, solution.certify().ok
    (array([1., 1.]), 1.0, True)
    """
    settings = DEFAULT if settings is None else of_type(settings, Settings, "settings")
    now = None if settings.time_limit == math.inf else time.monotonic_ns()
    if x_ref is not None and isinstance(hierarchy, Hierarchy):
        x_ref = finite_vector(x_ref, hierarchy.n, "x_ref")
    key, solver = _borrow(hierarchy, backend, settings, damping)
    if now is not None:
        solver._called = now
    solution = solver.solve(hierarchy, x_ref, aims)
    _return(key, solver)
    if solution.status is Status.INVALID:
        raise InvalidInput(solution.message)
    if solution.status is Status.UNSUPPORTED:
        raise Unsupported(solution.message)
    return solution


class _Once(Solver):
    """A native solver that need not be ready for all that a control loop may come to: who solves once can wait."""

    def _new_backend(self) -> Backend:
        return make_backend(self.backend, self.settings, once=True)


#: What :func:`solve` keeps: so many solvers of the native backend a thread, one a structure, the last used last.
KEPT = 8
_kept = threading.local()


def _borrow(
    hierarchy: Hierarchy, backend: str, settings: Settings, damping: Mapping[int | str, DampingRule | float] | None
) -> tuple[Any, Solver]:
    """A cold solver, taken from those that are kept if there is one of this structure: it has its memory ready."""
    plain = damping is None and isinstance(hierarchy, Hierarchy)
    if not (plain and isinstance(backend, str) and backend == DEFAULT_BACKEND):
        return None, Solver(backend, settings, damping)
    key = hierarchy.structure, settings
    try:
        solver = _kept.solvers.pop(key, None)
    except AttributeError:
        solver, _kept.solvers = None, {}
    if solver is None:
        return key, _Once(backend, settings)
    solver.forget()
    return key, solver


def _return(key: Any, solver: Solver) -> None:
    """Keep the solver for the next call of this thread with such a hierarchy."""
    if key is not None:
        _kept.solvers[key] = solver
        if len(_kept.solvers) > KEPT:
            del _kept.solvers[next(iter(_kept.solvers))]
