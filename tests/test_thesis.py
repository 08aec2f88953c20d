"""Chapter 4: the scenarios are those of the text, and the laws do what is said of them."""

from __future__ import annotations

import csv
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest

import hqp
from hqp import InvalidInput
from tasks.thesis import claims, figures, laws, report, runs, scenarios
from tasks.thesis.runs import Job, jobs_of, run
from tasks.thesis.scenarios import SCENARIOS, scenario

FIGURES = [*range(2, 10), *range(26, 38)]


def short(figure):
    """A scenario of a hundred ticks: coarse, but end to end."""
    return replace(scenario(figure), tick=0.6)


def test_every_straight_line_of_chapter_4_is_there():
    assert list(SCENARIOS) == [f"4.{number}" for number in FIGURES]


def test_odd_figures_are_with_priority_and_even_ones_without():
    for number, item in zip(FIGURES, SCENARIOS.values(), strict=True):
        assert (item.phi is None) == (number % 2 == 0)
    desired = [np.degrees(item.phi) for item in SCENARIOS.values() if item.phi is not None]
    assert desired == pytest.approx([0, 90, 0, 90, 0, 90, 45, 0, 90, 45])


def test_arms_start_close_to_their_path():
    """The text rounds the start to whole degrees: up to 6 cm off the line, in its own figures too."""
    for item in SCENARIOS.values():
        tip = item.arm.pose(item.q0)[:2]
        assert np.linalg.norm(tip - item.path(0.0)[0]) < 0.07
        assert max(np.linalg.norm(np.asarray(end)) for end in (item.start, item.end)) < sum(item.lengths)


def test_units_are_converted_once():
    item = scenario("4.7")
    assert (item.duration, item.tick) == (60.0, pytest.approx(0.012))
    for gain, c1, c2 in (item.position_gain * 60, 20, 100), (item.orientation_gain * 60, 100, 2500):  # per minute
        np.testing.assert_allclose([2 * gain, gain**2], [c1, c2])
    assert item.velocity_limit * 60 == pytest.approx(40)
    assert item.acceleration_limit * 60**2 == pytest.approx(4000)
    assert np.degrees(item.q0) == pytest.approx([62, -90, -52])
    np.testing.assert_allclose(item.path(30.0)[0], [1.0, 0.5])


def test_figures_of_the_same_motion_are_one_run():
    assert scenario("4.6") == scenario("4.8")
    assert len({scenario(f"4.{number}") for number in (26, 28, 30)}) == 1
    assert len(set(SCENARIOS.values())) == 14
    assert jobs_of(scenario("4.6"), "pseudoinverse") == jobs_of(scenario("4.8"), "pseudoinverse")


@pytest.mark.parametrize(
    ("figure", "named"),
    [("4.99", "'4.99' is unknown; available: 4.2, 4.3"), ("4.14", "'4.14' is not available yet"), (4.7, "is unknown")],
)
def test_refuses_unknown_figures(figure, named):
    with pytest.raises(InvalidInput, match=named):
        scenario(figure)


def test_the_three_laws_as_stacks():
    item = scenario("4.7")
    names = [[[part.name for part in level] for level in law.stack(item).levels] for law in laws.laws_of(item)]
    assert names == [
        [["position"], ["joint motion of orientation"]],
        [["position"], ["orientation"]],
        [["velocity", "acceleration"], ["position"], ["orientation"]],
    ]
    assert [len(law.stack(scenario("4.6"))) for law in laws.laws_of(scenario("4.6"))] == [1, 2]


def test_a_backend_shows_only_the_laws_it_can():
    titles = {
        backend: [(job.law.key, job.backend) for job in jobs_of(scenario("4.7"), backend)]
        for backend in ("pseudoinverse", "pseudoinverse:joint", hqp.DEFAULT_BACKEND)
    }
    closed = [("thesis", "pseudoinverse:joint"), ("strict", "pseudoinverse")]
    assert titles["pseudoinverse"] == [closed[0], ("thesis", "pseudoinverse"), closed[1]]
    assert titles["pseudoinverse:joint"] == closed
    assert len(titles[hqp.DEFAULT_BACKEND]) == 5
    refusal = laws.LIMITS.refusal(hqp.backend_info("pseudoinverse"))
    assert refusal is not None
    assert "left out, pseudoinverse takes no inequalities" in refusal


def phi_error(record):
    return np.abs(np.degrees(record.errors["orientation"][:, 0]))


@pytest.mark.parametrize(("figure", "peak", "share"), [("4.7", 19.0, 0.43), ("4.35", 33.6, 0.19), ("4.31", 17.1, 0.03)])
def test_eq_4_8_holds_phi_only_approximately(figure, peak, share):
    item = scenario(figure)
    job = jobs_of(item, "pseudoinverse")[0]
    record = run(job)
    claim = claims.measure(job, record)
    assert claim.backend == "pseudoinverse:joint"
    assert claim.phi_peak_deg == pytest.approx(peak, abs=0.1)
    assert claim.phi_share == pytest.approx(share, abs=0.006)
    assert claim.tip_error_mm < 1.0
    assert claim.certified == 1.0
    # The law by hand, at a tick in the middle.
    k = 2000
    q, v, t = record.q[k], record.v[k], record.t[k]
    J, Jdot = item.arm.jacobian(q), item.arm.jacobian_dot(q, v)
    xd, xd_dot, xd_ddot = item.path(t)
    h1 = xd_ddot - Jdot[:2] @ v + (xd_dot - J[:2] @ v) / 3 + (xd - item.arm.pose(q)[:2]) / 36
    h2 = -Jdot[2:] @ v - J[2:] @ v * 5 / 3 + (item.phi - item.arm.pose(q)[2:]) * 25 / 36
    J1_pinv = np.linalg.pinv(J[:2])
    a = J1_pinv @ h1 + (np.eye(len(q)) - J1_pinv @ J[:2]) @ np.linalg.pinv(J[2:]) @ h2
    np.testing.assert_allclose(record.a[k], a, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("figure", "diverged"), [("4.3", 0.771), ("4.5", 0.075), ("4.27", 0.763), ("4.9", None)])
