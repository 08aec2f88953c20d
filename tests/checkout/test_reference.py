"""The reference: every public name is documented once, with all that it takes, and what its examples show is so."""

from __future__ import annotations

import doctest
import inspect
import re
import sys
from collections import Counter
from enum import Enum
from importlib import import_module
from typing import Any

import pytest
from command import ROOT

sys.path.insert(0, str(ROOT / "docs/_site"))
from constants import constants
from public import NAMESPACES, PARTS, public

NAMES = public()
DOCUMENTED = [name for name in NAMES if inspect.isclass(name.value) or inspect.isroutine(name.value)]
LONGEST_SENTENCE = 160

#: What nobody constructs: results, and bases whose subclasses have examples; and what needs MuJoCo.
WITHOUT_EXAMPLE = {
    *("hqp.BatchSolution", "hqp.Certificate", "hqp.Explanation", "hqp.Solution"),
    *("tasks.IkResult", "tasks.Record", "tasks.Tick", "tasks.FrameTask", "tasks.TargetTask"),
    *("tasks.MujocoPlant", "tasks.RigidContactPlant"),  # which take a robot that stands: docs/contacts.md
}


def text(value: Any) -> str:
    return inspect.getdoc(value) or ""


def taken(value: Any) -> list[str]:
    """The parameters that a user gives by name; of a protocol, an enumeration and an exception none."""
    if inspect.isclass(value) and (getattr(value, "_is_protocol", False) or issubclass(value, Enum | Exception)):
        return []
    parameters = inspect.signature(value.__init__ if inspect.isclass(value) else value).parameters
    return [name for name, each in parameters.items() if each.kind is not each.VAR_KEYWORD and is_given(name)]


def is_given(parameter: str) -> bool:
    return not parameter.startswith("_") and parameter not in {"self", "args"}


def told(docstring: str) -> set[str]:
    """The names that stand with a type, or above an explanation, in the sections of parameters and attributes."""
    found: set[str] = set()
    for section in re.split(r"\n(?=\w[\w ]*\n-{3,}\n)", docstring):
        if section.startswith(("Parameters", "Other Parameters", "Attributes")):
            for line in re.findall(r"^(\S[^\n:]*?)(?: : .+$|$\n(?=    ))", section, re.MULTILINE):
                found.update(word.strip(" *") for word in line.split(","))
    return found


def methods(value: type) -> dict[str, Any]:
    return {
        name: each
        for name, each in vars(value).items()
        if not name.startswith("_") and (inspect.isroutine(each) or isinstance(each, property | classmethod))
    }


def test_every_exported_name_has_one_place():
    counts = Counter(name.path for name in NAMES)
    assert [path for path, count in counts.items() if count > 1] == []
    exported = [getattr(import_module(space), name) for space in NAMESPACES for name in import_module(space).__all__]
    assert all(any(value is name.value for name in NAMES) for value in exported if not inspect.ismodule(value))
    assert {name.part for name in NAMES} == set(PARTS)


def test_the_first_sentence_says_what_it_is():
    """It is short, and no class leaves it to its base."""
    wrong = [name.path for name in DOCUMENTED if inspect.isclass(name.value) and "__doc__" not in vars(name.value)]
    for name in DOCUMENTED:
        paragraph = text(name.value).split("\n\n")[0].replace("\n", " ")
        first = re.split(r"(?<=\w[.)])\s+(?=[A-Z`])", paragraph)[0]
        if not paragraph.endswith((".", ":")) or len(first) > LONGEST_SENTENCE:
            wrong.append(f"{name.path}: {first}")
    assert wrong == []


def test_every_parameter_is_told():
    missing = {
        name.path: [each for each in taken(name.value) if each not in told(text(name.value))] for name in DOCUMENTED
    }
    assert {path: names for path, names in missing.items() if names} == {}


def test_every_method_is_told():
    """An attribute by its own words or by those of its class; a protocol of one attribute by its sentence."""
    missing = []
    for name in DOCUMENTED:
        if inspect.isclass(name.value) and not getattr(name.value, "_is_protocol", False):
            own, by_class = methods(name.value), told(text(name.value))
            missing += [f"{name.path}.{each}" for each in own if not inspect.getdoc(own[each]) and each not in by_class]
    assert missing == []


@pytest.mark.parametrize("part", ["hqp", "tasks", *PARTS])
def test_what_examples_show_is_so(part: str):
    module = import_module(part)
    assert text(module).split("\n\n")[0].endswith(".")
    run(module, part, recurse=False)
    for name in DOCUMENTED:
        if name.part == part:
            run(name.value, name.path)


def test_what_users_construct_has_an_example():
    """Tasks, limits, criteria and obstacles; robots; targets; whatever solves."""
    ours = [name for name in DOCUMENTED if name.namespace in {"hqp", "tasks"} and inspect.isclass(name.value)]
    assert {name.path for name in ours if taken(name.value) and ">>>" not in text(name.value)} == WITHOUT_EXAMPLE


def run(value: Any, path: str, recurse: bool = True) -> None:
    module = import_module(value.__module__) if hasattr(value, "__module__") else value
    for example in doctest.DocTestFinder(recurse=recurse).find(value, path, module=module):
        assert doctest.DocTestRunner().run(example).failed == 0, f"{example.name} shows something else"


def test_constants_have_their_reason():
    found = list(constants())
    assert len(found) > 100
    assert [f"{each.path}: {each.name}" for each in found if not each.about] == []
