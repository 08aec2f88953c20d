"""``hqp warmup`` at the command: compiled once, found afterwards, and what happened told in one line."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from hqp.kernels import curved, damped, judge, solver
from tasks.cli import run
from tasks.rows.kernels import law


def test_what_is_compiled_is_found_and_its_place_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["warmup"]) == 0
    told = capsys.readouterr()
    kernels = {
        "certificate": judge.judge,
        "native": solver.solve,
        "damped": damped.solve_damped,
        "curved": curved.solve_curved,
        "rows": law.write_law,
    }
    for (name, kernel), line in zip(kernels.items(), told.out.splitlines(), strict=True):
        folder = re.escape(str(kernel.stats.cache_path))
        assert re.fullmatch(rf"{name}: already compiled, ready in \d+\.\d s; kept in {folder}", line)
    assert told.err == ""


def test_a_solver_that_cannot_be_kept_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    unkept = SimpleNamespace(signatures=["int64(int64, int64)"], stats=SimpleNamespace(cache_path=None))
    monkeypatch.setattr(solver, "solve", unkept)
    assert run(["warmup"]) == 0
    told = capsys.readouterr().out.splitlines()[1]
    assert told.endswith("s; not kept: no folder can be written to, or this Numba has no stamp for what is kept")


@pytest.mark.sweep
def test_an_empty_folder_is_filled_once(tmp_path: Path) -> None:
    """In processes of their own: this one has the solver already."""
    done = [
        subprocess.run(
            [sys.executable, "-c", "from tasks.cli import main; main()", "warmup"],
            env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
            capture_output=True,
            text=True,
            check=True,
        )
        for _ in range(2)
    ]
    names = "certificate", "native", "damped", "curved", "rows"
    for one, said in zip(done, ("compiled", "already compiled, ready"), strict=True):
        for name, line in zip(names, one.stdout.splitlines(), strict=True):
            assert re.fullmatch(rf"{name}: {said} in \d+\.\d s; kept in {re.escape(str(tmp_path))}.*", line)
    for what, line in zip(
        ("the certificate", "the native solver", "damped levels", "curved levels", "the rows of tasks"),
        done[0].stderr.splitlines(),
        strict=True,
    ):
        assert line.startswith(f"hqp: compiling {what}, once ")
    assert done[1].stderr == ""
    assert list(tmp_path.rglob("*.nbc"))
