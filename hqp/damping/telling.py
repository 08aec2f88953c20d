"""The stages of an answer with damped levels, written anew from the hierarchy that was given.

An answer keeps no stage that was solved, only its x. So if the problem that was solved differs from the one which the
given rows, the rule and the aim define, its x is not optimal, and the certificate says so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from ..arrays import Array
from ..hierarchy import Hierarchy
from ..solution import NO_COUNTS, Solution, Stages, Status
from .rules import DampingRule
from .staged import NONE, Known, Staging


def told(
    damping: dict[int | str, DampingRule],
    solve: Callable[[Hierarchy, Array], Solution],
    solution: Solution,
    points: Array,
    aims: Array | None,
) -> Stages:
    """The stages of an answer for which all were solved at once; the last one has the counts of all.

    Parameters
    ----------
    damping : dict of int or str to DampingRule
        The damped levels, by number or name, and the rule of each.
    solve : callable
        Solves a stage that was not asked: a hierarchy, and the reference of its norms, shape (n,).
    solution : Solution
        The answer, whose x and counts these stages have.
    points : array, shape (damped, 2 + 2 n)
        Of every damped level lambda, whether the levels above were solved alone, their x, and its own.
    aims : array, shape (damped, n), or None
        See :meth:`Staging.run`.
    """
    staging, n = Staging(solution.hierarchy, damping, solution.settings, solve), solution.hierarchy.n
    of, end = dict(zip(staging.rules, points, strict=True)), len(solution.hierarchy.levels)
    last = end - 1 if end - 1 in of and of[end - 1][0] >= NONE else end

    def ask(k: int, above: bool, hierarchy: Hierarchy, x_ref: Array) -> Solution:
        x = solution.x if k not in of else of[k][2 : 2 + n] if above else of[k][2 + n :]
        counts = solution.counts if k == last and not above else NO_COUNTS
        kind, given = solution.backend, hierarchy.copy()
        return Solution(x.copy(), Status.OPTIMAL, kind, given, x_ref, solution.settings, counts=counts, staged=None)

    known = {k: Known(float(point[0]), bool(point[1])) for k, point in of.items()}
    return staging.run(solution.hierarchy, solution.x_ref, ask, known, aims)


def retold(
    damping: dict[int | str, DampingRule],
    solve: Callable[[Hierarchy, Array], Solution],
    x_ref: Array,
    solution: Solution,
    answers: Mapping[tuple[int, bool], Solution],
    aims: Array | None,
) -> Stages:
    """The stages of an answer that was found stage by stage; the rules give lambda once more.

    Parameters
    ----------
    damping, solve, solution
        See :func:`told`.
    x_ref : array, shape (n,)
        From which the norms of the hierarchy count.
    answers : mapping
        The answer of every stage, by the arguments of the call, see :class:`.staged.Ask`.
    aims : array, shape (damped, n), or None
        See :meth:`Staging.run`.
    """
    staging = Staging(solution.hierarchy, damping, solution.settings, solve)

    def ask(k: int, above: bool, hierarchy: Hierarchy, x_ref: Array) -> Solution:
        known = answers.get((k, above))
        if known is None:  # of numbers that are not the given ones: it was not asked
            return solve(hierarchy, x_ref)
        return replace(known, hierarchy=hierarchy.copy(), x_ref=x_ref)

    return staging.run(solution.hierarchy, x_ref, ask, aims=aims)
