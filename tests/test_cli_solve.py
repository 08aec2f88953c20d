"""``hqp solve`` at the command: the answer to a hierarchy from a file, with proof or with exit code 1."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import hqp
from hqp import Hierarchy, Level
from tasks.cli import run


def example(**names: str) -> Hierarchy:
    return Hierarchy(
        [
            Level.bounds([-1.0] * 3, [1.0] * 3, name="limits"),
            Level.equality([[2.0, 1.0, 0.0]], [4.0], name="reach"),
            Level.equality([[0.0, 1.0, 0.0]], [1 / 3], name=names.get("last", "posture")),
        ]
    )


@pytest.fixture
def file(tmp_path: Path) -> str:
    hqp.save(tmp_path / "h.npz", example())
    return str(tmp_path / "h.npz")


def cells(text: str, first: str) -> list[str]:
    """The line of a table that begins so."""
    (line,) = (line for line in text.splitlines() if line.strip().startswith(first))
    return line.split()


def close(words: str | list[str], expected: list[float]) -> bool:
    """Whether numbers, as they are printed, are these but for round-off."""
    found = [float(word) for word in (words.strip("[]").split(",") if isinstance(words, str) else words)]
    return len(found) == len(expected) and np.allclose(found, expected, rtol=1e-5, atol=1e-9)


def line_of(text: str, first: str) -> str:
    """The rest of the line that begins so."""
    (line,) = (line.removeprefix(first) for line in text.splitlines() if line.startswith(first))
    return line


def test_it_prints_status_levels_x_and_certificate(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["solve", file]) == 0
    text = capsys.readouterr().out
    solution = hqp.solve(example())
    assert text.startswith(f"{hqp.DEFAULT_BACKEND}: optimal\n")
    assert close(cells(text, "level 0 ('limits')")[3:], [3, 0, 0, 2])  # rows, residual, rank, at a bound
    assert close(cells(text, "level 1 ('reach')")[3:], [1, 1, 1, 0])
    assert close(cells(text, "level 2 ('posture')")[3:], [1, 2 / 3, 1, 0])
    assert f"\n{solution.explain()}\n" in text
    assert "reach short by 1: x[0] limits (upper), then x[1] limits (upper)\n" in text
    x = [float(number) for number in line_of(text, "x = ").strip("[]").split(",")]
    np.testing.assert_array_equal(x, solution.x)  # every digit
    assert text.rstrip().endswith(str(solution.certify()))


def test_an_answer_that_is_not_certified_is_exit_code_1(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["solve", file, "--backend", "pseudoinverse"]) == 1
    text = capsys.readouterr().out
    assert text.startswith("pseudoinverse: unsupported, level 0 ('limits'), row 0 is an inequality")
    assert "NOT optimal: level 1 (reach) falls short" in text


def test_numbers_that_mean_nothing_are_named_and_exit_code_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    h = example()
    h.levels[1].A[0, 2] = np.nan
    hqp.save(tmp_path / "h.npz", h)
    said = "invalid, level 1 ('reach'), row 0: A[2] = nan must be finite"
    assert run(["solve", str(tmp_path / "h.npz")]) == 1
    assert capsys.readouterr().out == f"{hqp.DEFAULT_BACKEND}: {said}\n"
    assert run(["solve", str(tmp_path / "h.npz"), "-b", "cascade:osqp", "-b", "pseudoinverse"]) == 1
    text = capsys.readouterr().out
    assert cells(text, "cascade:osqp  ") == ["cascade:osqp", "invalid", "NO"]
    assert f"pseudoinverse: {said}\n" in text


def test_several_backends_are_compared_a_line_each(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["solve", file, "-b", "cascade:proxsuite", "-b", "cascade:qpsolvers/proxqp"]) == 0
    text = capsys.readouterr().out
    for name in "cascade:proxsuite", "cascade:qpsolvers/proxqp":
        assert cells(text, name)[:3] == [name, "optimal", "yes"]
        assert close(cells(text, name)[3:], [0, 1, 2 / 3])
    assert "residual norms of level 0 ('limits'), level 1 ('reach'), level 2 ('posture')" in text
    assert run(["solve", file, "-b", "cascade:proxsuite", "-b", "pseudoinverse"]) == 1
    text = capsys.readouterr().out
    assert cells(text, "pseudoinverse  ")[1:4] == ["unsupported", "NO", "0"]  # it gives x_ref back
    assert "pseudoinverse: unsupported, level 0 ('limits'), row 0" in text


def test_x_ref_is_the_one_of_the_file_unless_another_is_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    hqp.save(tmp_path / "h.npz", example(), [0.0, 0.0, 0.25])
    assert run(["solve", str(tmp_path / "h.npz")]) == 0
    text = capsys.readouterr().out
    assert line_of(text, "x_ref = ") == "[0.0, 0.0, 0.25]"
    assert close(line_of(text, "x = "), [1.0, 1.0, 0.25])
    assert run(["solve", str(tmp_path / "h.npz"), "--x-ref", "-1,0,-0.5"]) == 0
    text = capsys.readouterr().out
    assert line_of(text, "x_ref = ") == "[-1.0, 0.0, -0.5]"
    assert close(line_of(text, "x = "), [1.0, 1.0, -0.5])


def test_names_of_others_are_printed_and_do_nothing_else(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hqp.save(tmp_path / "h.npz", example(last="[red]\x1b[31m \ud800 \u03c6"))
    for more in [], ["-b", "cascade:proxsuite", "-b", "cascade:osqp"]:
        assert run(["solve", str(tmp_path / "h.npz"), *more]) == 0
        assert r"[red]\x1b[31m \ud800 φ" in capsys.readouterr().out


def text(tmp_path: Path, *optimum: float) -> str:
    """The example in the text format of LexLS, with an optimum that somebody claims."""
    path = tmp_path / "h.dat"
    hqp.lexls.write(path, example(), solution_guess=[1.0, 1.0, 2.0], solution=optimum)
    return str(path)


def test_a_text_file_is_solved_like_an_archive(file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["solve", file]) == 0
    archive = capsys.readouterr().out
    assert run(["solve", text(tmp_path, 1.0, 1.0, 0.0)]) == 0
    more = re.fullmatch(
        r"#SolGuess: (\S+) from the x of native\n#Solution: certified; (\S+) from the x of native\n",
        capsys.readouterr().out.removeprefix(archive),
    )
    assert more
    assert close([*more.groups()], [2, 0])


@pytest.mark.parametrize(
    ("optimum", "said"),
    [
        ((1.0, 1.0, 0.5), "certified at all 3 levels of the file, which leave x free; 0.5 from the x of native"),
        ((1.0, 0.0, 0.0), "NOT optimal: level 1 (reach) falls short, its residual 2 could be lower by up to"),
        ((2.0, 0.0, 0.0), "NOT optimal: level 0 (limits) falls short, its residual 1 could be lower by up to"),
    ],
)
def test_the_solution_of_a_file_is_put_to_the_certificate(
    optimum: tuple[float, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for more in [], ["-b", "native", "-b", "cascade:proxsuite"]:
        assert run(["solve", text(tmp_path, *optimum), *more]) == 0  # ours are certified, whatever theirs is
        assert f"\n#Solution: {said}" in capsys.readouterr().out


def test_the_solution_of_a_file_is_judged_with_the_x_ref_that_is_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["solve", text(tmp_path, 1.0, 1.0, 0.5), "--x-ref", "0,0,0.5"]) == 0
    told = re.search(r"#Solution: certified; (\S+) from the x of native\n$", capsys.readouterr().out)
    assert told
    assert close([told[1]], [0])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["missing.npz"], "missing.npz': No such file"),
        ([__file__], "is no hierarchy, or damaged: line 1: found "),
        ([""], "path = '' must be the name of a file"),
        ([], "'FILE'"),
        (["FILE", "-b", "nonsense"], "unknown backend 'nonsense'; installed here: "),
        (["FILE", "--x-ref", "1,2"], "x_ref has shape (2,); it must be (3,)"),
        (["FILE", "--x-ref", "left"], "--x-ref 'left': give numbers with commas between them, as in 0.5,0,-1"),
    ],
)
def test_wrong_input_is_one_line_and_exit_code_2(
    arguments: list[str], said: str, file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["solve", *(file if word == "FILE" else word for word in arguments)]) == 2
    text = capsys.readouterr().err
    assert said in text
    assert text.count("\n") == 1
