"""Hierarchies that break solvers, each for one reason: the makers behind :mod:`hqp.problems.families`.

All are pure functions of a random generator. The level which gives a hierarchy its name has a name of its own; what
stands above and below it comes from :func:`hqp.problems.random_hierarchy`. Unknowns: 2 to 12; levels: up to 6.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from ..hierarchy import Hierarchy, Level
from .random import random_hierarchy, random_sides


def _unknowns(rng: np.random.Generator, least: int = 2) -> int:
    return int(rng.integers(least, 13))


def _matrix(rng: np.random.Generator, least: int, most: int, n: int) -> Array:
    return rng.standard_normal((int(rng.integers(least, most + 1)), n))


def _decade(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(low, high))


def _level(rng: np.random.Generator, A: Array, name: str, weights: Array | None = None) -> Level:
    """Equalities, or rows of all kinds, one as likely as the other."""
    if rng.random() < 0.5:
        return Level.equality(A, rng.standard_normal(len(A)), weights=weights, name=name)
    return Level(A, *random_sides(rng, A @ rng.standard_normal(A.shape[1])), weights=weights, name=name)


def _stack(rng: np.random.Generator, n: int, *own: Level, top: bool = False) -> Hierarchy:
    """These levels, random ones below and, unless they belong on top, now and then one above."""
    above = 0 if top or len(own) == 6 else int(rng.random() < 0.3)
    below = int(rng.integers(0, min(3, 6 - above - len(own)) + 1))
    some = random_hierarchy(rng, n=n, levels=above + below).levels
    return Hierarchy([*some[:above], *own, *some[above:]], n=n)


def nearly_singular(rng: np.random.Generator) -> Hierarchy:
    """A singular value of a level is 1e-14 to 1e-1 of the others."""
    n = _unknowns(rng)
    left, singular, right = np.linalg.svd(_matrix(rng, 2, n, n), full_matrices=False)
    singular[:] = 1.0
    singular[-1] = _decade(rng, -14, -1)
    return _stack(rng, n, _level(rng, left * singular @ right, "nearly singular"))


def algorithmic_singularity(rng: np.random.Generator) -> Hierarchy:
    """J2 = T J1, and noise of 1e-14 to 1e-1 beside it."""
    n = _unknowns(rng)
    J1 = _matrix(rng, 1, n - 1, n)
    J2 = _matrix(rng, 1, 3, len(J1)) @ J1
    J2 += _decade(rng, -14, -1) * rng.standard_normal(J2.shape)
    return _stack(rng, n, _level(rng, J1, "first"), _level(rng, J2, "second"))


def nearly_parallel(rng: np.random.Generator) -> Hierarchy:
    """Rows which differ by 1e-10 to 1e-4, in one level or in two."""
    n = _unknowns(rng)
    A = _matrix(rng, 1, max(1, n // 2), n)
    beside = A + _decade(rng, -10, -4) * rng.standard_normal(A.shape)
    if rng.random() < 0.5:
        return _stack(rng, n, _level(rng, np.concatenate([A, beside]), "parallel"))
    return _stack(rng, n, _level(rng, A, "parallel"), _level(rng, beside, "beside"))


def rows_again(rng: np.random.Generator) -> Hierarchy:
    """The same rows in all levels, negated and scaled, asking for the same or contradicting."""
    n = _unknowns(rng)
    pool, point = _matrix(rng, 1, n // 2 + 1, n), rng.standard_normal(n)
    levels = []
    for k in range(int(rng.integers(2, 6))):
        A = pool[rng.integers(len(pool), size=int(rng.integers(1, len(pool) + 3)))]
        A = A * rng.choice([1.0, 1.0, -1.0, 2.0, -0.5], (len(A), 1)) * _decade(rng, -3, 3)
        levels.append(Level(A, *random_sides(rng, A @ point), name=f"again {k}"))
    return _stack(rng, n, *levels)


def repeated_conflict(rng: np.random.Generator) -> Hierarchy:
    """A row comes again one level down, with another target."""
    n = _unknowns(rng)
    A = _matrix(rng, 1, max(1, n // 2), n)
    levels = [Level.equality(A, rng.standard_normal(len(A)), name="once")]
    for k in range(int(rng.integers(1, 4))):
        A = np.concatenate([A[rng.integers(len(A), size=1)], _matrix(rng, 0, n // 3, n)])
        levels.append(Level.equality(A, rng.standard_normal(len(A)), name=f"again {k}"))
    return _stack(rng, n, *levels)


def _corner(rng: np.random.Generator, A: Array, point: Array, inward: Array, name: str) -> Level:
    """Inequalities, all active at `point`; from there all permit the direction `inward`."""
    below, value = A @ inward <= 0.0, A @ point
    far = np.where(rng.random(len(A)) < 0.3, 64.0, np.inf)
    return Level(A, np.where(below, value - far, value), np.where(below, value, value + far), name=name)


def _pulls(rng: np.random.Generator, target: Array) -> list[Level]:
    """One to three levels which pull towards the target, each a little beside it."""
    rows = [_matrix(rng, 1, len(target), len(target)) for _ in range(int(rng.integers(1, 4)))]
    return [Level.equality(A, A @ (target + 0.3 * rng.standard_normal(A.shape[1])), name="pull") for A in rows]


def vertex(rng: np.random.Generator) -> Hierarchy:
    """4n integer rows through one vertex, where simplex methods cycle, and a pull outward."""
    n = _unknowns(rng)
    A, point = rng.integers(-3, 4, (4 * n, n)).astype(float), rng.integers(-2, 3, n).astype(float)
    inward = rng.standard_normal(n)
    return Hierarchy([_corner(rng, A, point, inward, "vertex"), *_pulls(rng, point - 3.0 * inward)])


def one_point(rng: np.random.Generator) -> Hierarchy:
    """Inequalities of several levels, all active in one point, and a pull outward."""
    n = _unknowns(rng)
    point, inward = rng.standard_normal((2, n))
    parts = [_matrix(rng, 1, 2 * n, n) for _ in range(int(rng.integers(2, 4)))]
    corners = [_corner(rng, A, point, inward, "corner") for A in parts]
    return Hierarchy([*corners, *_pulls(rng, point - 3.0 * inward)])


def thin_slab(rng: np.random.Generator) -> Hierarchy:
    """Feasible sets which are 1e-12 to 1e-3 wide, and a pull outward."""
    n = _unknowns(rng)
    A, point = _matrix(rng, 1, n - 1, n), rng.standard_normal(n)
    value, width = A @ point, _decade(rng, -12, -3)
    if rng.random() < 0.5:
        slab = Level(A, value, value + width, name="slab")
    else:  # the same, a row for each side
        slab = Level(np.concatenate([A, -A]), -np.inf, np.concatenate([value + width, -value]), name="slab")
    return Hierarchy([slab, *_pulls(rng, point + 3.0 * rng.standard_normal(n))])


def single_point(rng: np.random.Generator) -> Hierarchy:
    """Inequalities which leave one point, and a pull outward."""
    n = _unknowns(rng)
    A, point = rng.standard_normal((n, n)), rng.standard_normal(n)
    A = np.concatenate([A, -A if rng.random() < 0.5 else -A.sum(axis=0, keepdims=True)])
    return Hierarchy([Level(A, -np.inf, A @ point, name="point"), *_pulls(rng, point + 3.0 * rng.standard_normal(n))])


def infeasible_top(rng: np.random.Generator) -> Hierarchy:
    """Inequalities at the top which contradict each other, by 1e-3 to 1e3."""
    n = _unknowns(rng)
    A, gap = _matrix(rng, 1, n, n), _decade(rng, -3, 3)
    value, free = A @ rng.standard_normal(n), np.full(len(A), np.inf)
    lower, upper = np.concatenate([value + gap, -free]), np.concatenate([free, value - gap])
    return _stack(rng, n, Level(np.concatenate([A, A]), lower, upper, name="infeasible"), top=True)


def nothing_said(rng: np.random.Generator) -> Hierarchy:
    """Zero rows with targets, free rows and empty levels."""
    n = _unknowns(rng)
    A = _matrix(rng, 2, 5, n)
    A[rng.integers(len(A))] = 0.0
    own = [
        _level(rng, A, "a zero row"),
        _level(rng, np.zeros((2, n)), "zero rows"),
        Level(np.zeros((0, n)), [], [], name="empty"),
        Level(_matrix(rng, 1, n, n), -np.inf, np.inf, name="free"),
    ]
    return _stack(rng, n, *(own[k] for k in rng.permutation(len(own))))


def nothing_left(rng: np.random.Generator) -> Hierarchy:
    """A top level of full rank, with as many equalities as unknowns, or more."""
    n = _unknowns(rng)
    A = _matrix(rng, n, n + 4, n)
    return _stack(rng, n, Level.equality(A, rng.standard_normal(len(A)), name="top"), top=True)


def scaled_levels(rng: np.random.Generator) -> Hierarchy:
    """Levels in units of 1e-6 to 1e6."""
    return _scaled(rng, lambda rows: np.full(rows, _decade(rng, -6, 6)))


def scaled_rows(rng: np.random.Generator) -> Hierarchy:
    """Rows of one level in units of 1e-6 to 1e6."""
    return _scaled(rng, lambda rows: 10.0 ** rng.uniform(-6, 6, rows))


def _scaled(rng: np.random.Generator, factors: Callable[[int], Array]) -> Hierarchy:
    """Rows in other units; plain bounds have none of their own."""
    hierarchy = random_hierarchy(rng)
    for level in hierarchy.levels:
        if level.A is not None:
            factor = factors(len(level))
            level.A[:] *= factor[:, None]
            level.lower[:] *= factor
            level.upper[:] *= factor
    return hierarchy


def scaled_variables(rng: np.random.Generator) -> Hierarchy:
    """Unknowns in units of 1e-3 to 1e3."""
    hierarchy = random_hierarchy(rng)
    unit = 10.0 ** rng.uniform(-3, 3, hierarchy.n)
    hierarchy.A *= unit
    for level in hierarchy.levels:
        if level.indices is not None:
            level.lower[:] /= unit[level.indices]
            level.upper[:] /= unit[level.indices]
    return hierarchy


def weights(rng: np.random.Generator) -> Hierarchy:
    """Weights of 1e-3 to 1e3 in one level."""
    n = _unknowns(rng)
    A = _matrix(rng, 2, n + 2, n)
    return _stack(rng, n, _level(rng, A, "weighted", 10.0 ** rng.uniform(-3, 3, len(A))))


def weighted_conflict(rng: np.random.Generator) -> Hierarchy:
    """Rows of one level contradict each other, with weights of 1e-3 to 1e3."""
    n = _unknowns(rng)
    A = np.tile(_matrix(rng, 1, max(1, n // 2), n), (int(rng.integers(2, 4)), 1))
    scales = 10.0 ** rng.uniform(-3, 3, len(A))
    return _stack(rng, n, Level.equality(A, rng.standard_normal(len(A)), weights=scales, name="conflict"))


def bounds(rng: np.random.Generator) -> Hierarchy:
    """Bounds which cross tasks, come twice, come again lower down, and fix unknowns."""
    n = _unknowns(rng)
    twice = np.concatenate([rng.permutation(n), rng.integers(n, size=2)])
    reach, fixed = np.abs(rng.standard_normal(n + 2)), rng.standard_normal(n // 2)
    A = _matrix(rng, 1, max(1, n // 2), n)
    own = [
        Level.bounds(-reach, reach, indices=twice, name="limits"),
        Level.equality(A, 3.0 * rng.standard_normal(len(A)), name="crossing"),
        Level.bounds(fixed, fixed, indices=rng.choice(n, n // 2, replace=False), name="fixed"),
        Level.bounds(*random_sides(rng, rng.standard_normal(n)), name="again"),
    ]
    return _stack(rng, n, *own)


def bad_numbers(rng: np.random.Generator) -> Hierarchy:
    """One number that means nothing: NaN, infinite in A, or lower > upper."""
    n = _unknowns(rng)
    hierarchy = _stack(rng, n, _level(rng, _matrix(rng, 1, n, n), "rows"))
    row, fault = int(rng.integers(hierarchy.m)), rng.choice(["crossed", "NaN bound", "A"])
    if fault == "crossed":
        hierarchy.lower[row], hierarchy.upper[row] = 1.0, -1.0
    elif fault == "NaN bound":
        (hierarchy.lower if rng.random() < 0.5 else hierarchy.upper)[row] = np.nan
    else:
        hierarchy.A[rng.integers(len(hierarchy.A)), rng.integers(n)] = rng.choice([np.nan, np.inf, -np.inf])
    return hierarchy
