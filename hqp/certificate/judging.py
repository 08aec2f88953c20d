"""The door to the compiled certificate, :mod:`hqp.kernels.proof`."""

from __future__ import annotations

import threading
from typing import Any

from ..arrays import Array
from ..hierarchy import Hierarchy
from ..kernels import layout as at
from ..kernels.judge import judge
from ..kernels.ready import door, make_ready
from ..kernels.workspace import Workspace

#: So many workspaces are kept by each thread, one a structure, the last used last.
KEPT = 8
_kept = threading.local()


def warm_up() -> bool:
    """Have the certificate ready: from disk, or compiled now. True if it had to be compiled."""
    return make_ready(judge, "the certificate")


def judged(
    hierarchy: Hierarchy, x: Array, x_ref: Array, tolerance: float, every: bool = True
) -> tuple[int | None, list[list[float]], Array]:
    """Judge x, of a hierarchy without a fault.

    Parameters
    ----------
    hierarchy, x, x_ref, tolerance
        See :func:`hqp.certify`.
    every : bool
        Whether all levels are judged, or none below the first that fails.

    Returns
    -------
    failed : int or None
        The first level that fails.
    verdict : list of list of float
        With `every`, what is told of each level, see :data:`hqp.kernels.layout.VERDICT`.
    multipliers : array, shape (levels + 1, m)
        With `every`, those by which the rows above, the first ones, balance each level.
    """
    warm_up()
    structure = hierarchy.structure
    work = _borrow(structure)
    work.x[:], work.x_ref[:], work.option[at.JUDGED], work.head[at.ALL] = x, x_ref, tolerance, every
    failed = door(judge)(work.address, hierarchy.address)
    verdict, multipliers = work.floats(at.VERDICT).tolist(), work.floats(at.HELD_BY).copy()
    _kept.work[structure] = work
    if len(_kept.work) > KEPT:
        del _kept.work[next(iter(_kept.work))]
    return None if failed == at.PASSES else int(failed), verdict, multipliers


def _borrow(structure: tuple[Any, ...]) -> Workspace:
    """A workspace that nobody else uses: if there is one, that of the last call with this structure."""
    try:
        found: Workspace | None = _kept.work.pop(structure, None)
    except AttributeError:
        found, _kept.work = None, {}
    return Workspace(structure) if found is None else found
