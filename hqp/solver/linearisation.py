"""The errors, curvatures and aims behind a hierarchy that is a linearisation: the input of :mod:`hqp.solver.curved`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array


class Bound(NamedTuple):
    """A loop that bounds curvatures: with weights w, the norm of their sum is at most the root of w' F w.

    Attributes
    ----------
    loop, table : int
        Its address, and that of its arguments.
    matrix : array, shape (rows, rows)
        Where it writes F.
    """

    loop: int
    table: int
    matrix: Array


class Contraction(NamedTuple):
    """A loop that adds the curvatures of some rows, each times its weight, to a matrix.

    Attributes
    ----------
    loop, table : int
        Its address, and that of its arguments.
    weights : array, shape (rows,)
        Where it finds the weights.
    row : int
        The first of its rows in the hierarchy.
    bound : Bound, optional
        What bounds the result, without which it is computed in every step.
    """

    loop: int
    table: int
    weights: Array
    row: int
    bound: Bound | None = None


class Errors(NamedTuple):
    """The errors of some rows.

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
    """The errors, curvatures and aims behind a linearised hierarchy. All arrays are kept up to date by the caller.

    Attributes
    ----------
    curved : tuple of int
        Which levels may be damped: 1; or are left strict, and may damp those below them: 2. Of the others, 0, only what
        they ask for counts.
    columns, block_of : array of int, shapes (n,) and (m,)
        The number of the block of every variable, and of every row: no row has variables of two blocks, so that each
        block is a problem of its own, and is damped as if there were no other.
    kinds : array of int, shape (blocks, levels)
        As `curved`, for the rows of each block alone: 0 where `curved` is, and 1 only where it is.
    errors : sequence of Errors
    contractions : sequence of Contraction
    unknown : array of bool, shape (m,)
        Rows that are not linear and whose curvature is not among the contractions.
    curvature : array, shape (n, n)
        What the contractions add to.
    scales : array, shape (m,)
        The rate at which the error of each row is to be reduced, relative to the fastest.
    worth : array, shape (m,)
        The error that a unit of a row's bound is worth, scaled; 0: the error is as measured. With a worth, rows below
        the first curved level look ahead, to what they lack where the levels above leave off, times that.
    shares : array, shape (blocks, levels)
        The share of its error that a level removes in one step.
    aims : array, shape (levels, n)
        The x to which the damping of a level pulls.
    last : array, shape (n,)
        The x of the step before.
    singular : str
        Text in explanations for a direction in which x hardly moves a level.
    kept : tuple
        Objects that must live as long as the addresses above are used.
    """

    curved: tuple[int, ...]
    columns: NDArray[np.int64]
    block_of: NDArray[np.int64]
    kinds: NDArray[np.int64]
    errors: Sequence[Errors]
    contractions: Sequence[Contraction]
    unknown: NDArray[np.bool_]
    curvature: Array
    scales: Array
    worth: Array
    shares: Array
    aims: Array
    last: Array
    singular: str = "its rows are nearly dependent in this direction"
    kept: tuple[Any, ...] = field(default=(), repr=False)
