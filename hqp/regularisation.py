r"""Damping where it is asked for, without taking freedom from the levels below.

A damped level k minimises, within what the levels above it leave,

.. math:: \|D_k w_k\|^2 + \lambda^2 \|x - x_\text{ref}\|^2,

which is one more plain level, of the rows :math:`[D_k A_k;\; \lambda I]`. Left in the hierarchy, these would
take up all freedom. So the hierarchy is solved in stages, each of them a plain one that any backend solves
and ``certify`` proves: for each damped level, from the highest, the levels down to it with the rows of
damping joined to it; then its rows are *frozen* at what they reached, :math:`A_k x = A_k x_k`, and the next
stage has the null space of :math:`A_k` to move in. Inequality rows that are satisfied stay inequalities.
The last stage is the whole hierarchy, every damped level frozen;
it is left out where the lowest level of all is damped, whose stage has decided every x.

For two equality levels of full rank, the second damped, this is, with :math:`\hat J_2 = J_2 N_1` and
:math:`x_\text{ref} = 0`,

.. math:: x = J_1^\# r_1 + \hat J_2^T (\hat J_2 \hat J_2^T + \lambda^2 I)^{-1} (r_2 - J_2 J_1^\# r_1).
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array, finite_vector, real_array
from .checks import of_type
from .damped import DampedLevel, has_inequalities, left_singular, project, refuse_inequalities
from .damping import DampingRule, as_rule
from .errors import InvalidInput, Unsupported, brief
from .guard import Guard
from .hierarchy import LARGEST, Hierarchy
from .relaxation import RegularisedSolution
from .settings import Settings
from .solution import Counts, Solution, Status
from .solve import DEFAULT_BACKEND, Solver

#: No singular values: of a rule that does not look at any.
NOTHING = np.zeros(0)


class RegularisedSolver:
    """Solves hierarchies of one structure again and again with damped levels, every stage warm from its last.

    Parameters
    ----------
    damping : mapping of int or str to DampingRule or float
        The levels to damp, by index or by name, each with its rule; a number is a :class:`FixedDamping`.
    backend : str
        A name from ``hqp.available_backends()``.
    settings : Settings, optional

    Raises
    ------
    InvalidInput
        If a rule is none.
    UnknownBackend
        If no backend of that name can run here.
    """

    def __init__(
        self,
        damping: Mapping[int | str, DampingRule | float],
        backend: str = DEFAULT_BACKEND,
        settings: Settings | None = None,
    ) -> None:
        if not isinstance(damping, Mapping):
            raise InvalidInput(f"damping = {brief(damping)} must map levels to rules, as in {{1: 0.1}}")
        self.damping = {key: _rule(key, rule) for key, rule in damping.items()}
        self.backend = backend
        self._last = Solver(backend, settings)
        self.settings = self._last.settings
        self._above: defaultdict[int, Solver] = defaultdict(self._solver)
        self._damped: defaultdict[int, Solver] = defaultdict(self._solver)
        self._structure: tuple[Any, ...] | None = None
        self._work: Hierarchy
        self._plan: list[tuple[int, DampingRule, DampedLevel]] = []
        self._zero = NOTHING
        self._guard = Guard("the solver")

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy is made from what defines it, and cold."""
        return type(self), (self.damping, self.backend, self.settings)

    def _solver(self) -> Solver:
        return Solver(self.backend, self.settings)

    def solve(self, hierarchy: Hierarchy, x_ref: ArrayLike | None = None) -> RegularisedSolution:
        """Solve, warm if the last hierarchy had the same structure.

        Parameters
        ----------
        hierarchy : Hierarchy
        x_ref : array, shape (n,), optional
            Reference of the damping, and of the implicit last level (default: zero).

        Raises
        ------
        InvalidInput
            If a damped level is not in the hierarchy, if numerical filtering meets an inequality row, or if
            x_ref is no array of real numbers or has the wrong shape.
        InUse
            If another thread is solving with it.
        """
        with self._guard:
            return self._solve(of_type(hierarchy, Hierarchy, "hierarchy"), x_ref)

    def _solve(self, hierarchy: Hierarchy, x_ref: ArrayLike | None) -> RegularisedSolution:
        if hierarchy.structure is not self._structure:
            self._adopt(hierarchy)
        work, dampings, stages = self._work, dict[int, float](), list[Solution]()
        work.numbers[:] = hierarchy.numbers
        reference = self._zero if x_ref is None else real_array(x_ref, "x_ref")
        if hierarchy.find_fault() or reference.shape != (hierarchy.n,) or not (np.abs(reference) <= LARGEST).all():
            stages.append(self._last.solve(hierarchy, reference))  # which says what is wrong
        else:
            for stage in self._stages(reference, dampings):
                stages.append(stage)
                if not stage.ok:
                    break
        return self._conclude(hierarchy, work.copy(), tuple(stages), dampings)

    def _adopt(self, hierarchy: Hierarchy) -> None:
        """Lay out the stages for hierarchies of this structure; the solvers stay warm if it says the same."""
        self._structure = None
        rules = self._rules(hierarchy)
        self._work = hierarchy.copy()
        self._plan = [(k, rule, DampedLevel(self._work, k)) for k, rule in sorted(rules.items())]
        self._zero = np.zeros(hierarchy.n)
        self._zero.flags.writeable = False
        self._structure = hierarchy.structure

    def _stages(self, x_ref: Array, dampings: dict[int, float]) -> Iterator[Solution]:
        """Every stage in its turn; level after level is frozen in the work, and its lambda noted in `dampings`."""
        x, decided = x_ref, 0  # x is where the levels above `decided` leave off
        for k, rule, level in self._plan:
            J, own = np.zeros((0, len(x_ref))), None
            if rule.mixes or rule.looks or (rule.grows and decided != k):
                level.refill()
            if rule.mixes:
                refuse_inequalities(level.levels)
            # Where the levels above leave off, unless it is known; the active rows of equalities are the same anywhere.
            if decided != k and (rule.grows or (rule.looks and has_inequalities(level.levels))):
                x = x_ref
                if not level.satisfied_above(x):
                    stage = self._above[k].solve(level.above, x_ref)
                    yield stage
                    x = stage.x
            if rule.looks:
                J, own = project(level.levels, x, x_ref, self.settings)
            vectors, singular = left_singular(J) if rule.looks else (J, NOTHING)
            damping = rule.damping(singular)
            if rule.grows:
                damping = math.hypot(damping, rule.growth(singular) * level.lacking(x))
                damping = 0.0 if damping < level.least_damping(self.settings) else min(damping, LARGEST)
            dampings[k] = damping
            if damping < 1.0 / LARGEST:
                continue  # strict, as the level stands
            if rule.mixes and own is not None and own.any():
                level.filter(own, vectors[:, -1], damping, rule.filtering(singular), x_ref)
            else:
                level.damp(damping, x_ref)
            stage = self._damped[k].solve(level.joined, x_ref)
            yield stage
            x, decided = stage.x, k + 1
            level.freeze(x, x_ref, self.settings)
        if decided < len(self._work.levels) or not decided:  # otherwise damping has left nothing to decide
            yield self._last.solve(self._work, x_ref)

    def _rules(self, hierarchy: Hierarchy) -> dict[int, DampingRule]:
        """The rules by the index of their level."""
        labels = [hierarchy.label(k) for k in range(len(hierarchy.levels))]
        rules: dict[int, DampingRule] = {}
        for key, rule in self.damping.items():
            named = [k for k, level in enumerate(hierarchy.levels) if k == key or (level.name == key != "")]
            if len(named) != 1:
                what = "is no level of the hierarchy" if not named else f"names {len(named)} of its levels"
                raise InvalidInput(f"damping: {key!r} {what}, which has {', '.join(labels) or 'none'}")
            if named[0] in rules:
                raise InvalidInput(f"damping: {labels[named[0]]} is given twice, by its index and by its name")
            rules[named[0]] = rule
        return rules

    def _conclude(
        self, hierarchy: Hierarchy, work: Hierarchy, stages: tuple[Solution, ...], dampings: dict[int, float]
    ) -> RegularisedSolution:
        last = stages[-1]
        solved, levels = len(last.hierarchy.pointers) - 1, len(hierarchy.pointers) - 1
        where = f"in the stage of levels 0 to {solved - 1}: " if solved < levels else ""
        plain = Solution(
            last.x,
            last.status,
            self.backend,
            hierarchy.copy(),
            last.x_ref,
            message=f"{where}{last.message}" if last.message else "",
            level=last.level,
            counts=Counts(*map(sum, zip(*(stage.counts for stage in stages), strict=True))),
            settings=last.settings,
        )
        return RegularisedSolution(plain, work, stages, dampings, self.settings)


