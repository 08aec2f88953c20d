"""One priority level: rows, or plain bounds on x, with bounds and weights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, Indices, index_vector, real_array
from ..checks import of_type
from ..errors import InvalidInput
from .label import Label, Labels, labels_of


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Level:
    """One priority level: ``lower <= A x - w <= upper``, minimising ``||diag(weights) w||``.

    Parameters
    ----------
    A : array, shape (m, n)
        Rows of the level.
    lower, upper : array, shape (m,)
        Bounds on ``A x``, in the unit of the row; a scalar stands for every row. ``-inf`` and
        ``inf`` leave that side free, ``lower == upper`` makes the row an equality.
    weights : array, shape (m,), optional
        Positive weights of the rows *inside* this level (default: ones). Priorities are never
        weights: no weight makes a lower level change this one.
    name : str
        Used in messages, tables and explanations.
    labels : sequence of Label, or function that gives it, optional
        Names of the rows in explanations. A function is called when the first label is read.

    Attributes
    ----------
    A : array, shape (m, n), or None
        None where the level is made of plain bounds (see `indices`).
    indices : array of int, shape (m,), or None
        The variables which plain bounds act on; None where the level has rows.

    Raises
    ------
    InvalidInput
        If shapes do not fit, a weight is not positive and finite, or a label is not a Label. The numbers in A, lower
        and upper are checked when the hierarchy is solved, because a control loop refills them.

    Notes
    -----
    Once in a hierarchy, ``hierarchy.levels[k]`` holds *views*: write ``level.A[:] = ...`` or
    ``level.lower[:] = ...`` and solve again.

    Examples
    --------
    >>> from hqp import Level
    >>> Level.equality([[1.0, 1.0]], [3.0], name="sum")
    Level('sum', rows: 1 equality)
    >>> Level([[1.0, -1.0]], -0.5, 0.5, name="difference")
    Level('difference', rows: 1 two-sided)
    >>> Level.bounds([-1.0, -1.0], [1.0, 1.0], name="limits")
    Level('limits', bounds on x[:2]: 2 two-sided)
    """

    A: Array | None
    lower: Array
    upper: Array
    weights: Array
    indices: Indices | None
    name: str
    labels: Sequence[Label] | None

    def __init__(
        self,
        A: ArrayLike,
        lower: ArrayLike,
        upper: ArrayLike,
        *,
        weights: ArrayLike | None = None,
        name: str = "",
        labels: Labels | None = None,
    ) -> None:
        rows = real_array(A, f"{_called(name)}: A")
        if rows.ndim != 2:
            raise InvalidInput(f"{_called(name)}: A has shape {rows.shape}; it must have two axes, (rows, unknowns)")
        m = len(rows)
        self._set(rows, _column(lower, m, "lower", name), _column(upper, m, "upper", name), weights, None, name, labels)

    @classmethod
    def equality(
        cls,
        A: ArrayLike,
        b: ArrayLike,
        *,
        weights: ArrayLike | None = None,
        name: str = "",
        labels: Labels | None = None,
    ) -> Level:
        """The level ``A x = b``: equality rows, met in the least-squares sense where they conflict."""
        return cls(A, b, b, weights=weights, name=name, labels=labels)

    @classmethod
    def bounds(
        cls,
        lower: ArrayLike,
        upper: ArrayLike,
        *,
        indices: ArrayLike | None = None,
        weights: ArrayLike | None = None,
        name: str = "",
        labels: Labels | None = None,
    ) -> Level:
        """The level ``lower <= x[indices] <= upper``, without dense rows.

        Without `indices` the bounds act on all of x, in order; a variable may be listed twice.
        """
        what = _called(name)
        low, high = real_array(lower, f"{what}: lower"), real_array(upper, f"{what}: upper")
        if indices is None:
            m = max(low.size, high.size)
            if low.ndim == high.ndim == 0:
                raise InvalidInput(
                    f"{what}: scalar bounds do not say how many unknowns there are; give indices or arrays"
                )
            columns = np.arange(m)
        else:
            columns = index_vector(indices, f"{what}: indices")
            if np.any(columns < 0):
                row = int(np.argmax(columns < 0))
                raise InvalidInput(f"{what}, row {row}: index {columns[row]} is negative; count unknowns from 0")
        level = object.__new__(cls)
        m = len(columns)
        level._set(
            None, _column(low, m, "lower", name), _column(high, m, "upper", name), weights, columns, name, labels
        )
        return level

    def _set(
        self,
        A: Array | None,
        lower: Array,
        upper: Array,
        weights: ArrayLike | None,
        indices: Indices | None,
        name: str,
        labels: Labels | None,
    ) -> None:
        m = len(lower)
        scale = np.ones(m) if weights is None else _column(weights, m, "weights", name)
        wrong = ~((scale > 0) & np.isfinite(scale))
        if wrong.any():
            row = int(np.argmax(wrong))
            raise InvalidInput(f"{_called(name)}, row {row}: weight {scale[row]} must be positive and finite")
        called = labels_of(labels, m, f"{_called(name)}: labels")
        self._hold(A, lower, upper, scale, indices, name, called)

    def _hold(self, *values: Array | Indices | str | Sequence[Label] | None) -> Level:
        """Take these arrays as they are, unchecked and uncopied, in the order of the fields."""
        for field, value in zip(self.__dataclass_fields__, values, strict=True):
            object.__setattr__(self, field, value)
        return self

    def __len__(self) -> int:
        return len(self.lower)

    def __repr__(self) -> str:
        equal = self.lower == self.upper
        free = np.isinf(self.lower) & np.isinf(self.upper) & ~equal
        two_sided = np.isfinite(self.lower) & np.isfinite(self.upper) & ~equal
        counts = {
            "equality": int(equal.sum()),
            "two-sided": int(two_sided.sum()),
            "one-sided": int((~equal & ~free & ~two_sided).sum()),
            "free": int(free.sum()),
        }
        rows = ", ".join(f"{count} {kind}" for kind, count in counts.items() if count) or "no rows"
        where = f"bounds on x{_short(self.indices)}" if self.indices is not None else "rows"
        return f"Level({self.name!r}, {where}: {rows})"


def _column(value: ArrayLike, m: int, what: str, name: str) -> Array:
    array = real_array(value, f"{_called(name)}: {what}")
    if array.ndim == 0:
        return np.full(m, float(array))
    if array.shape != (m,):
        raise InvalidInput(f"{_called(name)}: {what} has shape {array.shape}; it must be ({m},), one number a row")
    return array


def _called(name: str) -> str:
    """How messages call the level; a name that is none is refused in the first of them."""
    return f"level {name!r}" if of_type(name, str, "name of a level") else "level"


def _short(indices: Indices) -> str:
    if np.array_equal(indices, np.arange(len(indices))):
        return f"[:{len(indices)}]"
    return "[" + ", ".join(map(str, indices[:6])) + (", ..." if len(indices) > 6 else "") + "]"
