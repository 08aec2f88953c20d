"""One thing grows, the rest stays: unknowns, levels, rows. For growth curves.

Bounds on every variable above tasks, every second of which is an inequality, above a posture; rows of norm one, so
that every method solves the same problem.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from hqp import Hierarchy, Level

from .family import Family, drawn

#: Where the curves are drawn. Rows are those of the tasks; levels count bounds and posture.
UNKNOWNS, LEVELS, ROWS = (3, 6, 12, 25, 50, 100), (2, 3, 4, 6, 8, 12), (10, 25, 50, 100, 200, 500)
#: What stays: tasks and their rows along n, as shares of n; unknowns along the levels; unknowns, tasks along the rows.
_TASKS, _SHARE, _N_LEVELS, _N_ROWS = 4, 0.6, 36, 50
#: Spread of the point at which a task would be met, half of the width of a two-sided row, and spread of its centre.
_SPREAD, _HALF_WIDTH, _CENTRE = 0.4, 0.8, 0.4


def stack(n: int, rows: tuple[int, ...], rng: np.random.Generator) -> Hierarchy:
    """Bounds, tasks of so many rows, and a posture."""
    levels = [Level.bounds(-np.ones(n), np.ones(n), name="limits")]
    for k, m in enumerate(rows):
        A = rng.standard_normal((m, n))
        A /= np.linalg.norm(A, axis=1)[:, None]
        if k % 2:
            centre = _CENTRE * rng.standard_normal(m)
            levels.append(Level(A, centre - _HALF_WIDTH, centre + _HALF_WIDTH))
        else:
            levels.append(Level.equality(A, A @ (_SPREAD * rng.standard_normal(n))))
    posture = 0.5 * _SPREAD * rng.standard_normal(n)
    return Hierarchy([*levels, Level.bounds(posture, posture, name="posture")])


def _parts(rows: int, tasks: int) -> tuple[int, ...]:
    """So many rows on so many tasks, as even as can be, none empty."""
    return tuple(max(1, rows // tasks + (k < rows % tasks)) for k in range(tasks))


def _family(curve: str, at: int, n: int, rows: tuple[int, ...]) -> Family:
    shape = " | ".join([f"{n} bounds", *(f"{m} {'<>' if k % 2 else '='}" for k, m in enumerate(rows)), "identity"])
    return Family(
        "size",
        f"{curve} {at}",
        f"n = {n}: {shape}",
        drawn(partial(stack, n, rows)),
        feasible=True,
        posture=True,
        curve=curve,
        at=at,
    )


FAMILIES = (
    *(_family("n", n, n, _parts(max(_TASKS, round(_SHARE * n)), _TASKS)) for n in UNKNOWNS),
    *(
        _family("levels", levels, _N_LEVELS, _parts(round(_SHARE * _N_LEVELS), levels - 2) if levels > 2 else ())
        for levels in LEVELS
    ),
    *(_family("rows", rows, _N_ROWS, _parts(rows, _TASKS)) for rows in ROWS),
)
