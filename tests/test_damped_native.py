"""Damped levels, all stages at once in the native solver: the answers of stage by stage, each stage proved."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hqp
from hqp import ErrorDamping, FixedDamping, Hierarchy, Level, ManipulabilityDamping, SingularValueDamping, Solver
from hqp.problems import hierarchies, random_hierarchy

seeds = st.integers(0, 2**32 - 1)


class Fixed(FixedDamping):
    """A rule of one's own, which no kernel knows: solved stage by stage."""


class Manipulability(ManipulabilityDamping):
    """The same."""


class SingularValue(SingularValueDamping):
    """The same."""


class Error(ErrorDamping):
    """The same."""


#: Kind of rule, what it is told.
RULES = [
    (FixedDamping, Fixed, (0.3,)),
    (FixedDamping, Fixed, (0.01,)),
    (ManipulabilityDamping, Manipulability, (0.5, 2.0)),
    (SingularValueDamping, SingularValue, (0.5, 1.0)),
    (ErrorDamping, Error, (2.0,)),
    (ErrorDamping, Error, (2.0, 0.3)),
]


def in_stages(solver: Solver) -> bool:
    """Whether it ever had to solve stage by stage."""
    assert solver._staged is not None
    return bool(solver._staged._stages)


def pair(rng: np.random.Generator, levels: int) -> tuple[dict[int, hqp.DampingRule], dict[int, hqp.DampingRule]]:
    """Rules for some levels, at least for one: as the kernel knows them, and as it does not."""
    damped = np.flatnonzero(rng.random(levels) < 0.5).tolist() or [int(rng.integers(levels))]
    chosen = [(k, RULES[rng.integers(len(RULES))]) for k in damped]
    return {k: rule(*told) for k, (rule, _, told) in chosen}, {k: own(*told) for k, (_, own, told) in chosen}


def agree(a: hqp.Solution, b: hqp.Solution, tolerance: float = 1e-9) -> None:
    np.testing.assert_allclose(a.x, b.x, atol=tolerance * (1.0 + np.abs(b.x).max()))
    # Their squares: lambda^2 = c^2 (1 - (sigma / threshold)^2) has the round-off of sigma^2, lambda its square root.
    squares = [{k: strength**2 for k, strength in solution.dampings.items()} for solution in (a, b)]
    assert squares[0] == pytest.approx(squares[1], rel=1e-8, abs=1e-14)
    if any(0.0 < square < 1e-14 for each in squares for square in each.values()):
        return  # whether a level with so little damping is strict, and has no stage of its own, is round-off
    assert len(a.stages) == len(b.stages)
    for mine, theirs in zip(a.stages, b.stages, strict=True):
        np.testing.assert_allclose(mine.x, theirs.x, atol=tolerance * (1.0 + np.abs(theirs.x).max()))


@given(seed=seeds)
@settings(max_examples=60)
def test_all_at_once_is_stage_by_stage_and_every_stage_is_proved(seed):
    rng = np.random.default_rng(seed)
    h = random_hierarchy(rng)
    x_ref = rng.standard_normal(h.n)
    known, own = pair(rng, len(h.levels))
    solver = Solver(damping=known)
    expected = hqp.solve(h, damping=own, x_ref=x_ref)
    for _ in range(2):  # cold, warm
        solution = solver.solve(h, x_ref)
        assert solution.ok
        assert solution.certify().ok
        agree(solution, expected)
    assert not in_stages(solver)


@pytest.mark.sweep
@pytest.mark.parametrize("family", [name for name in hqp.problems.FAMILIES if name != "bad numbers"])
def test_families_are_proved_with_any_level_damped(family):
    undecidable, stalled = hqp.problems.FAMILIES[family].expect == "undecidable rank", []
    for seed, h in enumerate(hierarchies(family, 60)):
        known, _ = pair(np.random.default_rng(seed), len(h.levels))
        solution = hqp.solve(h, damping=known)
        if undecidable and solution.status is hqp.Status.STALLED:
            stalled.append(seed)
            continue
        assert solution.ok or not hqp.solve(h).ok, f"{family} {seed}: {solution.message}"
        assert solution.certify().ok, f"{family} {seed}: {solution.certify()}"
    assert len(stalled) <= 2, stalled


