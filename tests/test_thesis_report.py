"""``tasks.thesis.report``: tables, pictures, and what is kept on the way."""

from __future__ import annotations

import csv
import signal
import subprocess
import sys
import time
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from interrupts import heard
from PIL import Image

import hqp
from hqp import InvalidInput
from tasks.simulation.record import Stop
from tasks.thesis import animation, drawings, figures, ideas, pictures, report, runs, scenarios, store, studies, tables
from tasks.thesis.measuring import digits, measure, to_csv
from tasks.thesis.runs import Job, jobs_of, run
from tasks.thesis.scenarios import scenario

ROOT = Path(__file__).parents[1]


def short(figure):
    """A scenario of a hundred ticks: coarse, but end to end."""
    return replace(scenario(figure), tick=0.6, free_tick=0.6)


@pytest.fixture
def short_figures(monkeypatch):
    coarse = {figure: replace(item, tick=0.6, free_tick=0.6) for figure, item in scenarios.SCENARIOS.items()}
    monkeypatch.setattr(scenarios, "SCENARIOS", coarse)


def make(out, *names, **options):
    return report.report(names, "pseudoinverse", out, processes=1, **options)


@pytest.fixture(scope="module")
def few():
    jobs = [*jobs_of(short("4.7"), "pseudoinverse"), *jobs_of(short("4.6"), "pseudoinverse")]
    return [measure(job, run(job)) for job in jobs]


def test_the_table_as_csv(few):
    rows = list(csv.DictReader(StringIO(to_csv(few))))
    assert [row["figure"] for row in rows] == ["4.7", "4.7", "4.7", "4.6"]
    assert float(rows[0]["phi_share"]) == few[0].phi_share
    assert rows[3]["phi_share"] == rows[3]["diverged_min"] == ""


def test_the_tables_as_markdown(few):
    text = tables.to_markdown(few, remarks=["A remark."])
    claims, every, remarks = text.split("\n# ")
    for part, rows in (claims, 2), (every, len(few)):
        table = [line for line in part.splitlines() if line.startswith("|")]
        assert len(table) == 2 + rows
        assert len({line.count("|") for line in table}) == 1
    assert "both tasks met with maximum accuracy" in claims
    assert "tip error after 0.7 min [mm]" in every
    assert remarks.endswith("\n\n* A remark.\n")


@pytest.mark.parametrize(("value", "text"), [(0.02213, "0.022"), (1.5, "1.5"), (136.4, "140"), (0.0, "0")])
def test_two_digits(value, text):
    assert digits(value) == text


def test_claims_stand_against_what_the_backend_found(few):
    """The backend's run speaks for a law where there is one, and each cell says whether the claim holds of it."""
    with_priority, without = tables.against_claims(few)
    spoken = [found for found in few if found.figure == "4.7" and found.law == "Eq. 4.8"][-1]
    assert with_priority[:2] == ["4.7", "0°"]
    assert with_priority[3].startswith(f"{spoken.phi_share:.2f} ✗")
    assert with_priority[5:] == ["", ""]
    assert without[1] == ""
    assert without[3] == f"{digits(few[3].tip_error_mm)} mm {'✓' if few[3].tip_error_mm < 1 else '✗'}"


def test_a_joint_that_still_turns_at_the_end_stands_beside_the_mark(few):
    item = scenario("4.37")
    rest, turning = (replace(few[0], phi_share=0.88, tip_error_mm=0.5, end_speed=speed) for speed in (0.9, 22.6))
    assert tables.verdict(item, item.claims[0], rest) == "0.88 ✓"
    assert tables.verdict(item, item.claims[0], turning) == "0.88 ✓ ↻23"
    assert tables.verdict(item, item.claims[0], replace(turning, diverged_min=0.5)) == "diverges at 0.500 min ✗"


def test_a_verdict_that_hangs_on_what_the_text_does_not_give_is_none(few):
    item = scenario("4.27")
    found = replace(few[0], figure="4.27", phi_share=0.68, tip_error_mm=0.4, end_speed=0.0)
    rows = tables.against_claims([replace(found, law="strict, joint limits")])
    assert [row[5] for row in rows] == ["0.68 ?", "0.4 mm ?"]
    assert tables.verdict(replace(item, undecided=""), item.claims[0], found) == "0.68 ✓"


def test_what_has_not_converged_has_a_table(few):
    rows = [replace(few[1], tick_deg=value, figure=figure) for figure, value in (("4.7", 9.18), ("4.9", 0.3))]
    assert tables.unconverged(rows) == [["4.7", "9.2", "", "", ""]]
    assert "# Not converged in the tick" in tables.to_markdown(rows)
    assert "# Not converged in the tick" not in tables.to_markdown(rows[1:])
    twice = [replace(few[1], figure=figure, law="tip alone", tick_deg=3.9) for figure in ("4.26", "4.28", "4.30")]
    assert [row[0] for row in tables.unconverged(twice)] == ["4.26"]  # one motion


