"""The command: its help, its refusals in one line, and ``hqp thesis`` end to end."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import pytest

import hqp
from hqp.commands.terminal import console
from tasks import cli
from tasks.thesis import scenarios


@pytest.fixture
def short_figures(monkeypatch):
    """Every figure in a hundred ticks."""
    coarse = {figure: replace(item, tick=0.6, free_tick=0.6) for figure, item in scenarios.SCENARIOS.items()}
    monkeypatch.setattr(scenarios, "SCENARIOS", coarse)


def test_thesis_end_to_end(short_figures, tmp_path, capsys):
    out = tmp_path / "new" / "folder"
    command = [
        "thesis",
        "--figure",
        "4.7",
        "-f",
        "4.6",
        "-f",
        "4.8",
        "-f",
        "workspace",
        "--jobs",
        "1",
        "--out",
        str(out),
    ]
    assert cli.run(command) == 0
    assert sorted(path.name for path in out.iterdir()) == [
        "claims.csv",
        "claims.md",
        *(
            f"figure-{figure}{kind}"
            for figure in ("4.6", "4.7", "4.8")
            for kind in ("-plain.pdf", "-plain.png", ".png")
        ),
        "runs",
        "workspace.png",
    ]
    rows = (out / "claims.csv").read_text().splitlines()
    assert len(rows) == 1 + 6 + 3 + 3
    printed = capsys.readouterr().out
    assert "both tasks met with maximum accuracy" in printed
    assert f"runs simulated: 15, pictures drawn: 4, all in {out}" in printed


def test_one_law_one_format(short_figures, tmp_path):
    command = [
        "thesis",
        "-f",
        "4.7",
        "--law",
        "damped",
        "-l",
        "strict",
        "--format",
        "svg",
        "-j",
        "1",
        "-o",
        str(tmp_path),
    ]
    assert cli.run(command) == 0
    assert (tmp_path / "figure-4.7.svg").exists()
    laws = {line.split(",")[1] for line in (tmp_path / "claims.csv").read_text().splitlines()[1:]}
    assert laws == {"strict stack", '"strict'}


def test_laws_that_a_backend_cannot_show_are_left_out_aloud(short_figures, tmp_path, capsys):
    assert cli.run(["thesis", "-f", "4.7", "--backend", "pseudoinverse", "-j", "1", "--out", str(tmp_path)]) == 0
    reason = "joint limits: left out, pseudoinverse takes no inequalities"
    assert reason in capsys.readouterr().out
    assert reason in (tmp_path / "claims.md").read_text()


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["thesis", "--figure", "4.99"], "figure '4.99' is unknown; available: 2.1"),
        (["thesis", "--law", "magic"], "law 'magic' is unknown; available: thesis, strict, limits, damped"),
        (["thesis", "--format", "bmp"], "format 'bmp' is unknown; available: png, pdf, svg"),
        (["thesis", "--jobs", "0"], "processes = 0"),
        (["thesis", "--backend", "magic"], "unknown backend 'magic'; installed here: native, pseudoinverse"),
        (["thesis", "--out", "/dev/null/here"], "cannot write to the folder '/dev/null/here'"),
        (["thesis", "--out", ""], "'--out' / '-o': it is empty; the current folder is '.'"),
        (["thesis", "--colour", "red"], "No such option"),
        (["thesis", "extra"], "unexpected extra argument"),
        (["nothing"], "No such command 'nothing'"),
    ],
)
def test_wrong_input_is_one_line_and_exit_code_2(arguments, named, capsys):
    assert cli.run(arguments) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("hqp: ")
    assert told.err.count("\n") == 1
    assert named in told.err


@pytest.mark.parametrize("name", ["figure-4.7.png", "claims.md", "claims.csv"])
def test_a_file_that_cannot_be_written_is_refused_before_anything_is_simulated(name, tmp_path, capsys, monkeypatch):
    from tasks.thesis import report

    monkeypatch.setattr(report, "run", None)
    (tmp_path / name).mkdir()
    assert cli.run(["thesis", "-f", "4.7", "-j", "1", "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err == f"hqp: cannot write {str(tmp_path / name)!r}: Is a directory\n"


def test_a_file_that_is_there_is_overwritten(short_figures, tmp_path):
    (tmp_path / "claims.csv").write_text("old")
    assert cli.run(["thesis", "-f", "4.6", "-j", "1", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "claims.csv").read_text().startswith("figure,")


@pytest.mark.parametrize(("columns", "width"), [(None, 140), ("100", 100), ("0", 140), ("wide", 140)])
def test_a_pipe_is_as_wide_as_columns_says(columns, width, monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    if columns is not None:
        monkeypatch.setenv("COLUMNS", columns)
    assert console(140).width == width


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["backends"], ["thesis", "--help"]])
def test_a_reader_who_leaves_is_no_error(arguments):
    command = subprocess.Popen(
        [sys.executable, "-c", "from tasks.cli import main; main()", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    command.stdout.close()
    assert command.stderr.read() == b""
    command.stderr.close()
    assert command.wait() == 141


def test_an_interruption_is_exit_code_130(monkeypatch, tmp_path, capsys):
    from tasks.thesis import report

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(report, "report", interrupted)
    assert cli.run(["thesis", "--out", str(tmp_path)]) == 130
    assert "interrupted" in capsys.readouterr().err


def test_help_version_and_nothing(capsys):
    assert cli.run(["--help"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("thesis", "validate", "backends"))
    assert cli.run(["--version"]) == 0
    assert capsys.readouterr().out == f"hqp {hqp.__version__}\n"
    assert cli.run([]) == 0
    assert "Usage" in capsys.readouterr().out
    assert cli.run(["thesis", "--help"]) == 0
    told = capsys.readouterr().out
    assert all(name in told for name in ("--figure", "argument", "lines, stacks"))


def test_the_command_imports_little():
    code = "import sys, tasks.cli; print([m for m in ('numba', 'matplotlib', 'scipy', 'rich') if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
    out = subprocess.run([sys.executable, "-c", "from tasks.cli import main; main(['nothing'])"], capture_output=True)
    assert out.returncode == 2
    assert b"Traceback" not in out.stderr
