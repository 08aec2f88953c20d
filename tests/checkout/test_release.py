"""What a release tells of itself is the same wherever it stands."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import pytest

import hqp
from tasks.drawing.stage import PORT

ROOT = Path(__file__).parents[2]


def test_the_version_is_the_same_everywhere() -> None:
    citation = (ROOT / "CITATION.cff").read_text()
    released = re.findall(r"^## \[(\d\S*)\] - (\S+)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    number, date = released[0]
    assert hqp.__version__ == number
    assert f"\nversion: {number}\n" in citation
    assert f"\ndate-released: {date}\n" in citation


def test_conda_gets_the_bounds_of_pip() -> None:
    """Under the names that conda-forge has for two of them; what it lacks comes by pip."""
    yaml = pytest.importorskip("yaml")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    asked = {*project["dependencies"], *extras["robots"], *extras["live"], f"python{project['requires-python']}"}
    bounds = dict(re.split("(?=>=)", dependency) for dependency in asked if ">=" in dependency)
    other = {"matplotlib": "matplotlib-base", "pin": "pinocchio"}
    expected = {other.get(name, name): bound for name, bound in bounds.items()}
    text = (ROOT / "environment.yml").read_text()
    own = yaml.safe_load(text)
    assert "not verified" in text
    assert (own["name"], own["channels"]) == ("hqp", ["conda-forge"])
    (by_pip,) = [each["pip"] for each in own["dependencies"] if isinstance(each, dict)]
    lines = [each for each in own["dependencies"] if isinstance(each, str)]
    assert {"pip", "--editable ."} <= {*lines, *by_pip}
    assert dict(line.split() for line in [*lines, *by_pip] if ">=" in line) == expected


def test_a_source_distribution_has_what_its_tests_read() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    taken = {each.removeprefix("/") for each in project["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]}
    assert all((ROOT / each).exists() for each in taken)
    read = {
        own for path in Path(__file__).parent.glob("*.py") for own in re.findall(r'ROOT / "([^"/]+)', path.read_text())
    }
    always = {"README.md", "LICENSE", "pyproject.toml", ".gitignore"}
    assert {each for each in read if (ROOT / each).exists()} <= taken | always


def test_a_container_installs_what_there_is() -> None:
    """JSON with a comment, as its readers allow."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    text = (ROOT / ".devcontainer" / "devcontainer.json").read_text()
    comment, _, rest = text.partition("\n")
    own = json.loads(rest)
    assert comment.startswith("// Not verified")
    oldest = project["requires-python"].removeprefix(">=")
    assert own["image"].endswith(f"python:{oldest}")
    (extra,) = re.findall(r"-e '\.\[(\w+)\]'", own["postCreateCommand"])
    assert any(each.startswith("pre-commit") for each in project["optional-dependencies"][extra])
    assert own["forwardPorts"] == [PORT]
    assert list(own["portsAttributes"]) == [str(PORT)]


@pytest.mark.parametrize(
    "name",
    ["CITATION.cff", ".pre-commit-config.yaml", ".github/ISSUE_TEMPLATE/bug.yml", ".github/ISSUE_TEMPLATE/config.yml"],
)
def test_files_of_the_project_can_be_read(name: str) -> None:
    yaml = pytest.importorskip("yaml")
    own = yaml.safe_load((ROOT / name).read_text())
    if name == "CITATION.cff":
        assert {"cff-version", "message", "title", "authors"} <= set(own)
        assert own["license"] == tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["license"]
    if name.endswith("bug.yml"):
        assert {"name", "description", "body"} <= set(own)
        needed = [part["id"] for part in own["body"] if part.get("validations", {}).get("required")]
        assert needed == ["file", "happened", "versions"]
        assert all(part["type"] in {"markdown", "textarea", "input"} for part in own["body"])


def test_addresses_are_added_when_there_are_some() -> None:
    """None is public: a release adds them, and the list of what to do says where."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    told = (ROOT / "RELEASING.md").read_text()
    assert "`[project.urls]` in `pyproject.toml`" in told
    assert all(address.startswith("https://") for address in project.get("urls", {}).values())
