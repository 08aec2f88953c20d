r"""Hierarchies constructed for a given solution: larger than those solved by hand, and known as exactly.

From above to below, every level is made for a point x and for multipliers that are chosen first. With the slacks w
and the weights d of its violated rows chosen too, what balances the level,

.. math::

    A_k^T D_k^2 w_k + \sum_{j<k} A_j^T \lambda_{kj} = 0,

is solved for its last row. The implicit last level is balanced by its reference,
:math:`x_\text{ref} = x + \sum_j A_j^T \lambda_j`. Since each level is convex, x is the optimum. Rows and x are small
integers, weights and slacks powers of two, so that no number is rounded.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..hierarchy import Hierarchy, Level, Side
from .answer import KnownAnswer

#: Of a row that is met: on which side x is of it.
MET = (Side.EQUALITY, Side.UPPER, Side.LOWER, Side.INACTIVE)
#: How many rows hold a level back, and how many of each level the last one.
PRESSING = 4


class KnownRows(NamedTuple):
    """The rows of a level: weights d, slacks w and sides at x."""

    A: Array
    weights: Array
    slack: Array
    sides: NDArray[np.int64]

    def level(self, x: Array, rng: np.random.Generator, name: str) -> Level:
        """A level with these slacks at x; the other bound of an inequality is 1 to 3 away, or infinite."""
        bound = self.A @ x - self.slack
        away = np.where(rng.random(len(bound)) < 0.5, np.inf, rng.integers(1, 4, len(bound)))
        upper = np.where(self.sides == Side.LOWER, bound + away, bound)
        lower = np.where(self.sides == Side.UPPER, bound - away, bound)
        inside = self.sides == Side.INACTIVE
        lower, upper = np.where(inside, bound - away, lower), np.where(inside, bound + 1.0, upper)
        return Level(self.A, lower, upper, weights=self.weights, name=name)


def backwards(n: int, rows: Sequence[int], seed: int) -> KnownAnswer:
    """The hierarchy of a seed: so many rows a level that are met, and, but in the first, two which are not."""
    rng = np.random.default_rng(seed)
    x = rng.integers(-3, 4, n).astype(float)
    parts: list[KnownRows] = []
    levels, chosen, pull = [], {}, np.zeros(n)
    for k, m in enumerate(rows):
        part = _met(rng, m, n)
        if k:
            above = _joined(parts)
            multipliers = _multipliers(rng, above, above.slack == 0.0)
            part = _joined([part, _violated(rng, -(above.A.T @ multipliers))])
            if k == 1:  # below a level which is not met, its rows and those above it depend on each other
                chosen[k] = multipliers
        parts.append(part)
        pull += part.A.T @ _multipliers(rng, part, np.ones(len(part.A), dtype=np.bool_))
        levels.append(part.level(x, rng, f"level {k}"))
    return KnownAnswer(
        name=f"backwards, n = {n}",
        source="our own",
        why="made for x and for chosen multipliers: the last row of a level is what balances them, x_ref what balances"
        " the last level",
        hierarchy=Hierarchy(levels),
        x=x,
        residuals=np.array([float(np.linalg.norm(part.weights * part.slack)) for part in parts]),
        multipliers=chosen,
        unique=False,
        x_ref=x + pull,
    )


def _joined(parts: Sequence[KnownRows]) -> KnownRows:
    return KnownRows(*(np.concatenate(pieces) for pieces in zip(*parts, strict=True)))


def _met(rng: np.random.Generator, m: int, n: int) -> KnownRows:
    """Rows without slack, of every side in turn."""
    sides = np.array([MET[i % len(MET)] for i in range(m)])
    return KnownRows(rng.integers(-2, 3, (m, n)).astype(float), _powers(rng, m), np.zeros(m), sides)


def _powers(rng: np.random.Generator, m: int) -> Array:
    """Weights of 1/2, 1 or 2: their squares are exact."""
    return np.array([0.5, 1.0, 2.0])[rng.integers(0, 3, m)]


def _violated(rng: np.random.Generator, force: Array) -> KnownRows:
    """Two rows, an inequality and an equality, which together pull with `force`: ``sum_i a_i d_i^2 w_i``."""
    first = rng.integers(-2, 3, len(force)).astype(float)
    weights, slack = _powers(rng, 2), rng.choice([-1.0, -0.5, 0.5, 1.0], 2)
    pull = weights**2 * slack
    second = (force - pull[0] * first) / pull[1]
    return KnownRows(
        np.array([first, second]),
        weights,
        slack,
        np.array([Side.UPPER if slack[0] > 0.0 else Side.LOWER, Side.EQUALITY]),
    )


def _multipliers(rng: np.random.Generator, rows: KnownRows, able: NDArray[np.bool_]) -> Array:
    """1 or 2 on some of the able rows, positive at an upper bound; of either sign on equalities and violated rows."""
    multipliers = np.zeros(len(rows.sides))
    candidates = np.flatnonzero(able & (rows.sides != Side.INACTIVE))
    pressing = rng.choice(candidates, min(PRESSING, len(candidates)), replace=False)
    free = (rows.sides == Side.EQUALITY) | (rows.slack != 0.0)
    signs = np.where(free, rng.choice([-1.0, 1.0], len(multipliers)), rows.sides)
    multipliers[pressing] = signs[pressing] * rng.integers(1, 3, len(pressing))
    return multipliers


#: One problem a size; the answers of both depend on x_ref.
BACKWARDS = (backwards(7, (4, 1, 0), seed=1), backwards(30, (8, 4, 3, 3, 2, 2, 1, 1), seed=1))
