"""The native solver: certified, warm or cold, whatever comes between, and nothing of it is shared with callers."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from test_conformance import PROBLEMS

from hqp import Hierarchy, InvalidInput, Level, Solution, Solver, Status, solve, solve_batch
from hqp.problems import FAMILIES, hierarchies, random_hierarchy

BACKEND = "native"
CERTIFIED = [name for name, family in FAMILIES.items() if family.expect == "certified"]


def draw(seed: int) -> tuple[Hierarchy, np.random.Generator]:
    """A random hierarchy, and a generator to do something with it."""
    return random_hierarchy(np.random.default_rng(seed)), np.random.default_rng([seed, 1])


def fresh(h: Hierarchy, x_ref: np.ndarray | None = None) -> Solution:
    """The answer of a solver which has never solved anything else."""
    return Solver(BACKEND).solve(h, x_ref)


def proved(solution: Solution) -> bool:
    return solution.ok and solution.certify().ok


def distance(x: np.ndarray, y: np.ndarray) -> float:
    """Relative, of an x from what it should be."""
    return float(np.linalg.norm(x - y) / max(1.0, float(np.linalg.norm(y))))


def reach(target: float = 1.5) -> Hierarchy:
    return Hierarchy([Level.bounds([-1.0] * 3, [1.0] * 3), Level.equality([[1.0, 1.0, 1.0]], [target], name="sum")])


# What it is for.


@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_problem_of_the_conformance_suite_is_certified(problem: str) -> None:
    solver = Solver(BACKEND)
    h = PROBLEMS[problem]()
    assert proved(solver.solve(h))
    assert proved(solver.solve(h)), "warm"


@pytest.mark.parametrize("first", range(10_000, 10_300, 100))
def test_300_random_hierarchies_are_certified_whatever_x_ref(first: int) -> None:
    solver, wrong = Solver(BACKEND), []
    for seed in range(first, first + 100):
        h, rng = draw(seed)
        x_ref = 10.0 ** rng.uniform(-3, 3) * rng.standard_normal(h.n)
        if not proved(solver.solve(h, x_ref)):
            wrong.append(seed)
    assert wrong == []


@pytest.mark.parametrize("name", CERTIFIED)
def test_families_that_can_be_certified_are(name: str) -> None:
    solver = Solver(BACKEND)
    assert [k for k, h in enumerate(hierarchies(name, 20)) if not proved(solver.solve(h))] == []


def test_it_counts_its_sweeps_and_the_iterations_of_the_safe_method() -> None:
    solver, safe = Solver(BACKEND), 0
    for h in hierarchies("vertex", 120):
        counts = solver.solve(h).counts
        assert counts.sweeps >= 1
        assert counts.iterations >= 0
        assert counts.qp_solves == counts.polishes == counts.levels_solved == 0
        safe += counts.iterations > 0
        assert solver.solve(h).counts[:2] == (1, 0), "the last active rows are the guess, and they are right"
    assert safe >= 3


# Warm.


@pytest.mark.parametrize("size", [1e-6, 1e-2, 1.0])
def test_a_warm_start_changes_the_time_not_the_answer_when_targets_move(size: float) -> None:
    apart = {}
    for seed in range(100):
        h, rng = draw(seed)
        solver = Solver(BACKEND)
        solver.solve(h)
        for step in range(3):
            shift = size * rng.standard_normal(h.m)
            h.lower += shift
            h.upper += shift
            warm, cold = solver.solve(h), fresh(h)
            assert proved(warm), (seed, step)
            apart[seed, step] = distance(warm.x, cold.x)
    assert max(apart.values()) <= 1e-9, max(apart, key=lambda case: apart[case])


@pytest.mark.parametrize("share", [0.05, 0.3, 1.0])
def test_a_warm_start_changes_the_time_not_the_answer_when_matrices_change(share: float) -> None:
    apart = {}
    for seed in range(100):
        h, rng = draw(seed)
        solver = Solver(BACKEND)
        solver.solve(h)
        for step in range(3):
            h.A[:] = (1.0 - share) * h.A + share * rng.standard_normal(h.A.shape)
            h.weights[:] *= 10.0 ** rng.uniform(-0.3, 0.3, h.m)
            warm, cold = solver.solve(h), fresh(h)
            assert proved(warm), (seed, step)
            apart[seed, step] = distance(warm.x, cold.x)
    assert max(apart.values()) <= 1e-9, max(apart, key=lambda case: apart[case])


def test_a_guess_from_quite_another_problem_is_only_a_guess() -> None:
    """Bounds that open, close and change sides between two calls."""
    for seed in range(100):
        h, rng = draw(seed)
        solver = Solver(BACKEND)
        for _ in range(4):
            low, high = np.sort(rng.standard_normal((2, h.m)), axis=0)
            kind = rng.integers(4, size=h.m)
            h.lower[:] = np.where(kind == 0, -np.inf, low)
            h.upper[:] = np.where(kind == 1, np.inf, np.where(kind == 2, low, high))
            h.lower[kind == 2] = low[kind == 2]
            warm = solver.solve(h)
            assert proved(warm), seed
            assert distance(warm.x, fresh(h).x) <= 1e-9, seed


def same(x: np.ndarray, y: np.ndarray) -> bool:
    """Equal to round-off: warm and cold go different ways to the same point."""
    return bool(np.linalg.norm(x - y) <= 1e-11 * np.linalg.norm(y))


def test_another_structure_is_solved_afresh() -> None:
    solver = Solver(BACKEND)
    made = [draw(seed)[0] for seed in range(10)]
    for h in [*made, *reversed(made)]:
        assert same(solver.solve(h).x, fresh(h).x)


# Numbers.


def spoil(h: Hierarchy, rng: np.random.Generator) -> tuple[int, str]:
    """One number that means nothing, anywhere; gives its row and what the message says of it."""
    row = int(rng.integers(h.m))
    fault = rng.choice(["A", "too long", "NaN bound", "crossed", "huge bound", "infinite", "weight"])
    if fault in ("A", "too long") and h.columns[row] < 0:
        place = h.A[int(np.count_nonzero(h.columns[:row] < 0))]
        place[rng.integers(h.n)] = rng.choice([np.nan, np.inf, -np.inf] if fault == "A" else [2e30, -1e300])
        return row, "A["
    if fault == "crossed":
        h.lower[row], h.upper[row] = 1.0, np.nextafter(1.0, 0.0)
        return row, "lower must not exceed upper"
    if fault == "huge bound":
        h.upper[row] = max(2e30, h.lower[row])
        return row, "must be infinite or at most 1e+30"
    if fault == "infinite":
        h.lower[row] = h.upper[row] = rng.choice([-np.inf, np.inf])
        return row, "lower must be below +inf"
    if fault == "weight":
        h.weights[row] = rng.choice([np.nan, np.inf, 0.0, -1.0, 1e31, 1e-31])
        return row, "weight"
    (h.lower if rng.random() < 0.5 else h.upper)[row] = np.nan
    return row, "a bound must be a number"


def test_numbers_that_mean_nothing_are_invalid_where_they_are_and_the_solver_works_on() -> None:
    for seed in range(300):
        h, rng = draw(seed)
        if h.m == 0:
            continue
        solver, good = Solver(BACKEND), h.numbers.copy()
        before = solver.solve(h) if rng.random() < 0.7 else None  # now and then the first call is the bad one
        row, said = spoil(h, rng)
        level, inside = h.locate(row)
        x_ref = rng.standard_normal(h.n)
        solution = solver.solve(h, x_ref)
        assert solution.status is Status.INVALID
        assert solution.message.startswith(f"{h.level_name(level)}, row {inside}: "), solution.message
        assert said in solution.message
        assert np.array_equal(solution.x, x_ref)
        with pytest.raises(InvalidInput, match=f"level {level} .*row {inside}"):
            solve(h, backend=BACKEND)
        h.numbers[:] = good
        after = solver.solve(h)
        assert proved(after), seed
        assert distance(after.x, (before or fresh(h)).x) <= 1e-9


def test_a_row_is_as_long_as_its_entries_permit_and_no_entry_beyond_1e30_passes() -> None:
    solver = Solver(BACKEND)
    h = Hierarchy([Level.equality([[1e30, 1e30, 1e30]], [1e30], name="long"), Level.equality([[0.0, 1.0, 0.0]], [1.0])])
    solution = solver.solve(h)
    assert proved(solution)
    np.testing.assert_allclose(solution.x, [0.0, 1.0, 0.0], atol=1e-9)
    h.A[0, 1] = 1.001e30
    solution = solver.solve(h)
    assert solution.status is Status.INVALID
    assert solution.message == "level 0 ('long'), row 0: A[1] = 1.001e+30 must be at most 1e+30 in size"
    h.A[0, 1] = 1e30
    assert proved(solver.solve(h))


def test_an_x_ref_that_means_nothing_is_invalid_and_leaves_no_trace() -> None:
    solver, h = Solver(BACKEND), reach()
    expected = solver.solve(h).x
    for bad in ([np.nan, 0.0, 0.0], [0.0, np.inf, 0.0], [0.0, 0.0, 1e31]):
        solution = solver.solve(h, bad)
        assert solution.status is Status.INVALID
        assert "x_ref" in solution.message
        assert solution.x.tolist() == [0.0, 0.0, 0.0]
        assert same(solver.solve(h).x, expected)


# What belongs to whom.


def test_x_belongs_to_the_caller() -> None:
    solver, h = Solver(BACKEND), reach()
    first = solver.solve(h)
    kept = first.x.copy()
    h.levels[1].lower[:] = h.levels[1].upper[:] = -2.0
    second = solver.solve(h)
    assert np.array_equal(first.x, kept)
    assert not np.array_equal(second.x, kept)
    second.x[:] = np.nan
    assert proved(solver.solve(h))


def test_a_refill_does_not_change_what_was_solved() -> None:
    solver, h = Solver(BACKEND), reach()
    asked, unasked = solver.solve(h), solver.solve(h)
    snapshot = asked.hierarchy
    h.levels[1].lower[:] = h.levels[1].upper[:] = -2.0
    h.A[:] = 7.0
    solver.solve(h)
    for solution in asked, unasked:
        assert solution.hierarchy.levels[1].lower.tolist() == [1.5]
        assert solution.hierarchy.A.tolist() == [[1.0, 1.0, 1.0]]
        assert solution.certify().ok
        assert [level.name for level in solution.levels] == ["", "sum"]
    assert asked.hierarchy is snapshot
    snapshot.A[:] = 0.0
    assert h.A.tolist() == [[7.0, 7.0, 7.0]]


def test_x_ref_holds_for_one_call() -> None:
    solver, h = Solver(BACKEND), reach()
    zero = solver.solve(h)
    x_ref = np.array([2.0, 0.0, -0.5])
    there = solver.solve(h, x_ref)
    assert proved(there)
    assert distance(there.x, zero.x) > 0.1
    assert np.array_equal(solver.solve(h).x, zero.x)
    x_ref[:] = 0.1  # the same array with other numbers, and one that cannot be written to
    assert np.array_equal(solver.solve(h, x_ref).x, fresh(h, x_ref).x)
    view = x_ref.view()
    view.flags.writeable = False
    first = solver.solve(h, view).x
    x_ref[:] = [0.3, 0.2, 0.9]
    assert np.array_equal(solver.solve(h, view).x, fresh(h, x_ref).x)
    assert not np.array_equal(first, fresh(h, x_ref).x)
    assert there.x_ref.tolist() == [2.0, 0.0, -0.5]
    assert np.array_equal(solver.solve(h).x, zero.x)


COPIES = {
    "copy": Hierarchy.copy,
    "copy.copy": copy.copy,
    "copy.deepcopy": copy.deepcopy,
    **{f"pickle {k}": lambda h, k=k: pickle.loads(pickle.dumps(h, protocol=k)) for k in (2, pickle.HIGHEST_PROTOCOL)},
}


@pytest.mark.parametrize("how", COPIES)
def test_a_copy_is_solved_like_the_original_and_independent_of_it(how: str) -> None:
    for seed in range(20):
        h, rng = draw(seed)
        solver = Solver(BACKEND)
        x = solver.solve(h).x
        twin = COPIES[how](h)
        assert same(solver.solve(twin).x, x)
        assert same(fresh(twin).x, x)
        shift = rng.standard_normal(h.m)
        twin.lower += shift
        twin.upper += shift
        moved = solver.solve(twin)
        assert proved(moved)
        assert same(solver.solve(h).x, fresh(h).x), "the original has its own numbers"
        assert same(solver.solve(COPIES[how](twin)).x, solver.solve(twin).x), "a copy of a copy"
        del h
        assert distance(solver.solve(twin).x, moved.x) <= 1e-9


def test_a_solution_survives_a_copy() -> None:
    h = reach()
    solution = Solver(BACKEND).solve(h)
    for twin in copy.deepcopy(solution), pickle.loads(pickle.dumps(solution)):
        h.lower[:] = -9.0
        assert proved(twin)
        assert np.array_equal(twin.x, solution.x)


def test_solvers_do_not_disturb_each_other() -> None:
    """Same structure, same layout, memory of their own."""
    a, b = Solver(BACKEND), Solver(BACKEND)
    low, high = reach(-1.5), reach(1.5)
    for _ in range(3):
        assert np.array_equal(a.solve(low).x, -b.solve(high).x)


@pytest.mark.parametrize("number", [223, 786])  # a row disappears in the round-off of one 1e10 longer
def test_rows_of_very_different_lengths_are_left_to_the_certificate(number: int) -> None:
    """Solved, as on some processors; or said to be stalled, at the level that the certificate refutes."""
    h = list(hierarchies("scaled rows", number + 1))[number]
    for solution in (Solver("native").solve(h), solve_batch([h])[0]):
        failed = solution.certify().failed
        if failed is None:
            continue
        assert (solution.status, solution.level) == (Status.STALLED, failed.level)
        assert f"no more progress at {h.level_name(failed.level)}, after" in solution.message


def test_a_row_that_holds_a_level_by_less_than_a_sign_is_kept_at_its_bound_by_the_certificate() -> None:
    bounds = Level(np.eye(3)[:2], [-np.inf, -np.inf], [0.0, 0.0])
    h = Hierarchy([bounds, Level.equality(np.eye(3)[:2], [0.5, 1e3]), Level.equality(np.eye(3)[[0, 2]], [-1.0, 0.5])])
    solver = Solver()
    assert solver.solve(h).ok
    h.levels[1].lower[0] = h.levels[1].upper[0] = 5e-9  # so small a share of the forces of this level has no clear sign
    solution = solver.solve(h)
    assert solution.ok
    assert solution.certify().ok
    assert (solution.counts.sweeps, solution.counts.iterations) == (2, 0)
    np.testing.assert_allclose(solution.x, [0.0, 0.0, 0.5], atol=1e-12)


def test_numbers_as_small_as_can_be_give_numbers() -> None:
    """A share of the least number of all is 0: rows without a violation joined by it, and x was infinite, or NaN."""
    rng, least = np.random.default_rng(1), np.nextafter(0.0, 1.0)
    for _ in range(200):
        n, solver = int(rng.integers(2, 7)), Solver(BACKEND)
        rows = [rng.standard_normal((int(rng.integers(1, 5)), n)) for _ in range(int(rng.integers(1, 4)))]
        for _ in range(5):
            levels = [Level.bounds(*(least * rng.integers([[-3] * n, [0] * n], [[1] * n, [4] * n])))]
            for A in rows:
                lower = least * rng.integers(-4, 5, len(A))
                free = rng.random(len(A)) < 0.3
                upper = np.where(free, np.inf, lower + least * rng.integers(0, 3, len(A)))
                levels.append(Level(np.where(free[:, None], 0.0, A), np.where(free, -np.inf, lower), upper))
            solution = solver.solve(Hierarchy(levels), least * rng.integers(-3, 4, n))
            assert np.abs(solution.x).max() <= 1e3 * least
