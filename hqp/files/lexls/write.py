"""A hierarchy to a text file."""

from __future__ import annotations

import os
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array, finite_vector, index_vector
from ...checks import of_type
from ...errors import InvalidInput, brief
from ...hierarchy import Hierarchy, Level, Side
from .problem import BOUNDS, EQUALITIES, HEADER, INEQUALITIES, INFINITE, POINTS, ROWS, SIDES, WITH_GUESS


def write(
    path: str | os.PathLike[str],
    hierarchy: Hierarchy,
    x_ref: ArrayLike | None = None,
    *,
    guess: ArrayLike | None = None,
    solution_guess: ArrayLike | None = None,
    solution: ArrayLike | None = None,
) -> None:
    """Write a hierarchy to a file in the text format of LexLS, see :mod:`hqp.lexls`; it appears whole or not at all.

    It is the same problem in other words, those of :func:`as_lexls`, and its numbers come back to the last bit. The
    implicit last level ``min ||x - x_ref||`` is no part of the format: without `x_ref`, where the levels leave x free,
    LexLS answers with some other optimum.

    Parameters
    ----------
    path : str or path
    hierarchy : Hierarchy
    x_ref : array, shape (n,), optional
        If given, one more level comes last, ``x = x_ref``.
    guess : array of int, shape (m,), optional
        For every row the :class:`hqp.Side` on which it may be active.
    solution_guess, solution : array, shape (n,), optional
        A starting point, and an optimum.

    Raises
    ------
    InvalidInput
        If the file has another suffix than .dat, .txt and .lexls, or cannot be written, the hierarchy has no level or a
        number that no solver takes, or an array has the wrong shape.
    """
    from ..names import HIERARCHY
    from ..whole import write_lines

    h = as_lexls(hierarchy, x_ref)
    sides = None if guess is None else _activations(guess, hierarchy.m, h.m)
    points = {
        field: finite_vector(point, h.n, field)
        for field, point in zip(POINTS, (solution_guess, solution), strict=True)
        if point is not None
    }
    write_lines(path, _lines(h, sides, points), *HIERARCHY)


def as_lexls(hierarchy: Hierarchy, x_ref: ArrayLike | None = None) -> Hierarchy:
    """The hierarchy as a problem that the format can hold.

    Rows are multiplied by their weights. Bounds on variables stay such on the first level, if its weights are one and
    it names no variable twice; elsewhere they become rows. Labels are left out. Where `x_ref` is given, one more level
    comes last, ``x = x_ref``.

    Parameters
    ----------
    hierarchy : Hierarchy
    x_ref : array, shape (n,), optional
        Reference of the implicit last level, which the format does not have: it becomes a level of rows.

    Raises
    ------
    InvalidInput
        If there is no level, or a number that no solver takes, with its weight or without.
    """
    h = of_type(hierarchy, Hierarchy, "the hierarchy")
    if fault := h.find_fault():
        raise InvalidInput(fault)
    levels = [_fitting(h, k) for k in range(len(h.levels))]
    if x_ref is not None:
        levels.append(Level.equality(np.eye(h.n), finite_vector(x_ref, h.n, "x_ref"), name="x_ref"))
    if not levels:
        raise InvalidInput("the hierarchy has no level; the text format asks for one")
    same = Hierarchy(levels, n=h.n)
    if fault := same.find_fault():
        raise InvalidInput(f"{fault}, its weight included")
    return same


def _fitting(hierarchy: Hierarchy, k: int) -> Level:
    """Level k in words of the format."""
    level = hierarchy.levels[k]
    weights, lower, upper, indices = level.weights, level.lower, level.upper, level.indices
    if k == 0 and indices is not None and len(set(indices)) == len(indices) and (weights == 1.0).all():
        return Level.bounds(lower, upper, indices=indices, name=level.name)
    return Level(weights[:, None] * hierarchy.matrix(k), weights * lower, weights * upper, name=level.name)


def _activations(guess: ArrayLike, m: int, rows: int) -> list[int]:
    """The guess of m rows as activation types; rows that come after them are equalities."""
    sides = index_vector(guess, "guess")
    if len(sides) != m or not np.isin(sides, SIDES).all():
        raise InvalidInput(f"guess = {brief(guess)} must be a hqp.Side for each of {m} rows")
    return [SIDES.index(Side(side)) for side in sides] + [SIDES.index(Side.EQUALITY)] * (rows - m)


def _lines(h: Hierarchy, sides: list[int] | None, points: dict[str, Array]) -> Iterator[str]:
    import json

    # Only what agrees to the last bit is written once: zeros have signs.
    equal = sides is None and h.lower.tobytes() == h.upper.tobytes()
    kind = EQUALITIES if equal else INEQUALITIES if sides is None else WITH_GUESS
    types = [ROWS if level.indices is None else BOUNDS for level in h.levels]
    counts = [kind], [h.n], [len(types)], map(len, h.levels), types
    yield f"# A hierarchy in the text format of LexLS. Bounds of {INFINITE:g} are infinite."
    for field, numbers in zip(HEADER, counts, strict=True):
        yield from ("", field, " ".join(map(str, numbers)))

    # LexLS passes over one line after the header and one after the last row: let them be blank.
    for k, level in enumerate(h.levels):
        yield from ("", f"#OBJECTIVE {k}" + (f" {json.dumps(level.name)}" if level.name else ""))
        first = h.matrix(k) if level.indices is None else level.indices[:, None] + 1
        ends = np.clip([level.lower] if equal else [level.lower, level.upper], -INFINITE, INFINITE).T
        for row, (front, back) in enumerate(zip(first, ends, strict=True)):
            last = [] if sides is None else [sides[h.pointers[k] + row]]
            yield " ".join(map(repr, [*front.tolist(), *back.tolist(), *last]))
    for field, point in points.items():
        yield from ("", field, *map(repr, point.tolist()))
    yield ""
