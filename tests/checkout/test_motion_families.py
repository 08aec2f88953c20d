"""Problems of real motions are what their names say, and their data what the recorder makes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.families import FAMILIES, Family, Sample
from benchmarks.motions import data, recording
from benchmarks.motions.__main__ import app
from benchmarks.motions.playback import FIGURES, SCENES, Played, motion, thesis
from benchmarks.motions.recording import at_limit, norm, record_scene
from benchmarks.motions.standing import families, standing
from hqp import Hierarchy, InvalidInput, Solver
from hqp.commands.command import run
from tasks.robots.robot import integrate

ROOT = Path(__file__).parents[2]
MOTIONS = [family for family in FAMILIES.values() if family.group == "motion"]
THESIS = [family for family in FAMILIES.values() if family.group == "thesis"]
STANDING = [family for family in FAMILIES.values() if family.group == "contacts"]
SOME = range(0, data.DRAWS, 4)
#: The share of the answers to robots that stand that has to be certified at least.
MOST = 0.9
#: Of a task, in the null space of those above it and in units of its norm: the singular value of a near singularity.
SINGULAR = 1e-2


@pytest.fixture(params=[*MOTIONS, *THESIS, *STANDING], ids=lambda family: family.key)
def family(request: pytest.FixtureRequest) -> Family:
    """Each family, in turn."""
    return needed(request.param)


def needed(family: Family) -> Family:
    """The family, if what it needs is here."""
    if family.needs:
        pytest.importorskip(family.needs)
    return family


def of_character(character: str) -> pytest.MarkDecorator:
    """The families of all robots in this character."""
    found = [family for family in MOTIONS if family.name.endswith(character)]
    return pytest.mark.parametrize("family", found, ids=lambda family: family.key)


def played(family: Family) -> Played:
    return {"motion": motion, "thesis": thesis, "contacts": standing}[family.group](family.name)


def smallest(problem: Hierarchy) -> float:
    """Of all tasks between limits and posture, the smallest singular value, in units of the task's norm."""
    N, found = np.eye(problem.n), []
    for k in range(1, len(problem.levels) - 1):
        A = problem.matrix(k)
        _, values, V = np.linalg.svd(A @ N)
        free = round(np.trace(N))
        found.append(values[min(len(A), free) - 1] / np.linalg.norm(A, 2))
        own = V[: np.count_nonzero(values > 1e-9)]
        N = N - own.T @ own
    return float(min(found))


def short(problem: Hierarchy) -> bool:
    """Whether a task between limits and posture cannot be met."""
    return any(level.residual_norm > 1e-6 for level in Solver().solve(problem).levels[1:-1])


def test_every_robot_has_four_characters_and_every_family_its_data() -> None:
    robots, characters = ("planar", "panda", "ur5", "g1", "talos"), ("slow", "saturated", "singular", "infeasible")
    assert [family.name for family in MOTIONS] == [f"{r} {c}" for r in robots for c in characters] == list(SCENES)
    assert [family.name for family in THESIS] == list(FIGURES)
    assert [family.name for family in STANDING] == list(families())
    assert {family.needs for family in STANDING} == {"pinocchio"}
    assert [family.needs for family in MOTIONS] == 4 * [""] + 16 * ["pinocchio"]
    assert not any(family.needs for family in THESIS)
    assert sum(path.stat().st_size for path in data.FOLDER.iterdir()) < 1.5e6


def test_the_data_fit_the_robot(family: Family) -> None:
    recording, shape = played(family), (family.draws, 2)
    robot, recorded = recording.robot, recording.recorded
    assert recorded["q"].shape == (*shape, robot.nq)
    assert recorded["v"].shape == (*shape, robot.nv)
    assert recorded["t"].shape == shape
    assert all(array.dtype == float and not np.isnan(array).any() for array in recorded.values())
    assert all(np.isfinite(array).all() or key.startswith("contacts/") for key, array in recorded.items())
    assert f"n = {family.sample(0, 0).now.n}: " in family.about
    assert family.about.endswith(("joints at a limit", "inequalities at a bound"))


def test_the_problems_are_those_that_were_recorded(family: Family) -> None:
    """A robot or a task that writes other rows makes other problems: then the motions are recorded anew."""
    (entry,) = (entry for entry in data.table() if (entry.group, entry.name) == (family.group, family.name))
    assert norm(played(family)) == pytest.approx(entry.norm, rel=1e-9)


def test_before_is_one_tick_before(family: Family) -> None:
    """A command holds over a tick: a velocity, or an acceleration, whose mean velocity is that of both ends."""
    recording = played(family)
    recorded = recording.recorded
    (dt,) = set(np.diff(recorded["t"], axis=1).round(9).flat)
    for q, v in zip(recorded["q"], recorded["v"], strict=True):
        step = dt * (v[1] if family.group == "motion" else (v[0] + v[1]) / 2)
        np.testing.assert_allclose(integrate(recording.robot, q[0], step), q[1], atol=1e-12)


