r"""The stages of a softened answer, written anew from the given hierarchy and the declared softening.

A stage that was solved lies in memory of the loops: a proof on that memory would repeat any error in it. So an answer
keeps no stage, only the x of every stage and the *declared softening*, the numbers of :class:`Declared`. The
certificate proves x on the rows of the given hierarchy, with its own numbers, beside

.. math:: D_k x = d_k, \qquad s_i c_i^T W_j x = s_i c_i^T W_j x_j,

the rows of damping, and those that levels j above leave soft or held: combinations c of their weighted rows W, each at
the value that its own stage reached. If another problem was solved, x is not optimal here, and the proof fails.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..certificate import Handed
from ..hierarchy import Hierarchy
from ..kernels import curved_layout as at


class Declared(NamedTuple):
    """How levels were softened, as the loops declare it.

    Attributes
    ----------
    opened, last : int
        The first and the last level that had a stage of its own.
    states : array of int, shape (m,)
        The state of every row for the levels below its own, see :mod:`hqp.kernels.curved_layout`.
    points : array, shape (levels, n)
        The x at the end of the stage of each level.
    strengths : array, shape (levels,)
        How strongly it was damped.
    norms : array, shape (levels, m)
        The length of its rows that are in the same block as a row, which scales that row where it is soft beside them.
    stiffness : array, shape (m,)
        Of soft rows, relative to that length.
    combined : array, shape (m, widest)
        What rows below their level are combinations of: its own, weighted.
    damped : array, shape (levels, n, n + 1)
        The rows of damping of every level, each with its bound.
    aims : array, shape (levels, n)
        The x to which the damping of every level pulls.
    """

    opened: int
    last: int
    states: NDArray[np.int64]
    points: Array
    strengths: Array
    norms: Array
    stiffness: Array
    combined: Array
    damped: Array
    aims: Array

    @property
    def levels(self) -> range:
        """Those that had a stage of their own."""
        return range(self.opened, self.last + 1)


class Stage:
    """The hierarchy of one stage.

    Parameters
    ----------
    given : Hierarchy
        As it was when it was to be solved.
    template : Hierarchy
        Of the structure of the stage.
    curved : sequence of int
        Of every level, whether it may be softened, or soften others.
    declared : Declared
    """

    def __init__(self, given: Hierarchy, template: Hierarchy, curved: Sequence[int], declared: Declared) -> None:
        self._given, self._told = given, declared
        self.hierarchy = template.with_numbers(np.zeros_like(template.numbers))
        k = len(template.levels) - 1
        for j in range(k):
            self._own(j)
            if curved[j]:
                self._hand_over(j)
        self._own(k)
        own, rows = self.hierarchy.levels[k], self.hierarchy.matrix(k)
        end = place = len(given.levels[k])
        for j in range(k):
            if curved[j]:
                end += len(given.levels[j])
                free = slice(place, end)
                rows[free], own.lower[free], own.upper[free], own.weights[free] = *self._soft(j, declared.norms[k]), 1.0
                place = end
        rows[place:], own.weights[place:] = declared.damped[k, :, :-1], 1.0
        own.lower[place:] = own.upper[place:] = declared.damped[k, :, -1]

    def _own(self, j: int) -> None:
        """The rows of a level, as they were given."""
        mine, level = self.hierarchy.levels[j], self._given.levels[j]
        own = slice(len(level))
        mine.lower[own], mine.upper[own], mine.weights[own] = level.lower, level.upper, level.weights
        if mine.A is not None:
            mine.A[own] = self._given.matrix(j)

    def _hand_over(self, j: int) -> None:
        """Of a level above, what is held at what it reached; what is soft, or of no matter, is free here."""
        mine, states = self.hierarchy.levels[j], self._told.states[slice(*self._given.pointers[j : j + 2])]
        changed, held = states != at.GIVEN, states == at.HELD
        rows = np.where(held[:, None], combinations(self._given, self._told, j), 0.0)
        reached = rows @ self._told.points[j]
        assert mine.A is not None
        mine.A[changed], mine.weights[changed] = rows[changed], 1.0
        mine.lower[changed] = np.where(held, reached, -np.inf)[changed]
        mine.upper[changed] = np.where(held, reached, np.inf)[changed]

    def _soft(self, j: int, norms: Array) -> tuple[Array, Array, Array]:
        """What a level above leaves soft, beside rows of these lengths; its other rows are free."""
        own = slice(*self._given.pointers[j : j + 2])
        soft = self._told.states[own] == at.SOFT
        scale = np.where(soft, self._told.stiffness[own] * norms[own], 0.0)
        rows = scale[:, None] * combinations(self._given, self._told, j)
        reached = rows @ self._told.points[j]
        return rows, np.where(soft, reached, -np.inf), np.where(soft, reached, np.inf)


def combinations(given: Hierarchy, declared: Declared, j: int) -> Array:
    """The rows that level j has for those below it, shape (m_j, n)."""
    own, level = slice(*given.pointers[j : j + 2]), given.levels[j]
    rows: Array = declared.combined[own, : len(level)] @ (level.weights[:, None] * given.matrix(j))
    return rows


def handed(given: Hierarchy, declared: Declared) -> tuple[Handed, ...]:
    """Of every level with levels below it, what these must leave where it is: all but what is declared soft."""
    found = list[Handed]()
    for j in range(declared.opened, declared.last):
        own, level = slice(*given.pointers[j : j + 2]), given.levels[j]
        states = declared.states[own]
        play = np.flatnonzero(states != at.GIVEN)
        rows = level.weights[play, None] * given.matrix(j)[play]
        soft = np.linalg.qr(declared.combined[own, : len(level)][states == at.SOFT][:, play].T)[0]
        kept, size = rows - soft @ (soft.T @ rows), float(np.linalg.norm(rows))
        found.append(Handed(j, kept, size, declared.points[j]))
    return tuple(found)


def softened(declared: Declared, pointers: Sequence[int]) -> tuple[int, ...]:
    """The softened levels: those with rows of damping, and those whose rows are soft for the levels below."""
    return tuple(
        k
        for k in declared.levels
        if declared.damped[k].any() or (declared.states[slice(*pointers[k : k + 2])] == at.SOFT).any()
    )