def test_the_strict_stack_is_exact_and_diverges_out_of_reach(figure, diverged):
    record = run(Job(scenario(figure), laws.STRICT, "pseudoinverse", closed_form=True))
    if diverged is None:
        assert record.stopped is None
        assert np.mean(phi_error(record) < 1) > 0.85
    else:
        assert record.diverged_at / 60 == pytest.approx(diverged, abs=6e-4)


@pytest.mark.parametrize("figure", ["4.7", "4.9"])
def test_with_limits_on_top_both_tasks_are_met(figure):
    """The text's "maximum accuracy", which its own law does not reach."""
    job = Job(scenario(figure), laws.LIMITS, hqp.DEFAULT_BACKEND)
    record = run(job)
    claim = claims.measure(job, record)
    assert record.stopped is None
    assert claim.phi_share >= 0.8
    assert claim.tip_error_mm < 1.0
    assert claim.certified > 0.95
    assert np.abs(record.v).max() <= job.scenario.velocity_limit + 1e-9
    assert np.abs(record.a).max() <= job.scenario.acceleration_limit + 1e-7


@pytest.mark.parametrize("law", [laws.THESIS, laws.STRICT], ids=lambda law: law.key)
def test_the_qp_reproduces_the_closed_form(law):
    item = short("4.7")
    closed = run(Job(item, law, law.closed_form, closed_form=True))
    job = Job(item, law, hqp.DEFAULT_BACKEND)
    claim = claims.measure(job, run(job), closed)
    assert claim.difference_rad < 1e-6
    assert claim.certified == 1.0


def test_what_a_stopped_run_missed_counts_as_lost():
    job = Job(scenario("4.5"), laws.STRICT, "pseudoinverse", closed_form=True)
    claim = claims.measure(job, run(job))
    assert claim.phi_share < 0.05
    assert np.isnan(claim.tip_error_mm)
    assert claim.diverged_min == pytest.approx(0.075, abs=1e-3)


@pytest.fixture(scope="module")
def few_claims():
    jobs = jobs_of(short("4.7"), "pseudoinverse") + jobs_of(short("4.6"), "pseudoinverse")
    return [claims.measure(job, run(job)) for job in jobs]


def test_the_table_as_csv(few_claims):
    rows = list(csv.DictReader(StringIO(claims.to_csv(few_claims))))
    assert [row["figure"] for row in rows] == ["4.7", "4.7", "4.7", "4.6"]
    assert float(rows[0]["phi_share"]) == few_claims[0].phi_share
    assert rows[3]["phi_share"] == rows[3]["diverged_min"] == ""


def test_the_table_as_markdown(few_claims):
    table = [line for line in claims.to_markdown(few_claims, ["A remark."]).splitlines() if line.startswith("|")]
    assert len(table) == 2 + len(few_claims)
    assert len({line.count("|") for line in table}) == 1
    assert "tip error after 0.7 min [mm]" in table[0]
    assert claims.to_markdown(few_claims, ["A remark."]).endswith("\n\n* A remark.\n")


@pytest.mark.parametrize("figure", ["4.6", "4.7", "4.5"])
def test_drawing(figure, tmp_path):
    item = replace(scenario(figure), tick=0.06)
    shown = {job: run(job) for job in jobs_of(item, "pseudoinverse") if job.closed_form}
    drawing = figures.draw(item, shown)
    assert f"Figure {figure}" in drawing.get_suptitle()
    assert len(drawing.axes) == 3 * len(shown)
    for axis, record in zip(drawing.axes, shown.values(), strict=False):
        lines = {line.get_label(): line for line in axis.lines}
        np.testing.assert_array_equal(lines["desired path"].get_xydata(), [item.start, item.end])
        np.testing.assert_array_equal(lines["actual path"].get_xydata(), record.pose[:, :2])
        assert axis.get_aspect() == 1.0
    drawing.savefig(tmp_path / "figure.png", dpi=40)


def test_a_run_that_several_figures_show_is_simulated_once(tmp_path, monkeypatch):
    monkeypatch.setattr(scenarios, "SCENARIOS", {figure: short(figure) for figure in ("4.6", "4.8")})
    simulated = []
    monkeypatch.setattr(report, "run", lambda job, progress: simulated.append(job) or runs.run(job, progress))
    rows = report.report(["4.6", "4.8"], "pseudoinverse", tmp_path)
    assert len(simulated) == 1
    assert [row.figure for row in rows] == ["4.6", "4.8"]


def test_what_is_finished_is_kept(tmp_path, monkeypatch):
    """An interruption in the second figure leaves the first one and its rows."""
    monkeypatch.setattr(scenarios, "SCENARIOS", {figure: short(figure) for figure in ("4.7", "4.9")})

    def interrupted(job, progress):
        if job.scenario.figure == "4.9":
            raise KeyboardInterrupt
        return runs.run(job, progress)

    monkeypatch.setattr(report, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        report.report(["4.7", "4.9"], "pseudoinverse", tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["claims.csv", "claims.md", "figure-4.7.png"]
    assert "4.7" in (tmp_path / "claims.csv").read_text()
