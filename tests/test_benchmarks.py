"""The benchmarks run, measure what they say, and refuse what they cannot."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "benchmarks", *arguments], capture_output=True, text=True, cwd=ROOT, check=False
    )


def test_a_small_run_fills_table_and_csv(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "table.csv"
    done = run("-n", "4", "-b", "pseudoinverse", "-b", "cascade:proxsuite", "-b", "cascade:osqp", "-o", str(out))
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert [(row["family"], row["backend"]) for row in rows] == [
        ("equalities", "pseudoinverse"),
        ("equalities", "cascade:proxsuite"),
        ("equalities", "cascade:osqp"),
        ("mixed", "cascade:proxsuite"),
        ("mixed", "cascade:osqp"),
    ]
    for row in rows:
        assert row["certified"] == row["rejected"] == "100.00%"
        assert float(row["cold us"]) > 0
        assert row["backend"] in done.stdout
    assert {row["ratio"] for row in rows if row["backend"] == "cascade:proxsuite"} == {"1.00"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-b", "nonsense"), "unknown backend 'nonsense'; installed here: "),
        (("-f", "nonsense"), "unknown family 'nonsense'; there are equalities, mixed"),
    ],
)
def test_wrong_input_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    done = run("-n", "1", *arguments)
    assert done.returncode == 2
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
