"""The solver for a control loop: hierarchies of one structure, again and again, each warm from the last."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, real_array
from ..backends.base import Answer, Backend, ShortWay
from ..backends.registry import make_backend
from ..checks import SetOnce, of_type
from ..damping import DampingRule, Staged, by_index, index_of, retold, rules_of, told
from ..errors import InvalidInput, brief
from ..guard import Guard
from ..hierarchy import LARGEST, Hierarchy
from ..settings import DEFAULT, Settings
from ..solution import Counts, Solution, Stages, Status

#: The backend used where none is named.
DEFAULT_BACKEND = "native"

OPTIMAL = Status.OPTIMAL
new = object.__new__
empty = np.empty


def solve_once(backend: str, settings: Settings, hierarchy: Hierarchy, x_ref: Array) -> Solution:
    """The answer of a new solver to one hierarchy, as a function that can be pickled."""
    return Solver(backend, settings).solve(hierarchy, x_ref)


class Solver(SetOnce):
    """Solves hierarchies of one structure again and again, each warm from the last.

    Parameters
    ----------
    backend : str
        A name from ``hqp.available_backends()``.
    settings : Settings, optional
    damping : mapping of int or str to DampingRule or float, optional
        The levels to damp, by index or by name, each with its rule; a number is a :class:`FixedDamping`.

    Raises
    ------
    UnknownBackend
        If no backend of that name can run here.
    InvalidInput
        If the settings are none, or a rule is none.

    Notes
    -----
    A call never raises on *numbers*: a hierarchy that holds NaN, an infinite row or crossed bounds
    comes back with status INVALID and a message naming level and row, x_ref (or zero) in the place
    of an answer. When the structure (sizes, bounded variables) changes, the solver starts afresh.
    A solver serves one thread at a time: it works in memory of its own, without the interpreter's lock, and raises
    where a second one comes. A copy, also one that was pickled, is another solver with the same settings, and cold.

    Examples
    --------
    >>> from hqp import Hierarchy, Level, Solver
    >>> hierarchy = Hierarchy([Level.equality([[1.0, 1.0]], [3.0], name="sum")])
    >>> solver = Solver()
    >>> for target in 3.0, 4.0:
    ...     hierarchy.levels[0].lower[:] = hierarchy.levels[0].upper[:] = target
    ...     print(solver.solve(hierarchy).x)
    [1.5 1.5]
    [2. 2.]
    """

    _stays = frozenset(("backend", "settings", "damping"))

    def __init__(
        self,
        backend: str = DEFAULT_BACKEND,
        settings: Settings | None = None,
        damping: Mapping[int | str, DampingRule | float] | None = None,
    ) -> None:
        self.backend = backend
        self.settings = DEFAULT if settings is None else of_type(settings, Settings, "settings")
        self.damping = {} if damping is None else rules_of(damping)
        self._backend = self._new_backend()
        self._staged = self._new_staged() if self.damping else None
        self._by_number, self._rules = not any(isinstance(key, str) for key in self.damping), dict[int, DampingRule]()
        self._places: dict[int | str, int] = {}  # of the aims of levels, by what these are called
        # The native solver has a short way for what its first sweep proves, and looks at the numbers on it.
        self._prepare = getattr(self._backend, "prepare", None)
        self._way = ShortWay()
        self._always = self.backend, self.settings, self._new_tell() if self.damping else None
        self._structure: tuple[Any, ...] | None = None
        self._zero = np.zeros(0)
        self._guard = Guard("the solver")
        self._take, self._give = self._guard.take, self._guard.give
        # A time limit counts from the call on, preparations included; 0: from that of solve().
        self._began = getattr(self._backend, "began", None) if self.settings.time_limit < math.inf else None
        self._called = 0

    def _new_backend(self) -> Backend:
        return make_backend(self.backend, self.settings)

    def __reduce__(self) -> tuple[type[Solver], tuple[str, Settings, dict[int | str, DampingRule]]]:
        """A copy is made from what defines it: memory that a kernel knows by its address cannot be copied."""
        return type(self), (self.backend, self.settings, self.damping)

    def solve(
        self,
        hierarchy: Hierarchy,
        x_ref: ArrayLike | None = None,
        aims: Mapping[int | str, ArrayLike] | None = None,
    ) -> Solution:
        """Solve, warm if the last hierarchy had the same structure.

        Parameters
        ----------
        hierarchy : Hierarchy
        x_ref : array, shape (n,), optional
            Reference of the implicit last level ``min ||x - x_ref||`` (default: zero).
        aims : mapping of int or str to array, shape (n,), optional
            Of damped levels, by index or by name: what they are damped towards, ``lambda (x - aim) = 0``, in place of
            x_ref.

        Raises
        ------
        InvalidInput
            If x_ref or an aim is no array of real numbers, or has the wrong shape; if a damped level is not in the
            hierarchy, one with an aim is not damped, or numerical filtering meets an inequality row.
        InUse
            If another thread is solving with it.
        """
        try:
            self._take()
        except IndexError:
            self._guard.refuse()
        try:
            # Around a small problem each call costs as much as some of its rows: what nearly all ticks do is done here.
            try:
                plain = self._way.plain
                as_before = x_ref is None and aims is None and hierarchy.structure is plain and plain is not None
            except AttributeError:  # no hierarchy
                as_before = False
            if as_before:
                reference, own_aims, fault = self._zero, None, None
            else:
                reference, own_aims, fault = self._set_up(hierarchy, x_ref, aims)
            way = self._way
            numbers, x = hierarchy.numbers, empty(way.n)
            solved = numbers.tobytes()  # the proof is about these numbers, even if they are overwritten later
            told = -1 if fault is not None else way.run(numbers, x)
            if told < 0:
                return self._solve_in_full(hierarchy, solved, x_ref, reference, own_aims, fault)
            solution = new(Solution)  # and its fields, at a third of the price of a frozen dataclass's __init__
            fields = solution.__dict__
            fields["x"], fields["status"] = x, OPTIMAL
            fields["_noted"] = hierarchy, solved, reference, self._always, told
            if way.points is not None:
                fields["_points"], fields["_aims"] = way.points(), own_aims
            return solution
        finally:
            self._give(None)

    def _set_up(
        self, hierarchy: Hierarchy, x_ref: ArrayLike | None, aims: Mapping[int | str, ArrayLike] | None
    ) -> tuple[Array, Array | None, str | None]:
        """Have all ready for a solve but the numbers: x_ref, aims, and what is wrong with x_ref, if anything."""
        now = 0 if self._began is None else self._called or time.monotonic_ns()
        structure = getattr(hierarchy, "structure", None)
        if structure is None or structure is not self._structure:
            if self._staged is None:
                self._adopt(hierarchy)
            else:
                self._adopt_damped(hierarchy)
        if self._began is not None:
            self._began(now)
        fault, reference = (None, self._zero) if x_ref is None else self._reference(x_ref)
        own_aims = None if aims is None else self._own_aims(hierarchy, aims, reference)
        if fault is None:
            self._way.refer(None if x_ref is None else reference, own_aims)
            plain = x_ref is None and own_aims is None and self._began is None
            self._way.plain = structure if plain else None
        return reference, own_aims, fault

    def _solve_in_full(
        self,
        hierarchy: Hierarchy,
        numbers: bytes,
        x_ref: ArrayLike | None,
        reference: Array,
        aims: Array | None,
        fault: str | None,
    ) -> Solution:
        """What the short way has not proved."""
        if self._staged is not None:
            reference = self._zero if x_ref is None else real_array(x_ref, "x_ref")
            return self._solve_in_stages(hierarchy, numbers, reference, aims)
        answer = self._answer(hierarchy, reference, fault)
        solution = new(Solution)
        fields = solution.__dict__
        fields["_noted"] = hierarchy, numbers, reference, self._always, answer.counts
        fields["x"], fields["status"] = answer.x, answer.status
        fields["message"], fields["level"] = answer.message, answer.level
        return solution

    def forget(self) -> None:
        """Make the next call a cold one: what is kept of the last hierarchy is its structure alone."""
        getattr(self._backend, "forget", self._backend.reset)()
        if self._staged is not None:
            self._staged.forget()

    def _new_staged(self) -> Staged:
        """Solvers for one stage each; an answer that outlives this solver makes its own when needed."""
        once = partial(solve_once, self.backend, self.settings)
        return Staged(self.damping, self.settings, lambda: Solver(self.backend, self.settings).solve, once)

    def _new_tell(self) -> Callable[[Solution, Array, Array | None], Stages]:
        """Tells the stages of an answer from its points."""
        return partial(told, self.damping, partial(solve_once, self.backend, self.settings))

    def _own_aims(self, hierarchy: Hierarchy, aims: Mapping[int | str, ArrayLike], reference: Array) -> Array | None:
        """What each damped level is damped towards, a row each: its own aim, or x_ref; None where none is damped."""
        if not isinstance(aims, Mapping):
            raise InvalidInput(f"aims = {brief(aims)} must map damped levels to arrays, as in {{1: np.zeros(7)}}")
        own = np.empty((len(self._rules), len(reference)))
        if len(aims) < len(own):
            own[:] = reference
        for key, aim in aims.items():
            place = self._places.get(key)
            if place is None:
                k = index_of(hierarchy, key, "aims")
                if k not in self._rules:
                    raise InvalidInput(f"aims: {hierarchy.level_name(k)} is not damped, and takes no aim")
                place = self._places[key] = list(self._rules).index(k)
            row = aim if type(aim) is np.ndarray and aim.dtype == np.float64 else real_array(aim, f"aim of {key!r}")
            if row.shape != reference.shape:
                raise InvalidInput(f"aim of {key!r} has shape {row.shape}; it must be {reference.shape}")
            own[place] = row
        return own if len(own) else None

    def _solve_in_stages(self, hierarchy: Hierarchy, numbers: bytes, reference: Array, aims: Array | None) -> Solution:
        """Stage by stage, where the backend does not take all at once, or has failed."""
        assert self._staged is not None
        if aims is not None and not (np.abs(aims) <= LARGEST).all() and not hierarchy.find_fault():
            k, aim = next((k, aim) for k, aim in zip(self._rules, aims, strict=True) if not _bounded(aim))
            message = f"aim of {hierarchy.level_name(k)} = {aim} must be finite, and at most {LARGEST:g} in size"
            x = np.where(np.abs(reference) <= LARGEST, reference, 0.0)
            given = hierarchy.copy(), x, self.settings, message
            return Solution(x.copy(), Status.INVALID, self.backend, *given, staged=None)
        stages = self._staged.solve(hierarchy, reference, aims)
        last = stages.solutions[-1]
        solved, levels = len(last.hierarchy.levels), len(hierarchy.levels)
        where = f"in the stage of levels 0 to {solved - 1}: " if solved < levels else ""
        solution = new(Solution)
        fields = solution.__dict__
        fields["x"], fields["status"], fields["level"] = last.x, last.status, last.level
        fields["message"] = f"{where}{last.message}" if last.message else ""
        counts = Counts(*map(sum, zip(*(stage.counts for stage in stages.solutions), strict=True)))
        if last.status is Status.INVALID:
            fields["staged"] = stages
        tell = partial(retold, self.damping, partial(solve_once, self.backend, self.settings), reference)
        fields["_noted"] = hierarchy, numbers, last.x_ref, (self.backend, self.settings, tell), counts
        fields["_points"], fields["_aims"] = self._staged.answers, aims
        return solution

    def _answer(self, hierarchy: Hierarchy, reference: Array, fault: str | None) -> Answer:
        """The answer of the backend, or why it is not called."""
        if self._prepare is None:
            fault = hierarchy.find_fault() or fault
        if fault is not None:
            return Answer(reference.copy(), Status.INVALID, fault)
        with np.errstate(all="ignore"):
            return self._backend.solve(hierarchy, reference)

    def _adopt(self, hierarchy: Hierarchy) -> None:
        """Start afresh if the structure differs, not only the object that holds it."""
        if not isinstance(hierarchy, Hierarchy):
            raise InvalidInput(f"solve takes a hqp.Hierarchy, not a {type(hierarchy).__name__}")
        if hierarchy.structure != self._structure:
            self._backend.reset()
            self._way = ShortWay()
            if self._prepare is not None and self._staged is None:
                self._way = self._prepare(hierarchy.structure)
            self._zero = np.zeros(hierarchy.n)
            self._zero.flags.writeable = False
        self._structure = hierarchy.structure

    def _adopt_damped(self, hierarchy: Hierarchy) -> None:
        """The same where levels are damped; which ones their names mean may differ though the structure does not."""
        known, self._places = self._structure, {}
        self._adopt(hierarchy)
        if hierarchy.structure == known and self._by_number:
            return
        self._structure = self._way.plain = None  # until the rules fit
        rules = by_index(hierarchy, self.damping)
        prepare = getattr(self._backend, "prepare_damped", None)
        if prepare is not None and (hierarchy.structure != known or rules != self._rules):
            self._way = prepare(hierarchy.structure, rules) or ShortWay()
        self._structure, self._rules = hierarchy.structure, rules

    def _reference(self, x_ref: ArrayLike) -> tuple[str | None, Array]:
        """What is wrong with x_ref, if anything, and what to use."""
        reference = real_array(x_ref, "x_ref")
        if reference.shape != self._zero.shape:
            raise InvalidInput(f"x_ref has shape {reference.shape}; it must be {self._zero.shape}")
        if _bounded(reference):
            return None, reference
        return f"x_ref = {reference} must be finite, and at most {LARGEST:g} in size", self._zero


def _bounded(vector: Array) -> bool:
    """Whether all its numbers mean something."""
    return bool((np.abs(vector) <= LARGEST).all())