def solve_regularised(
    hierarchy: Hierarchy,
    damping: Mapping[int | str, DampingRule | float],
    *,
    backend: str = DEFAULT_BACKEND,
    x_ref: ArrayLike | None = None,
    settings: Settings | None = None,
) -> RegularisedSolution:
    """Solve a hierarchy with damped levels once.

    Parameters
    ----------
    hierarchy : Hierarchy
    damping : mapping of int or str to DampingRule or float
        The levels to damp, by index or by name, each with its rule; a number is a :class:`FixedDamping`.
    backend : str
        A name from ``hqp.available_backends()``.
    x_ref : array, shape (n,), optional
        Reference of the damping, and of the implicit last level (default: zero).
    settings : Settings, optional

    Returns
    -------
    RegularisedSolution
        ``.x``, ``.status``, ``.levels[k]``, ``.relaxed``; ``.certify().ok`` is the proof of every stage.

    Raises
    ------
    InvalidInput, UnknownBackend, Unsupported
        As :func:`hqp.solve`, and if a damped level is not in the hierarchy.
    """
    if x_ref is not None and isinstance(hierarchy, Hierarchy):
        x_ref = finite_vector(x_ref, hierarchy.n, "x_ref")
    solution = RegularisedSolver(damping, backend, settings).solve(hierarchy, x_ref)
    if solution.status is Status.INVALID:
        raise InvalidInput(solution.message)
    if solution.status is Status.UNSUPPORTED:
        raise Unsupported(solution.message)
    return solution


def _rule(key: object, value: object) -> DampingRule:
    if not isinstance(key, Integral | str) or isinstance(key, bool):
        raise InvalidInput(f"damping: {brief(key)} must be the index or the name of a level")
    return as_rule(value, f"damping of {key!r}")
