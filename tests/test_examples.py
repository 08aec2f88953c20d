"""The examples run, without a warning, say something, and stay short."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))
MOST_LINES = 60

#: What each must print, whatever the machine.
SAYS = {
    "01_levels": "NOT optimal: level 1 (sum) falls short",
    "02_planar_arm": "150 of 150 checked ticks certified",
    "03_which_limit": "held back by joint 1 velocity limit (upper)",
    "04_compare_backends": "native                      exact          40/40     40/40",
    "05_joint_limits": "afterwards a joint is at most 0.000000 deg outside",
}


def test_every_example_is_expected():
    assert [path.stem for path in EXAMPLES] == sorted(SAYS)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example(path: Path, tmp_path: Path):
    assert len(path.read_text(encoding="utf-8").splitlines()) < MOST_LINES
    done = subprocess.run(
        [sys.executable, "-W", "error", str(path)], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert SAYS[path.stem] in done.stdout
    assert not list(tmp_path.iterdir()), "an example leaves no files"
