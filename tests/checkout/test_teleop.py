"""The teleoperation scenes: what is measured is what it says, and this library answers every tick within the limits."""

from __future__ import annotations

import csv
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio")

from benchmarks.__main__ import main
from benchmarks.teleoperation import metrics, setups
from benchmarks.teleoperation.hand import Hand, Sway
from benchmarks.teleoperation.loop import COLD, Run, drive
from benchmarks.teleoperation.measure import Measure, measure
from benchmarks.teleoperation.report import COMING_BACK, SHOWN, shown, table
from benchmarks.teleoperation.scenes import KNOWN, SCENES, Scene
from benchmarks.teleoperation.setups import SETUPS, Own, Peer
from benchmarks.teleoperation.tracking import errors, inevitable, strayed, track
from tasks.base.rotations import log

ROOT = Path(__file__).parents[2]
DT = 0.005
OWN = [setup for setup in SETUPS if isinstance(setup, Own)]


def scene(name: str) -> Scene:
    return next(s for s in SCENES if s.name == name)


@cache
def own_runs(name: str, seconds: float = 1.5) -> list[Run]:
    return drive(scene(name).stream(seconds), [setup.driver for setup in OWN])


def waves(*parts: tuple[float, float], seconds: float = 20.0) -> np.ndarray:
    """A signal of these frequencies [Hz] and amplitudes."""
    t = DT * np.arange(round(seconds / DT))
    return sum(size * np.sin(2 * np.pi * rate * t) for rate, size in parts)[:, None]


# What is measured.


def test_the_fast_share_of_sines_is_known() -> None:
    assert metrics.fast_share(waves((5.0, 1.0)), DT) == pytest.approx(1.0, abs=1e-6)
    assert metrics.fast_share(waves((1.0, 1.0)), DT) == pytest.approx(0.0, abs=1e-6)
    assert metrics.fast_share(waves((0.5, 3.0), (8.0, 1.0)), DT) == pytest.approx(0.1, abs=1e-3)
    both = np.hstack([waves((0.5, 1.0)), waves((8.0, 1.0))])
    assert metrics.fast_share(both, DT) == pytest.approx(0.5, abs=1e-3)
    assert metrics.fast_share(np.zeros((100, 7)), DT) == 0.0
    assert metrics.fast_share(np.ones((1000, 1)), DT) == pytest.approx(0.0, abs=1e-6), "a constant is slow"
    assert metrics.fast_share((-1.0) ** np.arange(1000)[:, None], DT) > 0.99, "chatter from tick to tick is fast"


def test_the_jerk_of_a_cubic_is_known() -> None:
    t = DT * np.arange(200)
    v = np.column_stack([0.5 * 6.0 * t**2, np.zeros_like(t)])  # of q = t^3, whose jerk is 6, and of rest
    assert metrics.jerk(v, DT) == pytest.approx(6.0 / np.sqrt(2.0), rel=1e-6)
    assert metrics.jerk(np.column_stack([2.0 * t + 1.0]), DT) == pytest.approx(0.0, abs=1e-6)


def test_the_longest_stretch_is_counted_at_both_ends() -> None:
    for mask, most in (("", 0), ("000", 0), ("111", 3), ("110111", 3), ("1110011", 3), ("0101", 1)):
        assert metrics.longest(np.array([c == "1" for c in mask], dtype=bool)) == most


def test_a_robot_is_frozen_that_stands_still_though_it_could_be_nearer() -> None:
    v = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 0.5], [9e-5, -9e-5], [2e-4, 0.0]])
    excess = np.array([0.01, 0.001, 0.01, 0.01, 0.01])
    assert metrics.frozen(v, excess, 5e-3).tolist() == [True, False, False, True, False]


