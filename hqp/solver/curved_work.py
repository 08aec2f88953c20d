"""The work memory of the loops for curved levels: the hierarchies of their stages, and a directory of all arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..hierarchy import Hierarchy, Label, Level
from ..kernels import curved_layout as at
from ..kernels import layout as plain
from ..kernels.workspace import aligned
from .curved_stages import Declared
from .linearisation import Bound, Linearisation

#: The numbers that tell how levels were softened; they lie in one block.
TOLD = at.POINTS, at.STRENGTHS, at.NORMS, at.STIFFNESS, at.COMBINED, at.DAMPED, at.AIMED
#: What all blocks write, beside these.
TOGETHER = at.ROW, at.VALUE, at.ERRORS, at.REACH


def directory_of(x: Array, sides: NDArray[np.int64]) -> NDArray[np.int64]:
    """A directory that holds only x and the sides of rows."""
    directory = np.zeros(plain.HEAD + 3 * (plain.SIDE + 1), dtype=np.int64)
    entries = directory[plain.HEAD :].reshape(-1, 3)
    entries[plain.X], entries[plain.SIDE] = (x.ctypes.data, len(x), 1), (sides.ctypes.data, len(sides), 1)
    return directory


def stage_of(hierarchy: Hierarchy, k: int, curved: Sequence[int]) -> Hierarchy:
    """The hierarchy of the stage of level k, without numbers."""
    n, levels = hierarchy.n, list[Level]()
    for j, level in enumerate(hierarchy.levels[: k + 1]):
        labels = [hierarchy.label_of(row) for row in range(*hierarchy.pointers[j : j + 2])]
        if j < k and not curved[j]:
            levels.append(level)
            continue
        if j == k:
            soft = range(sum(len(above) for above, bent in zip(hierarchy.levels[:k], curved, strict=False) if bent))
            labels += [Label("soft", f"row {i}") for i in soft]
            labels += [Label("damping", f"direction {i}") for i in range(n)]
        zeros = np.zeros(len(labels))
        levels.append(Level(np.zeros((len(labels), n)), zeros, zeros, name=level.name, labels=labels))
    return Hierarchy(levels, n=n)


def in_numbers(bound: Bound | None) -> tuple[int, int, int]:
    """The three numbers of a loop that bounds curvatures."""
    return (0, 0, 0) if bound is None else (bound.loop, bound.table, bound.matrix.ctypes.data)


def integers(given: Any) -> NDArray[np.int64]:
    """These as one contiguous array."""
    return np.ascontiguousarray(given, dtype=np.int64).ravel()


def lines(rows: int, columns: int = 1) -> Array:
    """An array of zeros, shape (rows, columns), that begins with a line of the processor's cache."""
    made = aligned(rows * columns).reshape(rows, columns)
    made.fill(0.0)
    return made


def enter(directory: NDArray[np.int64], made: Mapping[int, NDArray[Any]]) -> None:
    """Enter arrays in a directory, each at its place."""
    entries = directory[plain.HEAD :].reshape(-1, 3)
    for place, array in made.items():
        entries[place] = array.ctypes.data, len(array), 1 if array.ndim == 1 else array.shape[1]


