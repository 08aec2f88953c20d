r"""One weighted QP in place of priorities, as whole-body controllers of the kind of TSID solve it, on the same rows.

Physics and limits are constraints, the tasks below them a cost,

.. math::

    \min_x \; \sum_k w_k \|D_k (A_k x - b_k)\|^2 + \varepsilon \|x\|^2
    \quad \text{subject to} \quad l \le C x \le u, \quad x_\text{low} \le x \le x_\text{high},

with weights :math:`w_k` that fall by two decades from one level to the next.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hqp.arrays import Array
from tasks.rows.hierarchy_writer import HierarchyWriter

#: From one level to the next, in the cost; what is added for its Hessian to be positive definite.
DECADES, REGULARISATION = 1e-2, 1e-8


@dataclass(frozen=True, eq=False)
class WeightedQP:
    """The QP of one tick.

    Attributes
    ----------
    H : array, shape (n, n)
    g : array, shape (n,)
        The cost is ``x H x / 2 + g x``.
    C : array, shape (m, n)
    lower, upper : array, shape (m,)
    low, high : array, shape (n,)
        Bounds on x.
    equal : array of bool, shape (m,)
        The rows that are equalities at this tick; those without any bounds are none.
    """

    H: Array
    g: Array
    C: Array
    lower: Array
    upper: Array
    low: Array
    high: Array

    @property
    def equal(self) -> NDArray[np.bool_]:
        return self.lower == self.upper


class Weighing:
    """Turns the rows of a stack into weighted QPs; what does not change from tick to tick is done here.

    Parameters
    ----------
    rows : HierarchyWriter
    hard : int
        How many levels are constraints.
    """

    def __init__(self, rows: HierarchyWriter, hard: int) -> None:
        h = self.hierarchy = rows.hierarchy
        plain = np.zeros(h.m, dtype=bool)
        for _, first, part, _, site in rows.work:
            plain[first : first + site.rows] = part.plain
        among = np.arange(h.m) < h.pointers[hard]
        in_A = np.cumsum(h.columns < 0) - 1  # where a row with an A of its own is in it
        self.constraints, self.bounds = np.flatnonzero(among & ~plain), np.flatnonzero(among & plain)
        self.C = in_A[self.constraints]
        columns = h.columns.copy()
        for k, part in ((first, part) for _, first, part, _, _ in rows.work if part.plain):
            own = part.columns(rows.unknowns, rows.shared.robot)
            columns[k : k + len(own)] = own
        self.columns = columns[self.bounds]
        soft = np.arange(h.pointers[hard], h.m)
        level = np.repeat(np.arange(len(h.levels)), np.diff(h.pointers))[soft]
        weights = h.weights[soft] ** 2 * DECADES ** (level - hard)
        whole = h.columns[soft] < 0
        self.tasks, self.A, self.weights = soft[whole], in_A[soft[whole]], weights[whole]
        self.alone, self.of, self.pulls = soft[~whole], h.columns[soft[~whole]], weights[~whole]
        self.diagonal = np.diag_indices(h.n)

    def qp(self) -> WeightedQP:
        """Of the rows as they are now."""
        h, n, A = self.hierarchy, self.hierarchy.n, self.hierarchy.A[self.A]
        pulled = A.T * self.weights
        H, g = pulled @ A, -(pulled @ h.lower[self.tasks])
        H[self.diagonal] += REGULARISATION + np.bincount(self.of, self.pulls, n)
        g -= np.bincount(self.of, self.pulls * h.lower[self.alone], n)
        low, high = np.full(n, -np.inf), np.full(n, np.inf)
        low[self.columns], high[self.columns] = h.lower[self.bounds], h.upper[self.bounds]
        own = self.constraints
        return WeightedQP(H, g, h.A[self.C], h.lower[own], h.upper[own], low, high)
