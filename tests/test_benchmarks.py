"""The benchmarks run, measure what they say, and refuse what they cannot."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import __main__ as command
from benchmarks.families import FAMILIES
from benchmarks.measure import measure

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
        (("-b", "pseudoinverse", "-f", "mixed"), "nothing to measure; mixed: left out, pseudoinverse takes no inequal"),
        (
            ("-b", "pseudoinverse:joint"),
            "equalities: left out, pseudoinverse:joint aims at the optimum of another hier",
        ),
        (("--count", "0"), "'--count'"),
        (("--count", "-1"), "'--count'"),
        (("--count", "abc"), "'--count'"),
        (("--seed", "-1"), "'--seed'"),
        (("extra",), "unexpected extra argument"),
        (("--out", ""), "'--out' / '-o': it is empty"),
        (("--out", "/dev/null/here/table.csv"), "cannot write to the folder '/dev/null/here': "),
        (("--out", "."), "cannot write '.': Is a directory"),
        (("-b", "nonsense"), "unknown backend 'nonsense'; installed here: "),
        (("-f", "nonsense"), "unknown family 'nonsense'; there are equalities, mixed"),
    ],
)
def test_wrong_input_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    done = run("-n", "1", *arguments)
    assert done.returncode == 2
    assert done.stdout == ""  # nothing was measured before
    assert done.stderr.startswith("benchmarks: ")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_family_that_no_backend_takes_is_left_out_aloud() -> None:
    done = run("-n", "1", "-b", "pseudoinverse")
    assert done.returncode == 0, done.stderr
    assert "mixed: left out, pseudoinverse takes no inequalities" in done.stdout
    assert "equalities: the shapes" in done.stdout
    assert measure(FAMILIES[1], ["pseudoinverse"], 3, 0) == []


def test_an_interruption_is_exit_code_130(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "measure", interrupted)
    monkeypatch.setattr("sys.argv", ["benchmarks", "-n", "1"])
    with pytest.raises(SystemExit) as leaving:
        command.main()
    assert leaving.value.code == 130
    assert capsys.readouterr().err.endswith("benchmarks: interrupted; what was finished is kept\n")
