"""NUMBA_DISABLE_JIT=1: the interpreter runs the loops, and writes the rows that the compiler's do."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import proving
import pytest
import rows_of_all

INTERPRETED = {**os.environ, "NUMBA_DISABLE_JIT": "1"}


def run(*command: str, env: dict[str, str] = INTERPRETED) -> str:
    done = subprocess.run([sys.executable, "-W", "error", *command], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("states", [2, pytest.param(20, marks=pytest.mark.sweep)])
def test_the_interpreter_writes_the_same_rows(tmp_path: Path, states: int) -> None:
    """Each in a process of its own: other tests set numbers of parts that are shared."""
    for name, env in ("theirs", INTERPRETED), ("mine", dict(os.environ)):
        run(rows_of_all.__file__, str(tmp_path / f"{name}.npz"), str(states), env=env)
    theirs, mine = np.load(tmp_path / "theirs.npz"), np.load(tmp_path / "mine.npz")
    assert set(theirs.files) == set(mine.files)
    assert {(name.split(",")[0], name.split(", ")[-2]) for name in mine} == {
        (robot, order) for robot in ("arm", "panda", "tiago", "g1") for order in rows_of_all.ORDERS
    }
    problems = []
    for name, numbers in mine.items():
        most = max(1.0, np.abs(numbers, where=np.isfinite(numbers), out=np.zeros_like(numbers)).max())
        near = most * (1e-12 if name.endswith("exact") else 1e-6)
        if not np.allclose(theirs[name], numbers, rtol=0.0, atol=near, equal_nan=True):
            with np.errstate(invalid="ignore"):  # inf less inf
                problems.append(f"{name}: {np.nanmax(np.abs(theirs[name] - numbers)) / most:.1e}")
    assert not problems, "\n".join(problems)


def test_the_interpreter_proves_what_is_proved_compiled(tmp_path: Path) -> None:
    """At optima of what breaks solvers, and beside them: the same verdicts, and the same numbers to round-off."""
    points = [
        point for point in (*proving.of_families(2, 8), *proving.far_out(10)) if proving.expected(point) is not None
    ]
    assert len(points) > 200
    kept, out = tmp_path / "points", tmp_path / "told"
    kept.write_bytes(pickle.dumps([tuple(point) for point in points]))
    run(proving.__file__, str(kept), str(out))
    off = []
    for point, (failed, numbers, multipliers) in zip(points, pickle.loads(out.read_bytes()), strict=True):
        mine = proving.told(point)
        assert (mine[0] is None) == (failed is None), point.name
        h = point.hierarchy
        size = float((h.row_norms() * h.weights).max(initial=1.0)) * (1.0 + float(np.linalg.norm(point.x)))
        for (residual, *_), (other, *_) in zip(mine[1], numbers, strict=True):
            assert abs(residual - other) <= 1e-12 * (residual + size), point.name
        for some, others in zip(mine[2], multipliers, strict=True):
            off.append(float(np.linalg.norm(some - others)) / (1e-12 + float(np.linalg.norm(some))))
    assert np.quantile(off, 0.9) <= 1e-9  # the others are of rows that nearly depend on each other


def test_a_controller_and_its_solver_work_and_all_is_ready_at_once() -> None:
    code = """
import numpy as np
from hqp import FixedDamping, Solver
from hqp.problems import hierarchies
from tasks import Controller, Damped, JointLimits, PlanarArm, PositionTask, PostureTask
from tasks.cli import run
assert run(["warmup"]) == 0
arm = PlanarArm([0.5, 0.4, 0.3], position_limit=(-2.0, 2.0), velocity_limit=1.0)
tip = PositionTask([0.6, 0.3], gain=2.0)
for task in tip, Damped(tip, FixedDamping(0.1)):
    controller = Controller(arm, JointLimits() >> task >> PostureTask(np.zeros(3), gain=1.0), dt=0.01)
    for t in range(3):
        step = controller(np.array([0.3, 0.7, 0.4]) + 0.01 * t, np.zeros(3))
        assert step.ok and step.solution.certify().ok
    for nowhere in np.nan, np.inf:
        assert not controller(np.full(3, nowhere), np.zeros(3)).ok
for name in "vertex", "thin slab":
    solver = Solver("native")
    assert all(solver.solve(hierarchy).certify().ok for hierarchy in hierarchies(name, 3, seed=0))
"""
    assert run("-c", code) == "the interpreter runs all kernels, as NUMBA_DISABLE_JIT asks for: nothing is compiled\n"
