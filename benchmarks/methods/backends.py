"""Every backend of the registry, through :class:`hqp.Solver`: native, cascades over flat QP solvers, DAQP."""

from __future__ import annotations

from hqp import Hierarchy, Solution, Solver, solve
from hqp.backends import BACKENDS, BackendInfo

from ..families import Family
from ..settings import TIGHT, Setting
from .method import Call, Method, Outcome


class Backend(Method):
    """A backend of ours."""

    @property
    def info(self) -> BackendInfo:
        """What the registry tells of it."""
        return BACKENDS[self.name]

    @property
    def slow(self) -> bool:
        return bool(self.info.qp_solver)

    @property
    def settings(self) -> tuple[Setting, ...]:
        return super().settings if self.info.qp_solver else (TIGHT,)

    @property
    def about(self) -> str:
        return self.info.summary

    def missing(self) -> str:
        if self.info.installed:
            return ""
        return f"the package {self.info.package!r} is not installed: pip install '{self.info.install}'"

    def refusal(self, family: Family) -> str:
        if not self.info.lexicographic:
            return f"{self.name} aims at the optimum of another hierarchy"
        if family.inequalities and not self.info.inequalities:
            return f"{self.name} takes no inequalities"
        return ""

    def cold(self, problem: Hierarchy, setting: Setting = TIGHT) -> Call:
        solver = Solver(self.name, settings=setting.settings)
        solver.solve(problem)
        solver.forget()
        return lambda: solver.solve(problem)

    def one_shot(self, problem: Hierarchy, setting: Setting = TIGHT) -> Call:
        return lambda: solve(problem, backend=self.name, settings=setting.settings)

    def warm(self, before: Hierarchy, now: Hierarchy, setting: Setting = TIGHT) -> Call:
        solver = Solver(self.name, settings=setting.settings)
        solver.solve(before)
        return lambda: solver.solve(now)

    def outcome(self, answer: Solution) -> Outcome:
        counts = answer.counts
        return Outcome(answer.x, answer.ok, str(answer.status), counts.sweeps + counts.iterations + counts.qp_solves)


METHODS = tuple(Backend(name) for name, info in BACKENDS.items() if info.lexicographic)
