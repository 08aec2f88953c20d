"""The bench of the parts: every stack is solved, ratios are against what it says, another checkout takes turns."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from command import ROOT, called, refused

pytest.importorskip("pinocchio")

from benchmarks.ticks.parts import DT, KINDS, ORDERS, PLAIN, Order, Scene
from tasks import Controller


@pytest.mark.parametrize("order", ORDERS)
def test_every_kind_has_an_optimal_tick(order: Order) -> None:
    for kind in KINDS:
        if order in kind.orders:
            scene = Scene(order)
            controller = Controller(scene.robot, kind.declare(scene), order=order, dt=DT, damping=None)
            step = controller(scene.robot.home, np.zeros(scene.robot.nv), 0.1)
            assert step.ok, kind.name
            assert step.solution.certify().ok, kind.name


def test_names_of_kinds_are_unique() -> None:
    names = [kind.name for kind in KINDS]
    assert len(set(names)) == len(names)
    assert KINDS[0] is PLAIN


def test_a_few_ticks_of_two_checkouts_fill_the_table(tmp_path: Path) -> None:
    out = tmp_path / "parts.csv"
    few = ("--ticks", "2", "--rounds", "2", "--poses", "1", "-p", "axis", "-p", "minimum torque")
    done = called("parts", *few, "--against", str(ROOT), "-o", str(out))
    assert done.returncode == 0, done.stderr
    rows = {(row["name"], row["order"]): row for row in csv.DictReader(out.read_text().splitlines())}
    assert list(rows) == [
        *((name, "velocity") for name in ("plain", "axis")),
        *((name, order) for order in ("acceleration", "torque") for name in ("plain", "axis", "minimum torque")),
        ("solve_ik", ""),
    ]
    for (name, order), row in rows.items():
        assert float(row["median us"]) > 0
        assert float(row["theirs us"]) > 0
        assert float(row["ours/theirs"]) > 0
        assert bool(row["to plain"]) == bool(order)
        assert bool(row["rows us"]) == bool(row["rows"]) == (order in {"velocity", "acceleration"})
        assert name != "plain" or float(row["to plain"]) == 1.0
        assert order != "velocity" or float(row["to velocity"]) == 1.0
    assert re.search(r"axis +for orientation", done.stdout)
    assert "to plain: to the plain stack at the same order" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-p", "nonsense"), "unknown part 'nonsense'; there are plain, relative_to"),
        (("--order", "nonsense"), "unknown order 'nonsense'; there are velocity, acceleration, torque"),
        (("--ticks", "0"), "'--ticks'"),
        (("--rounds", "0"), "'--rounds'"),
        (("--poses", "-1"), "'--poses'"),
        (("--against", "/nowhere"), "'/nowhere' is no checkout of this library"),
        (("--out", "."), "'.'; a table is called .csv"),
    ],
)
def test_wrong_input_of_the_parts_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    refused(called("parts", "--ticks", "1", "--rounds", "1", *arguments), said)
