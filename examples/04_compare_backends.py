"""The same hierarchies through every backend installed here, judged by the certificate alone."""

import time

import numpy as np

from hqp import DEFAULT_BACKEND, Solver, available_backends, backend_info
from hqp.problems import random_hierarchy

COUNT = 40
problems = [random_hierarchy(np.random.default_rng([1, k])) for k in range(COUNT)]
print(f"{COUNT} random hierarchies with conflicts, repeated rows and weights, up to 6 levels, such as\n{problems[5]}\n")

default = Solver(DEFAULT_BACKEND)
reference = [default.solve(problem).x for problem in problems]

print(f"{'backend':27} {'class':11} {'claimed':>8} {'certified':>9} {'difference':>11} {'QPs':>5} {'ms':>6}")
for name in available_backends():
    info = backend_info(name)
    if not (info.inequalities and info.lexicographic):
        print(f"{name:27} {info.accuracy:11} takes equalities only")
        continue
    solver = Solver(name)
    start = time.perf_counter()
    solutions = [solver.solve(problem) for problem in problems]
    seconds = time.perf_counter() - start
    claimed = sum(solution.ok for solution in solutions)
    certified = sum(solution.certify().ok for solution in solutions)
    distances = [
        float(np.linalg.norm(solution.x - x) / max(1.0, float(np.linalg.norm(x))))
        for solution, x in zip(solutions, reference, strict=True)
        if solution.ok
    ]
    qps = sum(solution.counts.qp_solves for solution in solutions) / COUNT
    print(
        f"{name:27} {info.accuracy:11} {claimed:5}/{COUNT} {certified:6}/{COUNT} {max(distances, default=np.nan):11.0e}"
        f" {qps:5.1f} {1e3 * seconds / COUNT:6.2f}"
    )
print(
    f"\nclaimed: the backend's own status; difference: of a claimed x, at the most, from {DEFAULT_BACKEND}'s, relative"
)
print("QPs, ms: mean of one hierarchy")
