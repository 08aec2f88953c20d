"""The examples run, without a warning, say something, stay short, and draw what the documentation shows."""

from __future__ import annotations

import runpy
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import pytest
from command import ROOT
from in_python import reasons

sys.path.insert(0, str(ROOT / "docs/_site"))
from gallery import pictures

EXAMPLES = sorted((ROOT / "examples").glob("[0-9]*.py"))
MOST_LINES = 60
IMAGES = EXAMPLES[0].parents[1] / "docs" / "images"
LARGEST = {".png": 150_000, ".gif": 1_000_000}  # of a picture [bytes]

#: What each must print, whatever the machine.
SAYS = {
    "01_levels": "NOT optimal: level 1 (sum) falls short",
    "02_planar_arm": "150 of 150 checked ticks certified",
    "03_which_limit": "held back by joint 1 velocity limit (upper)",
    "04_compare_backends": "native                      exact          40/40     40/40",
    "05_joint_limits": "afterwards a joint is at most 0.000000 deg outside",
    "06_panda_elbow_up": "lowest elbow 0.5500 m",
    "07_ur5_singularity": "40 of 40",
    "08_humanoid_reach": "damped, the joints move it little in this direction",
    "13_priority_swap": "hand off by 373.4 mm, rest by 0.1 deg",
    "09_torque_minimisation": "diverged at t = 1.8",
    "10_liegeois": "a joint at 100 % of its half range",
    "11_obstacle": "limit above the tip  nearest   38.23 mm",
    "12_torque_limited_panda": "slow: hand at most 0.68 mm off",
    "14_welding": "tip off by at most  0.35 mm, torch by 20.8",
    "15_spraying": "square first gun off by at most 74.2",
    "16_snake_arm": "body clear nearest  10.3",
    "17_inspection": "pipes known   nearest  34.1",
    "18_biped_lifts_a_foot": "25 of 25 checked ticks certified); 1250 optimal",
    "19_quadruped_is_pushed": "30 of 30 checked ticks certified); 1500 optimal",
    "20_humanoid_leans": "support polygon met (1 of 8 rows at a bound)",
    "21_panda_presses_a_table": "40 of 40 checked ticks certified",
    "22_walking_in_place": "40 of 40 checked ticks certified); 2000 optimal",
    "23_planner_ik": "5 solutions of the goal; straight to the first: -",
}

#: Why Python writes parts of their stacks; loops write all others.
IN_PYTHON: dict[str, set[str]] = {}

#: What each draws into the folder that it is given, also kept in the documentation.
DRAWS = {
    "02_planar_arm": ["planar_arm.png"],
    "05_joint_limits": ["joint_limits.png"],
    "06_panda_elbow_up": ["panda_elbow.png"],
    "07_ur5_singularity": ["ur5_singularity.png"],
    "08_humanoid_reach": ["humanoid_reach.png"],
    "09_torque_minimisation": ["torque_minimisation.png"],
    "10_liegeois": ["liegeois.png"],
    "11_obstacle": ["obstacle.png"],
    "12_torque_limited_panda": ["torque_panda.gif", "torque_panda.png"],
    "13_priority_swap": ["priority_swap.png"],
    "14_welding": ["welding.png"],
    "15_spraying": ["spraying.png"],
    "16_snake_arm": ["snake_arm.png"],
    "17_inspection": ["inspection.png"],
    "18_biped_lifts_a_foot": ["biped.png"],
    "19_quadruped_is_pushed": ["quadruped.png"],
    "20_humanoid_leans": ["leaning.png"],
    "21_panda_presses_a_table": ["pressing.png"],
    "22_walking_in_place": ["walking.png"],
}

#: What some take after the folder, to be short: seconds.
SHORT = {
    "12_torque_limited_panda": ["6"],
    "18_biped_lifts_a_foot": ["2.5"],
    "19_quadruped_is_pushed": ["3"],
    "20_humanoid_leans": ["3"],
    "21_panda_presses_a_table": ["4"],
    "22_walking_in_place": ["4"],
}

#: Of every kind one, which also runs by itself: one that prints, one that draws.
ALONE = ("01_levels", "06_panda_elbow_up")

#: What some need that is no part of every installation.
NEEDS = dict.fromkeys(SHORT, "mujoco")


def test_every_example_is_expected():
    assert [path.stem for path in EXAMPLES] == sorted(SAYS)


@pytest.mark.parametrize("name", DRAWS)
def test_the_gallery_shows_what_an_example_draws(name: str):
    code = (EXAMPLES[0].parent / f"{name}.py").read_text(encoding="utf-8")
    assert sorted(pictures(code)) == DRAWS[name]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """In this process, which has the kernels already: another takes seconds to start."""
    assert len(path.read_text(encoding="utf-8").splitlines()) < MOST_LINES
    if path.stem in NEEDS:
        pytest.importorskip(NEEDS[path.stem], reason=f"the example needs {NEEDS[path.stem]}")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", command(path, tmp_path))
    monkeypatch.syspath_prepend(path.parent)  # where it looks if it runs alone
    with monkeypatch.context() as modules, mpl.rc_context(), reasons() as told:
        for own in path.parent.glob("_*.py"):  # which set what the context takes back
            modules.delitem(sys.modules, own.stem, raising=False)
        runpy.run_path(str(path), run_name="__main__")
    check(path, tmp_path, capsys.readouterr().out)
    assert told == IN_PYTHON.get(path.stem, set())


@pytest.mark.parametrize("path", [path for path in EXAMPLES if path.stem in ALONE], ids=lambda path: path.stem)
def test_an_example_alone(path: Path, tmp_path: Path):
    """In a process of its own, as anybody runs it."""
    done = subprocess.run(
        [sys.executable, "-W", "error", *command(path, tmp_path)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    check(path, tmp_path, done.stdout)


def command(path: Path, folder: Path) -> list[str]:
    """An example and its arguments."""
    return [str(path), *([str(folder), *SHORT.get(path.stem, [])] if path.stem in DRAWS else [])]


def check(path: Path, folder: Path, said: str) -> None:
    """What an example said, and what it left in its folder."""
    drawn = DRAWS.get(path.stem, [])
    assert SAYS[path.stem] in said
    left = sorted(file.name for file in folder.iterdir())
    assert left == drawn, "an example leaves its pictures alone, where it was told to"
    for picture in drawn:
        for place in folder, IMAGES:
            assert 0 < (place / picture).stat().st_size < LARGEST[Path(picture).suffix]
