"""Kernels as built-in functions, and the short way of a solver through them."""

from __future__ import annotations

import gc
import pickle
from typing import Any

import numpy as np
import pytest

from hqp import Hierarchy, InvalidInput, Level, Settings, Solver, Status
from hqp.backends.native import Memory, warm_up
from hqp.kernels import builtin
from hqp.kernels import layout as at
from hqp.kernels import solver as kernel
from hqp.problems import random_hierarchy
from hqp.solution.status import counted


def drawn(count: int) -> list[Hierarchy]:
    """Random hierarchies, with and without a contradiction."""
    return [random_hierarchy(np.random.default_rng(seed)) for seed in range(count)]


@pytest.mark.parametrize("in_python", [False, True], ids=["compiled", "in Python"])
def test_it_tells_what_the_kernel_reports_and_writes_what_it_has_proved(
    in_python: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    warm_up()
    monkeypatch.setattr(builtin, "INTERPRETED", in_python or builtin.INTERPRETED)
    proved = refused = 0
    for h in drawn(60):
        for budget in 1, 1000:
            memory = Memory(h.structure, Settings(iterations=budget))
            x, untouched = np.full(h.n, np.nan), np.full(h.n, np.nan)
            told = builtin.runner(memory, kernel.solve)(h.numbers, x)
            if memory.head[at.OUTCOME] == 0:
                proved += 1
                assert counted(told)[:2] == (memory.head[at.SWEEPS], memory.head[at.ITERATIONS])
                assert np.array_equal(x, memory.x)
            else:
                refused += 1
                assert told == -1
                assert np.array_equal(x, untouched, equal_nan=True)
    assert min(proved, refused) > 5


def test_it_refuses_another_number_of_arguments_and_outlives_all_that_made_it() -> None:
    warm_up()
    (h,) = drawn(1)
    memory = Memory(h.structure, Settings())
    run, x = builtin.runner(memory, kernel.solve), np.empty(h.n)
    for wrong in (), (h.numbers,), (h.numbers, x, x):
        with pytest.raises((SystemError, TypeError)):
            run(*wrong)
    del memory
    gc.collect()
    spoilt = [np.full(size, np.nan) for size in range(2, 4000)]  # where the workspace would have been
    assert np.isnan(spoilt[-1]).all()
    assert run(h.numbers, x) >= 0
    np.testing.assert_allclose(x, Solver().solve(h).x, atol=1e-9)


@pytest.mark.parametrize("sweeps", [0, 1, 7])
@pytest.mark.parametrize("iterations", [0, 1, 2**31 - 1])
def test_sweeps_and_iterations_are_told_in_one_number(sweeps: int, iterations: int) -> None:
    assert counted(sweeps + at.ITERATION * iterations)[:2] == (sweeps, iterations)


def calls(h: Hierarchy, other: Hierarchy, rng: np.random.Generator) -> list[tuple[Hierarchy, Any, Any]]:
    """Calls of one solver, good and bad: x_ref and aims may be given, and those of another structure come between."""
    x, aim = rng.standard_normal(h.n), {1: rng.standard_normal(h.n)}
    bad: list[tuple[Hierarchy, Any, Any]] = [
        (h, np.zeros(h.n + 1), None),
        (other, np.zeros(other.n + 1), None),
        (h, np.full(h.n, np.nan), None),
        (h, None, {0: x}),
        ("no hierarchy", None, None),  # type: ignore[list-item]
    ]
    return [(h, None, None), (h, x, None), (other, None, None), (h, None, aim), (h.copy(), x, aim), *bad]


@pytest.mark.parametrize("limit", [np.inf, 10.0])
@pytest.mark.parametrize("damping", [{}, {1: 0.3}], ids=["plain", "damped"])
@pytest.mark.parametrize("backend", ["native", "cascade:qpsolvers/quadprog"])
def test_an_answer_does_not_depend_on_the_calls_before(
    backend: str, damping: dict[int | str, float], limit: float
) -> None:
    """What is left out, because nothing but numbers has changed since the last call, was indeed as before."""
    rng, settings = np.random.default_rng(3), Settings(time_limit=limit)
    limits = Level.bounds(-np.ones(4), np.ones(4))
    h = Hierarchy([limits, Level.equality(rng.standard_normal((2, 4)), [0.3, 0.2])])
    other = Hierarchy([limits, Level.equality(rng.standard_normal((3, 4)), [0.1, 0.2, 0.3])])
    solver, made = Solver(backend, settings, damping), calls(h, other, rng)
    for k in rng.integers(0, len(made), 150):
        answers = []
        for each in solver, Solver(backend, settings, damping):
            try:
                answers.append(each.solve(*made[k]))
            except InvalidInput as refusal:
                answers.append(str(refusal))
        if isinstance(answers[1], str):
            assert answers[0] == answers[1]
            continue
        assert answers[0].status is answers[1].status
        np.testing.assert_allclose(answers[0].x, answers[1].x, atol=1e-9)
        np.testing.assert_array_equal(answers[0].x_ref, answers[1].x_ref)
        assert answers[0].aims.keys() == answers[1].aims.keys()


def test_counts_are_those_of_their_own_solve_whenever_they_are_read() -> None:
    solver, made = Solver(), drawn(40)
    read = [Solver().solve(h).counts for h in made]
    later = []
    for h in made:
        solver.forget()
        later.append(solver.solve(h))
    assert [solution.counts for solution in later] == read
    assert [pickle.loads(pickle.dumps(solution)).counts for solution in later] == read
    assert len(set(read)) > 3


def test_numbers_that_mean_nothing_leave_the_short_way() -> None:
    (h,) = drawn(1)
    solver = Solver()
    assert solver.solve(h).ok
    right = h.numbers.copy()
    h.numbers[0] = np.nan
    assert solver.solve(h).status is Status.INVALID
    h.numbers[:] = right
    assert solver.solve(h).certify().ok