def test_coming_back_is_no_violation_and_going_out_again_is() -> None:
    low, high = np.array([-1.0, -1.0]), np.array([1.0, 1.0])
    back = metrics.ranges(np.array([[1.2, 0.0], [1.1, 0.0], [1.0, 0.0], [0.9, 0.0]]), low, high)
    assert back == metrics.Ranges(ticks=0, worst=0.0, back=2, further=0.0)
    again = metrics.ranges(np.array([[1.2, 0.0], [0.9, 0.0], [1.3, 0.0], [0.0, 0.0]]), low, high)
    assert (again.ticks, again.back, again.further) == (1, 1, 0.0)
    assert again.worst == pytest.approx(0.3)
    never = metrics.ranges(np.array([[0.0, -1.2], [0.0, -1.5], [0.0, -1.1]]), low, high)
    assert (never.ticks, never.worst, never.back) == (0, 0.0, None)
    assert never.further == pytest.approx(0.3)
    assert metrics.ranges(np.zeros((3, 2)), low, high).back == 0


def test_too_fast_is_counted_beyond_round_off() -> None:
    v = np.array([[1.0, -1.0], [1.0 + 1e-12, 0.0], [1.5, -3.0]])
    ticks, worst = metrics.overspeed(v, np.array([1.0, 2.0]))
    assert ticks == 1
    assert worst == pytest.approx(1.0)


# What the hand does.


def test_a_hand_starts_at_rest_where_the_frame_is() -> None:
    p, R = np.array([0.3, 0.1, 0.5]), np.eye(3)
    for s in SCENES:
        for hand in s.motions.values():
            (a, A), (b, B) = hand.at(0.0, p, R), hand.at(1e-4, p, R)
            np.testing.assert_array_equal(a, p)
            np.testing.assert_allclose(A, R, atol=1e-15)
            assert np.linalg.norm(b - a) < 1e-9, "from rest"
            assert np.linalg.norm(log(B @ A.T)) < 1e-9


def test_a_wave_can_go_out_and_back_on_one_side() -> None:
    hand = Hand((Sway(0.5, move=(0.2, 0.0, 0.0), phase=-np.pi / 2),), ease=1e-9)
    x = np.array([hand.at(t, np.zeros(3), np.eye(3))[0][0] for t in np.linspace(0.0, 2.0, 201)])
    assert x.min() >= -1e-12
    assert x.max() == pytest.approx(0.4)
    assert x[-1] == pytest.approx(0.0, abs=1e-12)


def test_a_hand_can_stop_and_stand() -> None:
    hand = Hand((Sway(0.5, move=(0.2, 0.0, 0.0)),), ease=1e-9, until=0.3)
    (before, _), (at, _), (after, _) = (hand.at(t, np.zeros(3), np.eye(3)) for t in (0.2, 0.3, 5.0))
    assert before[0] < at[0] == after[0]


def test_what_no_configuration_avoids() -> None:
    near, far = scene("figure eight").stream(3.0), scene("out of reach").stream(3.5)
    frame = near.scene.frames[0]
    assert inevitable(near).max() < 1e-6
    least = inevitable(far)
    assert least[0] < 1e-6
    assert 0.3 < least.max() < 0.6
    beyond = np.linalg.norm(far.positions[frame] - [0.0, 0.0, 0.333], axis=1) - least
    assert 0.7 < beyond[least > 0.01].min() <= beyond[least > 0.01].max() < 1.1, "the arm is as long as it is"


def test_the_errors_of_a_robot_that_stands_are_those_of_its_targets() -> None:
    stream = scene("figure eight").stream(1.0)
    frame = stream.scene.frames[0]
    far, turned = errors(stream, stream.q)
    moved = np.linalg.norm(stream.positions[frame] - stream.positions[frame][0], axis=1)
    np.testing.assert_allclose(far, moved, atol=1e-12)
    assert turned[0] < 1e-12 < turned[-1]


# What this library does.


def test_frames_that_stand_are_measured_apart_from_those_that_are_led() -> None:
    stream = scene("humanoid").stream(0.1)
    assert stream.scene.led == ["left_rubber_hand", "right_rubber_hand"]
    assert stream.scene.standing == ["left_ankle_roll_link", "right_ankle_roll_link"]
    moved = stream.q.copy()
    moved[5:, 0] += 0.01  # the base
    np.testing.assert_allclose(strayed(stream, moved), np.where(np.arange(len(stream)) < 5, 0.0, 0.01), atol=1e-12)
    far, turned = errors(stream, stream.q)
    assert (far.shape, turned.size) == ((len(stream),), 0)
    assert inevitable(stream, [0])[0] < 1e-4


