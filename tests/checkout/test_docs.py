"""The documentation is true: its Python runs and prints what it shows, its commands and its links exist."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest
from command import ROOT, called
from in_python import reasons

from tasks.cli import run

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md"]
#: Why Python writes parts of the stacks of a page; loops write all others.
IN_PYTHON = {
    "extending.md": {"ElbowHeightTask has its own jacobian()", "WallLimit has its own write()"},
    "obstacles.md": {"the distances of its shapes come from Coal"},
    "redundancy.md": {"AwayFrom has its own value()"},
    "robots.md": {"GapTask has its own error()"},
    "survey.md": {"Extremal has its own error()"},
}
BLOCK = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)


def blocks(page: Path) -> list[tuple[str, str, int, bool]]:
    """Language and text of every fenced block, its line, and whether only blank lines part it from the one before."""
    text, found, end = page.read_text(encoding="utf-8"), [], 0
    for match in BLOCK.finditer(text):
        follows = bool(found) and not text[end : match.start()].strip()
        found.append((match[2], dedent(match[3]), text[: match.start(3)].count("\n"), follows))
        end = match.end()
    return found


def trimmed(text: str) -> list[str]:
    return [line.rstrip() for line in text.rstrip().splitlines()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_python_blocks_run_and_print_what_is_shown(page: Path):
    # One namespace a page, as a module: dataclasses look their module up.
    name = f"docs_{page.stem.lower()}"
    module = type(sys)(name)
    sys.modules[name] = module
    space: dict[str, Any] = module.__dict__
    try:
        with reasons() as told:
            _run(page, space)
        assert told == IN_PYTHON.get(page.name, set())
    finally:
        del sys.modules[name]


def _run(page: Path, space: dict[str, Any]) -> None:
    """All Python blocks of a page, one after the other."""
    printed = None
    for language, text, line, follows in blocks(page):
        if language == "python":
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(compile("\n" * line + text, str(page), "exec"), space)
            printed = out.getvalue()
        elif language == "text" and follows and printed is not None:
            assert trimmed(printed) == trimmed(text), f"{page.name}, line {line + 1}"
            printed = None
        else:
            printed = None


def commands() -> list[str]:
    """Every command line of the shell blocks which starts one of ours."""
    lines = []
    for page in PAGES:
        for language, text, _, _ in blocks(page):
            if language in {"bash", "console"}:
                parts = (part.strip().removeprefix("$ ") for line in text.splitlines() for part in line.split("&&"))
                lines += [part for part in parts if part.startswith(("hqp ", "python -m "))]
    return sorted(set(lines))


@cache
def help_text(*command: str) -> str:
    """What ``--help`` of one of our own commands says."""
    if command[0] == "hqp":
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            assert run([*command[1:], "--help"]) == 0, f"{' '.join(command)} is unknown"
        return out.getvalue()
    asked = called(*command[3:], "--help")
    assert asked.returncode == 0, asked.stderr
    return asked.stdout


def test_there_are_commands_to_check():
    assert {"hqp thesis", "python -m pytest"} <= set(commands())


@pytest.mark.parametrize("command", commands())
def test_commands_and_their_options_exist(command: str):
    words = shlex.split(command, comments=True)
    options = [word.partition("=")[0] for word in words if word.startswith("--")]
    if words[0] == "python" and words[2] != "benchmarks":
        assert find_spec(words[2]) is not None
        return
    name = 1 if words[0] == "hqp" else 3
    ours = (*words[:name], *(word for word in words[name : name + 1] if not word.startswith("-")))
    for option in options:
        assert re.search(rf"{option}\b", help_text(*ours)), f"{' '.join(ours)} has no {option}"
    assert help_text(*ours)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path):
    for target, heading in re.findall(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]+))?\)", page.read_text(encoding="utf-8")):
        place = page.parent / target if target else page
        assert place.exists(), f"{page.name} links to {target}"
        if heading:
            titles = re.findall(r"^#+ (.*)$", place.read_text(encoding="utf-8"), re.MULTILINE)
            anchors = {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}
            assert heading in anchors, f"{page.name} links to {target}#{heading}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_formulas_survive_markdown(page: Path):
    r"""Some readers of Markdown take the backslash from ``\{``, ``\,`` or ``\#``; others know no ``\operatorname``."""
    text = re.sub(r"`[^`\n]*`", "", BLOCK.sub("", page.read_text(encoding="utf-8")))
    formulas = re.findall(r"\$\$.*?\$\$|\$[^$\n]+\$", text, re.DOTALL)
    assert not [formula for formula in formulas if re.search(r"\\[{},#!;:]|\\operatorname", formula)]
    assert "$" not in re.sub(r"\$\$.*?\$\$|\$[^$\s]\$|\$[^$\s][^$\n]*[^$\s]\$", "", text, flags=re.DOTALL), "a stray $"
