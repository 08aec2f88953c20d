"""The cascade: what it counts, what it keeps, and what it says when its QP solver fails."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from hqp import Hierarchy, Level, Settings, Solver, Status, load, solve
from hqp.backends import cascade
from hqp.backends.polish import MENDING, polish
from hqp.backends.subproblem import LevelRows, State, objective
from hqp.problems import random_hierarchy
from hqp.qp import FlatQP, FlatResult

BACKEND = "cascade:proxsuite"


def stack() -> Hierarchy:
    rng = np.random.default_rng(3)
    return Hierarchy(
        [
            Level.bounds(-np.ones(6), np.ones(6), name="limits"),
            Level.equality(rng.standard_normal((2, 6)), [3.0, -3.0], name="hand"),
            Level(rng.standard_normal((2, 6)), [0.5, -np.inf], [np.inf, -0.5], name="elbow"),
            Level.equality(rng.standard_normal((3, 6)), [1.0, 2.0, 3.0], name="gaze"),
        ]
    )


def test_it_counts_what_it_did() -> None:
    counts = solve(stack(), backend=BACKEND).counts
    assert counts.levels_solved + counts.levels_met == 5  # four levels and the implicit last one
    assert counts.levels_met >= 1  # x = 0 meets the limits
    assert counts.levels_solved >= 2
    assert counts.qp_solves == counts.levels_solved + counts.proximal_steps
    assert counts.levels_polished == counts.levels_solved <= counts.polishes


class Spy:
    """A flat solver between the cascade and the real one."""

    calls: list[str]

    def __init__(self, real, calls: list[str]) -> None:
        self.real, self.calls = real, calls

    def solve(self, qp: FlatQP) -> FlatResult:
        self.calls.append("solve")
        return self.real.solve(qp)

    def move(self, g: np.ndarray) -> FlatResult:
        self.calls.append("move")
        return self.real.move(g)


@pytest.fixture
def spied(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    calls: list[str] = []
    real = cascade.make_flat_solver

    def make(*arguments):
        calls.append("make")
        return Spy(real(*arguments), calls)

    monkeypatch.setattr(cascade, "make_flat_solver", make)
    return calls


def test_every_counted_solve_is_one_of_the_named_solver(spied: list[str]) -> None:
    counts = solve(stack(), backend=BACKEND).counts
    assert spied.count("solve") + spied.count("move") == counts.qp_solves
    assert spied.count("move") == counts.proximal_steps


def test_problems_persist_between_calls_of_a_solver(spied: list[str]) -> None:
    solver, h = Solver(BACKEND), stack()
    shifts = (0.0, 0.01, -0.01, 0.02)

    def go_round() -> None:
        for shift in shifts:
            h.levels[1].lower[:] = h.levels[1].upper[:] = np.array([3.0, -3.0]) + shift
            assert solver.solve(h).ok

    go_round()
    made = spied.count("make")  # the active set, and with it the sizes, may have changed on the way round
    go_round()
    assert spied.count("make") == made


def _failing_from(monkeypatch: pytest.MonkeyPatch, level: int, how: str) -> None:
    """Make the flat solver of one level fail: by its status, by nonsense, by NaN, or by an exception."""
    real = cascade.Cascade._flat

    class Broken:
        def solve(self, qp: FlatQP) -> FlatResult:
            if how == "raises":
                raise RuntimeError("out of cheese")
            y = np.full(len(qp.g), np.nan if how == "nan" else 1e3)
            return FlatResult(y, how != "status", "gave up", np.zeros(len(qp.lower)), np.zeros(len(qp.g)))

        def move(self, g: np.ndarray) -> FlatResult:
            raise AssertionError("not reached")

    broken = Broken()
    broken.move = lambda g: FlatResult(np.full(len(g), 1e3), True, "gave up", np.zeros(99), np.zeros(len(g)))  # type: ignore[method-assign]
    monkeypatch.setattr(cascade.Cascade, "_flat", lambda self, k, sizes: broken if k == level else real(self, k, sizes))


@pytest.mark.parametrize("how", ["status", "nan", "nonsense", "raises"])
def test_a_level_that_fails_is_a_status_with_the_last_good_x(monkeypatch: pytest.MonkeyPatch, how: str) -> None:
    h = stack()
    whole = solve(h, backend=BACKEND)
    _failing_from(monkeypatch, 3, how)
    solution = Solver(BACKEND).solve(h)
    assert solution.status is Status.FAILED
    assert not solution.ok
    assert solution.level == 3
    assert "level 3 ('gaze'): proxsuite failed" in solution.message
    if how == "raises":
        assert "RuntimeError: out of cheese" in solution.message
    assert np.isfinite(solution.x).all()
    # What is above the failed level is as good as ever.
    assert all(level.ok for level in solution.certify(unique=False).levels[:3])
    for mine, theirs in zip(solution.levels[:3], whole.levels[:3], strict=True):
        assert mine.residual_norm == pytest.approx(theirs.residual_norm, abs=1e-9)


def test_without_polish_it_is_as_exact_as_its_solver() -> None:
    rough = Settings(polish=False)
    for seed in range(20):
        h = random_hierarchy(np.random.default_rng(seed), n=5, levels=2)
        solution, exact = solve(h, backend=BACKEND, settings=rough), solve(h, backend=BACKEND)
        assert solution.counts.polishes == 0
        for mine, theirs in zip(solution.levels, exact.levels, strict=True):
            assert mine.residual_norm == pytest.approx(theirs.residual_norm, abs=1e-5 * (1 + np.linalg.norm(exact.x)))


def test_the_number_of_kept_problems_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cascade, "MOST_SOLVERS", 3)
    solver, h = Solver(BACKEND), stack()
    for _ in range(3):
        assert solver.solve(h).certify().ok
    assert len(solver._backend.flat) <= 3  # type: ignore[attr-defined]


def test_a_proximal_step_makes_a_rank_deficient_level_exact_even_unpolished() -> None:
    """Plain regularisation leaves an error of order rho; the proximal steps take it away."""
    A = np.array([[1.0, 1.0, 0.0], [2.0, 2.0, 0.0]])
    h = Hierarchy([Level.equality(A, [1.0, 2.0])])
    slack = {}
    for steps in (1, 10):
        rough = Settings(polish=False, proximal_weight=1e-3, proximal_steps=steps)
        slack[steps] = np.linalg.norm(solve(h, backend=BACKEND, settings=rough).levels[0].slack)
    assert slack[10] < 1e-7 < slack[1]


@pytest.mark.parametrize("first", range(0, 500, 250))
def test_500_random_hierarchies(first: int) -> None:
    """All of them: a share of 99.5 % would let a regression hide."""
    seeds = range(first, first + 250)
    made = {k: random_hierarchy(np.random.default_rng(k)) for k in seeds}
    assert [k for k, h in made.items() if not solve(h, backend=BACKEND).certify().ok] == []


#: Contact forces of a humanoid in their cones and accelerations, 59 unknowns and 203 rows: apexes of cones at zero,
#: limits which no x can keep, and a solver's rho which outweighs what they leave.
SATURATED = Path(__file__).parent / "data" / "saturated_forces.npz"


def test_a_saturated_body_is_optimal_and_proved(general_backend: str) -> None:
    hierarchy, x_ref = load(SATURATED)
    solution = solve(hierarchy, backend=general_backend, x_ref=x_ref)
    assert solution.ok, solution.message
    assert solution.certify().ok


@pytest.mark.parametrize("found", ["a saturated body", *range(12)])
def test_what_was_not_verified_is_claimed_only_if_it_is_proved(monkeypatch: pytest.MonkeyPatch, found: object) -> None:
    """The polish verifies nothing; where the certificate refutes x, it is not optimal, and says from which level on."""
    monkeypatch.setattr(cascade, "polish", lambda *arguments: replace(polish(*arguments), verified=False))
    if found == "a saturated body":
        hierarchy, x_ref = load(SATURATED)
    else:
        hierarchy, x_ref = random_hierarchy(np.random.default_rng([int(str(found)), 5])), None
    solution = solve(hierarchy, backend=BACKEND, x_ref=x_ref)
    failed = solution.certify().failed
    assert solution.ok == (failed is None)
    if failed is not None:
        assert solution.level is not None
        assert solution.level <= failed.level
        assert solution.status in (Status.STALLED, Status.FAILED)
        assert "the levels above" in solution.message


def test_an_answer_that_is_off_is_stalled_at_its_level(monkeypatch: pytest.MonkeyPatch) -> None:
    """As by a polish that ends elsewhere, 8 % off at the second level."""
    real, h = cascade.Cascade._solve_level, stack()

    def off(self, k, problem, tally):
        settled = real(self, k, problem, tally)
        return settled._replace(y=0.92 * settled.y, verified=False) if k == 1 else settled

    monkeypatch.setattr(cascade.Cascade, "_solve_level", off)
    solution = solve(h, backend=BACKEND)
    assert (solution.status, solution.level) == (Status.STALLED, 1)
    assert "level 1 ('hand'): the certificate refutes the answer of proxsuite" in solution.message
    assert all(level.ok for level in solution.certify(unique=False).levels[:1])


def test_where_a_later_level_fails_too_the_first_wrong_one_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    real, h = cascade.Cascade._solve_level, stack()

    def off(self, k, problem, tally):
        if k == 3:
            raise cascade.LevelFailed("gave up")
        settled = real(self, k, problem, tally)
        return settled._replace(y=0.92 * settled.y, verified=False) if k == 1 else settled

    monkeypatch.setattr(cascade.Cascade, "_solve_level", off)
    solution = solve(h, backend=BACKEND)
    assert (solution.status, solution.level) == (Status.FAILED, 1)
    assert "level 3 ('gaze'): proxsuite failed (gave up)" in solution.message
    assert "level 1 ('hand')" in solution.message


def first_level(h: Hierarchy):
    """The problem that the top level is, from x = 0."""
    rows = next(LevelRows.of(h, np.zeros(h.n)))
    return rows.problem(State.start(np.zeros(h.n)), rows.at(np.zeros(h.n), Settings()), Settings())


@pytest.mark.parametrize("seed", range(10))
def test_the_polish_arrives_from_wherever_it_starts(seed: int) -> None:
    """Inequalities that contradict each other, and a start that tells nothing of which are active: it is convex."""
    rng = np.random.default_rng(seed)
    A, centre = rng.standard_normal((60, 20)), 3.0 * rng.standard_normal(60)
    problem = first_level(Hierarchy([Level(A, centre - 0.1, centre + 0.1)]))
    ends = [
        polish(problem, y, np.zeros(0, dtype=np.int8), Settings().rank_tolerance)
        for y in (np.zeros(20), 1e3 * rng.standard_normal(20))
    ]
    assert all(end.verified for end in ends)
    values = [objective(problem.slacks(end.y)) for end in ends]
    assert values[0] == pytest.approx(values[1], rel=1e-9)


def test_no_round_of_descent_is_worse_than_the_one_before(monkeypatch: pytest.MonkeyPatch) -> None:
    from hqp.backends import polish as module

    hierarchy, x_ref = load(SATURATED)
    values: list[tuple[object, float]] = []
    real = module._pays

    def seen(problem, y, d, active):
        values.append((problem, objective(problem.slacks(y))))
        return real(problem, y, d, active)

    monkeypatch.setattr(module, "_pays", seen)
    solution = solve(hierarchy, backend=BACKEND, x_ref=x_ref)
    assert solution.counts.polishes > MENDING
    assert values
    for (problem, before), (following, after) in pairwise(values):
        assert problem is not following or after <= before * (1.0 + 1e-9)


def test_a_far_reference_leaves_no_row_beyond_its_bound() -> None:
    """Rows through zero, and x_ref outside: the step ends at zero, where what a first-order solver leaves is large."""
    for seed in range(60):
        rng = np.random.default_rng(seed)
        A = rng.standard_normal((int(rng.integers(1, 4)), int(rng.integers(1, 4))))
        solution = solve(
            Hierarchy([Level(A, 0.0, np.inf)]), backend=BACKEND, x_ref=-A.T @ rng.uniform(0.1, 3.0, len(A))
        )
        assert solution.ok, seed
        assert solution.certify().ok, seed