def test_the_study_of_lines(few):
    """A mark for every end, although the figures themselves are left undecided; each end and tick is a run."""
    study = studies.STUDIES["lines"]
    runs = {run: replace(few[0], tip_error_mm=0.5, phi_share=0.6, end_speed=0.0) for run in study.runs()}
    section = study.tabulate(runs)
    assert all(cell.endswith(("✓", "✗")) for row in section.rows for cell in row[4:])
    assert {row[0] for row in section.rows} == {"4.26", "4.27", "4.29", "4.31", "4.32", "4.33", "4.35", "4.37"}
    assert len(section.rows) == 24
    assert len(runs) == 66
    ends = {item.path(60.0)[0].round(6).tolist()[0] for item, _ in runs}
    assert ends == {0.5, 0.3, -0.4}
    assert len({item.free_tick for item, law in runs if law.key == "tip" and len(item.lengths) == 3}) == 4
    for job in study.jobs(hqp.DEFAULT_BACKEND):
        start, end = (job.scenario.path(t)[0] for t in (0.0, 60.0))
        np.testing.assert_allclose(start - end, start[0] - end[0], atol=1e-12)  # at 45 degrees


def test_the_study_of_stacks_end_to_end(short_figures, tmp_path, capsys):
    rows = report.report(["stacks"], None, tmp_path, processes=1)
    assert rows == []
    text = (tmp_path / "claims.md").read_text()
    table = [line for line in text.splitlines() if line.startswith("| 4.")]
    assert len(table) == 24
    assert "Claims against results" not in text
    assert "strict, limits, coasting" in text
    assert "pictures drawn: 0" in capsys.readouterr().out


def test_studies_are_left_out_where_the_backend_cannot_show_them(short_figures, tmp_path):
    make(tmp_path, "4.6", "stacks")
    assert "# Other stacks" not in (tmp_path / "claims.md").read_text()


@pytest.mark.parametrize("figure", ["4.6", "4.7", "4.5", "4.25", "4.33"])
def test_drawing(figure, tmp_path):
    item = replace(scenario(figure), tick=0.06, free_tick=0.06)
    shown = {job: run(job) for job in jobs_of(item, "pseudoinverse") if job.closed_form}
    drawing = figures.draw(item, shown)
    assert f"Figure {figure}" in " ".join(text.get_text() for text in drawing.texts)
    assert len(drawing.axes) == len(figures.PANELS) * len(shown)
    for axis, record in zip(drawing.axes, shown.values(), strict=False):
        lines = {line.get_label(): line for line in axis.lines}
        np.testing.assert_array_equal(lines["desired path"].get_xydata()[0], item.path(0.0)[0])
        np.testing.assert_array_equal(lines["actual path"].get_xydata(), record.pose[:, :2])
        assert axis.get_aspect() == 1.0
    drawing.savefig(tmp_path / "figure.png", dpi=40)


def test_which_joint_is_at_which_limit_is_drawn():
    item = replace(scenario("4.9"), tick=0.06, free_tick=0.06)
    job = Job(item, runs.laws_of(item, ["limits"])[0], "cascade:proxsuite")
    record = run(job)
    drawing = figures.draw(item, {job: record})
    stripes = drawing.axes[-1].images[0].get_array()
    assert stripes.shape[0] == 3
    for joint in range(3):
        for bit, name in ((1, "velocity"), (2, "acceleration")):
            assert (stripes[joint] & bit).any() == (record.active[name][:, joint] != 0).any()


def test_reach():
    """The ring of all places, by chains in random poses: none outside, and its edges are met."""
    assert ideas.reach([0.5, 0.5, 0.5]) == (0.0, 1.5)
    assert ideas.reach([1.0, 0.2, 0.3]) == pytest.approx((0.5, 1.5))
    arm = scenario("4.3").arm
    centre, inner, outer = ideas.reach_at(arm, np.pi / 2)
    np.testing.assert_allclose(centre, [0.0, 0.5], atol=1e-15)
    assert (inner, outer) == (0.0, 1.0)
    rng = np.random.default_rng(0)
    for q in rng.uniform(-np.pi, np.pi, (200, 3)):
        q[2] = np.pi / 2 - q[0] - q[1]
        assert np.linalg.norm(arm.points(q)[-1] - centre) <= outer + 1e-12


