"""What ``import hqp`` gives: the public names, imported when asked for, and the former ones with a warning."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from importlib import import_module

import pytest

import hqp
import tasks


def test_public_names_are_there() -> None:
    assert {*hqp.__all__} <= {*dir(hqp)}
    assert all(getattr(hqp, name) is not None for name in hqp.__all__)


@pytest.mark.parametrize("code", ["import hqp", "import hqp; hqp.__version__", "import hqp.commands.command"])
def test_numpy_waits_for_the_first_name(code: str) -> None:
    told = subprocess.check_output([sys.executable, "-c", f"import sys; {code}; print('numpy' in sys.modules)"])
    assert told.split() == [b"False"]


@pytest.mark.parametrize("code", ["from hqp import *; solve, Hierarchy, lexls.read", "import hqp.solver; hqp.solve"])
def test_any_way_to_import_gives_the_names(code: str) -> None:
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("old", hqp._FORMER)
def test_former_names_say_what_is_there_now(old: str) -> None:
    now = hqp._FORMER[old]
    place, _, name = f"hqp.{now}".rpartition(".")
    with pytest.warns(DeprecationWarning, match=rf"^hqp\.{old} is hqp\.{now} now$"):
        assert getattr(hqp, old) is getattr(import_module(place), name)
    assert old not in hqp.__all__


@pytest.mark.parametrize("old", tasks._FORMER)
def test_former_names_of_tasks_say_where_they_are_now(old: str) -> None:
    place, _, name = f"tasks.{tasks._FORMER[old]}".rpartition(".")
    with pytest.warns(DeprecationWarning, match=rf"^tasks\.{old} is {place}\.{name} now$"):
        assert getattr(tasks, old) is getattr(import_module(place), name)
    assert old not in tasks.__all__


def test_a_frame_task_names_the_tasks_of_a_frame() -> None:
    """Whoever knows the class of that name in other libraries is told which one is meant."""
    with pytest.raises(hqp.InvalidInput, match=r"PoseTask.*PositionTask.*OrientationTask"):
        tasks.FrameTask("tool0", position_cost=1.0, orientation_cost=1.0)  # type: ignore[call-arg]


PARTS = [
    name
    for name in tasks.__all__
    if inspect.isclass(getattr(tasks, name)) and issubclass(getattr(tasks, name), tasks.Part)
]


@pytest.mark.parametrize("name", sorted({*PARTS} - {"Part"}))
def test_help_on_a_task_or_limit_tells_every_argument(name: str) -> None:
    """Without a look at another class."""
    own = getattr(tasks, name)
    section = (inspect.getdoc(own) or "").split("Parameters\n----------\n")[1].split("\n\n")[0]
    told = re.findall(r"\w+", " ".join(re.findall(r"^([\w*, ]+?)(?: :.*)?$", section, re.MULTILINE)))
    assert {*inspect.signature(own.__init__).parameters} - {"self"} <= {*told}
    assert "See :class:" not in section


def test_the_former_path_of_the_families() -> None:
    sys.modules.pop("hqp.families", None)
    with pytest.warns(DeprecationWarning, match=r"^hqp\.families is hqp\.problems now$"):
        from hqp.families import hierarchies
    assert hierarchies is hqp.problems.hierarchies


def test_a_name_that_never_was() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = hqp.nothing


def test_former_names_of_methods_say_what_they_are_now() -> None:
    h = hqp.Hierarchy([hqp.Level.bounds(0.0, [1.0], name="box")])
    with pytest.warns(DeprecationWarning, match=r"^Hierarchy\.label is Hierarchy\.level_name now$"):
        assert h.label(0) == h.level_name(0) == "level 0 ('box')"
    task = tasks.PositionTask([1.0, 0.2], gain=2.0, name="hand")
    with pytest.warns(DeprecationWarning, match=r"^PositionTask\.label is PositionTask\.full_name now$"):
        assert task.label() == task.full_name() == "PositionTask 'hand'"
    case = hqp.problems.Case(7, (3, 4), "repeated row")
    with pytest.warns(DeprecationWarning, match=r"^Case\.label is Case\.name now$"):
        assert case.label == case.name == "7; 3,4 repeated row"


def test_the_former_name_of_an_order_says_what_it_is_now() -> None:
    stack, arm = tasks.Stack(tasks.PositionTask([1.0, 0.2], gain=2.0)), tasks.PlanarArm([0.5, 0.5, 0.5])
    with pytest.warns(DeprecationWarning, match=r"^order 'step' is 'displacement' now$"):
        old = stack.build(arm, "step")  # type: ignore[arg-type]
    state = arm.at([0.3, -0.8, 0.5], [0.0, 0.0, 0.0])
    same = old.fill(state, 0.0).lower, stack.build(arm, "displacement").fill(state, 0.0).lower
    assert (same[0] == same[1]).all()


def test_a_part_of_ones_own_that_defines_the_former_label_is_told_so_and_named_by_it():
    with pytest.warns(DeprecationWarning, match=r"^Mine\.label is called full_name now$"):

        class Mine(tasks.PositionTask):
            def label(self) -> str:
                return "mine"

    assert Mine([1.0, 0.2], gain=2.0).full_name() == "mine"
