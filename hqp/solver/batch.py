"""Many hierarchies of one structure: their numbers in one array, and their answers.

For sampling, for learning, for the worlds of a simulation; solved by :mod:`.batch_solver`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..checks import SetOnce, listed, of_type, whole_number
from ..errors import InvalidInput
from ..hierarchy import Hierarchy
from ..settings import Settings
from ..solution import Counts, Solution, Status

if TYPE_CHECKING:
    pass

#: The most numbers of a batch: 8 GiB of them.
MOST_NUMBERS = 2**30


class LevelNumbers(NamedTuple):
    """One level of all hierarchies of a batch: views, to be refilled in place.

    A : array, shape (B, m_k, n), or None for plain bounds; lower, upper, weights : array, shape (B, m_k).
    """

    A: Array | None
    lower: Array
    upper: Array
    weights: Array


class Batch(SetOnce):
    """B hierarchies of one structure, all numbers in one array.

    Parameters
    ----------
    template : Hierarchy
        Its structure and, to begin with, its numbers are those of every one.
    count : int
        How many, B.

    Attributes
    ----------
    numbers : array, shape (B, numbers of one hierarchy)
        See :class:`Hierarchy`.
    levels : tuple of LevelNumbers
        Views: ``batch.levels[1].lower[:] = ...``.

    Raises
    ------
    InvalidInput
        If the template is no hierarchy, or count no integer of at least 0; or that would be more than 2^30 numbers.

    Examples
    --------
    >>> import numpy as np
    >>> from hqp import Batch, Hierarchy, Level, solve_batch
    >>> batch = Batch(Hierarchy([Level.equality([[1.0, 1.0]], [3.0], name="sum")]), 3)
    >>> batch.levels[0].lower[:, 0] = batch.levels[0].upper[:, 0] = [1.0, 2.0, 3.0]
    >>> solve_batch(batch).x
    array([[0.5, 0.5],
           [1. , 1. ],
           [1.5, 1.5]])
    """

    _stays = frozenset(("numbers", "levels"))
    _instead = "its numbers may be written in place, as in batch.levels[1].lower[:] = ..."

    def __init__(self, template: Hierarchy, count: int) -> None:
        self._template = of_type(template, Hierarchy, "the template of a batch")
        most = MOST_NUMBERS // max(self._template.numbers.size, 1)
        self.numbers: Array = np.tile(template.numbers, (whole_number(count, "count", most=most), 1))
        self.levels = tuple(self._views())

    @classmethod
    def of(cls, hierarchies: Iterable[Hierarchy]) -> Batch:
        """The batch of these hierarchies; their numbers are copied.

        Raises
        ------
        InvalidInput
            If there is none, or two differ in structure.
        """
        given = listed(hierarchies, "a batch", "hierarchies")
        if not given:
            raise InvalidInput("a batch of no hierarchies has no structure; use Batch(template, 0)")
        batch = cls(given[0], len(given))
        for b, hierarchy in enumerate(given):
            if of_type(hierarchy, Hierarchy, f"hierarchy {b} of the batch").structure != batch.structure:
                raise InvalidInput(f"hierarchy {b} of the batch has another structure than hierarchy 0")
            batch.numbers[b] = hierarchy.numbers
        return batch

    def _views(self) -> Iterator[LevelNumbers]:
        count, n, m = len(self.numbers), self._template.n, self._template.m
        dense = self._template.A.size
        A = self.numbers[:, :dense].reshape(count, dense // n if n else 0, n)
        lower, upper, weights = (self.numbers[:, dense + k * m : dense + (k + 1) * m] for k in range(3))
        row = 0
        for level, first in zip(self._template.levels, self._template.pointers, strict=False):
            own, rows = slice(first, first + len(level)), 0 if level.A is None else len(level)
            yield LevelNumbers(
                None if level.A is None else A[:, row : row + rows], lower[:, own], upper[:, own], weights[:, own]
            )
            row += rows

    def __reduce__(self) -> tuple[Any, ...]:
        return Batch._on, (self._template, self.numbers)

    def __deepcopy__(self, memo: dict[int, Any]) -> Batch:
        return Batch._on(self._template.copy(), self.numbers.copy())

    @classmethod
    def _on(cls, template: Hierarchy, numbers: Array) -> Batch:
        """A batch on these numbers, with views of its own."""
        batch = object.__new__(cls)
        own = np.ascontiguousarray(numbers)
        batch._template = template
        batch.numbers = own if own.flags.writeable else own.copy()  # joblib maps large arrays read-only
        batch.levels = tuple(batch._views())
        return batch

    @property
    def structure(self) -> tuple[object, ...]:
        """Of every one of them, see :class:`Hierarchy`."""
        return self._template.structure

    def __len__(self) -> int:
        return len(self.numbers)

    def __getitem__(self, b: int) -> Hierarchy:
        """One of them, on the numbers of the batch: no copy."""
        return self._template.with_numbers(self.numbers[b])

    def __repr__(self) -> str:
        return f"Batch of {len(self)} x {self._template!r}"


@dataclass(frozen=True, eq=False)
class BatchSolution:
    """The answers to a batch.

    Attributes
    ----------
    batch : Batch
        The same object: where its numbers change, judge before.
    x : array, shape (B, n)
    statuses : tuple of Status
    messages : dict
        b -> why, where the status is not OPTIMAL.
    levels : int array, shape (B,)
        Where a status other than OPTIMAL arose; the number of levels for the implicit last one, -1 otherwise.
    sweeps, iterations : int array, shape (B,)
        See :class:`Counts`.
    x_ref : array, shape (n,) or (B, n)
    settings : Settings
    """

    batch: Batch
    x: Array
    statuses: tuple[Status, ...]
    messages: dict[int, str]
    levels: NDArray[np.int64]
    sweeps: NDArray[np.int64]
    iterations: NDArray[np.int64]
    x_ref: Array
    settings: Settings

    @property
    def ok(self) -> NDArray[np.bool_]:
        """Which of them the solver calls optimal, shape (B,). The proof is ``solution[b].certify()``."""
        return np.array([status is Status.OPTIMAL for status in self.statuses], dtype=bool)

    def __len__(self) -> int:
        return len(self.x)

    def __getitem__(self, b: int) -> Solution:
        """The answer to one of them."""
        level = int(self.levels[b])
        return Solution(
            x=self.x[b].copy(),
            status=self.statuses[b],
            backend="native",
            hierarchy=self.batch[b].copy(),
            x_ref=self.x_ref if self.x_ref.ndim == 1 else self.x_ref[b],
            message=self.messages.get(range(len(self))[b], ""),
            level=level if level >= 0 else None,
            counts=Counts(sweeps=int(self.sweeps[b]), iterations=int(self.iterations[b])),
            settings=self.settings,
        )
