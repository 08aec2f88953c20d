"""What the default stack is held against: laws over rows, coming back, what is moved from below, what a tick costs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pinocchio")

from benchmarks.__main__ import main
from benchmarks.teleoperation.cost import cost, timed
from benchmarks.teleoperation.loop import drive
from benchmarks.teleoperation.measure import Measure
from benchmarks.teleoperation.returns import Returns, returns
from benchmarks.teleoperation.scenes import KNOWN, SCENES, Scene
from benchmarks.teleoperation.setups import SETUPS, Own
from benchmarks.teleoperation.shadow import moved, pushed
from benchmarks.teleoperation.soonest import soonest
from benchmarks.teleoperation.targets import BEYOND, CALM, COSTS, EDGE, IN_REACH, OURS, STRICT, UNMOVED, checks, costs
from tasks import PlanarArm

DT, K = 0.005, 20.0


def scene(name: str) -> Scene:
    return next(s for s in SCENES if s.name == name)


def row(**given: object) -> Measure:
    """A run without a fault."""
    calm = Measure(
        far=0.02, far_max=0.03, excess=0.01, excess_max=0.02, turned=0.1, turned_max=0.2, jerk=100.0, fast=0.001,
        frozen=0, longest=0, raised=0, by="", out_ticks=0, out=0.0, further=0.0, back=0.2, over_ticks=0, over=0.0,
        reach=0.1, soonest=None, caught=0, moved=0.0, pushed=0.0, strayed=1e-4, end=0.4, forced=0.4,
        p50=10.0, p99=20.0,
    )  # fmt: skip
    return replace(calm, **given)  # type: ignore[arg-type]


def missed(name: str, *, gain: float = K, **given: object) -> list[str]:
    rows = {OURS: row(**given), STRICT: row(), CALM: row()}
    return [check.what for check in checks(replace(scene(name), gain=gain), rows) if not check.met]


def test_every_scene_has_its_laws() -> None:
    assert {*IN_REACH, *EDGE, *BEYOND, "humanoid"} == {s.name for s in SCENES}
    for s in SCENES:
        assert missed(s.name) == []
        assert missed(s.name, over=1e-6) == ["joints too fast"]
        assert checks(s, {STRICT: row()}) == []


def test_a_law_is_missed_by_what_breaks_it() -> None:
    assert missed("figure eight", excess=0.0103) == ["error from strict"]
    assert missed("tremor", turned=0.102, jerk=111.0) == ["angle from strict", "jerk"]
    assert missed("stretched", excess=0.0106, jerk=251.0, fast=0.006) == ["error", "jerk", "power above 3 Hz"]
    assert missed("outside", back=None) == ["joints back"]
    assert missed("faster", excess=0.0126, jerk=201.0) == ["error", "jerk"]
    assert missed("up", reach=0.3, caught=1, moved=2e-3) == ["caught", "back in reach", "moved by levels below"]
    assert missed("up", pushed=2e-3) == ["pushed by levels below"]
    assert missed("humanoid", strayed=1e-3, end=0.45, jerk=501.0) == ["feet", "at the end", "jerk"]
    assert missed("stretched", gain=10.0, jerk=251.0, reach=0.4) == [], "as slow as the gain, and no absolute jerk"


def test_without_the_row_to_compare_with_nothing_is_claimed() -> None:
    found = checks(scene("faster"), {OURS: row()})
    assert [check.what for check in found if check.met is None] == ["jerk"]


def test_coming_back_is_timed_from_where_the_target_is_in_reach() -> None:
    forced = np.repeat([0.0, 0.1, 0.0, 0.1, 0.0], 100)
    excess, still = np.zeros(500), np.zeros(500)
    assert returns(forced, excess, still, K, DT, 0.25) == Returns(0.0, 0, 400)
    excess[150:230] = 0.05
    assert returns(forced, excess, still, K, DT, 0.25) == Returns(pytest.approx(30 * DT), 0, 200)
    excess[400:] = 0.05
    assert returns(forced, excess, still, K, DT, 0.25) == Returns(pytest.approx(30 * DT), 1, 200)
    assert returns(forced, excess, still + 1.0, K, DT, 0.25) == Returns(0.0, 0, 400), (
        "a moving target is followed at v / K"
    )
    assert returns(forced, excess, still, K, DT, 1.0).caught == 0, "gone again too soon to tell"
    assert returns(np.zeros(500), excess, still, K, DT, 0.25) == Returns(None, 0), "it never left"


def test_no_hand_is_back_sooner_than_its_joints_are_fast() -> None:
    arm = PlanarArm([1.0], position_limit=(-1.0, 1.0), velocity_limit=2.0)
    angles = np.linspace(0.3, 0.6, 101)  # at 0.6 rad/s; the joint follows from 0 with 2
    targets = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(101)])
    within = np.full(101, 1e-4)
    found = soonest(arm, "link1", np.zeros(1), targets, within, DT)
    assert found == pytest.approx(0.3 / (2.0 - 0.6), abs=DT)
    assert soonest(arm, "link1", angles[:1], targets, within, DT) == 0.0, "it is there already"
    beyond = soonest(arm, "link1", np.zeros(1), 1.1 * targets, np.full(101, 0.1001), DT)
    assert beyond == pytest.approx(found, abs=2 * DT), "what is forced is allowed"


def test_levels_below_move_nothing_of_a_strict_stack_and_a_push_is_seen() -> None:
    stream = scene("figure eight").stream(0.6)
    strict = next(setup for setup in SETUPS if setup.name == STRICT)
    assert isinstance(strict, Own)
    (run,) = drive(stream, [strict.driver])
    still = moved(stream, run, strict)
    assert still is not None
    assert 0.0 <= still < UNMOVED
    assert 0.0 <= pushed(stream, run, strict) <= still
    away = replace(run, q=run.q.copy())
    away.q[50] = stream.robot.home - 0.3  # the end of the first piece
    for measure in moved, pushed:
        assert measure(stream, away, strict) > 0.01
        assert measure(scene("humanoid").stream(0.02), run, strict) is None, "several tasks on the first level"


def test_the_cost_of_a_tick_is_told_in_and_out_of_reach() -> None:
    stream = scene("figure eight").stream(0.6)
    default = next(setup for setup in SETUPS if setup.name == OURS)
    (run,) = drive(stream, [default.driver])
    us = timed(stream, run, 1)
    assert all(each.shape == (120,) and (each[np.isfinite(each)] > 0).all() for each in us)
    forced = np.where(np.arange(120) < 60, 0.0, 0.1)
    rows = cost("figure eight", *us, forced)
    assert [r["where"] for r in rows] == ["in reach", "out of reach"]
    assert cost("figure eight", *us, np.zeros(120))[0]["ticks"] == str(np.isfinite(us[0]).sum())
    half = [{"where": where, "ratio p50": "1.5"} for where in COSTS]
    assert [check.met for check in costs(half)] == [False, True]


@pytest.mark.parametrize(
    "only", [("-m", "hqp strict"), ("-m", "hqp", "-m", "hqp strict", "--gain", "10", "--dt", "0.01")]
)
def test_the_command_tells_the_targets(
    only: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ("-s", KNOWN[0].name, "--seconds", "0.5", "--rounds", "1", "--targets", *only)
    monkeypatch.setattr("sys.argv", ["benchmarks", "teleop", *arguments])
    with pytest.raises(SystemExit):
        main()
    said = capsys.readouterr().out
    assert ("error from strict" in said) == (OURS in only)
    assert ("K 10 /s, dt 10 ms" in said) == ("--gain" in only)
    assert "met, " in said