@pytest.mark.parametrize("name", [s.name for s in KNOWN])
def test_ours_answers_every_tick_and_passes_no_limit(name: str) -> None:
    stream, runs = scene(name).stream(1.5), own_runs(name)
    low, high = stream.robot.position_limit
    for run in runs:
        assert not run.held.any()
        assert not run.raised
        kept = metrics.ranges(run.q, low, high)
        assert (kept.ticks, kept.further <= metrics.ROUND_OFF) == (0, True)
        assert metrics.overspeed(run.v, stream.robot.velocity_limit)[0] == 0
        assert kept.back is not None
        assert (kept.back > 0) == bool(stream.scene.beyond)
        assert kept.back * DT < 0.5


def test_ours_brakes_where_it_is_told_to() -> None:
    strict, braked = (next(r for r in own_runs("outside") if r.name == f"hqp {kind}") for kind in ("strict", "braked"))
    inside = metrics.ranges(braked.q, *scene("outside").load().position_limit).back
    changes = [np.abs(np.diff(run.v[inside:], axis=0)).max() / DT for run in (strict, braked)]
    assert changes[1] <= setups.ACCELERATION + 1e-6 < changes[0]


def test_motions_are_the_same_again_and_times_are_of_all_rounds() -> None:
    first = own_runs("stretched", 0.5)
    again = drive(scene("stretched").stream(0.5), [setup.driver for setup in OWN], rounds=2)
    for one, other in zip(first, again, strict=True):
        np.testing.assert_array_equal(one.q, other.q)
        assert (one.ns.shape, other.ns.shape) == ((1, 100), (2, 100))
        assert np.isnan(other.ns[:, :COLD]).all(), "caches of somebody else"
        assert (other.ns[:, COLD:50] > 0).all()


def test_slow_joints_are_a_tenth_as_fast_for_everyone() -> None:
    slow, full = scene("slow joints").stream(0.1), scene("figure eight").stream(0.1)
    np.testing.assert_allclose(slow.robot.velocity_limit, 0.1 * full.robot.velocity_limit)
    for setup in SETUPS:
        if not setup.missing():
            (run,) = drive(replace(scene("slow joints"), gain=100.0).stream(1.0), [setup.driver])
            assert np.abs(run.v).max() < 0.3, setup.name
            assert np.abs(run.v).max() > 0.2, setup.name


def measured(name: str, seconds: float = 1.5) -> dict[str, Measure]:
    stream, runs = scene(name).stream(seconds), own_runs(name, seconds)
    forced = inevitable(stream)
    return measure(stream, runs, track(stream, runs, forced), forced, {setup.name: setup for setup in OWN})


def test_a_table_has_a_row_a_run_and_fits_the_terminal() -> None:
    for name in "stretched", "outside":
        rows = table(scene(name), measured(name))
        assert [row["method"] for row in rows] == [setup.name for setup in OWN]
        assert all({*SHOWN, COMING_BACK} <= set(row) for row in rows)
        assert (COMING_BACK in shown(scene(name), rows)[0]) == (name == "outside")
        assert all(float(row["mm"]) <= float(row["max"]) for row in rows)
        assert all(float(row["mm"]) <= float(row["whole mm"]) for row in rows)


