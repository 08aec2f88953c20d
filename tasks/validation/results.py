"""All checks on all backends, spread over the cores; no number but the times depends on how many there are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hqp.validation import Finding, Parting, Point, Report

#: One stack at every sigma for so many a case.
CASE_STACKS_A_POINT = 15
#: What is also run without polish, to show what the flat QPs alone would give.
UNPOLISHED = "cascade:osqp"


@dataclass(frozen=True)
class Results:
    """What was found, in the order of the registry and of the checks.

    Attributes
    ----------
    backends : tuple of str
    count, near : int
        Random stacks a case, and at every sigma.
    seed : int
    reports, points, partings, findings : list
        See :mod:`hqp.validation`.
    """

    backends: tuple[str, ...]
    count: int
    near: int
    seed: int
    reports: list[Report]
    points: list[Point]
    partings: list[Parting]
    findings: list[Finding]

    @property
    def wrong(self) -> list[str]:
        """Backends outside their class where the rank is decidable, or on a known answer; or formulas that differ."""
        named: list[Report | Point | Finding] = [*self.reports, *self.points, *self.findings]
        wrong = {item.backend for item in named if not item.ok}
        return [name for name in self.backends if name in wrong] + [
            f"Eq. 4.8 ({relation})" for relation in dict.fromkeys(p.relation for p in self.partings if not p.ok)
        ]


def run(names: Sequence[str], count: int, seed: int, jobs: int) -> Results:
    """Do all checks.

    Parameters
    ----------
    names : sequence of str
        Backends.
    count : int
        Random stacks a case.
    seed : int
    jobs : int
        Processes; -1 for one a core.
    """
    from joblib import Parallel, delayed
    from rich.console import Console
    from rich.progress import track

    from hqp import Solver
    from hqp.problems import equality_cases
    from hqp.validation import PLACES, RELATIONS, approach, check, compare, part, validate_case

    for name in names:
        Solver(name)  # what has to be compiled is compiled once, not by every process
    near = max(1, count // CASE_STACKS_A_POINT)
    work = [delayed(approach)(name, place, near, seed) for name in names for place in PLACES]
    if UNPOLISHED in names:
        work += [delayed(approach)(UNPOLISHED, place, near, seed, polished=False) for place in PLACES]
    work += [delayed(validate_case)(name, case, count, seed) for name in names for case in equality_cases()]
    work += [delayed(part)(place, near, seed) for place in PLACES]
    work += [delayed(compare)(relation, count, seed) for relation in RELATIONS]
    work += [delayed(check)(name) for name in names]
    done = Parallel(n_jobs=jobs, return_as="generator")(work)
    found: dict[type, list] = {Report: [], Point: [], Parting: [], Finding: []}  # type: ignore[type-arg]
    for batch in track(done, "solving", total=len(work), console=Console(stderr=True), transient=True):
        for item in batch:
            found[type(item)].append(item)
    return Results(tuple(names), count, near, seed, found[Report], found[Point], found[Parting], found[Finding])
