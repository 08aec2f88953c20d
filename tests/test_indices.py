"""No kernel counts from the end: indices are compiled unasked, and asked of when HQP_TRAP_INDICES=1."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

KERNEL = """
import sys
import numpy as np
from hqp.kernels.compile import entry

@entry
def entry_before(x, k):
    return x[k - 1]

print(entry_before(np.arange(3.0), int(sys.argv[1])))
"""
#: The tests that together run all kernels.
ALL_KERNELS = [
    "test_curved*.py", "test_damped*.py", "test_native*.py", "test_controller.py", "test_contact*.py",
    "test_criteria*.py", "test_collisions.py", "test_obstacle*.py", "test_limits*.py", "test_tasks.py", "test_ik.py",
    "test_curvature.py", "test_certificate.py", "test_claims.py", "test_live.py", "test_kernels_*.py",
    "test_symmetric.py", "test_batch.py", "test_cascade.py", "test_jacobians.py",
]  # fmt: skip


def trapped(*command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run Python with kernels that end the process at an index from the end, and are kept in this folder."""
    environment = os.environ | {"HQP_TRAP_INDICES": "1", "NUMBA_CACHE_DIR": str(folder / "cache")}
    return subprocess.run([sys.executable, *command], env=environment, capture_output=True, text=True)


def test_an_index_from_the_end_ends_the_process(tmp_path: Path) -> None:
    """So that the following test can fail."""
    (tmp_path / "kernel.py").write_text(KERNEL)
    done = trapped(str(tmp_path / "kernel.py"), "2", folder=tmp_path)
    assert (done.returncode, done.stdout) == (0, "1.0\n"), done.stderr
    assert trapped(str(tmp_path / "kernel.py"), "0", folder=tmp_path).returncode != 0


@pytest.mark.sweep
def test_no_index_counts_from_the_end(tmp_path: Path) -> None:
    here = Path(__file__).parent
    tests = sorted({str(path) for pattern in ALL_KERNELS for path in here.glob(pattern)})
    done = trapped("-m", "pytest", "-q", "-n", "2", "-p", "no:cacheprovider", *tests, folder=tmp_path)
    assert done.returncode == 0, done.stdout[-4000:]