@pytest.mark.parametrize("name", list(ideas.IDEAS))
def test_ideas_are_drawn(name, tmp_path):
    item = replace(scenario("4.3"), tick=0.3, free_tick=0.3)
    shown = {job: run(job) for law in ideas.IDEAS[name].laws for job in [Job(item, law, "cascade:proxsuite")]}
    ideas.IDEAS[name].draw(shown).savefig(tmp_path / "idea.png", dpi=40)
    assert (tmp_path / "idea.png").stat().st_size > 5000


def test_a_run_that_several_figures_show_is_simulated_once(short_figures, tmp_path, monkeypatch):
    simulated = []
    monkeypatch.setattr(report, "run", lambda job: simulated.append(job) or runs.run(job))
    rows = make(tmp_path, "4.6", "4.8")
    assert len(simulated) == 2  # itself and at twice the tick
    assert [row.figure for row in rows] == ["4.6", "4.8"]
    assert len(list((tmp_path / "runs").glob("*.npz"))) == 2


def test_nothing_is_made_twice(short_figures, tmp_path, monkeypatch, capsys):
    make(tmp_path, "4.7")
    assert "runs simulated: 5, pictures drawn: 1" in capsys.readouterr().out
    picture = tmp_path / "figure-4.7.png"
    before = picture.stat().st_mtime_ns
    make(tmp_path, "4.7")
    assert "runs simulated: 0, pictures drawn: 0" in capsys.readouterr().out
    assert picture.stat().st_mtime_ns == before
    # What is gone, and only that, is made again.
    picture.unlink()
    next((tmp_path / "runs").glob("strict-*.npz")).unlink()
    make(tmp_path, "4.7", "4.9")
    assert "runs simulated: 6, pictures drawn: 2" in capsys.readouterr().out


def test_what_made_a_run_is_part_of_its_name(tmp_path, monkeypatch):
    job = jobs_of(short("4.7"), "pseudoinverse")[0]
    kept = store.Store(tmp_path)
    others = [
        replace(job, closed_form=not job.closed_form),
        replace(job, backend="cascade:osqp"),
        replace(job, law=runs.laws_of(job.scenario, ["damped"])[0]),
        replace(job, scenario=replace(job.scenario, damping=0.2)),
        replace(job, scenario=replace(job.scenario, lengths=(0.7, 0.7, 0.31))),
    ]
    assert len({kept.path(other) for other in [job, *others]}) == 6
    assert kept.path(job) == kept.path(replace(job, scenario=replace(job.scenario, figure="5.1")))
    before = kept.path(job)
    monkeypatch.setattr(store, "sources", lambda **_: "other sources")
    assert kept.path(job) != before


def test_runs_of_other_versions_go_and_files_of_others_stay(short_figures, tmp_path):
    folder = tmp_path / "runs"
    folder.mkdir()
    stale = folder / f"strict-formula-{'0' * 8}-{'1' * 16}.npz"
    other = [folder / "mine.npz", folder / f"{'0' * 8}-{'1' * 16}.npz", tmp_path / stale.name]
    for path in stale, *other:
        path.touch()
    make(tmp_path, "4.6")
    make(tmp_path, "4.7")
    assert not stale.exists()
    assert all(path.exists() for path in other)
    assert len(list(folder.glob("*.npz"))) == 2 + 2 + 5


def test_all_figures_come_with_the_ideas_unless_laws_are_chosen():
    everything = pictures.subjects([], report.NAMES)
    assert len(everything) == len(drawings.DRAWINGS) + 36 + len(ideas.IDEAS) + len(studies.STUDIES)
    assert len(pictures.subjects([], ["limits"])) == 36
    assert [item.name for item in pictures.subjects(["argument", " argument "], ["limits"])] == ["argument"]


def test_a_picture_that_is_being_drawn_is_not_up_to_date(tmp_path):
    drawn = store.Drawn(tmp_path, tmp_path / "drawn.json")
    (tmp_path / "figure.png").touch()
    drawn.add("figure.png", "key")
    assert drawn.has("figure.png", "key")
    drawn.forget(["figure.png"])
    assert not store.Drawn(tmp_path, tmp_path / "drawn.json").has("figure.png", "key")


def test_a_table_of_drawings_that_cannot_be_read_means_none(tmp_path):
    (tmp_path / "drawn.json").write_text("[1, 2")
    assert store.Drawn(tmp_path, tmp_path / "drawn.json").keys == {}


