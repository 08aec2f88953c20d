"""All checks on all backends, spread over the cores; no number but the times depends on how many there are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from . import Finding, Judgement, Parting, Point, Report, summed

#: One stack at every sigma for so many a case, and one random hierarchy of every size.
CASE_STACKS_A_POINT, CASE_STACKS_A_HIERARCHY = 15, 5
#: Random hierarchies given to all backends in one go.
TOGETHER = 5
#: What is also run without polish, to show what the flat QPs alone would give.
UNPOLISHED = "cascade:osqp"
#: The kinds of checks -> what they find.
KINDS: dict[str, type] = {
    "closed forms": Report,
    "singularities": Point,
    "two formulas": Parting,
    "random hierarchies": Judgement,
    "known answers": Finding,
}


@dataclass(frozen=True)
class Results:
    """The results of all checks, in the order of the registry and of the checks.

    Attributes
    ----------
    backends : tuple of str
    count, near, whole : int
        Random stacks a case, and at every sigma, and random hierarchies of every size.
    seed : int
    reports, points, partings, judgements, findings : list
        See :mod:`hqp.validation`.
    """

    backends: tuple[str, ...]
    count: int
    near: int
    whole: int
    seed: int
    reports: list[Report]
    points: list[Point]
    partings: list[Parting]
    judgements: list[Judgement]
    findings: list[Finding]

    @property
    def outside(self) -> dict[str, list[str]]:
        """Backend -> the kinds of checks that found it outside its class, where the rank is decidable."""
        judged: list[Report | Point | Judgement | Finding] = [
            *self.reports, *self.points, *summed(self.judgements), *self.findings
        ]  # fmt: skip
        wrong = {(item.backend, type(item)) for item in judged if not item.ok}
        kinds = {name: [kind for kind, found in KINDS.items() if (name, found) in wrong] for name in self.backends}
        return {name: found for name, found in kinds.items() if found}

    @property
    def wrong(self) -> list[str]:
        """Backends outside their class, and by which checks; and formulas that differ where they must not."""
        return [f"{name} ({', '.join(kinds)})" for name, kinds in self.outside.items()] + [
            f"Eq. 4.8 ({relation})" for relation in dict.fromkeys(p.relation for p in self.partings if not p.ok)
        ]


def run(names: Sequence[str], count: int, seed: int, jobs: int, kinds: Sequence[str] = tuple(KINDS)) -> Results:
    """Run these checks.

    Parameters
    ----------
    names : sequence of str
        Backends.
    count : int
        Random stacks a case.
    seed : int
    jobs : int
        Processes; -1 for one a core.
    kinds : sequence of str
        Of `KINDS`.
    """
    from joblib import Parallel, delayed
    from rich.console import Console
    from rich.progress import track

    from ..certificate import judging
    from ..solver import Solver

    for name in names:
        Solver(name)  # what has to be compiled is compiled once, not by every process
    judging.warm_up()
    near, whole = max(1, count // CASE_STACKS_A_POINT), max(1, count // CASE_STACKS_A_HIERARCHY)
    work = [
        delayed(call)(*arguments, **options)
        for kind, call, arguments, options in _work(names, count, near, whole, seed)
        if kind in kinds
    ]
    done = Parallel(n_jobs=jobs, return_as="generator")(work)
    found: dict[type, list[Any]] = {kind: [] for kind in KINDS.values()}
    for batch in track(done, "solving", total=len(work), console=Console(stderr=True), transient=True):
        for item in batch:
            found[type(item)].append(item)
    return Results(
        tuple(names), count, near, whole, seed,
        found[Report], found[Point], found[Parting], _by_backend(names, found[Judgement]), found[Finding],
    )  # fmt: skip


#: Of one piece of work: the kind of check, the call, its arguments and options.
Work = tuple[str, Callable[..., Any], tuple[Any, ...], dict[str, Any]]


def _work(names: Sequence[str], count: int, near: int, whole: int, seed: int) -> Iterator[Work]:
    """All checks in pieces, the longest first."""
    from ..problems import equality_cases
    from . import PLACES, RELATIONS, SIZES, approach, check, compare, judge, part, validate_case

    for size in reversed(SIZES):
        for first in range(0, whole, TOGETHER):
            some = min(TOGETHER, whole - first)
            yield "random hierarchies", judge, (names, size, some, seed), {"first": first}
    for name in names:
        for place in PLACES:
            yield "singularities", approach, (name, place, near, seed), {}
    if UNPOLISHED in names:
        for place in PLACES:
            yield "singularities", approach, (UNPOLISHED, place, near, seed), {"polished": False}
    for name in names:
        for case in equality_cases():
            yield "closed forms", validate_case, (name, case, count, seed), {}
    for place in PLACES:
        yield "two formulas", part, (place, near, seed), {}
    for relation in RELATIONS:
        yield "two formulas", compare, (relation, count, seed), {}
    for name in names:
        yield "known answers", check, (name,), {}


def _by_backend(names: Sequence[str], judgements: Sequence[Judgement]) -> list[Judgement]:
    """One a backend and size: what was given to all in several goes."""
    total: dict[tuple[int, int], Judgement] = {}
    for each in sorted(judgements, key=lambda each: (names.index(each.backend), each.n)):
        key = names.index(each.backend), each.n
        total[key] = total[key] + each if key in total else each
    return list(total.values())
