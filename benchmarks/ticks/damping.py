"""Cost of damped levels: the hierarchies of one motion, solved damped and undamped in turn."""

from __future__ import annotations

from time import perf_counter_ns

import numpy as np

from hqp import DampingRule, ErrorDamping, FixedDamping, Hierarchy, ManipulabilityDamping, SingularValueDamping, Solver
from tasks import Controller, JointLimits

from ..tables import Row
from .redundancy import DT, bench

#: How often the motion is run through; the fastest time of each hierarchy counts.
ROUNDS = 7
#: Name -> the damped levels of limits > hand > orientation > posture, by their index, with their rules.
DAMPINGS: dict[str, dict[int, DampingRule]] = {
    "none": {},
    "orientation, fixed": {2: FixedDamping(0.1)},
    "hand and orientation, fixed": {1: FixedDamping(0.1), 2: FixedDamping(0.1)},
    "orientation, by singular value": {2: SingularValueDamping(0.1, 0.2)},
    "both, by singular value": {1: SingularValueDamping(0.1, 0.2), 2: SingularValueDamping(0.1, 0.2)},
    "both, by singular value, always near": {1: SingularValueDamping(0.1, 9.0), 2: SingularValueDamping(0.1, 9.0)},
    "orientation, by manipulability": {2: ManipulabilityDamping(0.1, 0.02)},
    "orientation, by error": {2: ErrorDamping(1.0)},
    "both, by error": {1: ErrorDamping(1.0), 2: ErrorDamping(1.0)},
}


def recorded(ticks: int) -> list[Hierarchy]:
    """The hierarchies of a Panda whose hand goes round a circle, undamped."""
    b = bench()
    controller = Controller(b.robot, JointLimits() >> b.hand >> b.turn >> b.rest(), dt=DT, damping=None)
    q, v, hierarchies = b.robot.home, np.zeros(b.robot.nv), []
    for k in range(ticks):
        step = controller(q, v, k * DT)
        assert step.v is not None
        hierarchies.append(controller.hierarchy.copy())
        q, v = b.robot.integrate(q, DT * step.v), step.v
    return hierarchies


def ratios(ticks: int) -> list[Row]:
    """A row a damping: the time of a warm solve, that over the undamped one's, and what is proved."""
    template, *_ = hierarchies = recorded(ticks)
    numbers = [h.numbers for h in hierarchies]
    given = [template.with_numbers(own) for own in numbers]
    solvers = {name: Solver(damping=damping) for name, damping in DAMPINGS.items()}
    times = {name: np.full(ticks, np.inf) for name in solvers}
    for _ in range(ROUNDS):
        for k, h in enumerate(given):
            for name, solver in solvers.items():  # interleaved: what else the machine does, hits all
                start = perf_counter_ns()
                solver.solve(h)
                times[name][k] = min(times[name][k], (perf_counter_ns() - start) / 1000.0)
    rows = []
    for name, solver in solvers.items():
        checked = [solver.solve(h) for h in given[::50]]
        proved = sum(solution.certify().ok for solution in checked)
        median, p99 = np.percentile(times[name], [50, 99])
        rows.append(
            {
                "method": name,
                "median us": f"{median:.2f}",
                "p99 us": f"{p99:.2f}",
                "to none": f"{median / np.median(times['none']):.2f}",
                "stages": f"{np.mean([len(solution.stages) for solution in checked]):.1f}",
                "proved": f"{proved}/{len(checked)}",
            }
        )
    return rows