def test_an_interruption_keeps_what_is_finished(short_figures, tmp_path, monkeypatch, capsys):
    simulated = []

    def interrupted(job):
        if len(simulated) == 4:
            raise KeyboardInterrupt
        simulated.append(job)
        return runs.run(job)

    monkeypatch.setattr(report, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        make(tmp_path, "4.7", "4.9")
    assert len(list((tmp_path / "runs").glob("*.npz"))) == 4
    monkeypatch.setattr(report, "run", runs.run)
    make(tmp_path, "4.7", "4.9")
    assert "runs simulated: 6, pictures drawn: 2" in capsys.readouterr().out


def test_ctrl_c_in_the_middle_and_on_again(tmp_path):
    """The real command with its processes: interrupted once something is finished, it goes on where it was."""
    script = (
        "import sys; from dataclasses import replace; from tasks import cli; from tasks.thesis import scenarios as s;"
        "s.SCENARIOS.update({k: replace(v, tick=0.12, free_tick=0.12) for k, v in s.SCENARIOS.items()});"
        "cli.main(sys.argv[1:])"
    )
    command = [sys.executable, "-c", script, "thesis", "-j", "2", "-o", str(tmp_path)]
    command += [word for figure in ("4.9", "4.17") for word in ("-f", figure)]
    with heard():
        first = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)
    deadline = time.monotonic() + 300
    while len(list(tmp_path.glob("runs/*.npz"))) < 2:
        assert time.monotonic() < deadline
        assert first.poll() is None, first.stderr.read()
        time.sleep(0.05)
    first.send_signal(signal.SIGINT)
    _, told = first.communicate()
    assert first.returncode == 130
    assert "hqp: interrupted; what was finished is kept" in told.splitlines()  # loky may tell of its files after it
    kept = len(list(tmp_path.glob("runs/*.npz")))
    assert 2 <= kept < 20
    second = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    assert f"runs simulated: {20 - kept}, pictures drawn: 2" in second.stdout


@pytest.mark.parametrize("form", ["pdf", "svg"])
def test_formats(form, short_figures, tmp_path):
    make(tmp_path, "4.6", form=form)
    head = (tmp_path / f"figure-4.6.{form}").read_bytes()[:5]
    assert head in (b"%PDF-", b"<?xml")


def test_animation(short_figures, tmp_path, monkeypatch):
    monkeypatch.setattr(animation, "FRAMES", 13)  # a sixth, and each takes as long
    make(tmp_path, "4.7", animated=True)
    with Image.open(tmp_path / "figure-4.7.gif") as picture:
        assert picture.n_frames > 10


@pytest.mark.parametrize(
    ("names", "options", "told"),
    [
        (["4.99"], {}, "figure '4.99' is unknown"),
        (["4.7"], {"form": "bmp"}, "format 'bmp' is unknown; available: png, pdf, svg"),
        (["workspace"], {"laws": ["magic"]}, "law 'magic' is unknown; available: thesis, strict, limits, damped"),
    ],
)
def test_refusals_come_before_the_work(names, options, told, tmp_path):
    with pytest.raises(InvalidInput, match=told):
        make(tmp_path / "new", *names, **options)
    assert not (tmp_path / "new").exists()


def test_a_damaged_run_is_made_anew(short_figures, tmp_path):
    before = make(tmp_path, "4.6")
    damaged = next((tmp_path / "runs").glob("tip-*.npz"))
    whole = damaged.read_bytes()
    damaged.write_bytes(whole[:1000])
    assert to_csv(make(tmp_path, "4.6")) == to_csv(before)
    assert len(damaged.read_bytes()) == len(whole)


def without_a_tick(record):
    """What is recorded where the solver has no answer at all."""
    none = {name: getattr(record, name)[:0] for name in ("a", "tau", "status", "checked_t", "ranks")}
    first = {name: getattr(record, name)[:1] for name in ("t", "q", "v", "pose", "manipulability")}
    errors = {name: values[:1] for name, values in record.errors.items()}
    active = {name: sides[:0] for name, sides in record.active.items()}
    stopped = Stop(0.0, "failed at t = 0 s", diverged=False)
    return replace(record, **none, **first, errors=errors, active=active, certified=0, stopped=stopped)


def test_a_run_without_an_answer_is_a_finding(tmp_path, monkeypatch):
    monkeypatch.setattr(animation, "FRAMES", 3)  # where all stands still, one is as good as any
    item = short("4.7")
    jobs = [Job(item, law, "cascade:proxsuite") for law in runs.laws_of(item)]
    shown = {job: without_a_tick(run(job)) for job in jobs}
    found = [measure(job, record) for job, record in shown.items()]
    assert {finding.note for finding in found} == {"failed at t = 0 s"}
    assert all(cell == "failed at t = 0 s ✗" for cell in tables.against_claims(found)[0][3:])
    figures.draw(item, shown).savefig(tmp_path / "figure.png", dpi=40)
    animation.animate(item, shown, tmp_path / "figure.gif")


def test_where_there_is_nothing_to_show(tmp_path):
    with pytest.raises(InvalidInput, match=r"nothing to show: .* takes no inequalities"):
        make(tmp_path, "4.6", laws=["limits"])
