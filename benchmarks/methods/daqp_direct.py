"""DAQP's own hierarchy, called as its users call it: arrays are laid out beforehand, without this library."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from hqp import Hierarchy
from hqp.backends.daqp import DaqpProblem

from ..families import Family
from ..settings import TIGHT, Setting
from .method import Call, Method, Outcome

#: DAQP's settings at which its answers are good to 1e-8; they cost no time.
TOLERANCES = {"rho_soft": 1e-8, "primal_tol": 1e-9, "dual_tol": 1e-12}
#: Its hierarchy with the identity level as rows, and with it as the cost ``||x - b||`` below all levels.
DAQP_ROWS, DAQP_COST = "daqp.solve/rows", "daqp.solve/cost"


class Daqp(Method):
    """DAQP keeps nothing from call to call, so its every call is cold. Its first level is hard."""

    @property
    def about(self) -> str:
        form = "the posture as the cost below all levels" if self.name == DAQP_COST else "all levels as rows"
        return f"DAQP's own hierarchy called directly, {form}"

    def missing(self) -> str:
        return "" if find_spec("daqp") else "the package 'daqp' is not installed: pip install 'daqp'"

    def refusal(self, family: Family) -> str:
        if not family.feasible:
            return f"{self.name} takes the first level for hard"
        if self.name == DAQP_COST and not family.posture:
            return f"{self.name} needs a last level that asks for x"
        return ""

    def cold(self, problem: Hierarchy, setting: Setting = TIGHT) -> Call:
        f = np.zeros(problem.n)
        if self.name == DAQP_COST:
            *above, posture = problem.levels
            problem, f = Hierarchy(above, n=problem.n), -posture.lower
        solve, rows = import_module("daqp").solve, DaqpProblem.of(problem)
        given = (np.eye(problem.n), f, rows.A, rows.upper, rows.lower, rows.sense, rows.break_points)
        tolerances = TOLERANCES if setting is TIGHT else {}
        return lambda: solve(*given, **tolerances)

    def warm(self, before: Hierarchy, now: Hierarchy, setting: Setting = TIGHT) -> Call:
        return self.cold(now, setting)

    def outcome(self, answer: Any) -> Outcome:
        x, _, flag, info = answer
        return Outcome(x, flag > 0, f"exit flag {flag}", info["iterations"])


METHODS = (Daqp(DAQP_ROWS), Daqp(DAQP_COST))
