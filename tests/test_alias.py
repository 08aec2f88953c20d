"""`hqp_tasks` is `tasks`, also beside a module of that name which is somebody else's."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import hqp_tasks
import tasks

OURS = str(Path(tasks.__file__).parents[1])
PROGRAM = """
import tasks
assert tasks.clean() == "swept"
from hqp_tasks import Controller, OrientationTask, PlanarArm, PositionTask
import hqp_tasks.robots.planar
assert hqp_tasks.robots.planar.PlanarArm is PlanarArm
arm = PlanarArm([0.5, 0.5, 0.5], velocity_limit=2.0)
stack = PositionTask([1.0, 0.2], gain=2.0) >> OrientationTask(0.0, gain=2.0)
step = Controller(arm, stack, backend="pseudoinverse")([1.1, -1.3, -0.7], [0.0, 0.0, 0.0])
print(step.v.tolist())
"""


def test_it_is_the_same_package() -> None:
    for name in tasks.__all__:
        assert getattr(hqp_tasks, name) is getattr(tasks, name)
    from hqp_tasks.robots import planar

    from tasks.robots import planar as own

    assert planar is own
    assert own.__spec__ is not None
    assert own.__spec__.name == "tasks.robots.planar"


def test_it_stands_beside_tasks_of_somebody_elses(tmp_path: Path) -> None:
    (tmp_path / "tasks.py").write_text("def clean(): return 'swept'\n")
    environment = os.environ | {"PYTHONPATH": OURS}
    command = [sys.executable, "-c", PROGRAM]  # which looks into its own folder first
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    arm = tasks.PlanarArm([0.5, 0.5, 0.5], velocity_limit=2.0)
    stack = tasks.PositionTask([1.0, 0.2], gain=2.0) >> tasks.OrientationTask(0.0, gain=2.0)
    step = tasks.Controller(arm, stack, backend="pseudoinverse", damping=None)([1.1, -1.3, -0.7], [0.0, 0.0, 0.0])
    assert step.v is not None
    assert done.stdout.strip() == str(step.v.tolist())


def test_what_is_kept_of_loops_under_one_name_is_not_that_of_the_other(tmp_path: Path) -> None:
    """Compiled loops name their modules: of one source there is a file a name, and neither makes the other stale."""
    (tmp_path / "tasks.py").write_text("def clean(): return 'swept'\n")
    tell = "import {0}.rows.kernels.law as law; of = law.write_law._cache._cache_file"
    tell += "; print(of._source_stamp, of._index_path, of._data_name_pattern)"
    environment, told = os.environ | {"PYTHONPATH": OURS}, []
    for name, folder in ("tasks", Path(OURS)), ("hqp_tasks", tmp_path):
        command = [sys.executable, "-c", tell.format(name)]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=True)
        told.append(done.stdout.split())
    (stamp, index, data), (other_stamp, other_index, other_data) = told
    assert stamp == other_stamp
    assert index != other_index
    assert data != other_data
