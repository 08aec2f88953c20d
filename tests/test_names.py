"""The suffix of a file's name promises a format: whatever writes a file keeps the promise, or refuses the name."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import hqp
import tasks
from hqp import Hierarchy, InvalidInput, Level
from tasks import Controller, JointLimits, PlanarArm, PositionTask, Record, simulate
from tasks.robots.stick_figure import stick_figure
from tasks.view.session import Session

ARM = PlanarArm([0.5, 0.4], position_limit=(-3.0, 3.0))
HIERARCHY = Hierarchy([Level.equality(np.eye(2), [1.0, 2.0])])
#: How files of each suffix begin; a name without one promises nothing.
BEGINS = {
    ".npz": b"PK",
    ".dat": b"# A hier",
    ".html": b"<!",
    ".png": b"\x89PNG",
    ".csv": b",",
    ".jpg": b"\xff",
    "": b"",
}
ALSO = {".txt": ".dat", ".lexls": ".dat", ".htm": ".html", ".NPZ": ".npz", ".HTM": ".html", ".PNG": ".png"}
SUFFIXES = (*BEGINS, *ALSO, ".npz.bak", ".pdf", ".html~")


def controller() -> Controller:
    return Controller(ARM, JointLimits() >> PositionTask([0.5, 0.2], gain=1.0), dt=0.01)


def record() -> Record:
    return simulate(controller(), [0.3, 0.4], duration=0.02)


def session(path: Path) -> None:
    live = Session(controller(), [0.3, 0.4], certify=0)
    live.record()
    live.step()
    live.save(path)


def picture(path: Path) -> None:
    robot = tasks.load_robot("ur5")
    stick_figure(path, robot, robot.home)


#: All that writes a file of a name that it is given, and one suffix that it must take.
WRITERS: dict[str, tuple[Callable[[Path], object], str, str]] = {
    "hqp.save": (lambda path: hqp.save(path, HIERARCHY), ".npz", ""),
    "hqp.lexls.write": (lambda path: hqp.lexls.write(path, HIERARCHY), ".dat", ""),
    "tasks.Record.save": (lambda path: record().save(path), ".npz", ""),
    "tasks.Record.save_html": (lambda path: record().save_html(path, rate=10), ".html", "viser"),
    "Session.save": (session, ".npz", "viser"),
    "stick_figure": (picture, ".png", "pinocchio"),
}


def refusal(write: Callable[[], object]) -> str | None:
    try:
        write()
    except InvalidInput as refused:
        return str(refused)
    return None


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", WRITERS)
def test_a_suffix_is_kept_or_refused(name: str, suffix: str, tmp_path: Path) -> None:
    write, own, package = WRITERS[name]
    if package:
        pytest.importorskip(package)
    path = tmp_path / f"file{suffix}"
    if suffix == own or (refused := refusal(lambda: write(path))) is None:
        write(path)
        assert path.read_bytes().startswith(BEGINS[ALSO.get(suffix, suffix)])
        return
    assert f"path = {str(path)!r}; " in refused
    assert f"is called {own}" in refused
    assert list(tmp_path.iterdir()) == []


def test_these_are_all_writers_that_are_public() -> None:
    spaces = {"hqp": hqp, "hqp.lexls": hqp.lexls, "tasks": tasks}
    found = {f"{space}.{name}": getattr(module, name) for space, module in spaces.items() for name in module.__all__}
    for place, own in list(found.items()):
        if inspect.isclass(own):
            found |= {f"{place}.{name}": each for name, each in vars(own).items() if inspect.isfunction(each)}
    takes = {
        place for place, own in found.items() if inspect.isroutine(own) and "path" in inspect.signature(own).parameters
    }
    assert takes - {"hqp.load", "hqp.lexls.read"} == {name for name in WRITERS if name.startswith(("hqp", "tasks"))}
