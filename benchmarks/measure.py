"""Every backend on every problem of a family, interleaved, so that the machine's moods hit all alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from hqp import Hierarchy, Solution, Solver, backend_info, certify

from .families import Family
from .tables import Row

#: The backend that ratios refer to.
YARDSTICK = "cascade:proxsuite"
#: How far an answer is moved, relative to max(1, ||x||), to see the certificate reject it.
PERTURBATION = 1e-3


@dataclass
class Measurement:
    """One backend on one family.

    Attributes
    ----------
    cold, warm : list of float
        Seconds of each first solve by a fresh solver, and of the same hierarchy solved again.
    error : float
        Largest relative distance from a certified answer of any backend (the optimum is unique).
    certified, rejected, failed, solved : int
        Answers certified; perturbed answers rejected; answers not claimed optimal; problems.
    """

    family: str
    backend: str
    cold: list[float] = field(default_factory=list)
    warm: list[float] = field(default_factory=list)
    error: float = 0.0
    certified: int = 0
    rejected: int = 0
    failed: int = 0
    solved: int = 0


def table(measurements: Sequence[Measurement]) -> list[Row]:
    """One row a backend; ratio: median of warm times over the yardstick's, pair by pair."""
    yardstick = next((m for m in measurements if m.backend == YARDSTICK), None)
    return [
        {
            "family": m.family,
            "backend": m.backend,
            "cold us": f"{1e6 * np.median(m.cold):.0f}",
            "warm us": f"{1e6 * np.median(m.warm):.0f}",
            "p99 us": f"{1e6 * np.quantile(m.warm, 0.99):.0f}",
            "ratio": "" if yardstick is None else f"{np.median(np.divide(m.warm, yardstick.warm)):.2f}",
            "error": f"{m.error:.0e}",
            "certified": f"{m.certified / m.solved:.2%}",
            "rejected": f"{m.rejected / m.solved:.2%}",
            "failed": str(m.failed),
        }
        for m in measurements
    ]


def measure(
    family: Family, backends: Sequence[str], count: int, seed: int, tick: Callable[[], None] = lambda: None
) -> list[Measurement]:
    """Measure `backends` on `count` problems; those that do not take the family are left out."""
    able = [name for name in backends if family.refusal(backend_info(name)) is None]
    if not able:
        return []
    rows = {name: Measurement(family.name, name) for name in able}
    rng = np.random.default_rng(seed)
    for number, hierarchy in enumerate(family.problems(count, seed)):
        order = able[number % len(able) :] + able[: number % len(able)]
        answers = {name: _twice(rows[name], hierarchy) for name in order}
        _judge(rows, answers, hierarchy, rng.standard_normal(hierarchy.n))
        tick()
    return list(rows.values())


def _twice(row: Measurement, hierarchy: Hierarchy) -> Solution:
    solver = Solver(row.backend)
    start = time.perf_counter()
    solution = solver.solve(hierarchy)
    between = time.perf_counter()
    solver.solve(hierarchy)
    row.cold.append(between - start)
    row.warm.append(time.perf_counter() - between)
    return solution


def _judge(
    rows: dict[str, Measurement], answers: dict[str, Solution], hierarchy: Hierarchy, direction: np.ndarray
) -> None:
    proved = {name: certify(hierarchy, answer.x).ok for name, answer in answers.items()}
    truth = next((answers[name].x for name in answers if proved[name]), None)
    for name, answer in answers.items():
        row, length = rows[name], float(np.linalg.norm(answer.x))
        step = PERTURBATION * max(1.0, length) * direction / (np.linalg.norm(direction) or 1.0)
        row.solved += 1
        row.failed += not answer.ok
        row.certified += proved[name]
        row.rejected += not certify(hierarchy, answer.x + step).ok
        if truth is not None:
            scale = float(np.linalg.norm(truth)) or 1.0
            row.error = max(row.error, float(np.linalg.norm(answer.x - truth)) / scale)
