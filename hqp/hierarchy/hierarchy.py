r"""The problem: a lexicographic sequence of least squares, stated once.

A :class:`Hierarchy` of levels :math:`k = 0, \dots, p-1` (0 is the highest) asks for

.. math::

    \operatorname{lex\,min}_{x \in \mathbb{R}^n} \; \bigl(\|D_0 w_0\|, \|D_1 w_1\|, \dots, \|D_{p-1} w_{p-1}\|\bigr)
    \quad \text{subject to} \quad l_k \le A_k x - w_k \le u_k,

with the weights :math:`D_k = \operatorname{diag}(\text{weights}_k)`, and, to make x unique, for one
last implicit level :math:`\min \|x - x_\text{ref}\|`. A row with ``lower == upper`` is an equality;
infinite bounds leave a side, or the whole row, free. The slack of any x is known in closed form:
``w = A x - clip(A x, lower, upper)``. So a hierarchy always has an answer: a level that cannot be met
is met as well as the levels above it permit.

All numbers live in one buffer, so that a control loop refills them in place and a snapshot is one
copy. A level of plain bounds on x keeps indices instead of rows.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any
from warnings import warn

import numpy as np

from ..arrays import Array, Indices, lengths
from ..checks import SetOnce, of_type
from ..errors import InvalidInput
from .form import called, checked_levels, form_of
from .label import Label, Labels, labels_of
from .level import Level

#: Numbers beyond this one are refused, and rows shorter than its inverse are zero rows: squares of what lies
#: between neither overflow nor underflow, weighted or not.
LARGEST = 1e30


class Hierarchy(SetOnce):
    """Levels in order of priority, and all their numbers in one place.

    Parameters
    ----------
    levels : sequence of Level
        The highest priority first. Their numbers are copied; change them afterwards through
        ``hierarchy.levels[k]``.
    n : int, optional
        Number of unknowns, at most a million. Needed only if no level determines it (no levels at all, or only
        bounds on listed indices).

    Attributes
    ----------
    n, m : int
        Unknowns, and rows of all levels together.
    levels : tuple of Level
        Views into the arrays below.
    A : array, shape (dense rows, n)
        Rows of all levels that have rows, in order.
    lower, upper, weights : array, shape (m,)
        Of all rows, in order; level k owns ``pointers[k]:pointers[k + 1]``.
    columns : array of int, shape (m,)
        The variable that a plain bound acts on; -1 for a row of A.
    numbers : array
        All of them, one after the other: A, lower, upper, weights. The arrays above are views of it.
    structure : tuple
        What must stay the same for a warm start: sizes and, for plain bounds, their variables. Shared by copies.

    Raises
    ------
    InvalidInput
        If the levels disagree on the number of unknowns, or an index is out of range.

    Examples
    --------
    >>> from hqp import Hierarchy, Level, solve
    >>> limits = Level.bounds([-1.0, -1.0], [1.0, 1.0], name="limits")
    >>> hierarchy = Hierarchy([limits, Level.equality([[1.0, 1.0]], [3.0], name="sum")])
    >>> hierarchy.n, hierarchy.m, solve(hierarchy).x
    (2, 3, array([1., 1.]))
    >>> hierarchy.levels[1].lower[:] = hierarchy.levels[1].upper[:] = 1.0
    >>> solve(hierarchy).x
    array([0.5, 0.5])
    """

    _stays = frozenset(
        ("n", "m", "levels", "A", "lower", "upper", "weights", "columns", "pointers", "numbers", "structure", "address")
    )
    _instead = "its numbers may be written in place, as in hierarchy.levels[1].lower[:] = ..."

    n: int
    m: int
    columns: Indices
    pointers: tuple[int, ...]
    numbers: Array
    structure: tuple[Any, ...]
    _names: tuple[str, ...]
    _labels: tuple[Sequence[Label] | None, ...]
    _has_rows: tuple[bool, ...]
    _dense: Indices
    _form: dict[str, Any]

    def __init__(self, levels: Iterable[Level], *, n: int | None = None) -> None:
        given = checked_levels(levels)
        form = form_of(given, n)
        self.__setstate__((form, np.empty(len(form["_dense"]) * form["n"] + 3 * form["m"])))
        for mine, level in zip(self.levels, given, strict=True):
            mine.lower[:], mine.upper[:], mine.weights[:] = level.lower, level.upper, level.weights
            if mine.A is not None and level.A is not None:
                mine.A[:] = level.A

    # All numbers are views of one buffer, cut when first asked for.
    @cached_property
    def A(self) -> Array:
        """Rows of all levels that have rows, in order, shape (dense rows, n)."""
        return self.numbers[: len(self._dense) * self.n].reshape(len(self._dense), self.n)

    @cached_property
    def lower(self) -> Array:
        """Lower bounds of all rows, in order, shape (m,)."""
        return self._columns[0]

    @cached_property
    def upper(self) -> Array:
        """Upper bounds of all rows, in order, shape (m,)."""
        return self._columns[1]

    @cached_property
    def weights(self) -> Array:
        """Weights of all rows, in order, shape (m,)."""
        return self._columns[2]

    @property
    def _columns(self) -> tuple[Array, ...]:
        return tuple(self.numbers[len(self._dense) * self.n :].reshape(3, self.m))

    @cached_property
    def address(self) -> int:
        """Where the numbers are in memory, for kernels: A, lower, upper, weights, one after the other."""
        return int(self.numbers.ctypes.data)

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """The levels, as views into the arrays."""
        levels, row = [], 0
        for k, name in enumerate(self._names):
            own = slice(self.pointers[k], self.pointers[k + 1])
            A, indices = None, None
            if self._has_rows[k]:
                A = self.A[row : row + own.stop - own.start]
                row += len(A)
            else:
                indices = self.columns[own]
            view = object.__new__(Level)
            numbers = A, self.lower[own], self.upper[own], self.weights[own], indices
            levels.append(view._hold(*numbers, name, self._labels[k]))
        return tuple(levels)

    def copy(self) -> Hierarchy:
        """A snapshot with numbers of its own: one buffer copied, the structure shared."""
        return self.with_numbers(self.numbers.copy())

    def with_numbers(self, numbers: Array) -> Hierarchy:
        """A hierarchy of this structure on this buffer, not a copy of it.

        Raises
        ------
        InvalidInput
            If it is no contiguous array of float64 of the size of ``self.numbers``.
        """
        given = of_type(numbers, np.ndarray, "numbers")
        if given.shape != self.numbers.shape or given.dtype != np.float64 or not given.flags.c_contiguous:
            raise InvalidInput(
                f"numbers of shape {given.shape} and type {given.dtype}; they must be contiguous,"
                f" of shape {self.numbers.shape} and type float64"
            )
        twin = object.__new__(Hierarchy)
        twin.__setstate__((self._form, numbers))
        return twin

    def with_labels(self, labels: Mapping[int, Labels]) -> Hierarchy:
        """A hierarchy on the same buffer, in which the rows of these levels are called otherwise.

        Raises
        ------
        InvalidInput
            If they are not a sequence of one Label a row, or a function that gives it.
        """
        called_now = list(self._labels)
        for k, own in labels.items():
            rows = self.pointers[k + 1] - self.pointers[k]
            called_now[k] = labels_of(own, rows, f"{self.level_name(k)}: labels")
        twin = object.__new__(Hierarchy)
        twin.__setstate__((self._form | {"_labels": tuple(called_now)}, self.numbers))
        return twin

    def __copy__(self) -> Hierarchy:
        return self.copy()

    def __deepcopy__(self, memo: dict[int, Any]) -> Hierarchy:
        return self.copy()

    def __getstate__(self) -> tuple[dict[str, Any], Array]:
        return self._form, self.numbers

    def __setstate__(self, state: tuple[dict[str, Any], Array]) -> None:
        form, numbers = state
        own = numbers if numbers.flags.writeable else numbers.copy()  # joblib maps large arrays read-only
        self.__dict__.update(form, _form=form, numbers=own)

    def matrix(self, k: int) -> Array:
        """Dense rows of level k, shape (m_k, n): a view for rows, a fresh 0/1 matrix for plain bounds."""
        level = self.levels[k]
        return level.A if level.A is not None else np.eye(self.n)[level.indices]

    def dense(self) -> Array:
        """Rows of all levels, shape (m, n): the view A, or a fresh matrix with a 0/1 row for each plain bound."""
        if self._all_dense:
            return self.A
        rows = np.eye(self.n)[self.columns]
        rows[self._dense] = self.A
        return rows

    def product(self, x: Array) -> Array:
        """``A x`` over the rows of all levels, shape (m,); plain bounds just pick their variable."""
        if self._all_dense:
            return self.A @ x
        out = x[self.columns]
        out[self._dense] = self.A @ x
        return out

    def row_norms(self) -> Array:
        """Euclidean norm of every row, shape (m,); 1 for a plain bound, 0 for a row shorter than 1e-30."""
        norms = np.ones(self.m)
        norms[self._dense] = lengths(self.A)
        norms[norms < 1.0 / LARGEST] = 0.0
        return norms

    @property
    def _all_dense(self) -> bool:
        return len(self._dense) == self.m

    def level_name(self, k: int) -> str:
        """Number and name of level k, as messages call it: ``level 2 ('hand')``."""
        return called(k, self._names[k])

    def label(self, k: int) -> str:
        """Former name of :meth:`level_name`."""
        warn("Hierarchy.label is Hierarchy.level_name now", DeprecationWarning, stacklevel=2)
        return self.level_name(k)

    def label_of(self, row: int) -> Label:
        """What row number `row` of the whole hierarchy is called; by level and number if it has no label."""
        k, inside = self.locate(row)
        labels, column = self._labels[k], self.columns[row]
        if labels is not None:
            return labels[inside]
        return Label(self._names[k] or f"level {k}", f"x[{column}]" if column >= 0 else f"row {inside}")

    def locate(self, row: int) -> tuple[int, int]:
        """Level, and row inside it, of row number `row` of the whole hierarchy."""
        level = bisect_right(self.pointers, row) - 1
        return level, row - self.pointers[level]

    def find_fault(self) -> str | None:
        """The first number that cannot mean anything, as a sentence naming level and row, or None."""
        plain = (np.abs(self.numbers) <= LARGEST).all() and (self.weights >= 1.0 / LARGEST).all()
        if plain and (self.lower <= self.upper).all():
            return None  # without infinite bounds this is all there is to ask
        if not (np.abs(self.A) <= LARGEST).all():
            row, column = np.argwhere(~(np.abs(self.A) <= LARGEST))[0]
            what, value = f"A[{column}]", self.A[row, column]
            return f"{self._where(int(self._dense[row]))}: {what} = {value} must be {_allowed(value)}"
        low, high = self.lower, self.upper
        wrong = ~(low <= high) | (low == np.inf) | (high == -np.inf)
        if wrong.any():
            i = int(np.argmax(wrong))
            where = self._where(i)
            if np.isnan(low[i]) or np.isnan(high[i]):
                return f"{where}: lower = {low[i]}, upper = {high[i]}; a bound must be a number or infinite"
            if low[i] > high[i]:
                return f"{where}: lower = {low[i]} > upper = {high[i]}; lower must not exceed upper"
            return f"{where}: lower = {low[i]}, upper = {high[i]}; lower must be below +inf and upper above -inf"
        for what, value in ("lower", low), ("upper", high):
            wrong = (np.abs(value) > LARGEST) & np.isfinite(value)
            if wrong.any():
                i = int(np.argmax(wrong))
                return f"{self._where(i)}: {what} = {value[i]} must be infinite or {_allowed(value[i])}"
        wrong = ~((self.weights >= 1.0 / LARGEST) & (self.weights <= LARGEST))
        if wrong.any():
            i = int(np.argmax(wrong))
            return f"{self._where(i)}: weight {self.weights[i]} must be positive and finite, from 1e-30 to 1e30"
        return None

    def _where(self, row: int) -> str:
        level, inside = self.locate(row)
        return f"{self.level_name(level)}, row {inside}"

    def __repr__(self) -> str:
        lines = [f"Hierarchy of {len(self.levels)} levels, {self.m} rows, {self.n} unknowns"]
        return "\n  ".join(lines + [f"{k}: {level!r}" for k, level in enumerate(self.levels)])


def _allowed(value: float) -> str:
    return f"at most {LARGEST:g} in size" if np.isfinite(value) else "finite"
