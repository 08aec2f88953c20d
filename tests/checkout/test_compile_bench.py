"""The bench of compiling: what was measured fills the table, and what it refuses."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from command import called, refused

from benchmarks import compile as bench


def test_a_program_is_compiled_once_and_then_found(tmp_path: Path) -> None:
    """A kernel of one line stands for the library, and notes whether it was found."""
    (tmp_path / "one.py").write_text("import numba\n\n@numba.njit(cache=True)\ndef one():\n    return 1\n")
    program = "from one import one\none()\nprint(sum(one.stats.cache_hits.values()), file=open('found', 'a'))\n"
    first, cached = bench._spent(program, tmp_path)
    assert (tmp_path / "found").read_text().split() == ["0"] + ["1"] * bench.STARTS
    assert min(first, cached) > 0


def test_the_table_is_filled_and_told_with_ratios(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench, "_spent", lambda program, tree: (6.0, 0.5) if tree == bench.HERE else (4.0, 1.0))
    out = tmp_path / "compile.csv"
    bench.compile_(program=["solve", "tick"], rounds=2, against=tmp_path, out=out)
    for row, name in zip(csv.DictReader(out.read_text().splitlines()), ("solve", "tick"), strict=True):
        assert row == {
            "name": name,
            "first": "6.00",
            "first, theirs": "4.00",
            "first, ratio": "1.50",
            "cached": "0.50",
            "cached, theirs": "1.00",
            "cached, ratio": "0.50",
        }


def test_what_it_refuses(tmp_path: Path) -> None:
    refused(called("compile", "-p", "run"), "unknown program 'run'; there are solve, tick, warmup")
    with pytest.raises(bench.InvalidInput, match="the program failed: ZeroDivisionError"):
        bench._started("1 / 0", tmp_path, str(tmp_path))
