"""The native solver: one compiled kernel, exact and warm.

All numbers stay where they are: the kernel reads the buffer of the hierarchy, works in memory that is laid out once
a structure, and remembers in it which rows were active. What it does is told in :mod:`hqp.kernels.solver`.
"""

from __future__ import annotations

import sys
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any

import numpy as np
from numba.core import event

from ..arrays import Array, Indices
from ..hierarchy import Hierarchy
from ..kernels import layout as at
from ..kernels import solver as kernel
from ..kernels.active_set import OPTIMAL, STALLED, SUBOPTIMAL
from ..settings import Settings
from ..solution import Counts, Status
from .base import Answer

STATUSES = {
    OPTIMAL: Status.OPTIMAL,
    SUBOPTIMAL: Status.SUBOPTIMAL,
    STALLED: Status.STALLED,
}
#: What almost every tick of a control loop takes.
ONE_SWEEP = Counts(sweeps=1)


class Native:
    """The kernel, its memory, and the active rows of the last call."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._layout: Indices | None = None
        self._reference: Array | None = None

    def solve(self, hierarchy: Hierarchy, x_ref: Array) -> Answer:
        if self._layout is None:
            self._lay_out(hierarchy)
        if x_ref is not self._reference:  # the solver's own zero is always the same array
            self._x_ref[:] = x_ref
            self._reference = x_ref if not x_ref.flags.writeable else None
        outcome = self._kernel(hierarchy.address)
        if outcome == kernel.CLEAR:
            return Answer(self._x.copy(), counts=ONE_SWEEP)
        if outcome == kernel.SUSPECT:
            return self._look_closer(hierarchy, x_ref)
        report = self._marks[: at.MARKS_HEAD].tolist()
        counts = Counts(sweeps=report[at.SWEEPS], iterations=report[at.ITERATIONS])
        status = STATUSES[outcome]
        if status is Status.OPTIMAL:
            return Answer(self._x.copy(), counts=counts)
        level = report[at.LEVEL]
        return Answer(self._x.copy(), status, self._why(hierarchy, status, level, counts), level, counts)

    def reset(self) -> None:
        self._layout = None

    def _look_closer(self, hierarchy: Hierarchy, x_ref: Array) -> Answer:
        """A number is out of range, or a row is so long that one of its entries could be."""
        fault = hierarchy.find_fault()
        if fault is not None:
            return Answer(x_ref.copy(), Status.INVALID, fault)
        self._marks[at.TRUSTED] = 1
        answer = self.solve(hierarchy, x_ref)
        self._marks[at.TRUSTED] = 0
        return answer

    @staticmethod
    def _why(hierarchy: Hierarchy, status: Status, level: int, counts: Counts) -> str:
        where = hierarchy.label(level) if level < len(hierarchy.levels) else "min ||x - x_ref||"
        what = "the budget ran out" if status is Status.SUBOPTIMAL else "no more progress"
        return f"{what} at {where}, after {counts.iterations} iterations; the levels above are exact"

    def _lay_out(self, hierarchy: Hierarchy) -> None:
        """Memory for hierarchies of this structure."""
        layout, floats, ints = _layout(hierarchy.structure)
        self._layout, self._memory, self._marks = layout, np.zeros(floats), np.zeros(ints, dtype=np.int64)
        given = self._settings
        self._memory[: at.LIMIT + 1] = given.rank_tolerance, given.tolerance, given.iterations, given.time_limit
        self._x_ref, self._x = self._memory[at.MEMORY_HEAD :][: 2 * hierarchy.n].reshape(2, hierarchy.n)
        self._reference = None
        self._kernel = partial(kernel.solve, *(array.ctypes.data for array in (layout, self._memory, self._marks)))


@lru_cache(maxsize=64)
def _layout(structure: tuple[Any, ...]) -> tuple[Indices, int, int]:
    """A structure as the kernel reads it, see :mod:`hqp.kernels.layout`, and the memory that it takes."""
    n, cuts, has_rows, indices = structure
    columns = np.frombuffer(indices, dtype=np.intp)
    owned = [columns[a:b] for a, b in pairwise(cuts)]
    distinct = [not rows and len(np.unique(own)) == len(own) for rows, own in zip(has_rows, owned, strict=True)]
    whole = [alone and len(own) == n for alone, own in zip(distinct, owned, strict=True)]
    dense = columns < 0
    widest = max(map(len, owned), default=0)
    head = np.zeros(at.LAYOUT_HEAD, dtype=np.int64)
    head[: at.BOXED + 1] = n, len(owned), len(columns), dense.sum(), widest, distinct[:1] == [True]
    rows = np.where(dense, np.cumsum(dense) - 1, -1)
    parts = [np.asarray(part, dtype=np.int64) for part in (head, cuts, whole, columns, rows)]
    return np.concatenate(parts), *at.sizes(n, len(owned), len(columns), int(dense.sum()), widest)


class _Announcement(event.Listener):
    """Says in one line that the kernel is being compiled: this takes its time, once."""

    def on_start(self, event: event.Event) -> None:
        if not self.said:
            print(
                "hqp: compiling the native solver, once for this version and machine ...", file=sys.stderr, flush=True
            )
        self.said = True

    def on_end(self, event: event.Event) -> None:
        """Nothing to say."""

    said = False


def warm_up() -> bool:
    """Have the kernel ready: from disk, or compiled now. True if it had to be compiled."""
    if kernel.solve.signatures:
        return False
    listener = _Announcement()
    try:
        with event.install_listener("numba:compile", listener):
            kernel.solve.compile("int64(int64, int64, int64, int64)")
    except OSError:  # a full disk: compiled, but not kept
        if not kernel.solve.signatures:
            raise
    return listener.said


def make(name: str, settings: Settings) -> Native:
    """The backend, ready to run."""
    warm_up()
    return Native(settings)
