r"""Backends on random hierarchies with inequalities, conflicts and weights, judged by the certificate and each other.

Inequalities and conflicts at every level, rows of different length, rows that come again further down, weights, and a
random x_ref: no formula gives these answers, but the certificate can tell whether one is right. Beside that backends
are compared in pairs, level by level: where residuals differ, the one with the larger residual has missed the optimum,
whatever a certificate says. An answer is unique, with the implicit last level :math:`\min \|x - x_\text{ref}\|`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..backends.registry import ACCURACY, backend_info
from ..certificate import Certificate, excess
from ..hierarchy import Hierarchy, Level
from ..problems import random_sides
from ..solution import Solution
from ..solver import Solver
from .conditioning import stream

#: Unknowns and levels.
SIZES = (3, 2), (7, 4), (15, 6), (30, 8)
#: Rows over unknowns, all levels together, and how many of them are rows from further up again.
CROWDED, AGAIN = 1.5, 0.4
#: Tolerances of the certificate for the accuracy classes; what is proved at one of them is proved.
PROVED = {"exact": (1e-9,), "first-order": (1e-9, 1e-6, 1e-3), "none": (1e-9,)}
#: The share of its answers that an honest backend may call failed.
GIVEN_UP = 0.01
#: Relative difference of residuals up to which round-off explains it, and levels further down are comparable.
AGREE = 1e-9


@dataclass(frozen=True)
class Judgement:
    """One backend on random hierarchies of one size or (see :func:`summed`) of several.

    Attributes
    ----------
    backend : str
    n, levels : int
        Of several sizes: the largest.
    count : int
        Hierarchies solved.
    certified
        How many answers the certificate accepts, with a tolerance of the backend's class.
    refuted
        How many it refutes at a level which the backend claims: any, or those above the one at which it gave up.
    failures
        How many the backend itself did not call optimal.
    beaten
        How many that it did another backend, one that promises something, does better.
    by : tuple of str
        Which ones.
    seconds
        Spent in ``Solver.solve``.
    """

    backend: str
    n: int
    levels: int
    count: int = 0
    certified: int = 0
    refuted: int = 0
    failures: int = 0
    beaten: int = 0
    by: tuple[str, ...] = ()
    seconds: float = 0.0

    @property
    def allowed(self) -> float:
        """The relative accuracy that the backend's class promises."""
        return ACCURACY[backend_info(self.backend).accuracy]

    @property
    def ok(self) -> bool:
        """Whether no claim is refuted or beaten, and failures are rare."""
        right = not self.refuted and not self.beaten and self.failures <= GIVEN_UP * self.count
        return right or math.isinf(self.allowed)

    def __add__(self, other: Judgement) -> Judgement:
        return Judgement(
            self.backend,
            n=max(self.n, other.n),
            levels=max(self.levels, other.levels),
            count=self.count + other.count,
            certified=self.certified + other.certified,
            refuted=self.refuted + other.refuted,
            failures=self.failures + other.failures,
            beaten=self.beaten + other.beaten,
            by=tuple(dict.fromkeys((*self.by, *other.by))),
            seconds=self.seconds + other.seconds,
        )


def crowded(n: int, levels: int, rng: np.random.Generator) -> Hierarchy:
    """A random hierarchy with inequalities, conflicts and weights at every level, and now and then bounds on top."""
    point, above, built = rng.standard_normal(n), np.zeros((0, n)), []
    if rng.random() < 0.5:
        reach = 0.5 + rng.random(n)
        built.append(Level.bounds(-reach, reach, name="bounds"))
    m = math.ceil(CROWDED * n / levels)
    for k in range(len(built), levels):
        A = rng.standard_normal((m, n)) * 10.0 ** rng.uniform(-0.5, 0.5, (m, 1)) / math.sqrt(n)
        again = np.flatnonzero(rng.random(m) < (AGAIN if len(above) else 0.0))
        A[again] = rng.choice(above, len(again)) * rng.choice([-1.0, 0.5, 1.0, 2.0], (len(again), 1))
        weights = 10.0 ** rng.uniform(-1, 1, m)
        built.append(Level(A, *random_sides(rng, A @ point), weights=weights, name=f"level {k}"))
        above = np.concatenate([above, A])
    return Hierarchy(built)


