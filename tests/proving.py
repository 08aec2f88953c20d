"""Run by the interpreter: what the compiled certificate accepts, `certify` accepts, at optima and beside them.

``NUMBA_DISABLE_JIT=1 python tests/proving.py`` prints how many points were judged, and how many each of both accepted.
"""

from __future__ import annotations

import numpy as np

import hqp
from hqp import Hierarchy
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


def judge(rng: np.random.Generator) -> tuple[int, int, int]:
    """Points that were judged; accepted by `certify`; and by the compiled certificate, too."""
    points = proved = accepted = 0
    for name in FAMILIES:
        for hierarchy in hierarchies(name, 5, seed=7):
            if hierarchy.n > 8 or hierarchy.find_fault():
                continue
            for x_ref in np.zeros(hierarchy.n), rng.standard_normal(hierarchy.n):
                best = hqp.solve(hierarchy, x_ref=x_ref).x
                for share in BESIDE:
                    x = best + share * max(1.0, float(np.linalg.norm(best))) * rng.standard_normal(hierarchy.n)
                    proof = hqp.certify(hierarchy, x, x_ref)
                    mine = accepts(hierarchy, x, x_ref)
                    assert proof.ok or not mine, f"{name}, {share:g} beside: accepted, and refused: {proof}"
                    points, proved, accepted = points + 1, proved + proof.ok, accepted + mine
    return points, proved, accepted


if __name__ == "__main__":
    print(*judge(np.random.default_rng(5)))
