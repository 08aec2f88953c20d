r"""Hierarchies that are linearisations: levels damped where how their rows bend says that the linearisation misleads.

See :mod:`hqp.kernels.bend` for what is looked at. What comes of it, level by level, is a stage: a plain hierarchy of
the levels above, held where they are, and this one with rows of damping; every stage is certified like any hierarchy.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..backends.native import SIGNATURE, Memory, door, make_ready
from ..certificate import row_states
from ..guard import Guard
from ..hierarchy import Hierarchy, Label, Level
from ..kernels import curved as kernel
from ..kernels import curved_layout as at
from ..kernels import layout as plain
from ..kernels import solver as kernel_solver
from ..kernels.active_set import OPTIMAL
from ..kernels.call import KNOWN, address_of
from ..kernels.compile import INTERPRETED
from ..settings import Settings
from ..solution import Counts, Solution, Stages, Status
from .solver import DEFAULT_BACKEND, Solver

WHAT = "curved levels"
_CALLBACK = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64)


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
    curved : tuple of bool
        Which levels may be damped; of the others, only what they ask for counts.
    errors : sequence of Errors
    contractions : sequence of Contraction
    curvature : array, shape (n, n)
        What the contractions add to.
    shares : array, shape (levels,)
        What share of its error a level takes away in one step.
    aims : array, shape (levels, n)
        Where the damping of a level draws x.
    last : array, shape (n,)
        The x of the step before; NaN if it is not known.
    """

    curved: tuple[bool, ...]
    errors: Sequence[Errors]
    contractions: Sequence[Contraction]
    curvature: Array
    shares: Array
    aims: Array
    last: Array
    kept: tuple[Any, ...] = field(default=(), repr=False)


