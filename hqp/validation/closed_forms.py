"""Backends against the closed forms, on random equality stacks in every rank case.

Two formulas are checked: Eq. 3.17, the optimum of the stack itself, and Eq. 4.8, the optimum of its
own hierarchy {J1 x = h1} > {x = J2# h2}, see :func:`hqp.backends.pseudoinverse.joint_form`. Rows have random weights,
and z, the reference of the last level, is random too: if it were zero, a missing last term would not be noticed.
"""

from __future__ import annotations

import math
import time
import zlib
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..backends.pseudoinverse import joint_form
from ..backends.registry import ACCURACY, backend_info
from ..certificate import certify
from ..hierarchy import Hierarchy, Level
from ..problems import Case
from ..solution import Solution
from ..solver import Solver

#: Formula -> the backend that evaluates it.
FORMULAS = {"Eq. 3.17": "pseudoinverse", "Eq. 4.8": "pseudoinverse:joint"}


@dataclass(frozen=True)
class Report:
    """One backend against one formula, on one case or (see :func:`merge`) on several.

    Attributes
    ----------
    backend, formula : str
    case : str
        The case; of several, the one with the largest difference in x.
    count : int
        Stacks solved.
    worst_x
        Largest ``||x - x_closed|| / ||x_closed||``.
    worst_residual
        Largest difference of a level's residual norm from the closed form's, relative to
        ``||b_k|| + ||A_k|| ||x||``.
    certified
        How many the certificate accepted.
    failures
        How many the backend itself did not call optimal.
    levels_solved, levels_met
        Levels that the named QP solver solved, and levels that needed no solver.
    seconds
        Spent in ``Solver.solve``.
    """

    backend: str
    formula: str
    case: str
    count: int
    worst_x: float
    worst_residual: float
    certified: int
    failures: int
    levels_solved: int
    levels_met: int
    seconds: float

    @property
    def allowed(self) -> float:
        """The relative accuracy that the backend's class promises."""
        return ACCURACY[backend_info(self.backend).accuracy]

    @property
    def ok(self) -> bool:
        """Whether the backend is inside its class."""
        worst = max(self.worst_x, self.worst_residual)
        return math.isinf(self.allowed) or (self.failures == 0 and worst <= self.allowed)


def validate_case(backend: str, case: Case, count: int, seed: int) -> list[Report]:
    """Solve `count` random stacks of one case; one report a formula that the backend aims at."""
    # Every backend meets the same stacks: the stream depends on the case and the seed alone.
    rng = np.random.default_rng([seed, zlib.crc32(case.name.encode())])
    stacks = [(weighted(case.hierarchy(rng), rng), rng.standard_normal(case.n)) for _ in range(count)]
    reports = []
    for formula in formulas_of(backend):
        tally = _Tally()
        solver, reference = Solver(backend), Solver(FORMULAS[formula])
        for stack, z in stacks:
            own, posed = problems(backend, formula, stack, z)
            start = time.perf_counter()
            solution = solver.solve(posed, z)
            tally.seconds += time.perf_counter() - start
            tally.add(own, solution, reference.solve(stack, z).x)
        reports.append(tally.report(backend, formula, case.name, count))
    return reports


class _Tally:
    """Running worst cases of one (backend, formula, case)."""

    def __init__(self) -> None:
        self.seconds = self.worst_x = self.worst_residual = 0.0
        self.certified = self.failures = self.solved = self.met = 0

    def add(self, hierarchy: Hierarchy, solution: Solution, x_closed: Array) -> None:
        x = solution.x
        self.worst_x = max(self.worst_x, difference(x, x_closed))
        self.worst_residual = max(self.worst_residual, residual_difference(hierarchy, x, x_closed))
        self.certified += certify(hierarchy, x, solution.x_ref).ok
        self.failures += not solution.ok
        self.solved += solution.counts.levels_solved
        self.met += solution.counts.levels_met

    def report(self, backend: str, formula: str, case: str, count: int) -> Report:
        return Report(
            backend, formula, case, count, self.worst_x, self.worst_residual,
            self.certified, self.failures, self.solved, self.met, self.seconds,
        )  # fmt: skip


def formulas_of(backend: str) -> list[str]:
    """The formulas whose optimum the backend aims at."""
    lexicographic = backend_info(backend).lexicographic
    return [name for name, closed_form in FORMULAS.items() if lexicographic or closed_form == backend]


def weighted(stack: Hierarchy, rng: np.random.Generator) -> Hierarchy:
    """The same equalities with weights over two decades."""
    return Hierarchy(
        [
            Level.equality(
                stack.matrix(k), level.lower, weights=10.0 ** rng.uniform(-1, 1, len(level)), name=level.name
            )
            for k, level in enumerate(stack.levels)
        ]
    )


def problems(backend: str, formula: str, stack: Hierarchy, z: Array | None = None) -> tuple[Hierarchy, Hierarchy]:
    """The hierarchy that the formula solves for a stack, above min ||x - z||, and what is given to the backend."""
    own = joint_form(stack, z) if FORMULAS[formula] == "pseudoinverse:joint" else stack
    # Eq. 4.8 as a backend reads the stack itself; all others solve its own hierarchy.
    return own, stack if backend == FORMULAS[formula] else own


def difference(x: Array, x_closed: Array) -> float:
    """``||x - x_closed|| / ||x_closed||``."""
    return float(np.linalg.norm(x - x_closed)) / (float(np.linalg.norm(x_closed)) or 1.0)


def residual_difference(hierarchy: Hierarchy, x: Array, x_closed: Array) -> float:
    """Largest difference of a level's residual norm, relative to ``||b_k|| + ||A_k|| ||x_closed||``."""
    worst = 0.0
    for k, level in enumerate(hierarchy.levels):
        A, b = hierarchy.matrix(k), level.lower
        norms = [float(np.linalg.norm(level.weights * (A @ point - b))) for point in (x, x_closed)]
        scale = float(
            np.linalg.norm(level.weights * b) + np.linalg.norm(level.weights[:, None] * A) * np.linalg.norm(x_closed)
        )
        worst = max(worst, abs(norms[0] - norms[1]) / (scale or 1.0))
    return worst


def merge(reports: Iterable[Report]) -> list[Report]:
    """One report per (backend, formula) over all cases, keeping the worst case's name."""
    groups: dict[tuple[str, str], list[Report]] = {}
    for report in reports:
        groups.setdefault((report.backend, report.formula), []).append(report)
    return [
        Report(
            backend=backend,
            formula=formula,
            case=max(group, key=lambda report: report.worst_x).case,
            count=sum(report.count for report in group),
            worst_x=max(report.worst_x for report in group),
            worst_residual=max(report.worst_residual for report in group),
            certified=sum(report.certified for report in group),
            failures=sum(report.failures for report in group),
            levels_solved=sum(report.levels_solved for report in group),
            levels_met=sum(report.levels_met for report in group),
            seconds=sum(report.seconds for report in group),
        )
        for (backend, formula), group in groups.items()
    ]
