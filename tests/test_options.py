"""The options of ``hqp``: numbers are spelled as in files, and stay inside their ends."""

from __future__ import annotations

import pytest
from spelling import Option, numeric

from tasks.cli import run
from tasks.cli.app import app

OPTIONS = numeric(app)


def test_there_are_options_to_check() -> None:
    assert {(own.command, own.name) for own in OPTIONS} >= {
        ("validate", "--count"),
        ("live", "--dt"),
        ("thesis", "--jobs"),
    }


@pytest.mark.parametrize("option", OPTIONS, ids=lambda own: f"{own.command} {own.name}")
def test_what_spells_no_number_or_one_too_large_is_one_line(option: Option, capsys: pytest.CaptureFixture[str]) -> None:
    for word in option.wrong():
        assert run([option.command, f"{option.name}={word}"]) == 2, word
        told = capsys.readouterr().err
        assert option.name in told
        assert repr(word) in told or f" {word} must be at least" in told
        assert told.count("\n") == 1


@pytest.mark.parametrize("option", OPTIONS, ids=lambda own: f"{own.command} {own.name}")
def test_the_help_tells_the_ends(option: Option, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([option.command, "--help"]) == 0
    said = capsys.readouterr().out
    assert option.name in said
    if option.least is not None:
        assert f"x>={option.least:g}" in said or f"{option.least:g}<=x<={option.most:g}" in said