def test_a_draw_is_always_the_same_problem(family: Family) -> None:
    first = family.sample(0, 3)
    kept = [problem.numbers.copy() for problem in first]
    other, again = family.sample(0, 40), family.sample(7, 3)
    for problem, numbers, twin in zip(first, kept, again, strict=True):
        np.testing.assert_array_equal(problem.numbers, numbers)
        np.testing.assert_array_equal(twin.numbers, numbers)
    assert not np.array_equal(other.now.numbers, first.now.numbers)


def test_before_and_now_are_different_problems_of_one_structure_and_certified(family: Family) -> None:
    samples = [family.sample(0, draw) for draw in SOME]
    assert {problem.structure for sample in samples for problem in sample} == {samples[0].now.structure}
    proofs = []
    for sample in samples:
        assert isinstance(sample, Sample)
        assert not np.array_equal(sample.before.numbers, sample.now.numbers)
        solver = Solver()
        proofs += [solver.solve(problem).certify().ok for problem in sample]
    # Who falls, or stands on the edge of a foot, has ticks at which the solver stops short: see docs/contacts.md.
    assert np.mean(proofs) >= (MOST if family in STANDING else 1.0)


@pytest.mark.parametrize("draw", [-1, data.DRAWS])
def test_there_are_so_many_draws(draw: int) -> None:
    assert {family.draws for family in (*MOTIONS, *THESIS, *STANDING)} == {data.DRAWS}
    with pytest.raises(InvalidInput, match=f"draw = {draw}; there are the draws 0 .. 63"):
        FAMILIES["motion/planar slow"].sample(0, draw)


@of_character("slow")
def test_slow_motions_meet_all_tasks_and_no_limit(family: Family) -> None:
    for problem in needed(family).problems(data.DRAWS, 0):
        assert not at_limit(problem)
        assert not short(problem)
        assert smallest(problem) > SINGULAR


@of_character("saturated")
def test_saturated_motions_have_joints_at_limits(family: Family) -> None:
    held = [at_limit(problem) for problem in needed(family).problems(data.DRAWS, 0)]
    assert np.mean(held) > 3
    assert f"{np.mean(held):.1f} of " in family.about


@of_character("singular")
def test_singular_motions_come_near_singularities_and_leave_them(family: Family) -> None:
    near = np.array([smallest(problem) < SINGULAR for problem in needed(family).problems(data.DRAWS, 0)])
    assert near.sum() >= 8
    assert np.count_nonzero(np.diff(near)) >= 2


@of_character("infeasible")
def test_infeasible_motions_leave_a_task_short_at_every_tick(family: Family) -> None:
    assert all(short(problem) for problem in needed(family).problems(data.DRAWS, 0))


@pytest.mark.parametrize("name", [name for name, scene in SCENES.items() if scene.robot == "planar"])
def test_the_recorder_makes_the_data(name: str) -> None:
    recorded = data.ticks("planar", name)
    anew = record_scene(SCENES[name], draws=6)
    assert list(anew) == list(recorded)
    for key, array in anew.items():
        np.testing.assert_allclose(array, recorded[key][:6], atol=1e-9, err_msg=key)


def test_the_command_writes_files_and_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, figure = "planar slow", "line"
    monkeypatch.setattr(recording, "SCENES", {scene: SCENES[scene]})
    monkeypatch.setattr(recording, "FIGURES", {figure: FIGURES[figure]})
    monkeypatch.setattr(recording.standing, "SCENES", {})
    monkeypatch.setattr(recording.standing, "families", dict)
    assert run(app, "python -m benchmarks.motions", ["--out", str(tmp_path)]) == 0
    for file, name in ("planar", scene), ("thesis", figure):
        for key, array in data.ticks(file, name, tmp_path).items():
            np.testing.assert_allclose(array, data.ticks(file, name)[key], atol=1e-9, err_msg=key)
    made = {entry.name: entry for entry in data.table() if entry.name in (scene, figure)}
    assert data.table(tmp_path) == [made[name]._replace(norm=pytest.approx(made[name].norm)) for name in made]


def test_what_is_not_there_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(InvalidInput, match=r"cannot read '.*families\.csv'"):
        data.table(tmp_path)
    with pytest.raises(InvalidInput, match=r"planar\.npz' has no motion 'planar fast'"):
        data.ticks("planar", "planar fast")
    assert run(app, "python -m benchmarks.motions", ["--out", ""]) == 2
    assert "'--out' / '-o': it is empty; the current folder is '.'" in capsys.readouterr().err


def test_families_are_there_without_pinocchio_and_without_loading_any() -> None:
    code = """
import sys
sys.modules["pinocchio"] = None
from benchmarks.families import FAMILIES
assert "tasks" not in sys.modules
for key in "motion/planar singular", "thesis/circle":
    assert FAMILIES[key].sample(0, 0).now.n == 3
"""
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