def judge(names: Sequence[str], size: tuple[int, int], count: int, seed: int, first: int = 0) -> list[Judgement]:
    """Judge these backends on `count` random hierarchies of a size, as far as they take them.

    Parameters
    ----------
    names : sequence of str
    size : tuple of int
        Unknowns and levels.
    count, seed : int
    first : int
        The number of the first hierarchy: hierarchies depend on seed and number only, not on `count`.
    """
    n, levels = size
    solvers = {name: Solver(name) for name in names if _takes(name)}
    tallies = {name: Judgement(name, n, levels) for name in solvers}
    for number in range(first, first + count):
        rng = stream(seed, "crowded", n, levels, number)
        hierarchy, x_ref = crowded(n, levels, rng), rng.standard_normal(n)
        answers = {}
        for name, solver in solvers.items():
            start = time.perf_counter()
            answer = answers[name] = solver.solve(hierarchy, x_ref)
            seconds, certificate = time.perf_counter() - start, _best(answer)
            tallies[name] += Judgement(
                name, n, levels, count=1, certified=int(certificate.ok), refuted=int(_refuted(answer, certificate)),
                failures=int(not answer.ok), seconds=seconds,
            )  # fmt: skip
        for name, others in beaten({name: answer for name, answer in answers.items() if answer.ok}).items():
            tallies[name] += Judgement(name, n, levels, beaten=1, by=others)
    return list(tallies.values())


def beaten(answers: dict[str, Solution]) -> dict[str, tuple[str, ...]]:
    """The backends whose answer is not the lexicographic optimum, each with a better one; `answers` by backend."""
    attained = {name: _residuals(answer) for name, answer in answers.items()}
    allowed = {name: ACCURACY[backend_info(name).accuracy] for name in answers}
    judges = [name for name in answers if not math.isinf(allowed[name])]
    found = {}
    for name, mine in attained.items():
        tolerance = min(allowed[name], ACCURACY["first-order"])
        better = tuple(other for other in judges if _worse(mine, attained[other], max(tolerance, allowed[other])))
        if better:
            found[name] = better
    return found


def summed(judgements: Iterable[Judgement]) -> list[Judgement]:
    """One judgement per backend, over all sizes."""
    total: dict[str, Judgement] = {}
    for each in judgements:
        total[each.backend] = total[each.backend] + each if each.backend in total else each
    return list(total.values())


def _takes(name: str) -> bool:
    info = backend_info(name)
    return info.inequalities and info.lexicographic


def _best(answer: Solution) -> Certificate:
    """The certificate at the tolerance of the backend's class at which it accepts the answer, or at the least one."""
    found = [answer.certify(tolerance=tolerance) for tolerance in PROVED[backend_info(answer.backend).accuracy]]
    return next((certificate for certificate in found if certificate.ok), found[0])


def _refuted(answer: Solution, certificate: Certificate) -> bool:
    """Whether a level fails which the backend claims."""
    failed = certificate.failed
    return failed is not None and (answer.level is None or failed.level < answer.level)


def _worse(mine: Array, theirs: Array, allowed: float) -> bool:
    """Whether at the first level at which residuals part they are larger here, by more than is allowed."""
    apart = mine - theirs
    parted = np.flatnonzero(np.abs(apart) > AGREE)
    return len(parted) > 0 and bool(apart[parted[0]] > allowed)


def _residuals(answer: Solution) -> Array:
    """``||D_k w_k||`` of every level, the implicit last one included, over ``||D_k A_k||`` and the size of x."""
    hierarchy, x = answer.hierarchy, answer.x
    size = 1.0 + float(np.linalg.norm(answer.x_ref))
    found = []
    for k, level in enumerate(hierarchy.levels):
        A = hierarchy.matrix(k)
        w = level.weights * excess(A @ x, level.lower, level.upper)
        scale = float(np.linalg.norm(level.weights[:, None] * A))
        found.append(float(np.linalg.norm(w)) / (scale * size))
    return np.array([*found, float(np.linalg.norm(x - answer.x_ref)) / size])