class CurvedSolver:
    """Solves hierarchies that are linearisations, damped where that misleads, each warm from the last.

    Parameters
    ----------
    hierarchy : Hierarchy
        The one that is refilled and solved again and again.
    linearisation : Linearisation
    backend : str
    settings : Settings, optional
    """

    def __init__(
        self,
        hierarchy: Hierarchy,
        linearisation: Linearisation,
        backend: str = DEFAULT_BACKEND,
        settings: Settings | None = None,
    ) -> None:
        self.backend, self.settings = backend, Settings() if settings is None else settings
        self._plain = Solver(backend, self.settings)
        self._levels = len(hierarchy.levels)
        self._stages = [
            _stage(hierarchy, k, linearisation.curved) if curved else None
            for k, curved in enumerate(linearisation.curved)
        ]
        make_ready(kernel.solve_curved, WHAT)
        self._hierarchy = hierarchy
        self.relinearise(linearisation)
        self._solvers: dict[int, Solver] = {}
        self._ask = _asked(self._answer_stage)
        self._native = backend == DEFAULT_BACKEND
        n = hierarchy.n
        if self._native:
            self._memories = [
                Memory(hierarchy.structure if stage is None else stage.structure, self.settings)
                for stage in [*self._stages, None]
            ]
            self._directories = np.array([memory.address for memory in self._memories], dtype=np.int64)
            self._quickly = address_of(kernel_solver.solve, SIGNATURE)
        self._points = [np.zeros(n) for _ in range(self._levels + 1)]
        self._sides = np.zeros(hierarchy.m, dtype=np.int64)
        self._plain_directories = [_directory(point, self._sides) for point in self._points]
        self._slowly = np.array([directory.ctypes.data for directory in self._plain_directories], dtype=np.int64)
        self._guard, self._failed = Guard("the solver"), dict[int, Solution]()
        self._always = backend, self.settings, self._tell

    def relinearise(self, linearisation: Linearisation) -> None:
        """Go by another linearisation of the same hierarchy."""
        self._linearisation = linearisation
        self._work = Work(self._hierarchy, linearisation, self._stages)
        self._head, self._run = self._work.head, partial(door(kernel.solve_curved), self._work.address)

    def forget(self) -> None:
        """Make the next call a cold one."""
        self._plain.forget()
        self._solvers.clear()
        if self._native:
            for memory in self._memories:
                memory.head[plain.WARM] = 0

    def solve(self, hierarchy: Hierarchy) -> Solution:
        """Solve it, as its linearisation is now."""
        with self._guard:
            return self._solve(hierarchy)

    def _solve(self, hierarchy: Hierarchy) -> Solution:
        work, head = self._work, self._head
        if self._native:
            head[at.SOLVE] = self._quickly
            work.directories[:] = self._directories
            if self._run(hierarchy.address) == OPTIMAL:
                opened = int(head[at.OPENED])
                asked = range(opened, self._levels) if opened < self._levels else (self._levels,)
                solved = [self._memories[k] for k in asked if k == self._levels or self._stages[k] is not None]
                heads = [memory.head for memory in solved]
                counts = Counts(sum(int(h[plain.SWEEPS]) for h in heads), sum(int(h[plain.ITERATIONS]) for h in heads))
                return self._solution(hierarchy, solved[-1].x.copy(), counts, opened)
        if hierarchy.find_fault():
            return self._plain.solve(hierarchy)
        self._failed.clear()
        head[at.SOLVE] = self._ask
        work.directories[:] = self._slowly
        outcome = self._run(hierarchy.address)
        opened = int(head[at.OPENED])
        if opened == self._levels:
            return self._failed[self._levels]
        self._failed.pop(self._levels, None)
        last = self._failed[max(self._failed)]
        counts = Counts(*map(sum, zip(*(stage.counts for stage in self._failed.values()), strict=True)))
        solution = self._solution(hierarchy, last.x, counts, opened)
        if outcome != OPTIMAL:
            told = {"status": last.status, "message": last.message, "level": last.level}
            solution.__dict__.update(told)
        return solution

    def _solution(self, hierarchy: Hierarchy, x: Array, counts: Counts, opened: int) -> Solution:
        solution = object.__new__(Solution)
        fields = solution.__dict__
        fields["x"], fields["status"], fields["counts"] = x, Status.OPTIMAL, counts
        fields["_noted"] = hierarchy, hierarchy.numbers.copy(), np.zeros(hierarchy.n), self._always
        if opened < self._levels:
            stages = [(k, stage.numbers.copy()) for k, stage in enumerate(self._stages) if stage and k >= opened]
            fields["_points"] = stages, self._work.points.copy(), self._work.damped.copy()
        return solution

    def _tell(self, solution: Solution, points: Any, aims: Any = None) -> Stages:
        """The stages of an answer."""
        stages, reached, damped = points
        zero, told = np.zeros(solution.hierarchy.n), list[Solution]()
        for k, numbers in stages:
            stage = self._stages[k]
            assert stage is not None
            told.append(
                Solution(
                    reached[k],
                    Status.OPTIMAL,
                    self.backend,
                    stage.with_numbers(numbers),
                    zero,
                    self.settings,
                    staged=None,
                )
            )
        dampings = {k: float(np.sqrt(damped[k].max())) for k, _ in stages}
        once = partial(_solve_once, self.backend, self.settings)
        return Stages(tuple(told), dampings, dict.fromkeys(dampings, zero), told[-1].hierarchy, once)

    def _answer_stage(self, directory: int, numbers: int) -> int:
        """Solve the stage of this directory by the backend: an outcome."""
        k = int(np.flatnonzero(self._slowly == directory)[0])
        if k == self._levels:
            solution = self._plain.solve(self._hierarchy)
            self._sides[:] = row_states(self._hierarchy, solution.x, np.zeros(self._hierarchy.n), 1e-9).sides
        else:
            if k not in self._solvers:
                self._solvers[k] = Solver(self.backend, self.settings)
            stage = self._stages[k]
            assert stage is not None
            solution = self._solvers[k].solve(stage)
        self._failed[k], self._points[k][:] = solution, solution.x
        return OPTIMAL if solution.ok else -1


def _solve_once(backend: str, settings: Settings, hierarchy: Hierarchy, x_ref: Array) -> Solution:
    return Solver(backend, settings).solve(hierarchy, x_ref)


