r"""Damping by curvature: damps levels of a linearised hierarchy where curvature invalidates it.

:mod:`hqp.kernels.bend` decides how much. Each damped level is a stage: a plain hierarchy of the levels above, held
where they are, and this one with rows of damping; every stage is certified like any hierarchy.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ..backends.native import Memory
from ..guard import Guard
from ..hierarchy import Hierarchy
from ..kernels import curved as kernel
from ..kernels import curved_layout as at
from ..kernels import layout as plain
from ..kernels import solver as kernel_solver
from ..kernels.active_set import OPTIMAL
from ..kernels.builtin import runner
from ..kernels.call import KNOWN, address_of
from ..kernels.compile import INTERPRETED
from ..kernels.curved import STAGED
from ..kernels.ready import SIGNATURE, door, make_ready
from ..settings import Settings
from ..solution import Counts, Solution, Stages, Status
from .curved_stages import Stage, handed, softened
from .curved_work import Work, directory_of, stage_of
from .linearisation import Linearisation
from .solver import DEFAULT_BACKEND, Solver, solve_once

WHAT = "curved levels"
new = object.__new__
empty = np.empty
#: The status of nearly every tick, looked up once.
OPTIMUM = Status.OPTIMAL
#: What a loop calls in Python: it gets a directory and numbers, and gives an outcome.
CALLBACK = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64)


def warm_up() -> bool:
    """Have the loops ready: from disk, or compiled now. True if they had to be compiled."""
    return make_ready(kernel.solve_curved, WHAT)


class CurvedSolver:
    """Solves hierarchies that are linearisations, damped where these are not valid, each warm from the last.

    The native solver is called by the loops themselves. Any other backend solves stage by stage, called from
    Python for the stages that the same loops write.

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
        self._plain, self._solvers = Solver(backend, self.settings), dict[int, Solver]()
        self._hierarchy, self._levels, self._native = hierarchy, len(hierarchy.levels), backend == DEFAULT_BACKEND
        self._stages = [
            stage_of(hierarchy, k, linearisation.curved) if curved else None
            for k, curved in enumerate(linearisation.curved)
        ]
        warm_up()
        self._points, sides = [np.zeros(hierarchy.n) for _ in range(self._levels + 1)], np.zeros(hierarchy.m, np.int64)
        self._plain_directories = [directory_of(point, sides) for point in self._points]
        self._slowly = np.array([directory.ctypes.data for directory in self._plain_directories], dtype=np.int64)
        self._callback, self._ask = _asked(self._answer_stage)
        if self._native:
            structures = [hierarchy.structure if stage is None else stage.structure for stage in [*self._stages, None]]
            self._memories = [Memory(structure, self.settings) for structure in structures]
            for memory in self._memories:  # loops look at the basis of all levels; of the last one, only where they may
                memory.head[plain.BASIS] = 1
            self._directories = np.array([memory.address for memory in self._memories], dtype=np.int64)
            self._quickly = address_of(kernel_solver.solve, SIGNATURE)
        self.relinearise(linearisation)
        self._guard, self._failed, self._raised = Guard("the solver"), dict[int, Solution](), list[BaseException]()
        self._take, self._give = self._guard.take, self._guard.give
        self._zero = np.zeros(hierarchy.n)
        self._zero.flags.writeable = False
        self._always = backend, self.settings, self._tell

    def relinearise(self, linearisation: Linearisation) -> None:
        """Use another linearisation of the same hierarchy, with the same levels curved."""
        self._linearisation = linearisation
        self._work = work = Work(self._hierarchy, linearisation, self._stages)
        self._head, self._told = work.head, work.told
        self._slow_run = partial(door(kernel.solve_curved), work.address)
        if self._native:
            self._run = runner(self._memories[-1], kernel.solve_curved, work.address)
        self._ask_for_stages(self._native)

    def know_last(self, known: bool) -> None:
        """Whether the last x of the linearisation is known from now on; at first it is."""
        self._work.know_last(known)

    def _ask_for_stages(self, native: bool) -> None:
        """Have the loops ask the native solver, or Python, for what they need solved."""
        self._head[at.SOLVE], self._head[at.QUICK] = (self._quickly, 1) if native else (self._ask, 0)
        self._work.directories[:] = self._directories if native else self._slowly

    def forget(self) -> None:
        """Make the next call a cold one."""
        self._plain.forget()
        self._solvers.clear()
        self._work.forget()
        if self._native:
            for memory in self._memories:
                memory.head[plain.WARM] = 0

    def solve(self, hierarchy: Hierarchy) -> Solution:
        """Solve it, as its linearisation is now."""
        try:
            self._take()
        except IndexError:
            self._guard.refuse()
        try:
            numbers = hierarchy.numbers
            given = numbers.tobytes()  # the proof is about these, even if they are overwritten later
            if self._native:
                x = empty(hierarchy.n)
                told = self._run(numbers, x)
                if told >= 0:  # as nearly always
                    solution = new(Solution)
                    fields = solution.__dict__
                    fields["x"], fields["status"] = x, OPTIMUM
                    if told & STAGED:
                        told ^= STAGED
                        fields["_points"] = self._told.tobytes()
                    fields["_noted"] = hierarchy, given, self._zero, self._always, told
                    return solution
            return self._solve(hierarchy, given)
        finally:
            self._give(None)

    def _solve(self, hierarchy: Hierarchy, given: bytes) -> Solution:
        """By the backend, stage after stage, asked in Python."""
        if hierarchy.find_fault():
            return self._plain.solve(hierarchy)
        self._failed.clear()
        self._ask_for_stages(native=False)
        outcome = self._slow_run(hierarchy.address)
        self._ask_for_stages(self._native)
        if self._raised:  # in Python, below a loop, through which no exception finds its way
            raise self._raised.pop()
        if self._head.item(at.OPENED) == self._levels:
            solution = self._failed[self._levels]
            solution.__dict__["_noted"] = hierarchy, given, self._zero, self._always, solution.counts
            return solution
        self._failed.pop(self._levels, None)
        last = self._failed[max(self._failed)]
        counts = Counts(*map(sum, zip(*(stage.counts for stage in self._failed.values()), strict=True)))
        solution = new(Solution)
        fields = solution.__dict__
        fields["x"], fields["status"], fields["_points"] = last.x, OPTIMUM, self._told.tobytes()
        fields["_noted"] = hierarchy, given, self._zero, self._always, counts
        if outcome != OPTIMAL:
            fields |= {"status": last.status, "message": last.message, "level": last.level}
        return solution

    def _tell(self, solution: Solution, told: bytes, _: object) -> Stages:
        """The stages of an answer, by what the given hierarchy and the declared softening make them."""
        given, declared, curved = solution.hierarchy, self._work.declared(told), self._linearisation.curved
        zero, stages = np.zeros(given.n), list[Solution]()
        for k in declared.levels:
            stage = Stage(given, self._template(k, given), curved, declared).hierarchy
            stages.append(
                Solution(declared.points[k], Status.OPTIMAL, self.backend, stage, zero, self.settings, staged=None)
            )
        if not solution.ok:
            said, level = solution.message, solution.level
            stages[-1] = replace(stages[-1], status=solution.status, message=said, level=level)
        return Stages(
            tuple(stages),
            {k: float(declared.strengths[k]) for k in declared.levels},
            {k: declared.aims[k] for k in declared.levels},
            partial(solve_once, self.backend, self.settings),
            {k: declared.points[k] for k in declared.levels},
            self._linearisation.singular,
            softened=softened(declared, given.pointers),
            handed=handed(given, declared),
        )

    def _template(self, k: int, given: Hierarchy) -> Hierarchy:
        """The structure of the stage of level k, with the labels of a hierarchy that was given."""
        known = self._stages[k]
        assert known is not None
        alike = all(own.labels is told.labels for own, told in zip(self._hierarchy.levels, given.levels, strict=True))
        return known if alike else stage_of(given, k, self._linearisation.curved)

    def _answer_stage(self, directory: int, numbers: int) -> int:
        """Solve the stage of this directory by the backend: an outcome."""
        try:
            k = int(np.flatnonzero(self._slowly == directory)[0])
            if k == self._levels:
                solution = self._plain.solve(self._hierarchy)
            else:
                if k not in self._solvers:
                    self._solvers[k] = Solver(self.backend, self.settings)
                stage = self._stages[k]
                assert stage is not None
                solution = self._solvers[k].solve(stage)
            self._failed[k], self._points[k][:] = solution, solution.x
        except BaseException as error:  # raised anew by solve()
            self._raised.append(error)
            return -1
        return OPTIMAL if solution.ok else -1


def _asked(answer: Callable[[int, int], int]) -> tuple[Any, int]:
    """A function in Python that loops may call, to be kept, and the address by which they know it."""
    if INTERPRETED:
        KNOWN.append(answer)
        return answer, len(KNOWN) - 1
    callback = CALLBACK(answer)
    return callback, ctypes.cast(callback, ctypes.c_void_p).value or 0
