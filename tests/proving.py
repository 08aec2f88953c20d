"""Points that a certificate is to judge, and what it says of them.

``python tests/proving.py POINTS OUT`` judges the pickled points, and pickles what :func:`told` says of each. With
NUMBA_DISABLE_JIT=1 the interpreter runs the loops of the certificate.
"""

from __future__ import annotations

import pickle
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import by_numpy
import numpy as np

import hqp
from hqp import Hierarchy, Level
from hqp.problems import FAMILIES, hierarchies

HARD = Path(__file__).parent / "data" / "hard"
#: How far beside an optimum, in units of its length.
BESIDE = (0.0, 1e-13, 1e-11, 1e-9, 1e-7, 1e-4, 1e-1)
#: A verdict is decided if tolerances smaller and larger by this share give the same.
DECIDED = 0.1


class Point(NamedTuple):
    """A point, and what it is."""

    name: str
    hierarchy: Hierarchy
    x: np.ndarray
    x_ref: np.ndarray


def beside(rng: np.random.Generator, name: str, h: Hierarchy, x_ref: np.ndarray) -> Iterator[Point]:
    """The optimum, and points beside it."""
    best = hqp.solve(h, x_ref=x_ref).x
    for share in BESIDE:
        away = share * max(1.0, float(np.linalg.norm(best))) * rng.standard_normal(h.n)
        yield Point(f"{name}, {share:g} beside", h, best + away, x_ref)


def of_families(count: int, most: int) -> Iterator[Point]:
    """So many of each family of up to `most` unknowns: of what breaks solvers."""
    rng = np.random.default_rng(5)
    for name in FAMILIES:
        for h in hierarchies(name, count, seed=7):
            if h.n <= most and not h.find_fault():
                for x_ref in np.zeros(h.n), rng.standard_normal(h.n):
                    yield from beside(rng, name, h, x_ref)


def far_out(count: int) -> Iterator[Point]:
    """Tasks that almost agree, far out, where the tolerances of their rows decide."""
    rng = np.random.default_rng(3)
    for _ in range(count):
        n, far = int(rng.integers(2, 6)), 10.0 ** rng.integers(3, 7)
        A, x = rng.standard_normal((n + 3, n)), far * rng.standard_normal(n)
        near = A @ x + far * 10.0 ** rng.uniform(-9.0, -7.0) * rng.standard_normal(n + 3)
        below = np.where(rng.random(n + 2) < 0.4, far, 0.0)  # some are inequalities
        tasks = Level(A[1:], near[1:] - below, near[1:], weights=rng.uniform(0.5, 2.0, n + 2))
        h = Hierarchy([Level.equality(A[:1], A[:1] @ x), tasks])
        best = hqp.solve(h).x
        for share in (0.0, 1e-11, 1e-10, 1e-9, 3e-9, 1e-8, 1e-7):
            away = share * float(np.linalg.norm(best)) * rng.standard_normal(n)
            yield Point(f"far out, {share:g} beside", h, best + away, np.zeros(n))


def nearly_parallel(seeds: Iterable[int]) -> Iterator[Point]:
    """Rows of one level that differ by 1e-6 to 1e-4, below limits: only large shifts move their difference."""
    for seed in seeds:
        rng = np.random.default_rng(seed)
        n = int(rng.integers(4, 8))
        limits, A = rng.standard_normal((n // 2, n)), rng.standard_normal((n // 2, n))
        A = np.concatenate([A, A + 10.0 ** rng.uniform(-6.0, -4.0) * rng.standard_normal(A.shape)])
        low = rng.standard_normal(len(A))
        tasks = Level(A, low, low + rng.choice([0.0, 1.0], len(A)))
        h = Hierarchy([Level(limits, -np.inf, rng.standard_normal(len(limits))), tasks])
        best, rng = hqp.solve(h).x, np.random.default_rng(seed)
        for share in (0.0, 1e-12, 1e-11, 1e-10, 3e-10):
            away = share * float(np.linalg.norm(best)) * rng.standard_normal(n)
            yield Point(f"nearly parallel {seed}, {share:g} beside", h, best + away, np.zeros(n))


def recorded() -> Iterator[Point]:
    """Hierarchies that were hard once, whole-body ticks most of them; and each with one number changed: x is wrong."""
    rng = np.random.default_rng(11)
    for file in sorted(HARD.glob("*.npz")):
        h, x_ref = hqp.load(file)
        x_ref = np.zeros(h.n) if x_ref is None else x_ref
        yield from beside(rng, file.stem, h, x_ref)
        best = hqp.solve(h, x_ref=x_ref).x
        for share in (1e-7, 1e-3, 1.0):
            wrong, row = h.with_numbers(h.numbers.copy()), int(rng.integers(h.m))
            shift = share * (1.0 + abs(float(h.product(best)[row])))
            wrong.lower[row], wrong.upper[row] = wrong.lower[row] + shift, wrong.upper[row] + shift
            yield Point(f"{file.stem}, a bound {share:g} off", wrong, best, x_ref)


def expected(point: Point) -> bool | None:
    """The verdict of NumPy; None if it is not decided: with other tolerances it is another."""
    said = {
        all(level.ok for level in by_numpy.judge(point.hierarchy, point.x, point.x_ref, tolerance * 1e-9))
        for tolerance in (1.0 - DECIDED, 1.0, 1.0 + DECIDED)
    }
    return said.pop() if len(said) == 1 else None


Told = tuple[int | None, list[tuple[float, float, float]], list[np.ndarray]]


def told(point: Point) -> Told:
    """The level that fails; residual, stationarity and gap of all levels; their multipliers."""
    proof = hqp.certify(*point[1:])
    numbers = [(level.residual_norm, level.stationarity, level.gap) for level in proof.levels]
    return None if proof.failed is None else proof.failed.level, numbers, [level.multipliers for level in proof.levels]


def main(points: str, out: str) -> None:
    made: list[Any] = pickle.loads(Path(points).read_bytes())
    Path(out).write_bytes(pickle.dumps([told(Point(*point)) for point in made]))


if __name__ == "__main__":
    main(*sys.argv[1:])
