"""Random hierarchies of the size of an arm, in which one of rank, conflict and active bounds is varied.

Seven unknowns: bounds on all of them above four equality levels of three, three, two and seven rows, the last one a
posture. All rows have norm one, so that every method solves the same problem.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from hqp import Hierarchy, Level, solve
from hqp.arrays import Array

from .family import Family, drawn

_N, _ROWS = 7, (3, 3, 2)
#: Bounds that no task reaches.
_FAR = 1e3
#: What is controlled, and to which shares.
_SHARES = (0.0, 0.25, 0.5, 0.75)


def _tasks(rng: np.random.Generator) -> list[Array]:
    return [rng.standard_normal((m, _N)) for m in _ROWS]


def _stack(rng: np.random.Generator, tasks: list[Array], bound: Callable[[Array], float]) -> Hierarchy:
    """Bounds, tasks and posture; `bound` tells the bounds from where x would be without them."""
    tasks = [A / np.linalg.norm(A, axis=1)[:, None] for A in tasks]
    targets = [A @ (0.5 * rng.standard_normal(_N)) + 0.5 * rng.standard_normal(len(A)) for A in tasks]
    levels = [Level.equality(A, b) for A, b in zip(tasks, targets, strict=True)]
    posture = 0.25 * rng.standard_normal(_N)
    levels.append(Level.bounds(posture, posture, name="posture"))
    width = bound(np.abs(solve(Hierarchy(levels), backend="pseudoinverse").x))
    return Hierarchy([Level.bounds(np.full(_N, -width), np.full(_N, width), name="limits"), *levels])


def rank(share: float, rng: np.random.Generator) -> Hierarchy:
    """Of the rows of every task, this share depends on the others."""
    tasks = _tasks(rng)
    for A in tasks:
        lost = round(share * len(A))
        own = max(1, len(A) - lost)
        A[own:] = rng.standard_normal((len(A) - own, own)) @ A[:own]
    return _stack(rng, tasks, lambda x: float(np.quantile(x, 0.7)))


def conflict(share: float, rng: np.random.Generator) -> Hierarchy:
    """Of the rows of the tasks below the first, this share lies in the row space of the first, with other targets."""
    first, *others = _tasks(rng)
    rows = [(A, i) for A in others for i in range(len(A))]
    for number in rng.permutation(len(rows))[: round(share * len(rows))]:
        A, i = rows[number]
        A[i] = rng.standard_normal(len(first)) @ first
    return _stack(rng, [first, *others], lambda x: float(np.quantile(x, 0.7)))


def active(share: float, rng: np.random.Generator) -> Hierarchy:
    """Without the bounds, this share of the unknowns would be outside them."""
    return _stack(rng, _tasks(rng), lambda x: float(np.quantile(x, 1.0 - share)) if share else _FAR)


FAMILIES = tuple(
    Family(
        "random",
        f"{what.__name__} {share:.0%}",
        f"n = 7, {text}: {share:.0%}",
        drawn(partial(what, share)),
        feasible=True,
        posture=True,
    )
    for what, text in (
        (rank, "rows of each task that depend on its others"),
        (conflict, "rows of lower tasks that contradict the first"),
        (active, "unknowns that would be outside their bounds"),
    )
    for share in _SHARES
)
