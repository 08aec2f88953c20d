"""Run by the interpreter: what the compiled certificate accepts, `certify` accepts, at optima and beside them.

``NUMBA_DISABLE_JIT=1 python tests/proving.py`` prints how many points were judged, and how many each of both accepted:
of what breaks solvers, and of tasks that almost agree, far out, where the tolerances of their rows decide.
"""

from __future__ import annotations

import numpy as np

import hqp
from hqp import Hierarchy, Level
from hqp.backends.native import Memory
from hqp.kernels.memory import given
from hqp.kernels.proof import proves
from hqp.kernels.solver import levels_that_count, load, note_blur
from hqp.problems import FAMILIES, hierarchies

#: How far beside an optimum, in units of its length.
BESIDE = (0.0, 1e-13, 1e-11, 1e-9, 1e-7, 1e-4, 1e-1)


def accepts(hierarchy: Hierarchy, x: np.ndarray, x_ref: np.ndarray) -> bool:
    """The verdict of the compiled certificate, given nothing but the numbers of the hierarchy and x."""
    memory = Memory(hierarchy.structure, hqp.Settings())
    memory.x_ref[:] = x_ref
    with np.errstate(all="ignore"):
        given(memory.address, hierarchy.address)
        if not load(memory.address, False, True):
            return False
        last = levels_that_count(memory.address)
        note_blur(memory.address)
        memory.x[:] = x
        return bool(proves(memory.address, last))


Counts = tuple[int, int, int]


def verdicts(hierarchy: Hierarchy, x: np.ndarray, x_ref: np.ndarray, name: str) -> Counts:
    """One point; whether `certify` accepts it; and the compiled certificate, too."""
    proof, mine = hqp.certify(hierarchy, x, x_ref), accepts(hierarchy, x, x_ref)
    assert proof.ok or not mine, f"{name}: accepted, and refused: {proof}"
    return 1, proof.ok, mine


def judge(rng: np.random.Generator) -> Counts:
    """Points that were judged; accepted by `certify`; and by the compiled certificate, too."""
    told = []
    for name in FAMILIES:
        for hierarchy in hierarchies(name, 5, seed=7):
            if hierarchy.n > 8 or hierarchy.find_fault():
                continue
            for x_ref in np.zeros(hierarchy.n), rng.standard_normal(hierarchy.n):
                best = hqp.solve(hierarchy, x_ref=x_ref).x
                for share in BESIDE:
                    x = best + share * max(1.0, float(np.linalg.norm(best))) * rng.standard_normal(hierarchy.n)
                    told.append(verdicts(hierarchy, x, x_ref, f"{name}, {share:g} beside"))
    return total(told)


def judge_shifts(rng: np.random.Generator) -> Counts:
    """The same where what the rows of a level still pull with is little more than round-off of their values."""
    told = []
    for _ in range(40):
        n, far = int(rng.integers(2, 6)), 10.0 ** rng.integers(3, 7)
        A, x = rng.standard_normal((n + 3, n)), far * rng.standard_normal(n)
        near = A @ x + far * 10.0 ** rng.uniform(-9.0, -7.0) * rng.standard_normal(n + 3)
        below = np.where(rng.random(n + 2) < 0.4, far, 0.0)  # some are inequalities
        tasks = Level(A[1:], near[1:] - below, near[1:], weights=rng.uniform(0.5, 2.0, n + 2))
        hierarchy = Hierarchy([Level.equality(A[:1], A[:1] @ x), tasks])
        best = hqp.solve(hierarchy).x
        for share in (0.0, 1e-11, 1e-10, 1e-9, 3e-9, 1e-8, 1e-7):
            beside = best + share * float(np.linalg.norm(best)) * rng.standard_normal(n)
            told.append(verdicts(hierarchy, beside, np.zeros(n), f"far out, {share:g} beside"))
    return total(told)


def total(told: list[Counts]) -> Counts:
    points, proved, accepted = map(sum, zip(*told, strict=True))
    return points, proved, accepted


if __name__ == "__main__":
    print(*judge(np.random.default_rng(5)), *judge_shifts(np.random.default_rng(3)))
