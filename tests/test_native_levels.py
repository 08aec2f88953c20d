"""The native solver level by level: what is saturated, stopped, taken up again, far away, or asked once."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import hqp
from hqp import Hierarchy, Level, Settings, Solution, Solver, Status
from hqp import solve as module_solve
from hqp.backends.native import Native, warm_up
from hqp.kernels import layout as at
from hqp.kernels.judge import judge
from hqp.kernels.ready import door
from hqp.problems import random_hierarchy

HARD = Path(__file__).parent / "data" / "hard"
BACKEND = "native"


def case(name: str) -> tuple[Hierarchy, np.ndarray]:
    """A hierarchy on which solvers did badly, and its x_ref."""
    h, x_ref = hqp.load(HARD / f"{name}.npz")
    return h, np.zeros(h.n) if x_ref is None else x_ref


def proved(solution: Solution) -> bool:
    return solution.ok and solution.certify().ok


def saturated(rng: np.random.Generator, n: int = 16) -> Hierarchy:
    """Equations, then cones with their apex at zero and two-sided rows, then tasks that ask for far too much."""
    half = n // 2
    M, J = rng.standard_normal((half, half)), rng.standard_normal((half, half))
    face = np.array([[1.0, 0.0, -0.7], [-1.0, 0.0, -0.7], [0.0, 1.0, -0.7], [0.0, -1.0, -0.7]])
    points = half // 3
    cones = np.hstack([np.zeros((4 * points, n - 3 * points)), np.kron(np.eye(points), face)])
    torques = np.hstack([M, -J])
    return Hierarchy(
        [
            Level.equality(np.hstack([M, -J])[:3], 0.3 * rng.standard_normal(3), name="motion"),
            Level(
                np.vstack([cones, torques[3:]]),
                np.r_[np.full(len(cones), -np.inf), np.full(half - 3, -1.0)],
                np.r_[np.zeros(len(cones)), np.full(half - 3, 1.0)],
                name="limits",
            ),
            Level.equality(rng.standard_normal((3, n)), 20.0 * rng.standard_normal(3), name="hand"),
            Level.equality(rng.standard_normal((n, n)), rng.standard_normal(n), name="rest"),
        ]
    )


def draws(count: int) -> Iterator[Hierarchy]:
    return (saturated(np.random.default_rng(seed)) for seed in range(count))


# What is saturated.


@pytest.mark.parametrize("name", sorted(file.stem for file in HARD.glob("*.npz")))
def test_what_was_hard_is_optimal_and_certified(name: str) -> None:
    h, x_ref = case(name)
    solver = Solver(BACKEND)
    for _ in range(3):  # cold, warm, and cold again
        assert proved(solver.solve(h, x_ref))
    solver.forget()
    assert proved(solver.solve(h, x_ref))


def test_dozens_of_active_inequalities_are_certified_cold_and_warm() -> None:
    solver, active = Solver(BACKEND), []
    for h in draws(150):
        solution = solver.solve(h)
        assert proved(solution)
        active.append(int(np.count_nonzero(solution.levels[1].active)))
        h.lower[-16:] = h.upper[-16:] = h.lower[-16:] + 0.3
        assert proved(solver.solve(h))
    assert np.median(active) >= 4


# What was solved before.


@pytest.mark.parametrize("name", ["sequence-1", "sequence-2"])
def test_the_answer_is_that_of_the_data_and_not_of_what_was_solved_before(name: str) -> None:
    (before, first_ref), (h, x_ref) = case(f"{name}-before"), case(name)
    solver = Solver(BACKEND)
    solver.solve(before, first_ref)
    for _ in range(3):
        solution = solver.solve(h, x_ref)
        assert proved(solution)
        alone = Solver(BACKEND).solve(h, x_ref).x
        np.testing.assert_allclose(solution.x, alone, rtol=0, atol=1e-9 * (1.0 + np.linalg.norm(alone)))


def test_a_solver_that_goes_from_one_problem_to_any_other_answers_as_a_fresh_one() -> None:
    made = list(draws(40))
    rng, solver = np.random.default_rng(5), Solver(BACKEND)
    for k in rng.integers(0, len(made), 200):
        x, alone = solver.solve(made[k]).x, Solver(BACKEND).solve(made[k]).x
        np.testing.assert_allclose(x, alone, rtol=0, atol=1e-8 * np.linalg.norm(alone))


def test_no_number_is_read_before_it_is_written() -> None:
    """Memory is not zeroed: whatever lies there, the answer is the same to the last bit."""
    made = [*draws(20), *(random_hierarchy(np.random.default_rng(seed)) for seed in range(200))]
    for h in made:
        answers = []
        for junk, mark in ((0.0, 0), (np.nan, -7), (1e300, 1 << 40)):
            solver = Solver(BACKEND)
            solver._adopt(h)
            memory = solver._backend._memory  # type: ignore[attr-defined]
            ints, floats = memory._blocks
            kept = memory.option.copy()
            ints[:], floats[:] = mark, junk
            memory.option[:], memory.x_ref[:] = kept, 0.0
            answers.append(solver.solve(h).x)
        assert np.array_equal(answers[0], answers[1])
        assert np.array_equal(answers[0], answers[2])


def test_a_warm_solve_begins_level_by_level_where_the_last_one_found_other_sides_so() -> None:
    """Sides that have just turned mostly turn again: no sweep is made in vain. Once they stay, one sweep is all."""
    sweeps = {"turned": 0, "settled": 0}
    for seed in range(60):
        rng = np.random.default_rng(seed)
        first = saturated(rng)
        targets = [10.0 * rng.standard_normal(first.m) for _ in range(2)]
        turned, settled = Solver(BACKEND), Solver(BACKEND)
        second, third = (asked(first, target) for target in targets)
        for h in (first, second):
            turned.solve(h)
        for h in (first, second, second):
            settled.solve(h)
        again = settled.solve(second)
        assert again.counts.sweeps == 1
        assert again.counts.iterations == 0
        one, other = turned.solve(third), settled.solve(third)
        assert proved(one)
        np.testing.assert_allclose(one.x, other.x, rtol=0, atol=1e-8 * np.linalg.norm(other.x))
        sweeps["turned"] += one.counts.sweeps
        sweeps["settled"] += other.counts.sweeps
    assert sweeps["turned"] < sweeps["settled"]


def asked(h: Hierarchy, target: np.ndarray) -> Hierarchy:
    """The same limits, and equalities that ask for so much more."""
    twin = h.copy()
    equal = twin.lower == twin.upper
    twin.lower[equal] += target[equal]
    twin.upper[equal] += target[equal]
    return twin


def test_the_certificate_in_a_solver_hangs_on_x_alone_not_on_the_sides_it_is_told() -> None:
    """The sides tell where its search begins: right, wrong or none, the verdict is the same, for good x and for bad."""
    verdicts, rng = set(), np.random.default_rng(7)
    for h in draws(30):
        solver = Solver(BACKEND)
        x, memory = solver.solve(h).x, solver._backend._memory  # type: ignore[attr-defined]
        sides = memory.ints(at.SIDE)
        right = sides.copy()
        some = np.where(rng.random(right.shape) < 0.5, right, rng.integers(-1, 2, right.shape))
        for moved in (0.0, 1e-3):
            found = []
            for told in (right, some, np.zeros_like(right), np.where(right == 0, 1, 0)):
                sides[:], memory.x[:] = told, x + moved * np.linalg.norm(x)
                found.append(door(judge)(memory.address, 0))
            assert len(set(found)) == 1, found
            verdicts.add((moved, found[0] == at.PASSES))
    assert verdicts == {(0.0, True), (1e-3, False)}


# What is stopped.


@pytest.mark.parametrize("iterations", [1, 3, 7, 12])
def test_stopped_anywhere_the_levels_above_are_exact_and_what_stopped_it_is_named(iterations: int) -> None:
    stopped = []
    for h in draws(60):
        solution = Solver(BACKEND, Settings(iterations=iterations)).solve(h)
        assert solution.counts.iterations <= iterations
        if solution.ok:
            assert proved(solution)
            continue
        assert solution.status is Status.SUBOPTIMAL
        assert solution.level is not None
        certificate = solution.certify()
        assert all(level.ok for level in certificate.levels[: solution.level]), str(certificate)
        stopped.append(solution.level)
    assert stopped


def test_the_level_where_it_stopped_is_no_worse_than_where_it_began() -> None:
    """One step from the point that is exact above: what is known of the level by then makes it better, or nothing."""
    warm_up()
    for h in draws(60):
        native = Native(Settings(iterations=12))
        native.prepare(h.structure).run(h.numbers, np.empty(h.n))
        answer = native.solve(h, np.zeros(h.n))
        if answer.level is None or answer.level >= len(h.levels):
            continue
        k = answer.level
        assert native._memory is not None
        began = hqp.certify(h, native._memory.floats(at.EXACT)[:, 0].copy())
        assert all(level.ok for level in began.levels[:k])
        stopped = hqp.certify(h, answer.x).levels[k].residual_norm
        assert stopped <= began.levels[k].residual_norm * (1.0 + 1e-9) + 1e-9


@pytest.mark.parametrize("solve", [lambda h, s: Solver(BACKEND, s).solve(h), lambda h, s: hqp.solve(h, settings=s)])
def test_a_time_limit_is_kept_in_every_loop(solve: Callable[[Hierarchy, Settings], Solution]) -> None:
    h = saturated(np.random.default_rng(1), n=90)
    solve(h, Settings())
    for limit in (1e-9, 1e-5, 1e-4):
        solution = solve(h, Settings(time_limit=limit))
        certificate = solution.certify()
        assert solution.ok or all(level.ok for level in certificate.levels[: solution.level])
    assert solve(h, Settings(time_limit=1e-9)).status is Status.SUBOPTIMAL
    assert solve(h, Settings(time_limit=60.0)).ok


@pytest.mark.parametrize("solve", [lambda h, s: Solver(BACKEND, s).solve(h), lambda h, s: hqp.solve(h, settings=s)])
@pytest.mark.parametrize("damping", [None, 0.1])
def test_what_memory_holds_by_chance_is_no_answer(
    solve: Callable[[Hierarchy, Settings], Solution], damping: float | None
) -> None:
    """A time or iteration limit may end a solve before anything was written."""
    rng = np.random.default_rng(3)
    for k in range(40):
        h = saturated(np.random.default_rng(k), n=16 + 2 * (k % 8))
        stopped = Settings(time_limit=10.0 ** rng.uniform(-9, -3)) if k % 4 else Settings(iterations=1 + k // 4)
        rubbish = [np.full(int(size), np.nan) for size in 2.0 ** rng.uniform(3, 19, 60)]
        del rubbish  # free memory that is not zero
        solution = solve(h, stopped) if damping is None else Solver(BACKEND, stopped, damping={2: damping}).solve(h)
        assert np.isfinite(solution.x).all()
        assert np.abs(solution.x).max() < 1e6


def test_a_time_limit_counts_from_the_call(monkeypatch: pytest.MonkeyPatch) -> None:
    """What has to be made ready first is part of it."""
    h = saturated(np.random.default_rng(2))
    late = time.monotonic_ns() - 10_000_000_000
    monkeypatch.setattr(time, "monotonic_ns", lambda: late)
    assert Solver(BACKEND, Settings(time_limit=1.0)).solve(h).status is Status.SUBOPTIMAL
    assert hqp.solve(h, settings=Settings(time_limit=1.0)).status is Status.SUBOPTIMAL
    assert hqp.solve(h, settings=Settings(time_limit=60.0)).ok


# What is far away.


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3, 1e7])
def test_what_must_not_move_is_certified_however_far_its_reference_is(size: float) -> None:
    """Safety filters, and robots that stand still: x next to zero."""
    rng = np.random.default_rng(3)
    for _ in range(60):
        n = int(rng.integers(2, 9))
        zero, some = np.zeros(int(rng.integers(1, 2 * n + 3))), int(rng.integers(1, n + 2))
        below = Level(rng.standard_normal((len(zero), n)), -np.inf, zero)
        x_ref = size * rng.standard_normal(n)
        assert proved(Solver(BACKEND).solve(Hierarchy([below]), x_ref))
        still = Level.equality(rng.standard_normal((some, n)), 1e-17 * rng.standard_normal(some))
        assert proved(Solver(BACKEND).solve(Hierarchy([still, below]), x_ref))
        limits, posture = Level.bounds(-np.ones(n), np.ones(n)), Level.bounds(x_ref, x_ref)
        assert proved(Solver(BACKEND).solve(Hierarchy([limits, still, posture])))


# What is asked once.


def test_one_shot_answers_as_a_solver_that_was_just_made() -> None:
    for turn in range(2):
        for seed in range(40):  # more structures than are kept
            h = random_hierarchy(np.random.default_rng(seed))
            assert np.array_equal(hqp.solve(h).x, Solver(BACKEND).solve(h).x), (turn, seed)


def test_only_a_few_solvers_are_kept_and_every_thread_has_its_own() -> None:
    from hqp.solver.once import KEPT, _kept

    for n in range(1, 3 * KEPT):
        hqp.solve(Hierarchy([Level.bounds(np.zeros(n), np.ones(n))]))
    mine = dict(_kept.solvers)
    assert len(mine) == KEPT
    found: list[object] = []

    def other() -> None:
        module_solve(Hierarchy([Level.bounds(np.zeros(2), np.ones(2))]))
        found.extend(_kept.solvers.values())

    thread = threading.Thread(target=other)
    thread.start()
    thread.join()
    assert len(found) == 1
    assert found[0] not in mine.values()


@pytest.mark.parametrize("slight", [3e-10, 1e-10, 3e-11])
def test_what_a_level_hardly_feels_does_not_take_x_far(slight: float) -> None:
    """Two rows that differ by less than the rank threshold ask for a step of 1 / slight; a row above holds x back."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        Q = np.linalg.qr(rng.standard_normal((3, 3)))[0]
        wall = Level(Q[:, 1:2].T, [0.0], [np.inf])
        apart = Level.equality(np.array([[1.0, slight, 0.0], [1.0, -slight, 0.0]]) @ Q.T, [1.0, -1.0])
        solution = module_solve(Hierarchy([wall, apart]), x_ref=Q @ [0.3, -1.0, 0.5], backend=BACKEND)
        assert proved(solution)
        np.testing.assert_allclose(Q.T @ solution.x, [0.0, 0.0, 0.5], atol=1e-6)
        assert solution.counts.iterations < 40
