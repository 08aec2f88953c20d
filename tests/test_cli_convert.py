"""``hqp convert`` at the command: the same problem in the other format, and word of what that one has no place for."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hqp
from hqp import Hierarchy, Label, Level, certify, lexls, solve
from hqp.lexls import as_lexls
from hqp.problems import random_hierarchy
from tasks.cli import run

FULL = Hierarchy(
    [
        Level.bounds([-1.0, -1.0], [1.0, np.inf], indices=[0, 2], name="limits"),
        Level.equality([[2.0, 1.0, 0.0]], [4.0], weights=[0.1], name="reach", labels=[Label("reach", "x", "m")]),
        Level.bounds([0.0], [0.3], indices=[1], name="slow"),
    ]
)
PLAIN = Hierarchy([Level([[1.0, 2.0]], 0.1, np.inf, name="one"), Level.equality([[3.0, -0.0]], 1 / 3, name="two")])


@pytest.fixture
def full(tmp_path: Path) -> str:
    hqp.save(tmp_path / "full.npz", FULL, [0.0, 0.5, 0.25])
    return str(tmp_path / "full.npz")


def assert_same(one: Hierarchy, other: Hierarchy) -> None:
    assert one.structure == other.structure
    assert one.numbers.tobytes() == other.numbers.tobytes()
    assert [level.name for level in one.levels] == [level.name for level in other.levels]


@pytest.mark.parametrize("name", ["h.dat", "h.txt", "h.LEXLS", "h"])
def test_what_text_has_no_place_for_is_told(
    name: str, full: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = str(tmp_path / name)
    assert run(["convert", full, target, *(["--to", "lexls"] if name == "h" else [])]) == 0
    assert capsys.readouterr().out == (
        f"wrote {target!r}, lexls: 3 levels, 4 rows, 3 unknowns\n"
        "  not kept: the labels of the rows of level 1\n"
        "  multiplied into their rows: the weights of level 1\n"
        "  made rows of A: the bounds on variables of level 2\n"
        "  written as one more level, 3: x = x_ref\n"
    )
    again = lexls.read(target).hierarchy
    assert_same(again, as_lexls(FULL, [0.0, 0.5, 0.25]))
    assert certify(again, solve(FULL, x_ref=[0.0, 0.5, 0.25]).x).ok


def test_what_is_kept_needs_no_word_and_comes_back_to_the_last_bit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [str(tmp_path / name) for name in ("a.npz", "b.dat", "c.npz")]
    hqp.save(files[0], PLAIN)
    for source, target in pairwise(files):
        assert run(["convert", source, target]) == 0
    assert [line.split(", ", 1)[1] for line in capsys.readouterr().out.splitlines()] == [
        "lexls: 2 levels, 2 rows, 2 unknowns",
        "npz: 2 levels, 2 rows, 2 unknowns",
    ]
    assert Path(files[0]).read_bytes() == Path(files[2]).read_bytes()


def test_guess_and_points_stay_in_text_and_are_left_out_of_npz(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, text, archive = (str(tmp_path / name) for name in ("a.dat", "b.txt", "c.npz"))
    hqp.lexls.write(source, PLAIN, guess=[-1, 2], solution_guess=[0.1, 0.2], solution=[1.0, 2.0])
    assert run(["convert", source, text]) == 0
    assert Path(source).read_bytes() == Path(text).read_bytes()
    assert len(capsys.readouterr().out.splitlines()) == 1
    assert run(["convert", source, archive]) == 0
    assert capsys.readouterr().out.endswith("\n  not kept: the guess of active rows, #SolGuess, #Solution\n")
    assert_same(hqp.load(archive)[0], PLAIN)


@given(st.integers(0, 2**32 - 1))
def test_there_and_back_it_is_the_same_problem(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    folder = tmp_path_factory.getbasetemp()
    source, text, back = (str(folder / name) for name in ("a.npz", "b.dat", "c.npz"))
    h = random_hierarchy(np.random.default_rng(seed))
    hqp.save(source, h)
    assert run(["convert", source, text, "--force"]) == 0
    assert run(["convert", text, back, "--force"]) == 0
    assert certify(hqp.load(back)[0], solve(h).x).ok


def test_a_file_that_exists_is_replaced_by_force_alone(
    full: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "h.dat"
    target.write_text("mine")
    assert run(["convert", full, str(target)]) == 2
    assert capsys.readouterr().err == f"hqp: {str(target)!r} exists; --force replaces it\n"
    assert target.read_text() == "mine"
    assert run(["convert", full, str(target), "--force"]) == 0
    assert len(lexls.read(target).hierarchy.levels) == 4


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["FULL"], "'TARGET'"),
        (
            ["FULL", "h.json"],
            "'h.json' ends with none of .npz, .dat, .txt, .lexls; if it has no suffix, --to npz or --to lexls tells",
        ),
        (["FULL", "h.dat", "--to", "xml"], "'--to'"),
        (["FULL", "h.dat", "--to", "npz"], "path = 'h.dat'; a file of arrays is called .npz, or has no suffix"),
        (
            ["FULL", "h.npz", "--to", "lexls"],
            "a hierarchy as text is called .dat, .txt or .lexls, or has no suffix",
        ),
        (["FULL", ""], "'' ends with none of .npz"),
        (["FULL", "missing/h.dat"], "cannot write "),
        (["missing.npz", "h.dat"], "cannot read "),
        (
            ["BROKEN", "h.npz"],
            "broken.dat' is no hierarchy, or damaged: line 12: found a row of 3; expected one of 4: 2 of A,",
        ),
        (["NAN", "h.dat"], "level 0 ('one'), row 0: A[1] = nan must be finite"),
    ],
)
def test_wrong_input_is_one_line_and_exit_code_2(
    arguments: list[str],
    said: str,
    full: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("broken.dat").write_text("#HierType\n200\n#nVar\n2\n#nObj\n1\n#nCtr\n1\n#ObjType\n200\n#OBJECTIVE 0\n1 2 3\n")
    broken = PLAIN.copy()
    broken.A[0, 1] = np.nan
    hqp.save("nan.npz", broken)
    before = sorted(tmp_path.iterdir())
    names = {"FULL": full, "BROKEN": "broken.dat", "NAN": "nan.npz"}
    assert run(["convert", *(names.get(word, word) for word in arguments)]) == 2
    text = capsys.readouterr().err
    assert said in text
    assert text.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before