def code(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> object:
    """The exit code of the command."""
    monkeypatch.setattr("sys.argv", ["benchmarks", "teleop", *arguments])
    with pytest.raises(SystemExit) as leaving:
        main()
    return leaving.value.code


# Beside others.


def peer(name: str) -> Peer:
    found = next(setup for setup in SETUPS if setup.name == name)
    assert isinstance(found, Peer)
    if why := found.missing():
        pytest.skip(why)
    return found


#: Who lags even in reach: what damps the level of the orientation is added to the one QP, and holds the position back.
LAGS = "roboplan levels lm"


@pytest.mark.parametrize("name", [s.name for s in SETUPS if isinstance(s, Peer) and s.name != LAGS])
def test_peers_follow_the_same_hand(name: str) -> None:
    """Slowly and in reach all lead the hand the same way, whatever they keep besides."""
    stream = scene("figure eight").stream(1.0)
    other, ours = drive(stream, [peer(name).driver, OWN[0].driver])
    assert not other.held.any()
    still = np.zeros(stream.robot.nv)
    ends = [stream.robot.at(run.q[-1], still).frame(stream.scene.frames[0]).position for run in (other, ours)]
    assert np.linalg.norm(ends[0] - ends[1]) < 1e-3
    assert np.linalg.norm(ours.v[-1]) > 0.1


@pytest.mark.parametrize(("name", "near"), [("pink daqp lm", 0.02), ("mink daqp", 0.01), ("mink daqp lm", 0.01)])
def test_peers_come_back_where_a_tick_is_enough_for_their_share_of_the_way(name: str, near: float) -> None:
    """They ask for a share of the way back at once, 0.5 and 0.95: more than the speed limit allows is infeasible."""
    for far, held in (near, 0), (1.5 * near, 20):
        stream = replace(scene("outside"), beyond={"panda_joint4": -far}).stream(0.1)
        (run,) = drive(stream, [peer(name).driver])
        assert run.held.sum() == held
        assert (metrics.ranges(run.q, *stream.robot.position_limit).back is None) == bool(held)
        assert (run.raised == {"NoSolutionFound": 20}) == bool(held)


def test_pink_stops_at_a_joint_outside_unless_told_not_to() -> None:
    (run,) = drive(scene("outside").stream(0.1), [peer("pink daqp").driver])
    assert run.held.all()
    assert run.raised == {"NotWithinConfigurationLimits": 20}
    assert not run.v.any()


def test_peers_that_are_not_here_are_left_out_aloud(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(setups, "find_spec", lambda name: None if name in {"pink", "daqp", "roboplan"} else object())
    left = [setup.missing() for setup in SETUPS if setup.missing()]
    assert left[0].startswith("pink daqp: left out, pink is not installed")
    assert any(why.startswith("mink daqp lm: left out, daqp is not installed") for why in left)
    assert len(left) == len(SETUPS) - len(OWN)
    assert code(monkeypatch, "-s", "stretched", "--seconds", "0.2", "--rounds", "1") == 0
    said = " ".join(capsys.readouterr().out.split())
    for why in left:
        assert why in said
    assert "hqp damped" in said


# The command.


def test_a_short_run_fills_tables_csv_and_pictures(tmp_path: Path) -> None:
    out, plot = tmp_path / "deep" / "teleop.csv", tmp_path / "pictures"
    chosen = ("-s", "outside", "-s", "ur5 stretched", "--seconds", "0.5", "--rounds", "1")
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "teleop", *chosen, "--out", str(out), "--plot", str(plot)],
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.read_text().splitlines()))
    here = [setup.name for setup in SETUPS if not setup.missing()]
    assert [(row["scene"], row["method"]) for row in rows] == [
        (name, method) for name in ("outside", "ur5 stretched") for method in here
    ]
    for row in rows:
        assert float(row["p50"]) > 0
        if row["method"].startswith("hqp"):
            assert (row["raised"], row["out"], row["over"], row["further"]) == ("0", "0", "0", "0")
    assert {path.name for path in plot.iterdir()} == {"teleop-outside.png", "teleop-ur5-stretched.png"}
    assert "outside: three joints start" in done.stdout
    assert "…" not in done.stdout, "all columns fit"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-s", "nonsense"), "unknown scene 'nonsense'; there are figure eight, tremor, stretched, out of reach"),
        (("--seconds", "0"), "'--seconds'"),
        (("--rounds", "0"), "'--rounds'"),
        (("--out", "."), "'.'; a table is called .csv"),
        (("--out", ""), "'--out' / '-o': it is empty"),
        (("--plot", "/dev/null/here"), "cannot write to the folder '/dev/null/here': "),
    ],
)
def test_wrong_input_is_one_line(
    arguments: tuple[str, ...], said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert code(monkeypatch, *arguments) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("benchmarks: ")
    assert said in told.err
    assert told.err.count("\n") == 1
