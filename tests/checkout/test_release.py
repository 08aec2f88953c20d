"""What a release tells of itself is the same wherever it stands."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import hqp

ROOT = Path(__file__).parents[2]


def test_the_version_is_the_same_everywhere() -> None:
    citation = (ROOT / "CITATION.cff").read_text()
    released = re.findall(r"^## \[(\d\S*)\] - (\S+)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    number, date = released[0]
    assert hqp.__version__ == number
    assert f"\nversion: {number}\n" in citation
    assert f"\ndate-released: {date}\n" in citation


def test_conda_gets_the_bounds_of_pip() -> None:
    """Under the names that conda-forge has for two of them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    asked = {*project["dependencies"], *extras["robots"], *extras["live"], f"python{project['requires-python']}"}
    bounds = dict(re.split("(?=>=)", dependency) for dependency in asked if ">=" in dependency)
    other = {"matplotlib": "matplotlib-base", "pin": "pinocchio"}
    expected = {other.get(name, name): bound for name, bound in bounds.items()}
    found = dict(re.findall(r"^ +- ([\w-]+) (>=\S+)$", (ROOT / "environment.yml").read_text(), re.M))
    assert found == expected
