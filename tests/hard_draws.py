"""Draws at the limits of double precision: units, ranks and conflicts that round-off decides."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hqp import (
    DampingRule,
    ErrorDamping,
    FixedDamping,
    Hierarchy,
    Level,
    ManipulabilityDamping,
    SingularValueDamping,
)
from hqp.arrays import Array
from hqp.problems import random_hierarchy


def of_mixed_scales(rng: np.random.Generator) -> Hierarchy:
    """Levels that each have their own unit, and often rows that have theirs."""
    n = int(rng.choice([1, 2, 3, 5, 8, 12]))
    levels = []
    for _ in range(int(rng.integers(1, n + 3))):
        m = int(rng.integers(1, n + 3))
        A, b = rng.standard_normal((m, n)), rng.choice([0.0, 1.0, 1e3]) * rng.standard_normal(m)
        if m > 1 and rng.random() < 0.3:
            A[-1] = A[0]
        kinds, lower, upper = rng.integers(5, size=m), b.copy(), b.copy()
        lower[kinds == 1], upper[kinds == 2] = -np.inf, np.inf
        upper[kinds == 3] += 1.0
        unit = np.full(m, 10.0 ** rng.uniform(-8, 8) if rng.random() < 0.4 else 1.0)
        if rng.random() < 0.4:
            unit *= 10.0 ** rng.uniform(-4, 4, m)
        levels.append(Level(unit[:, None] * A, unit * lower, unit * upper))
    return Hierarchy(levels)


def nearly_dependent(rng: np.random.Generator, unit: float = 1.0) -> Hierarchy:
    """Rows that repeat rows above but for a share of 1e-17 to 1e-3, and unknowns in units of 1 / unit to unit."""
    h, above = random_hierarchy(rng), list[Array]()
    for level in (level for level in h.levels if level.A is not None):
        for row in level.A:
            if above and rng.random() < 0.5:
                share = 10.0 ** rng.uniform(-17, -3)
                row[:] = above[rng.integers(len(above))] * 10.0 ** rng.uniform(-3, 3)
                row += share * rng.standard_normal(h.n)
            above.append(row.copy())
        equal = level.lower == level.upper
        level.lower[equal] = level.upper[equal] = (level.A @ rng.standard_normal(h.n))[equal]
    h.A[:] *= unit ** rng.uniform(-1.0, 1.0, h.n)
    return h


def in_many_units(rng: np.random.Generator) -> Hierarchy:
    """Unknowns and levels that each have a unit of their own, from 1e-6 to 1e6."""
    h = random_hierarchy(rng).copy()
    h.A[:] *= 10.0 ** rng.uniform(-6.0, 6.0, h.n)
    for level in (level for level in h.levels if level.A is not None):
        unit = 10.0 ** rng.uniform(-6.0, 6.0)
        for numbers in (level.A, level.lower, level.upper):
            numbers *= unit
    return h


def in_conflict(rng: np.random.Generator) -> Hierarchy:
    """Levels with more rows than unknowns, often of a rank that is clear only to 1e-14 to 1e-4, and weights."""
    n = int(rng.integers(2, 9))
    levels = []
    for _ in range(int(rng.integers(1, 5))):
        m, rank = int(rng.integers(1, 2 * n)), int(rng.integers(1, n + 1))
        A = rng.standard_normal((m, n))
        if rng.random() < 0.5:
            A = A @ rng.standard_normal((n, rank)) @ rng.standard_normal((rank, n))
            A += 10.0 ** rng.uniform(-14.0, -4.0) * rng.standard_normal((m, n))
        lower = rng.standard_normal(m) * 10.0 ** rng.uniform(-2.0, 3.0)
        upper, kinds = lower.copy(), rng.integers(4, size=m)
        lower[kinds == 1], upper[kinds == 2] = -np.inf, np.inf
        upper[kinds == 3] += rng.uniform(0.0, 1.0)
        levels.append(Level(A, lower, upper, weights=10.0 ** rng.uniform(-2.0, 2.0, m)))
    return Hierarchy(levels, n=n)


def repeated(rng: np.random.Generator) -> Hierarchy:
    """Rows that come again on their level, times a factor, and with bounds that are the same but for 1e-12 to 1."""
    h, levels = random_hierarchy(rng), []
    for k, level in enumerate(h.levels):
        A, again = h.matrix(k), rng.integers(len(level), size=int(rng.integers(0, len(level) + 1)))
        shift = rng.choice([0.0, 1e-12, 1e-6, 0.1, 1.0], len(again)) * rng.standard_normal(len(again))
        factor = rng.choice([-1.0, 0.1, 1.0, 2.0], len(again))
        ends = factor * (level.lower[again] + shift), factor * (level.upper[again] + shift)
        lower, upper = np.minimum(*ends), np.maximum(*ends)
        rows = np.concatenate([A, factor[:, None] * A[again]])
        bounds = np.concatenate([level.lower, lower]), np.concatenate([level.upper, upper])
        levels.append(Level(rows, *bounds, weights=np.concatenate([level.weights, level.weights[again]])))
    return Hierarchy(levels, n=h.n)


def through_zero(rng: np.random.Generator) -> Hierarchy:
    """All bounds are zero or infinite."""
    h = random_hierarchy(rng).copy()
    for bounds in (h.lower, h.upper):
        bounds[np.isfinite(bounds)] = 0.0
    return h


#: Name -> a hierarchy at random.
DRAWS: dict[str, Callable[[np.random.Generator], Hierarchy]] = {
    "nearly dependent": nearly_dependent,
    "nearly dependent in many units": lambda rng: nearly_dependent(rng, 1e6),
    "many units": in_many_units,
    "conflict": in_conflict,
    "repeated": repeated,
    "through zero": through_zero,
}


def far(rng: np.random.Generator, n: int) -> Array:
    """x_ref: zero, near, or far."""
    x_ref: Array = rng.standard_normal(n) * rng.choice([0.0, 1.0, 10.0 ** rng.uniform(-3.0, 7.0)])
    return x_ref


def damping(rng: np.random.Generator, h: Hierarchy) -> dict[int, DampingRule]:
    """Rules for some levels, at least for one, with a damping from 1e-6 to 1e3."""
    rules: dict[int, DampingRule] = {}
    for k in rng.choice(len(h.levels), size=int(rng.integers(1, len(h.levels) + 1)), replace=False).tolist():
        much = 10.0 ** rng.uniform(-6.0, 3.0)
        rules[k] = (
            FixedDamping(much),
            ErrorDamping(much),
            ManipulabilityDamping(much, 0.5),
            SingularValueDamping(much, 0.5),
        )[rng.integers(4)]
    return dict(sorted(rules.items()))
