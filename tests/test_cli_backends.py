"""``hqp validate`` and ``hqp backends`` at the command."""

from __future__ import annotations

import pytest

from tasks.cli import run


def test_backends_lists_all_and_how_to_get_the_rest(capsys: pytest.CaptureFixture[str]) -> None:
    from hqp.backends import BACKENDS

    assert run(["backends"]) == 0
    text = capsys.readouterr().out
    assert "native exact yes the project's own: compiled, exact, warm (the default)" in " ".join(text.split())
    for info in BACKENDS.values():
        assert info.name in text
        if not info.installed:
            assert f"pip install '{info.install}'" in text


def test_validate_prints_both_formulas(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["validate", "--count", "2", "-b", "cascade:proxsuite", "--jobs", "1"]) == 0
    text = capsys.readouterr().out
    assert "Eq. 3.17 (pseudoinverse)" in text
    assert "Eq. 4.8 (pseudoinverse:joint)" in text
    assert "96 solves, every backend inside its class" in text  # 24 cases, two stacks, two formulas


def test_validate_by_case(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["validate", "--count", "1", "-b", "native", "--jobs", "1", "--cases"]) == 0
    assert capsys.readouterr().out.count("30; 6,6,6,30 repeated row") == 2


def test_a_backend_outside_its_class_is_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from hqp import validation

    monkeypatch.setitem(validation.ACCURACY, "exact", 1e-30)
    assert run(["validate", "--count", "1", "-b", "native", "--jobs", "1"]) == 1
    assert "outside their class: native" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["validate", "-b", "nonsense"], "unknown backend 'nonsense'; installed here: "),
        (["validate", "--count", "0"], "'--count'"),
        (["validate", "--count", "many"], "'--count'"),
        (["validate", "--jobs", "0"], "--jobs 0: give a number of processes"),
        (["nonsense"], "nonsense"),
        (["validate", "--nonsense"], "--nonsense"),
    ],
)
def test_wrong_input_is_one_line_and_exit_code_2(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) == 2
    text = capsys.readouterr().err
    assert said in text
    assert text.count("\n") == 1
