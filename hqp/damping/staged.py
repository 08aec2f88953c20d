r"""Damped levels, solved in stages, so that the levels below keep their null space.

A damped level k minimises, within what the levels above it leave,

.. math:: \|D_k w_k\|^2 + \lambda^2 \|x - r_k\|^2,

where :math:`r_k` is the *aim* of the level, :math:`x_\text{ref}` unless given. This is one more plain level, of the
rows :math:`[D_k A_k;\; \lambda I]`. Left in the hierarchy, these would leave no null space to the levels below. So the
hierarchy is solved in stages, each of them a plain one that any backend solves and ``certify`` proves: for each damped
level, from the highest, the levels down to it with the rows of damping joined to it; then its rows are *frozen* at what
they reached, :math:`A_k x = A_k x_k`, and the next stage has the null space of :math:`A_k` to move in. Inequality rows
that are satisfied stay inequalities. The last stage is the whole hierarchy, every damped level frozen; it is left out
where the lowest level of all is damped, whose stage has decided every x.

In all that belongs to a damped level its aim stands for :math:`x_\text{ref}`: its rows ask for it, x is the aim where
neither they nor the levels above say anything, and :math:`x_a`, where the levels above leave off, is the point of
theirs that is nearest to it. So whatever is true of damping towards :math:`x_\text{ref}` is true of any aim.

For two equality levels of full rank, the second damped, this is, with :math:`\hat J_2 = J_2 N_1` and aim and
:math:`x_\text{ref}` zero,

.. math:: x = J_1^\# r_1 + \hat J_2^T (\hat J_2 \hat J_2^T + \lambda^2 I)^{-1} (r_2 - J_2 J_1^\# r_1).

This module defines the stages, for all backends; :mod:`.telling` writes those of an answer anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from numbers import Integral
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..arrays import Array
from ..errors import InvalidInput, brief
from ..hierarchy import LARGEST, Hierarchy
from ..settings import Settings
from ..solution import Solution, Stages
from .level import DampedLevel, has_inequalities, left_singular, project, refuse_inequalities
from .rules import DampingRule, as_rule

#: No singular values: of a rule that does not look at any.
NOTHING = np.zeros(0)
#: A lambda below is none.
NONE = 1.0 / LARGEST


class Known(NamedTuple):
    """The lambda of a damped level, and whether the levels above it were solved alone."""

    damping: float
    alone: bool


class Ask(Protocol):
    """Who solves a stage: of the levels above damped level k, of those with it, or, with k one too many, of all."""

    def __call__(self, k: int, above: bool, hierarchy: Hierarchy, x_ref: Array) -> Solution:
        """The answer to this stage."""
        ...


class Staging:
    """The stages of hierarchies of one structure, laid out once and refilled.

    Parameters
    ----------
    hierarchy : Hierarchy
    damping : dict of int or str to DampingRule
        By index or name of the level.
    settings : Settings
    solve : callable
        Solves one plain hierarchy; used when the strict residual of an answer is read.

    Raises
    ------
    InvalidInput
        If a damped level is not in the hierarchy.
    """

    def __init__(
        self,
        hierarchy: Hierarchy,
        damping: Mapping[int | str, DampingRule],
        settings: Settings,
        solve: Callable[[Hierarchy, Array], Solution],
    ) -> None:
        self.rules = by_index(hierarchy, damping)
        self._settings, self._solve, self._work = settings, solve, hierarchy.copy()
        self._plan = [(k, rule, DampedLevel(self._work, k)) for k, rule in self.rules.items()]

    def run(
        self,
        hierarchy: Hierarchy,
        x_ref: Array,
        ask: Ask,
        known: Mapping[int, Known] | None = None,
        aims: Array | None = None,
    ) -> Stages:
        """Every stage in its turn, up to the first that has no optimum; lambda by the rules, unless it is `known`.

        Of `aims`, shape (damped, n), each damped level has a row; they are x_ref by default.
        """
        self._work.numbers[:] = hierarchy.numbers
        dampings, solutions = dict[int, float](), list[Solution]()
        aim = {k: x_ref if aims is None else aims[d] for d, k in enumerate(self.rules)}
        if known is None:
            stages = self._stages(x_ref, aim, dampings, ask)
        else:
            stages = self._known(x_ref, aim, dampings, ask, known)
        for solution in stages:
            solutions.append(solution)
            if not solution.ok:
                break
        gave = tuple(k for k, damping in dampings.items() if damping >= NONE)
        return Stages(tuple(solutions), dampings, aim, self._solve, softened=gave)

    def _stages(self, x_ref: Array, aims: dict[int, Array], dampings: dict[int, float], ask: Ask) -> Iterator[Solution]:
        """Level after level is frozen in the work, and its lambda noted in `dampings`."""
        x, start, decided = x_ref, x_ref, 0  # x is where the levels above `decided` leave off, nearest to the start
        for k, rule, level in self._plan:
            J, own, aim = np.zeros((0, len(x_ref))), None, aims[k]
            known = decided == k and (aim is start or np.array_equal(aim, start))
            start = aim
            if rule.mixes or rule.looks or (rule.grows and not known):
                level.refill()
            if rule.mixes:
                refuse_inequalities(level.levels)
            # Where the levels above leave off, unless it is known; the active rows of equalities are the same anywhere.
            if not known and (rule.grows or (rule.looks and has_inequalities(level.levels))):
                x = aim
                if not level.satisfied_above(x):
                    stage = ask(k, True, level.above, aim)
                    yield stage
                    x = stage.x
            if rule.looks:
                J, own = project(level.levels, x, aim, self._settings)
            vectors, singular = left_singular(J) if rule.looks else (J, NOTHING)
            damping = rule.damping(singular)
            if rule.grows:
                damping = math.hypot(damping, rule.growth(singular) * level.lacking(x))
                damping = 0.0 if damping < level.least_damping(self._settings) else min(damping, LARGEST)
            dampings[k] = damping
            if damping < NONE:
                continue  # strict, as the level stands
            if rule.mixes and own is not None and own.any():
                level.filter(own, vectors[:, -1], damping, rule.filtering(singular), aim)
            else:
                level.damp(damping, aim)
            stage = ask(k, False, level.joined, aim)
            yield stage
            x, decided = stage.x, k + 1
            level.freeze(x, aim, self._settings)
        yield from self._last(x_ref, decided, ask)

    def _known(
        self,
        x_ref: Array,
        aims: dict[int, Array],
        dampings: dict[int, float],
        ask: Ask,
        known: Mapping[int, Known],
    ) -> Iterator[Solution]:
        """The same of what a solver has been through."""
        decided = 0
        for k, _, level in self._plan:
            dampings[k], alone = known[k]
            if alone:
                level.refill()
                yield ask(k, True, level.above, aims[k])
            if dampings[k] >= NONE:
                level.damp(dampings[k], aims[k])
                stage = ask(k, False, level.joined, aims[k])
                yield stage
                decided = k + 1
                level.freeze(stage.x, aims[k], self._settings)
        yield from self._last(x_ref, decided, ask)

    def _last(self, x_ref: Array, decided: int, ask: Ask) -> Iterator[Solution]:
        levels = len(self._work.levels)
        if decided < levels or not decided:  # otherwise damping has left nothing to decide
            yield ask(levels, False, self._work, x_ref)


class Staged:
    """Solves hierarchies with damped levels stage by stage, every stage warm from its last.

    Parameters
    ----------
    damping : dict of int or str to DampingRule
    settings : Settings
    plain : callable
        Makes what solves one plain hierarchy again and again, given x_ref.
    solve : callable
        See :class:`Staging`.

    Attributes
    ----------
    answers : dict
        Of the last solve: what every stage answered, by what was asked of it, see :class:`Ask`.
    """

    def __init__(
        self,
        damping: dict[int | str, DampingRule],
        settings: Settings,
        plain: Callable[[], Callable[[Hierarchy, Array], Solution]],
        solve: Callable[[Hierarchy, Array], Solution],
    ) -> None:
        self._damping, self._settings, self._plain, self._solve = damping, settings, plain, solve
        self._stages: dict[tuple[int, bool], Callable[[Hierarchy, Array], Solution]] = {}
        self._structure: tuple[Any, ...] | None = None
        self._staging: Staging
        self.answers = dict[tuple[int, bool], Solution]()

    def solve(self, hierarchy: Hierarchy, x_ref: Array, aims: Array | None = None) -> Stages:
        """Solve; numbers that mean nothing are those of the only stage, which says so. Aims as of `Staging.run`."""
        if hierarchy.structure is not self._structure:
            self._structure = None  # what solves the stages stays warm if it says the same
            self._staging = Staging(hierarchy, self._damping, self._settings, self._solve)
            self._structure = hierarchy.structure
        self.answers = {}
        if hierarchy.find_fault() or not (np.abs(x_ref) <= LARGEST).all():
            told = self._ask(len(hierarchy.levels), False, hierarchy, x_ref)
            return Stages((told,), {}, {}, self._solve)
        return self._staging.run(hierarchy, x_ref, self._ask, aims=aims)

    def forget(self) -> None:
        """Make the next call a cold one."""
        self._stages.clear()

    def _ask(self, k: int, above: bool, hierarchy: Hierarchy, x_ref: Array) -> Solution:
        solve = self._stages.get((k, above))
        if solve is None:
            solve = self._stages[k, above] = self._plain()
        solution = self.answers[k, above] = solve(hierarchy, x_ref)
        return solution


def rules_of(damping: object) -> dict[int | str, DampingRule]:
    """The rules as given by the user, each made one; InvalidInput says which is none."""
    if not isinstance(damping, Mapping):
        raise InvalidInput(f"damping = {brief(damping)} must map levels to rules, as in {{1: 0.1}}")
    for key in damping:
        if not isinstance(key, Integral | str) or isinstance(key, bool):
            raise InvalidInput(f"damping: {brief(key)} must be the index or the name of a level")
    return {key: as_rule(rule, f"damping of {key!r}") for key, rule in damping.items()}


def by_index(hierarchy: Hierarchy, damping: Mapping[int | str, DampingRule]) -> dict[int, DampingRule]:
    """The rules by the index of their level, in order."""
    rules: dict[int, DampingRule] = {}
    for key, rule in damping.items():
        k = index_of(hierarchy, key, "damping")
        if k in rules:
            raise InvalidInput(f"damping: {hierarchy.level_name(k)} is given twice, by its index and by its name")
        rules[k] = rule
    return dict(sorted(rules.items()))


def index_of(hierarchy: Hierarchy, key: object, what: str) -> int:
    """The level that an index or a name means, or InvalidInput that begins with `what`."""
    named = [k for k, level in enumerate(hierarchy.levels) if k == key or (level.name == key != "")]
    if len(named) == 1:
        return named[0]
    problem = "is no level of the hierarchy" if not named else f"names {len(named)} of its levels"
    names = [hierarchy.level_name(k) for k in range(len(hierarchy.levels))]
    raise InvalidInput(f"{what}: {key!r} {problem}, which has {', '.join(names) or 'none'}")
