"""Solving a batch on all cores, each hierarchy exactly and warm from its own last time.

A compiled loop solves them one after the other without the interpreter, and several threads share them. No answer
depends on the number of threads, nor on its neighbours.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, real_array
from ..checks import SetOnce, of_type, whole_number
from ..errors import InvalidInput
from ..guard import Guard
from ..hierarchy import LARGEST, Hierarchy
from ..settings import Settings
from ..solution import Counts, Solution, Status
from .batch import Batch, BatchSolution
from .solver import Solver

if TYPE_CHECKING:
    from ..backends.base import Answer
    from ..backends.native import Memory

#: Pieces of work a thread: small enough that none waits long for the last.
PIECES = 4
#: The most threads.
MOST_THREADS = 1024


class BatchSolver(SetOnce):
    """Solves batches with the native solver, each hierarchy warm from its own last time.

    Parameters
    ----------
    settings : Settings, optional
    threads : int, optional
        Default: as many as there are cores for this process.

    Raises
    ------
    InvalidInput
        If the settings are none, or threads is no integer from 1 to 1024.

    Examples
    --------
    >>> from hqp import Batch, BatchSolver, Hierarchy, Level
    >>> batch = Batch(Hierarchy([Level.equality([[1.0, 1.0]], [3.0], name="sum")]), 2)
    >>> BatchSolver(threads=1).solve(batch).x
    array([[1.5, 1.5],
           [1.5, 1.5]])
    """

    _stays = frozenset(("settings", "threads"))

    def __init__(self, settings: Settings | None = None, threads: int | None = None) -> None:
        from ..backends.native import warm_up

        warm_up()
        self.settings = Settings() if settings is None else of_type(settings, Settings, "settings")
        self.threads = _cores() if threads is None else whole_number(threads, "threads", least=1, most=MOST_THREADS)
        self._structure: tuple[object, ...] | None = None
        self._sides = np.zeros((0, 0), dtype=np.int64)
        self._memories: SimpleQueue[Memory] = SimpleQueue()
        self._warm = False
        self._pool: ThreadPoolExecutor | None = None
        self._guard, self._pid = Guard("the batch solver"), os.getpid()

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy is made from what defines it, and cold: threads and their memory are its own."""
        return type(self), (self.settings, self.threads)

    def forget(self) -> None:
        """Make the next call a cold one."""
        self._warm = False

    def solve(self, batch: Batch, x_ref: ArrayLike | None = None) -> BatchSolution:
        """Solve all of them; numbers never raise, see :class:`Solver`.

        Parameters
        ----------
        batch : Batch
        x_ref : array, shape (n,) or (B, n), optional
            Reference of the implicit last level (default: zero).

        Raises
        ------
        InvalidInput
            If `batch` is none, or x_ref is no such array.
        InUse
            If another thread is solving with it.
        """
        of_type(batch, Batch, "what a BatchSolver solves")
        with self._guard:
            return self._solve(batch, x_ref)

    def _solve(self, batch: Batch, x_ref: ArrayLike | None) -> BatchSolution:
        from ..backends.native import STATUSES, judged
        from ..kernels.active_set import OPTIMAL

        if self._pid != os.getpid():  # a forked child, which has none of the threads
            self._pid, self._pool, self._structure = os.getpid(), None, None
        count, n, m = len(batch), batch._template.n, batch._template.m
        reference = _reference(x_ref, count, n)
        if batch.structure != self._structure or self._sides.shape != (count, m):
            self._prepare(batch)
        x, said = np.zeros((count, n)), np.zeros((count, 4), dtype=np.int64)

        def piece(ends: tuple[int, int]) -> None:
            memory = self._memories.get()
            memory.run_many(
                ends, batch.numbers, reference if reference.ndim == 2 else None, x, self._sides, said, self._warm
            )
            self._memories.put(memory)

        if reference.ndim == 1:
            self._share(reference)
        cuts = np.linspace(0, count, min(count, 1 if self.threads == 1 else PIECES * self.threads) + 1).astype(int)
        pieces = list(zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True))
        if self.threads == 1:
            for ends in pieces:
                piece(ends)
        else:
            self._pool = self._pool or ThreadPoolExecutor(self.threads)
            list(self._pool.map(piece, pieces))
        self._warm = True

        statuses, levels, messages = [Status.OPTIMAL] * count, np.full(count, -1, dtype=np.int64), {}
        for b in np.flatnonzero(said[:, 0] != OPTIMAL).tolist():
            outcome, level, *counts = said[b].tolist()
            own = reference if reference.ndim == 1 else reference[b]
            alone: Answer | Solution | None = None
            if outcome in STATUSES:
                alone = judged(batch[b], x[b], own, outcome, level, Counts(*counts))
            if alone is None or alone.status is Status.STALLED:  # in doubt, or out of range
                alone = Solver("native", self.settings).solve(batch[b], own)
                x[b], said[b, 2:], self._sides[b] = alone.x, alone.counts[:2], 0
            statuses[b] = alone.status
            if alone.status is not Status.OPTIMAL:
                levels[b], messages[b] = -1 if alone.level is None else alone.level, alone.message
        return BatchSolution(
            batch, x, tuple(statuses), messages, levels, said[:, 2], said[:, 3], reference, self.settings
        )

    def _prepare(self, batch: Batch) -> None:
        from ..backends.native import Memory

        self._structure, self._warm = batch.structure, False
        self._sides = np.zeros((len(batch), batch._template.m), dtype=np.int64)
        self._memories = SimpleQueue()
        for _ in range(self.threads):
            self._memories.put(Memory(batch.structure, self.settings))

    def _share(self, reference: Array) -> None:
        """Tell every thread the x_ref of all."""
        for _ in range(self.threads):
            memory = self._memories.get()
            memory.x_ref[:] = reference
            self._memories.put(memory)


