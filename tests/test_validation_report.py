"""The files that ``hqp validate --out`` writes."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from hqp import validation
from hqp.problems import equality_cases
from hqp.validation import KNOWN, PLACES, RELATIONS, SIGMAS, SIZES, TARGETS, report
from tasks.cli import run

NATIVE = ["validate", "--count", "1", "--backend", "native"]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("report") / "new"
    assert run([*NATIVE, "--jobs", "1", "--out", str(out)]) == 0
    return out


def rows(folder: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((folder / report.NUMBERS).read_text(encoding="utf-8").splitlines()))


def test_the_files_appear_whole_and_nothing_else_does(written: Path) -> None:
    assert sorted(path.name for path in written.iterdir()) == sorted(report.FILES)
    assert (written / report.PICTURE).read_bytes().startswith(b"\x89PNG")


def test_the_numbers_are_all_there(written: Path) -> None:
    found = rows(written)
    count = {check: sum(row["check"] == check for row in found) for check in {row["check"] for row in found}}
    formulas = 2
    assert count == {
        "closed form": formulas * len(list(equality_cases())),
        "singular": formulas * len(PLACES) * len(TARGETS) * len(SIGMAS),
        "Eq. 4.8 and strict": len(RELATIONS) + len(PLACES) * len(SIGMAS),
        "random hierarchy": len(SIZES),
        "known answer": len(KNOWN),
    }
    assert {row["ok"] for row in found} == {"True"}
    assert all(float(row["x_most"]) >= 0.0 for row in found if row["check"] != "random hierarchy")


def test_the_text_has_everything_in_it(written: Path) -> None:
    text = (written / report.TEXT).read_text(encoding="utf-8")
    assert "Every backend is inside its class wherever the rank is decidable." in text
    assert f"]({report.PICTURE})" in text
    assert "`rank_tolerance` 1e-09" in text
    assert "numpy" in text
    assert all(answer.name in text for answer in KNOWN)
    assert all(f"| native | {place} |" in text for place in PLACES)
    for line in text.splitlines():
        assert "nan" not in line.split(), line


def test_no_number_depends_on_the_number_of_processes(written: Path, tmp_path: Path) -> None:
    assert run([*NATIVE, "--jobs", "2", "--out", str(tmp_path)]) == 0
    assert rows(tmp_path) == rows(written)


def test_what_is_outside_is_written_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(validation.ACCURACY, "exact", 1e-30)
    assert run([*NATIVE, "--jobs", "1", "--out", str(tmp_path)]) == 1
    assert "outside their class: native" in capsys.readouterr().out
    assert "**Outside their class: native" in (tmp_path / report.TEXT).read_text(encoding="utf-8")
    judged = [row for row in rows(tmp_path) if row["check"] == "singular" and float(row["x_least"]) > 0.0]
    assert {(row["zone"] == "undecidable", row["ok"]) for row in judged} == {(True, "True"), (False, "False")}


def test_known_answers_and_singularities_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*NATIVE, "--jobs", "1"]) == 0
    text = capsys.readouterr().out
    assert "harmonic, n = 20" in text
    assert "Eq. 3.17, singular values from 1 to 1e-14" in text
    assert "…" not in text


@pytest.mark.parametrize(
    ("out", "said"), [("", "it is empty"), ("{file}", "cannot write to the folder"), ("{file}/in", "cannot write")]
)
def test_a_folder_that_cannot_be_is_one_line_and_exit_code_2(
    out: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "file"
    file.write_text("")
    assert run([*NATIVE, "--out", out.format(file=file)]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
