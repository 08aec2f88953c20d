"""A user's program with types: what a controller gives is known by its order."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import tasks

PROGRAM = """
import numpy as np
from numpy.typing import NDArray

from tasks import Controller, OrientationTask, PlanarArm, PositionTask

arm = PlanarArm([0.5, 0.5, 0.5])
stack = PositionTask([1.0, 0.2], gain=2.0) >> OrientationTask(0.0, gain=2.0)
q, v = np.zeros(3), np.zeros(3)
speed: NDArray[np.float64] = Controller(arm, stack)(q, v).v
a: NDArray[np.float64] = Controller(arm, stack, order="acceleration", dt=0.01)(q, v).a
tau: NDArray[np.float64] = Controller(arm, stack, order="torque", dt=0.01)(q, v).tau
none: None = Controller(arm, stack)(q, v).a


def run(any_of_them: Controller) -> NDArray[np.float64]:
    return np.asarray(any_of_them(q, v).v)
"""


def test_steps_are_typed_by_the_order(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    (tmp_path / "program.py").write_text(PROGRAM)
    environment = os.environ | {"MYPYPATH": str(Path(tasks.__file__).parents[1])}
    command = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--no-error-summary"]
    done = subprocess.run([*command, "program.py"], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.stdout + done.stderr == ""