@given(seed=seeds)
@settings(max_examples=20)
def test_a_loop_is_warm_and_gives_what_a_cold_solver_gives(seed):
    """Limits come and go, levels above and below the damped ones are out of reach and in reach again."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 9))
    J = [rng.standard_normal((m, n)) for m in (2, 2, n)]
    known, own = pair(rng, 4)
    solver = Solver(damping=known)
    template = None
    for t in range(15):
        levels = [Level.bounds(np.full(n, -0.6), np.full(n, 0.6))]
        levels += [Level.equality(A, np.sin(0.2 * t + np.arange(len(A)))) for A in J]
        h = Hierarchy(levels)
        template = h if template is None else template.with_numbers(h.numbers)
        solution = solver.solve(template)
        agree(solution, hqp.solve(h, damping=own), 1e-8)
        assert solution.certify().ok
    assert not in_stages(solver)


@pytest.mark.parametrize("k", range(4))
def test_every_place_and_limits_above_and_below(k):
    """Bounds, a task out of reach, inequalities, a posture: each damped in its turn."""
    rng = np.random.default_rng(k)
    for _ in range(10):
        levels = [
            Level.bounds(np.full(6, -0.5), np.full(6, 0.5)),
            Level.equality(rng.standard_normal((3, 6)), 5.0 * rng.standard_normal(3)),
            Level(rng.standard_normal((3, 6)), np.full(3, -0.1), np.full(3, 0.2)),
            Level.bounds(np.full(6, 0.4), np.full(6, 0.4)),
        ]
        h = Hierarchy(levels)
        solver = Solver(damping={k: 0.2})
        solution = solver.solve(h)
        assert solution.certify().ok
        agree(solution, hqp.solve(h, damping={k: Fixed(0.2)}))
        assert not in_stages(solver)


def test_a_posture_below_is_where_the_rest_goes():
    """The last level has a reference of its own, which is not that of the damping."""
    hand = Level.equality([[1.0, 1.0, 0.0]], [2.0], name="hand")
    posture = Level.equality(np.eye(3), [0.0, 3.0, 1.0], name="posture")
    solution = hqp.solve(Hierarchy([hand, posture]), damping={"hand": 1.0})
    reached = 2.0 * 2.0 / (2.0 + 1.0)  # s^2 / (s^2 + lambda^2) of what is asked, s^2 = 2
    np.testing.assert_allclose(solution.x, [0.5 * (reached - 3.0), 0.5 * (reached + 3.0), 1.0], atol=1e-12)


def test_rows_of_a_damped_level_that_are_nearly_dependent_count_by_what_is_left_of_them():
    """Damping bounds what becomes of them, so that no rank is decided before it."""
    for share in 1e-6, 1e-8, 1e-10, 1e-12:
        h = Hierarchy([Level.equality([[1.0, 0.0], [1.0, share]], [1.0, 1.0 + share])])
        J = np.array([[1.0, 0.0], [1.0, share]])
        damping = 1e-4
        expected = J.T @ np.linalg.solve(J @ J.T + damping**2 * np.eye(2), [1.0, 1.0 + share])
        np.testing.assert_allclose(hqp.solve(h, damping={0: damping}).x, expected, atol=1e-9)


def test_names_that_move_are_looked_up_again():
    first = Level.equality([[1.0, 0.0]], [1.0], name="a"), Level.equality([[0.0, 1.0]], [1.0], name="b")
    second = Level.equality([[1.0, 0.0]], [1.0], name="b"), Level.equality([[0.0, 1.0]], [1.0], name="a")
    solver = Solver(damping={"a": 1.0})
    np.testing.assert_allclose(solver.solve(Hierarchy(first)).x, [0.5, 1.0])
    np.testing.assert_allclose(solver.solve(Hierarchy(second)).x, [1.0, 0.5])
    with pytest.raises(hqp.InvalidInput, match="'a' is no level"):
        solver.solve(Hierarchy(first[1:] + first[1:]))


def test_numbers_that_mean_nothing_are_told_and_forgotten():
    h = Hierarchy([Level.equality(np.eye(2), [1.0, 2.0]), Level.equality([[1.0, 1.0]], [0.0])])
    solver = Solver(damping={0: 0.5})
    good = solver.solve(h).x
    bad = h.with_numbers(h.numbers.copy())
    bad.levels[0].lower[0] = np.nan
    solution = solver.solve(bad)
    assert (solution.status, solution.relaxed) == (hqp.Status.INVALID, ())
    np.testing.assert_array_equal(solver.solve(h).x, good)


def test_without_damping_a_solution_has_one_stage_and_nothing_is_relaxed():
    solution = hqp.solve(Hierarchy([Level.equality(np.eye(2), [1.0, 2.0])]))
    assert (solution.stages, solution.relaxed, solution.dampings) == ((solution,), (), {})
    assert solution.certify().stages[0].ok
    assert type(Solver(damping={}).solve(solution.hierarchy)) is hqp.Solution


def test_a_stage_that_is_needed_for_the_first_time_in_a_warm_loop():
    """Rest is forbidden from the third tick on: only then what the limits leave is asked for by itself."""
    rng = np.random.default_rng(1)
    for _ in range(20):  # whatever is in memory that others have left
        rules = {k: ErrorDamping(1.0) for k in (1, 2)}
        solver, own = Solver(damping=rules), {k: Error(1.0) for k in (1, 2)}
        tasks = [Level.equality(rng.standard_normal((2, 5)), rng.standard_normal(2)) for _ in range(2)]
        template = None
        for least in -1.0, -1.0, 0.1, 0.2, -1.0, 0.1:
            h = Hierarchy([Level.bounds(np.full(5, least), np.full(5, 1.0)), *tasks])
            template = h if template is None else template.with_numbers(h.numbers)
            agree(solver.solve(template), hqp.solve(h, damping=own))


def test_nothing_is_read_before_it_is_written(monkeypatch):
    """Memory comes as others have left it."""
    empty = np.empty

    def soiled(shape, dtype=np.float64):
        array = empty(shape, dtype)
        array.fill(np.nan if array.dtype.kind == "f" else 7)
        return array

    monkeypatch.setattr("hqp.kernels.workspace.np.empty", soiled)
    for seed in range(40):
        rng = np.random.default_rng(seed)
        h = random_hierarchy(rng)
        known, own = pair(rng, len(h.levels))
        solver = Solver(damping=known)
        for shift in 0.0, 0.2, 0.0:
            given = h.with_numbers(h.numbers.copy())
            given.lower[:] += shift
            given.upper[:] += shift
            agree(solver.solve(given), hqp.solve(given, damping=own))
