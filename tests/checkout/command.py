"""The benchmarks' command, called from the checkout."""

from __future__ import annotations

import subprocess
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

from benchmarks.__main__ import app
from hqp.commands import command

ROOT = Path(__file__).parents[2]


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    """In a process of its own, as anybody calls it."""
    return subprocess.run(
        [sys.executable, "-m", "benchmarks", *arguments], capture_output=True, text=True, cwd=ROOT, check=False
    )


def called(*arguments: str) -> subprocess.CompletedProcess[str]:
    """The same in this process, without the second and more that another takes to start."""
    with chdir(ROOT), redirect_stdout(StringIO()) as told, redirect_stderr(StringIO()) as errors:
        code = command.run(app, "python -m benchmarks", arguments)
    return subprocess.CompletedProcess(arguments, code, told.getvalue(), errors.getvalue())


def refused(done: subprocess.CompletedProcess[str], said: str) -> None:
    assert done.returncode == 2
    assert done.stdout == ""  # nothing was measured before
    assert done.stderr.startswith("benchmarks: ")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
