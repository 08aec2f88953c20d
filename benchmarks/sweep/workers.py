"""Runs the cells of a sweep: in this process, in local processes, or on a Dask cluster, with the same results.

Each yields pairs of a cell and its result, in any order, and gives a cell to another worker when the one that had it
dies. A worker whose source files differ from the caller's refuses to measure.
"""

from __future__ import annotations

import platform
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from typing import Any, NamedTuple

from hqp import InvalidInput

from .cell import Row, measure
from .machine import describe, sources
from .plan import Cell, Plan

#: How many workers a cell may lose before it counts as what kills them.
LIVES = 3
#: How long to wait for a cluster and its workers [s].
PATIENCE = 30


class Measured(NamedTuple):
    """A finished cell, and where it was measured."""

    rows: list[Row]
    machine: dict[str, str]


class Failed(NamedTuple):
    """A cell that could not be measured: the traceback."""

    why: str


Done = tuple[Cell, Measured | Failed]


def work(plan: Plan, cell: Cell, wanted: str) -> Done:
    """Measure one cell, here, if the sources are those that are wanted."""
    if sources() != wanted:
        return cell, Failed(f"{platform.node()}: other sources or package versions, {sources()} in place of {wanted}\n")
    try:
        return cell, Measured(measure(plan, cell), describe())
    except Exception:  # nothing that one cell does may cost the others
        return cell, Failed(traceback.format_exc())


def serial(plan: Plan, cells: Sequence[Cell]) -> Iterator[Done]:
    """One after the other, in this process."""
    return (work(plan, cell, sources()) for cell in cells)


def processes(plan: Plan, cells: Sequence[Cell], jobs: int) -> Iterator[Done]:
    """In so many processes, or -1 for one a core, by joblib."""
    from joblib import Parallel
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    left, lost = list(cells), Counter[Cell]()
    while left:
        fresh, begun = [cell for cell in left if not lost[cell]], list[Cell]()
        at_once = "n_jobs" if fresh else 1  # suspects come last, and alone, so that none suffers from another
        parallel = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1, pre_dispatch=at_once)
        results = parallel(_handed_out(plan, fresh or left, begun))
        try:
            for cell, result in results:
                left.remove(cell)
                yield cell, result
        except TerminatedWorkerError:  # all workers go with it; what they had is done again
            lost.update(cell for cell in begun if cell in left)
            for cell in [cell for cell in left if lost[cell] >= LIVES]:
                left.remove(cell)
                yield cell, Failed(f"its process died, {LIVES} times\n")
        finally:
            with warnings.catch_warnings(action="ignore", category=UserWarning):  # whoever stops here knows
                results.close()


def _handed_out(plan: Plan, cells: Sequence[Cell], begun: list[Cell]) -> Iterator[Any]:
    """The work of these cells, one by one as they are asked for, which `begun` remembers."""
    from joblib import delayed

    for cell in tuple(cells):
        begun.append(cell)
        yield delayed(work)(plan, cell, sources())


def cluster(plan: Plan, cells: Sequence[Cell], address: str) -> Iterator[Done]:
    """On the workers of the Dask cluster whose scheduler has this address.

    Raises
    ------
    InvalidInput
        If there is no cluster, or a worker would measure something else: other sources, several threads at once. If
        the scheduler is lost on the way.
    """
    try:
        from dask.distributed import Client, KilledWorker, as_completed
        from distributed.comm import CommClosedError
    except ImportError:
        raise InvalidInput("--dask needs the package 'distributed': python -m pip install -e '.[cluster]'") from None

    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        raise InvalidInput(f"--dask {address}: no cluster answers: {error}") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise InvalidInput(f"--dask {address}: the cluster has no workers") from None
        _check(client, address)
        futures = {client.submit(work, plan, cell, sources(), pure=False): cell for cell in cells}
        for future in as_completed(list(futures)):
            try:
                yield future.result()
            except KilledWorker as error:
                yield futures[future], Failed(f"{error}\n")
            except (CancelledError, CommClosedError):  # as it goes, or while an answer is on its way
                raise InvalidInput(f"--dask {address}: the scheduler is lost; what was finished is kept") from None
            future.release()


def _check(client: Any, address: str) -> None:
    for worker, number in client.nthreads().items():
        if number != 1:
            raise InvalidInput(f"--dask {address}: worker {worker} has {number} threads; start it with --nthreads 1")
    try:
        digests = client.run(sources)
    except ImportError as error:
        raise InvalidInput(f"--dask {address}: a worker lacks our sources, start it in the checkout: {error}") from None
    for worker, theirs in digests.items():
        if theirs != sources():
            raise InvalidInput(f"--dask {address}: worker {worker} has other sources or package versions")
