"""Levels of equalities alone, in every rank case: where the closed form, Eq. 3.17, applies."""

from __future__ import annotations

from hqp.problems import CASES, SHAPES, Case

from .family import Family, drawn

#: An arm with a pose and a posture, and a humanoid with four levels, of the shapes of ``hqp validate``.
_CHOSEN = [shape for shape in SHAPES if shape[0] in (7, 30) and len(shape[1]) > 2]

FAMILIES = tuple(
    Family(
        "equalities",
        f"n {n} {rank}",
        f"n = {n}: {' | '.join(f'{m} =' for m in rows)}; {rank}",
        drawn(Case(n, rows, rank).hierarchy),
        inequalities=False,
    )
    for n, rows in _CHOSEN
    for rank in CASES
)
