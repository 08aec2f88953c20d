"""The native solver in numbers that a default run has no time for: ``python -m pytest -m sweep -k native``."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest
from test_conformance import PROBLEMS

from hqp import Hierarchy, Solution, Solver, Status, available_backends, backend_info, certify, solve
from hqp.problems import FAMILIES, hierarchies, random_hierarchy

pytestmark = pytest.mark.sweep

BACKEND, COUNT = "native", 1000
#: Peers which promise an exact optimum.
PEERS = [
    info.name
    for info in map(backend_info, available_backends())
    if info.lexicographic and info.accuracy == "exact" and info.name != BACKEND
]


def families(expect: str) -> list[str]:
    return [name for name, family in FAMILIES.items() if family.expect == expect]


def outcomes(name: str) -> tuple[dict[int, Solution], dict[int, Solution]]:
    """The cases of a family that are not called optimal, and those that the certificate refutes, by their number."""
    solver = Solver(BACKEND)
    solutions = dict(enumerate(map(solver.solve, hierarchies(name, COUNT))))
    doubted = {k: solution for k, solution in solutions.items() if not solution.ok}
    refuted = {k: solution for k, solution in solutions.items() if not solution.certify().ok}
    assert {solution.status for solution in doubted.values()} <= {Status.STALLED}
    print(f"{name}: {len(doubted)} stalled {list(doubted)}, {len(refuted)} not certified {list(refuted)}")
    return doubted, refuted


@pytest.mark.parametrize("first", range(1_000_000, 1_100_000, 10_000))
def test_100_000_random_hierarchies_are_certified(first: int) -> None:
    solver, wrong = Solver(BACKEND), {}
    for seed in range(first, first + 10_000):
        solution = solver.solve(random_hierarchy(np.random.default_rng(seed)))
        if solution.status is Status.SUBOPTIMAL or not solution.certify().ok:
            wrong[seed] = str(solution.status)
    assert wrong == {}


@pytest.mark.parametrize("name", families("certified"))
def test_1000_of_a_family_that_can_be_certified_are(name: str) -> None:
    doubted, refuted = outcomes(name)
    assert list(refuted) == []
    assert len(doubted) <= 3, "optimal, and no sweep proves it"


@pytest.mark.parametrize("name", families("undecidable rank"))
def test_of_1000_whose_rank_is_undecidable_few_are_not_certified(name: str) -> None:
    _, refuted = outcomes(name)
    assert len(refuted) <= 0.02 * COUNT


@pytest.mark.parametrize("name", families("certified or stalled"))
def test_of_1000_that_may_stall_none_claims_what_is_refuted(name: str) -> None:
    doubted, refuted = outcomes(name)
    assert refuted.keys() == doubted.keys()
    assert len(doubted) <= 20
    for k, solution in doubted.items():
        failed = solution.certify().failed
        assert failed is not None, k
        assert failed.level == solution.level, k


@pytest.mark.parametrize("name", families("refused"))
def test_1000_that_are_refused_are_told_level_and_row(name: str) -> None:
    solver = Solver(BACKEND)
    for k, h in enumerate(hierarchies(name, COUNT)):
        solution = solver.solve(h)
        assert solution.status is Status.INVALID, k
        assert re.match(r"level \d+.*, row \d+: ", solution.message), solution.message


def residuals(h: Hierarchy, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residual norms of all levels, the implicit last one included, and the size of the numbers they are made of."""
    bound = np.maximum(*(np.where(np.isinf(side), 0.0, np.abs(side)) for side in (h.lower, h.upper)))
    rows = h.weights * (h.row_norms() * np.linalg.norm(x) + bound)
    sizes = [np.linalg.norm(rows[first:end]) for first, end in pairwise(h.pointers)]
    return np.array([level.residual_norm for level in certify(h, x).levels]), np.array([*sizes, np.linalg.norm(x)])


def better(h: Hierarchy, x: np.ndarray, other: np.ndarray) -> bool:
    """Whether `other` is lexicographically better than x, by 1e-7 of the numbers of the level that decides."""
    mine, size = residuals(h, x)
    theirs, _ = residuals(h, other)
    apart = np.flatnonzero(np.abs(mine - theirs) > 1e-7 * size)
    return len(apart) > 0 and bool(theirs[apart[0]] < mine[apart[0]])


LOTS = {"conformance": lambda: PROBLEMS.items()} | {
    f"random {first}": lambda first=first: (
        (str(seed), lambda seed=seed: random_hierarchy(np.random.default_rng(seed)))
        for seed in range(first, first + 100)
    )
    for first in (20_000, 20_100, 20_200)
}


@pytest.mark.parametrize("lot", LOTS)
def test_no_exact_backend_is_lexicographically_better(lot: str) -> None:
    found = []
    for name, make in LOTS[lot]():
        h = make()
        x = solve(h, backend=BACKEND).x
        for peer in PEERS:
            solution = Solver(peer).solve(h)
            if solution.status is not Status.UNSUPPORTED and better(h, x, solution.x):
                found.append((name, peer))
    assert found == []
