"""The errors, curvatures and aims behind a hierarchy that is a linearisation: the input of :mod:`hqp.solver.curved`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ..arrays import Array


class Contraction(NamedTuple):
    """A loop that adds the curvatures of some rows, each times its weight, to a matrix.

    Attributes
    ----------
    loop, table : int
        Its address, and that of what it is told.
    weights : array, shape (rows,)
        Where it finds the weights.
    row : int
        The first of its rows in the hierarchy.
    """

    loop: int
    table: int
    weights: Array
    row: int


class Errors(NamedTuple):
    """How far some rows are from where they are wanted.

    Attributes
    ----------
    error, below, above : array, shape (rows,)
        The error that the row reduces, and its band: an equality has none.
    row : int
        The first of these rows in the hierarchy.
    """

    error: Array
    below: Array
    above: Array
    row: int


@dataclass(frozen=True, eq=False)
class Linearisation:
    """What a hierarchy is the linearisation of. All arrays are kept up to date by the caller.

    Attributes
    ----------
    curved : tuple of int
        Which levels may be damped: 1; or are left strict, and may damp those below them: 2. Of the others, 0, only what
        they ask for counts.
    errors : sequence of Errors
    contractions : sequence of Contraction
    curvature : array, shape (n, n)
        What the contractions add to.
    scales : array, shape (m,)
        How fast the error of each row is to go, relative to the fastest.
    shares : array, shape (levels,)
        What share of its error a level takes away in one step.
    aims : array, shape (levels, n)
        Where the damping of a level draws x.
    last : array, shape (n,)
        The x of the step before; NaN if it is not known.
    singular : str
        What explanations say of a direction in which x hardly moves a level.
    kept : tuple
        What has to live as long as the addresses above mean something.
    """

    curved: tuple[int, ...]
    errors: Sequence[Errors]
    contractions: Sequence[Contraction]
    curvature: Array
    scales: Array
    shares: Array
    aims: Array
    last: Array
    singular: str = "its rows are nearly dependent in this direction"
    kept: tuple[Any, ...] = field(default=(), repr=False)
