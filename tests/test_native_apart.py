"""Kernels that stand apart, certificate and safe method: ready before a control loop, awaited by a single solve."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator
from itertools import chain

import numpy as np
import pytest
from test_native import BACKEND

from hqp import Hierarchy, Level, Solver, solve
from hqp.backends import native
from hqp.problems import hierarchies
from hqp.solver import once

#: Where their addresses are.
PLACES = list(native.APART)

ALONE = """
from hqp import Hierarchy, Level, Solver, solve
from hqp.kernels.call import is_ready

h = Hierarchy([Level.bounds([-1.0, -1.0], [1.0, 1.0]), Level.equality([[1.0, 1.0]], [3.0])])
x = solve(h).x
from hqp.backends.native import APART

print([is_ready(kernel) for kernel in APART.values()], x)
solver = Solver()
print([is_ready(kernel) for kernel in APART.values()], solver.solve(h).x)
"""


def test_a_single_solve_does_not_wait_for_them_and_a_solver_has_them_when_it_is_made() -> None:
    """In a process of its own: here they are ready."""
    done = subprocess.run([sys.executable, "-c", ALONE], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["[False, False] [1. 1.]", "[True, True] [1. 1.]"]


def drawn() -> Iterator[Hierarchy]:
    """Many that the first sweep does not prove."""
    return chain.from_iterable(
        hierarchies(name, 40) for name in ("vertex", "one point", "scaled rows", "nearly singular", "weights")
    )


def test_a_single_solve_that_comes_to_one_is_what_it_would_have_been(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is repeated with all of them, from nothing that the first time has left."""
    compile_all, waited = native.warm_up, list[bool]()

    def wait() -> bool:
        waited.append(True)
        monkeypatch.setattr(native, "is_ready", lambda kernel: True)
        return compile_all()

    lacked = 0
    monkeypatch.setattr(native, "warm_up", wait)
    for h in drawn():
        expected = Solver(BACKEND).solve(h)
        monkeypatch.setattr(native, "is_ready", lambda kernel: False)
        monkeypatch.setattr(once, "_kept", threading.local())
        waited.clear()
        for _ in range(2):
            found = solve(h, backend=BACKEND)
            assert found.x.tolist() == expected.x.tolist()
            assert (found.status, found.message, found.counts) == (expected.status, expected.message, expected.counts)
        assert len(waited) <= 1, "once is enough"
        lacked += len(waited)
        monkeypatch.setattr(native, "is_ready", lambda kernel: True)
    assert lacked > 10, "many come to one"


@pytest.mark.parametrize("damping", [{}, {1: 0.1}], ids=["plain", "damped"])
def test_every_directory_of_a_solver_has_their_addresses(damping: dict[int | str, float]) -> None:
    h = Hierarchy([Level.bounds([-1.0, -1.0], [1.0, 1.0]), Level.equality([[1.0, 1.0]], [3.0])])
    solver = Solver(BACKEND, damping=damping)
    solver.solve(h)
    memory = solver._backend._memory
    for each in (memory, memory._twin) if damping else (memory,):
        assert np.all(each.head[PLACES] != 0)