def _asked(answer: Callable[[int, int], int]) -> Any:
    """The address of a function in Python that is called from loops: kept in the object itself."""
    if INTERPRETED:
        KNOWN.append(answer)
        return len(KNOWN) - 1
    callback = _CALLBACK(answer)
    address = _Address(ctypes.cast(callback, ctypes.c_void_p).value or 0)
    address.kept = callback
    return address


class _Address(int):
    kept: Any


def _directory(x: Array, sides: NDArray[np.int64]) -> NDArray[np.int64]:
    """A directory in which nothing is but x, and the sides of rows."""
    directory = np.zeros(plain.HEAD + 3 * (plain.SIDE + 1), dtype=np.int64)
    entries = directory[plain.HEAD :].reshape(-1, 3)
    entries[plain.X], entries[plain.SIDE] = (x.ctypes.data, len(x), 1), (sides.ctypes.data, len(sides), 1)
    return directory


def _stage(hierarchy: Hierarchy, k: int, curved: Sequence[bool]) -> Hierarchy:
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


class Work:
    """What the kernel works in, and the directory of it."""

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
        whose = np.searchsorted(hierarchy.pointers[1:], [c.row for c in linearisation.contractions], side="right")
        calls = [(c.loop, c.table, c.weights.ctypes.data, c.row, len(c.weights)) for c in linearisation.contractions]
        measured = [
            (*(array.ctypes.data for array in part[:3]), part.row, len(part.error)) for part in linearisation.errors
        ]
        dense_rows = hierarchy.columns < 0
        owned: dict[int, Any] = {
            plain.PTR: hierarchy.pointers,
            at.CURVED: linearisation.curved,
            plain.COL: hierarchy.columns,
            plain.ROW_OF: np.where(dense_rows, np.cumsum(dense_rows) - 1, -1),
            at.NUMBERS: [0 if stage is None else stage.address for stage in stages],
            at.SIZES: sizes,
            at.FIRST: first,
            at.DENSE: dense,
            at.CALLS: np.array(calls, dtype=np.int64).reshape(-1, 5),
            at.CALLS_OF: np.searchsorted(whose, np.arange(levels + 1)),
            at.MEASURED: np.array(measured, dtype=np.int64).reshape(-1, 5),
        }
        arrays = {place: np.ascontiguousarray(given, dtype=np.int64).ravel() for place, given in owned.items()}
        arrays[at.DIRECTORIES] = self.directories
        ints, reals = at.shapes(n, levels, m, widest)
        made: dict[int, NDArray[Any]] = dict(arrays)
        made |= {place: np.zeros(shape[0] * shape[1], dtype=np.int64) for place, shape in ints.items()}
        made |= {place: np.zeros(shape) for place, shape in reals.items()}
        made |= {at.SHARES: linearisation.shares, at.AIMS: linearisation.aims, at.LAST: linearisation.last}
        made[at.S] = linearisation.curvature
        directory = np.zeros(plain.HEAD + 3 * at.PLACES, dtype=np.int64)
        directory[[plain.N, plain.LEVELS, plain.ROWS, at.MEASURES, at.TOP]] = (
            n,
            levels,
            m,
            len(measured),
            next((k for k, curved in enumerate(linearisation.curved) if curved), levels),
        )
        entries = directory[plain.HEAD :].reshape(-1, 3)
        for place, array in made.items():
            entries[place] = array.ctypes.data, len(array), 1 if array.ndim == 1 else array.shape[1]
        for place, shape in zip(
            (plain.A, plain.LOWER, plain.UPPER, plain.WEIGHTS), ((len(hierarchy.A), n), *[(m, 1)] * 3), strict=True
        ):
            entries[place, 1:] = shape
        self._kept, self._directory = (made, linearisation), directory
        self.head, self.address = directory[: plain.HEAD], int(directory.ctypes.data)
        self.points: Array = made[at.POINTS]
        self.damped: Array = made[at.DAMPED]
