"""What the kernel leaves alone: the heap, the interpreter's lock, and Numba until it is needed."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from numba.core.registry import cpu_target
from numba.core.runtime import _nrt_python, rtsys

from hqp import Hierarchy, Level, Settings, Solver
from hqp.backends.native import Memory, warm_up
from hqp.kernels import layout as at
from hqp.kernels.workspace import Workspace
from hqp.problems import random_hierarchy


@pytest.fixture
def allocations() -> Iterator[Callable[[], tuple[int, ...]]]:
    """Counts of what compiled code has taken from the heap and given back."""
    _nrt_python.memsys_enable_stats()
    yield rtsys.get_allocation_stats
    _nrt_python.memsys_disable_stats()


def test_10_000_solves_warm_and_cold_take_nothing_from_the_heap(allocations: Callable[[], tuple[int, ...]]) -> None:
    made = [random_hierarchy(np.random.default_rng(seed)) for seed in range(200)]
    solvers = [Solver("native") for _ in made]
    before = allocations()
    for turn in range(50):
        for h, solver in zip(made, solvers, strict=True):
            if turn % 3 == 0:
                solver.forget()
            solver.solve(h)
            h.lower += 0.01
            h.upper += 0.01
    assert allocations() == before


@pytest.mark.parametrize("damping", [{}, {0: 0.1}], ids=["strict", "damped"])
def test_a_solver_that_forgets_is_as_new_in_all_that_follows(damping: dict[int | str, float]) -> None:
    """To the last bit, and by the same iterations: also where the second solve is warm from the first."""
    for seed in range(100):
        h, rng = random_hierarchy(np.random.default_rng(seed)), np.random.default_rng([seed, 1])
        lower, upper = h.lower.copy(), h.upper.copy()
        shifts = [rng.uniform(-1.0, 1.0, h.m) for _ in range(7)]

        def answers(solver: Solver, some: list[np.ndarray], h: Hierarchy = h, ends: Any = (lower, upper)) -> list[Any]:
            found = []
            for shift in some:
                h.lower[:], h.upper[:] = ends[0] + shift, ends[1] + shift
                solution = solver.solve(h)
                found.append((solution.x.tobytes(), solution.counts))
            return found

        used = Solver(damping=damping)
        answers(used, shifts[:4])
        used.forget()
        assert answers(used, shifts[4:]) == answers(Solver(damping=damping), shifts[4:]), seed


def test_what_compiled_code_takes_from_the_heap_is_counted(allocations: Callable[[], tuple[int, ...]]) -> None:
    """Or the test above would prove nothing."""
    rtsys.initialize(cpu_target.target_context)
    before = allocations()
    block = rtsys.meminfo_alloc(64)
    assert allocations() != before
    del block


def lets_others_in(call: Callable[[], object]) -> bool:
    """Whether another thread gets to run during one of 100 calls.

    The interpreter would not switch threads by itself for an hour, so that only a call which lets go of its lock does.
    """
    gate, came = threading.Lock(), []

    def other() -> None:
        with gate:
            came.append(True)

    interval = sys.getswitchinterval()
    sys.setswitchinterval(3600.0)
    gate.acquire()
    thread = threading.Thread(target=other)
    try:
        thread.start()
        gate.release()
        for _ in range(100):
            call()
            if came:
                return True
        return False
    finally:
        sys.setswitchinterval(interval)
        thread.join()


def test_other_threads_run_while_the_kernel_does() -> None:
    warm_up()
    n, rng = 60, np.random.default_rng(0)
    A = rng.integers(-3, 4, (4 * n, n)).astype(float)  # a vertex, where the safe method takes its time
    h = Hierarchy([Level(A, -np.inf, A @ np.ones(n)), Level.equality(np.eye(n), 1.0 + A.sum(axis=0))])
    memory, solver = Memory(h.structure, Settings()), Solver("native")

    def run() -> None:
        memory.head[at.WARM] = 0
        memory.run(h.address)

    def solve() -> None:
        solver.forget()
        solver.solve(h)

    assert lets_others_in(run)
    assert lets_others_in(solve)
    assert memory.head[at.ITERATIONS] > 0
    assert not lets_others_in(lambda: sum(range(100_000))), "a call that keeps the lock is told apart"


def test_numba_is_imported_when_a_solver_is_made_and_not_before() -> None:
    code = "import sys, hqp; assert 'numba' not in sys.modules; hqp.Solver(); assert 'numba' in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_every_array_begins_with_a_line_of_the_cache() -> None:
    """A step of a loop over whole lines then reads one line, not two; and rows of whole lines stay so."""
    line = 8 * at.PAD
    for seed in range(50):
        work = Workspace(random_hierarchy(np.random.default_rng(seed)).structure)
        for place in at.PLACES[1]:
            assert work.floats(int(place)).ctypes.data % line == 0