def solve_batch(
    batch: Batch | Iterable[Hierarchy],
    *,
    x_ref: ArrayLike | None = None,
    settings: Settings | None = None,
    threads: int | None = None,
) -> BatchSolution:
    """Solve many hierarchies of one structure once, on all cores.

    Parameters
    ----------
    batch : Batch, or hierarchies
    x_ref : array, shape (n,) or (B, n), optional
    settings : Settings, optional
    threads : int, optional

    Raises
    ------
    InvalidInput
        If the hierarchies differ in structure, or a number of one cannot mean anything; names hierarchy, level and row.

    Examples
    --------
    >>> from hqp import Hierarchy, Level, solve_batch
    >>> hierarchies = [Hierarchy([Level.equality([[1.0, 1.0]], [float(k)], name="sum")]) for k in (1, 2)]
    >>> solve_batch(hierarchies).x
    array([[0.5, 0.5],
           [1. , 1. ]])
    """
    whole = batch if isinstance(batch, Batch) else Batch.of(batch)
    solution = BatchSolver(settings, threads).solve(whole, x_ref)
    for b, message in solution.messages.items():
        if solution.statuses[b] is Status.INVALID:
            raise InvalidInput(f"hierarchy {b} of the batch: {message}")
    return solution


def _cores() -> int:
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity is not None else os.cpu_count() or 1


def _reference(x_ref: ArrayLike | None, count: int, n: int) -> Array:
    if x_ref is None:
        return np.zeros(n)
    reference = real_array(x_ref, "x_ref")
    if reference.shape not in ((n,), (count, n)):
        raise InvalidInput(f"x_ref has shape {reference.shape}; it must be ({n},) or ({count}, {n})")
    if not (np.abs(reference) <= LARGEST).all():
        raise InvalidInput(f"x_ref must be finite, and at most {LARGEST:g} in size")
    return np.ascontiguousarray(reference)
