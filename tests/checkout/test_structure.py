"""The structure that the project keeps: few files and folders, no circle, no upward import, functions on one screen."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from structure import ROOT, layers, structure

MOST_ENTRIES, ONE_SCREEN = 20, 60
LAYOUT = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("package", ["hqp", "tasks"])
def test_few_files_and_folders_in_one_direction(package: str) -> None:
    found = structure(package)
    assert len(found.entries) <= MOST_ENTRIES
    assert found.upward == []


@pytest.mark.parametrize("package", ["hqp", "tasks", "benchmarks"])
def test_no_circles_and_functions_on_one_screen(package: str) -> None:
    found = structure(package)
    assert found.circles == []
    assert found.long_functions == []


@pytest.mark.parametrize("package", ["hqp", "tasks"])
def test_the_source_layout_has_all_folders_in_the_order_of_the_contract(package: str) -> None:
    section = LAYOUT.split(f"## {package}/", 1)[1].split("## ", 1)[0]
    cells = re.findall(r"^\| (`[^|]*`) \|", section, re.MULTILINE)
    named = [name for cell in cells for name in re.findall(r"`(\w+)`", cell)]
    folders = [path.name for path in (ROOT / package).iterdir() if (path / "__init__.py").exists()]
    assert sorted(named) == sorted(folders)
    down = [layers(package, ROOT)[name] for name in named]
    assert down == sorted(down)


def test_the_source_layout_is_one_screen_of_paths_that_exist() -> None:
    assert LAYOUT.count("\n") <= ONE_SCREEN
    paths = re.findall(r"`((?:tasks|hqp|tests)/[\w/]+\.py)`", LAYOUT)
    assert len(paths) >= 6
    assert [path for path in paths if not (ROOT / path).exists()] == []


def test_faults_are_found(tmp_path: Path) -> None:
    """A package with one of each, and the contract that says so."""
    house = tmp_path / "house"
    house.mkdir()
    (tmp_path / "pyproject.toml").write_text(
        '[[tool.importlinter.contracts]]\ncontainers = ["house"]\nlayers = ["roof", "left | right", "floor"]\n'
    )
    files = {
        "__init__": "",
        "roof": "from . import left",
        "left": "def f():\n    from .roof import x",
        "right": "from house.left import y",
        "floor": "def long():\n" + "    pass\n" * 80 + "\n" * 300,
    }
    for name, text in files.items():
        (house / f"{name}.py").write_text(text)
    found = structure("house", tmp_path)
    assert found.entries == ["floor", "left", "right", "roof"]
    assert found.circles == [["house.left", "house.roof"]]
    assert found.upward == [("house.left", "house.roof"), ("house.right", "house.left")]
    assert found.long_functions == [("house.floor.long", 81)]
    assert found.long_files == [("house.floor", 381)]