class Work:
    """The work memory of the kernel, and its directory.

    Attributes
    ----------
    head : array of int
    address : int
        Of the directory.
    told : array
        What tells how levels were softened, in one block to be copied; :meth:`declared` unpacks it.
    """

    def __init__(self, hierarchy: Hierarchy, linearisation: Linearisation, stages: Sequence[Hierarchy | None]) -> None:
        n, m, levels = hierarchy.n, hierarchy.m, len(hierarchy.levels)
        widest = max(len(level) for level in hierarchy.levels)
        self.directories, shape = np.zeros(levels + 1, dtype=np.int64), (levels, levels)
        sizes, first, dense = np.zeros((levels, 2), dtype=np.int64), np.full(shape, -1), np.full(shape, -1)
        for k, stage in enumerate(stages):
            if stage is None:
                continue
            sizes[k] = len(stage.A), stage.m
            first[k, : k + 1] = stage.pointers[: k + 1]
            rows = np.cumsum([0, *(0 if level.A is None else len(level) for level in stage.levels)])
            dense[k, : k + 1] = [-1 if level.A is None else row for level, row in zip(stage.levels, rows, strict=False)]
        dense_rows = hierarchy.columns < 0
        owned: dict[int, Any] = {
            plain.PTR: hierarchy.pointers,
            at.UNKNOWN: linearisation.unknown,
            plain.COL: hierarchy.columns,
            plain.ROW_OF: np.where(dense_rows, np.cumsum(dense_rows) - 1, -1),
            at.NUMBERS: [0 if stage is None else stage.address for stage in stages],
            at.SIZES: sizes,
            at.FIRST: first,
            at.DENSE: dense,
            at.MEASURED: [
                (*(array.ctypes.data for array in part[:3]), part.row, len(part.error)) for part in linearisation.errors
            ],
            at.BLOCK_OF: linearisation.block_of,
        }
        made: dict[int, NDArray[Any]] = {place: integers(given) for place, given in owned.items()}
        self._blocks, self._of_rows = len(linearisation.kinds), linearisation.block_of
        reals = at.shapes(n, levels, m, widest, n, self._blocks)[1]
        self._begin = begin = plain.padded(2 + m)
        self.told = lines(begin + sum(math.prod(reals[place]) for place in TOLD))[:, 0]
        made[at.SPAN], made[at.STATE] = np.split(self.told[: 2 + m].view(np.int64), [2])  # in the same block
        for place in TOLD:
            rows, columns = reals[place]
            made[place] = self.told[begin : begin + rows * columns].reshape(rows, columns)
            begin += rows * columns
        made |= {place: lines(*reals[place]) for place in TOGETHER}
        made |= {
            at.DIRECTORIES: self.directories,
            at.S: linearisation.curvature,
            at.ALL_OF_S: linearisation.curvature.reshape(-1),
            at.SCALES: linearisation.scales,
            at.WORTH: linearisation.worth,
            at.AIMS: linearisation.aims,
            at.LAST: linearisation.last,
        }
        self._shapes, self._rows = [made[place].shape for place in TOLD], m
        self._kept: list[Any] = [linearisation, made]
        self._own: list[tuple[dict[int, NDArray[Any]], NDArray[np.int64]]] = []
        whole = self._directory(hierarchy, linearisation, made, None if self._blocks > 1 else 0)
        blocks = [whole]
        if self._blocks > 1:
            blocks = [self._directory(hierarchy, linearisation, made, number) for number in range(self._blocks)]
        self._kept.append(addresses := np.array([block.ctypes.data for block in blocks], dtype=np.int64))
        for directory in {id(each): each for each in (whole, *blocks)}.values():
            enter(directory, {at.BLOCKS: addresses})
        self.head, self.address = whole[: plain.HEAD], int(whole.ctypes.data)
        self._last, self._unknown = linearisation.last, np.full(n, np.nan)
        self.forget()

    def know_last(self, known: bool) -> None:
        """Have the loops look at the last x of the linearisation, or at one that is NaN."""
        for _, directory in self._own:
            enter(directory, {at.LAST: self._last if known else self._unknown})

    def forget(self) -> None:
        """Forget which bounds were met, and that stages were needed."""
        self.head[at.OPENED] = self.head[plain.LEVELS]
        for own, _ in self._own:
            own[at.MET][:] = 0

    def _directory(
        self, hierarchy: Hierarchy, linearisation: Linearisation, made: dict[int, NDArray[Any]], number: int | None
    ) -> NDArray[np.int64]:
        """The directory of a block of variables, of all of them if its number is None; `made` is shared by all."""
        n, m, levels = hierarchy.n, hierarchy.m, len(hierarchy.levels)
        alone, widest = number is None or self._blocks == 1, max(len(level) for level in hierarchy.levels)
        rows = np.arange(m) if alone else np.flatnonzero(linearisation.block_of == number)
        columns = np.arange(n) if alone else np.flatnonzero(linearisation.columns == number)
        curved = linearisation.curved if number is None else linearisation.kinds[number]
        contractions = [c for c in linearisation.contractions if alone or linearisation.block_of[c.row] == number]
        whose = np.searchsorted(hierarchy.pointers[1:], [c.row for c in contractions], side="right")
        calls = [
            (c.loop, c.table, c.weights.ctypes.data, c.row, len(c.weights), *in_numbers(c.bound)) for c in contractions
        ]
        owned: dict[int, Any] = {
            at.CURVED: curved,
            at.CALLS: np.array(calls, dtype=np.int64).reshape(-1, at.CALL),
            at.CALLS_OF: np.searchsorted(whose, np.arange(levels + 1)),
            at.OWN: rows,
            at.OWN_OF: np.searchsorted(rows, hierarchy.pointers),
            at.COLUMNS: columns,
        }
        own = {place: integers(given) for place, given in owned.items()}
        ints, reals = at.shapes(n, levels, m, widest, len(columns), self._blocks)
        own |= {
            place: np.zeros(shape[0] * shape[1], dtype=np.int64) for place, shape in ints.items() if place not in made
        }
        own |= {place: lines(*shape) for place, shape in reals.items() if place not in made}
        own[at.SHARES] = linearisation.shares[number or 0]
        directory = np.zeros(plain.HEAD + 3 * at.PLACES, dtype=np.int64)
        directory[[plain.N, plain.LEVELS, plain.ROWS, at.MEASURES, at.LOOKS_AHEAD, at.TOP, at.NUMBER]] = (
            n,
            levels,
            m,
            len(linearisation.errors),
            linearisation.worth.any(),
            next((k for k, kind in enumerate(curved) if kind), levels),
            number or 0,
        )
        enter(directory, made | own)
        entries = directory[plain.HEAD :].reshape(-1, 3)
        for place, shape in zip(
            (plain.A, plain.LOWER, plain.UPPER, plain.WEIGHTS), ((len(hierarchy.A), n), *[(m, 1)] * 3), strict=True
        ):
            entries[place, 1:] = shape
        self._own.append((own, directory))
        return directory

    def declared(self, copied: bytes) -> Declared:
        """How levels were softened, from a copy of ``told``, the block of the numbers that tell it."""
        block = np.frombuffer(copied)
        opened, last, *states = block[: 2 + self._rows].view(np.int64).tolist()
        told, n = block[self._begin :], int(self.head[plain.N])
        ends = np.cumsum([rows * columns for rows, columns in self._shapes])
        parts = [part.reshape(shape) for part, shape in zip(np.split(told, ends[:-1]), self._shapes, strict=True)]
        points, strengths, norms, stiffness, combined, damped, aims = parts
        vectors = strengths[:, 0], norms[:, self._of_rows], stiffness[:, 0]
        rows = damped[:, : n + 1].reshape(-1, n, n + 1)
        return Declared(opened, last, np.array(states), points[:, :n], *vectors, combined, rows, aims[:, :n])
