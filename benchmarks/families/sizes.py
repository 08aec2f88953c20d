"""Families for growth curves: one of unknowns, levels and rows grows, the rest stays the same.

Bounds on every variable above inequalities and tasks above a posture; rows of norm one, so that every method solves
the same problem.

``n``
    Four tasks, every second of which is an inequality, with 0.6 n rows in all.
``levels``
    36 unknowns; six inequalities above 18 equality rows, on more and more levels.
``rows``
    36 unknowns; inequalities above a task of 12 rows and one of 6, as the distances of a robot to what surrounds it:
    more and more of them, few of them active.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from hqp import Hierarchy, Level

from .family import Family, drawn

#: Where the curves are drawn. Levels count bounds and posture, rows are those of the inequalities.
UNKNOWNS, LEVELS, ROWS = (3, 6, 12, 25, 50, 100), (2, 3, 4, 6, 8, 12), (10, 25, 50, 100, 200, 500)
#: Unknowns where something else grows, and rows of the tasks as a share of the unknowns where these grow.
_N, _SHARE = 36, 0.6
#: Spread of the point at which a task would be met.
_SPREAD = 0.4
#: Half of the width of a two-sided row, and spread of its centre: narrow ones, and such as few points x leave.
_NARROW, _WIDE = (0.8, 0.4), (1.0, 0.0)

#: Rows of a level, and their width; none for equalities.
_Shape = tuple[int, tuple[float, float] | None]


def stack(n: int, shapes: tuple[_Shape, ...], rng: np.random.Generator) -> Hierarchy:
    """Bounds, levels of these shapes, and a posture."""
    levels = [Level.bounds(-np.ones(n), np.ones(n), name="limits")]
    for rows, width in shapes:
        A = rng.standard_normal((rows, n))
        A /= np.linalg.norm(A, axis=1)[:, None]
        if width is None:
            levels.append(Level.equality(A, A @ (_SPREAD * rng.standard_normal(n))))
        else:
            centre = width[1] * rng.standard_normal(rows)
            levels.append(Level(A, centre - width[0], centre + width[0]))
    posture = 0.5 * _SPREAD * rng.standard_normal(n)
    return Hierarchy([*levels, Level.bounds(posture, posture, name="posture")])


def _parts(rows: int, levels: int) -> list[int]:
    """So many rows on so many levels, as even as can be, none empty."""
    return [max(1, rows // levels + (k < rows % levels)) for k in range(levels)]


def _along_n(n: int) -> tuple[_Shape, ...]:
    return tuple((m, _NARROW if k % 2 else None) for k, m in enumerate(_parts(round(_SHARE * n), 4)))


def _along_levels(levels: int) -> tuple[_Shape, ...]:
    inequalities: tuple[_Shape, ...] = ((6, _NARROW),) if levels > 2 else ()
    return inequalities + tuple((m, None) for m in _parts(18, levels - 3)) if levels > 3 else inequalities


def _along_rows(rows: int) -> tuple[_Shape, ...]:
    return (rows, _WIDE), (12, None), (6, None)


def _family(curve: str, at: int, n: int, shapes: tuple[_Shape, ...]) -> Family:
    levels = [f"{n} bounds", *(f"{m} {'<>' if width else '='}" for m, width in shapes), "identity"]
    return Family(
        "size",
        f"{curve} {at}",
        f"n = {n}: {' | '.join(levels)}",
        drawn(partial(stack, n, shapes)),
        feasible=True,
        posture=True,
        curve=curve,
        at=at,
    )


FAMILIES = (
    *(_family("n", n, n, _along_n(n)) for n in UNKNOWNS),
    *(_family("levels", levels, _N, _along_levels(levels)) for levels in LEVELS),
    *(_family("rows", rows, _N, _along_rows(rows)) for rows in ROWS),
)
