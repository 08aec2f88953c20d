"""The races and ticks run, measure what they say, and refuse what they cannot."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from command import called, refused, run
from spelling import Option, numeric

from benchmarks.__main__ import app
from benchmarks.families.control import CONTROL
from benchmarks.methods import METHODS, required
from benchmarks.methods.daqp_direct import DAQP_COST, DAQP_ROWS, TOLERANCES
from benchmarks.race import COLD, ONE_SHOT, RACED, Timing, race, raced
from benchmarks.ratios import table, yardstick
from benchmarks.standing.scenes import SCENES as STANDING
from benchmarks.tables import save
from benchmarks.tick import PEERS, _drivers
from benchmarks.ticks.interleaved import measure as measure_ticks
from benchmarks.ticks.redundancy import STACKS
from benchmarks.ticks.scenes import SCENES, Scene
from benchmarks.ticks.stream import record
from hqp import InvalidInput, certify, solve

#: With rows of norm one, as DAQP takes them, and a posture, which it can take as its cost.
UNIT = [name for name, family in CONTROL.items() if family.posture]


def test_without_a_command_it_tells_the_commands() -> None:
    done = run()
    assert done.returncode == 0
    assert "compare" in done.stdout
    assert "solve" in done.stdout


@pytest.mark.parametrize("name", UNIT)
def test_daqp_is_certified_on_rows_of_norm_one(name: str) -> None:
    pytest.importorskip("daqp")
    for h in CONTROL[name].problems(8, 0):
        assert solve(h, backend="daqp").certify().ok


@pytest.mark.parametrize("name", UNIT)
def test_both_forms_of_daqp_solve_the_same_problem(name: str) -> None:
    pytest.importorskip("daqp")
    for h in CONTROL[name].problems(2, 0):
        x = solve(h).x
        for form in DAQP_ROWS, DAQP_COST:
            method = METHODS[form]
            cold, warm = (method.outcome(call()) for call in (method.cold(h), method.warm(h, h)))
            assert cold.claimed
            assert cold.iterations > 0
            np.testing.assert_allclose(cold.x, x, atol=1e-6)
            assert certify(h, warm.x, tolerance=1e-6).ok
    assert TOLERANCES["primal_tol"] == 1e-9


def test_the_race_is_run_by_what_is_here(monkeypatch: pytest.MonkeyPatch) -> None:
    names = [method.name for method in raced()]
    assert set(names) <= set(RACED)
    assert {"native", "cascade:proxsuite", "pseudoinverse"} <= set(names)
    monkeypatch.setattr(type(METHODS[DAQP_ROWS]), "missing", lambda self: "not here")
    assert not {DAQP_ROWS, DAQP_COST} & {method.name for method in raced()}
    with pytest.raises(InvalidInput, match=r"daqp\.solve/rows: not here"):
        required([METHODS["native"], METHODS[DAQP_ROWS]])


def test_a_race_pairs_every_draw_and_start() -> None:
    seen = []
    methods = [METHODS["pseudoinverse"], METHODS["cascade:proxsuite"]]
    timings = race(CONTROL["P1"], methods, 2, 10, [0.0, 0.1], lambda: seen.append(1))
    assert len(seen) == 20
    assert {t.start for t in timings} == {COLD, ONE_SHOT, "0 %", "10 %"}
    assert all(t.certified and t.seconds > 0 and t.error < 1e-9 for t in timings)
    keys = {m.name: [(t.draw, t.start) for t in timings if t.method == m.name] for m in methods}
    assert len(keys["pseudoinverse"]) == len(set(keys["pseudoinverse"])) == 80
    assert len(keys["cascade:proxsuite"]) == 40  # slow: every other draw
    assert set(keys["cascade:proxsuite"]) < set(keys["pseudoinverse"])
    assert race(CONTROL["P2"], [METHODS["pseudoinverse"]], 1, 1, []) == []


def test_ratios_are_taken_draw_by_draw_to_the_better_form() -> None:
    times = {DAQP_ROWS: [4.0, 4.0, 4.0], DAQP_COST: [1.0, 2.0, 5.0], "native": [1.0, 1.0, 10.0]}
    timings = [
        Timing(name, COLD, draw, 1e-6 * some, draw > 0, 0.0)
        for name, all_ in times.items()
        for draw, some in enumerate(all_)
    ]
    assert yardstick(timings) == DAQP_COST
    rows, cost, native = table("P2", timings)
    assert (native["ratio"], native["its p90"], native["of medians"]) == ("1", "1.8", "0.5")
    assert native["median us"] == "1.0"
    assert (rows["ratio"], cost["ratio"], rows["certified"]) == ("2", "1", "2/3")
    assert table("P2", timings[:3])[0]["ratio"] == "1"
    alone = [t for t in timings if t.method == "native"]
    assert yardstick(alone) is None
    assert table("P2", alone)[0]["ratio"] == ""


def test_a_small_race_fills_tables_and_csv(tmp_path: Path) -> None:
    out = tmp_path / "race.csv"
    done = called("solve", "--seeds", "1", "--draws", "1", "-o", str(out))
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert list(dict.fromkeys(row["family"] for row in rows)) == list(CONTROL)
    assert list(dict.fromkeys(row["start"] for row in rows)) == [COLD, ONE_SHOT, "0 %", "2 %", "10 %"]
    for row in rows:
        assert row["method"] in [method.name for method in raced()]
        assert row["method"] != "pseudoinverse" or row["family"] == "P1"
        assert float(row["median us"]) > 0
        assert row["certified"].endswith("/1")
        if not row["method"].startswith("daqp"):
            assert row["certified"] == "1/1", row
    for f in CONTROL.values():
        assert f"{f.name}: {f.about}" in done.stdout


def test_a_race_of_chosen_ones() -> None:
    few = ("--draws", "1", "--seeds", "1", "--moved", "0.05")
    done = called("solve", "-f", "P2", "-f", "P1", "-m", "pseudoinverse", *few)
    assert done.returncode == 0, done.stderr
    assert "P1: n = 3" in done.stdout
    assert "P2: left out, no method takes it" in done.stdout
    assert "5 %" in done.stdout
    assert "ratios to" not in done.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-f", "nonsense"), "unknown family 'nonsense'; there are P1, P2, P3, P3h, P4, W48, WB"),
        (("-m", "nonsense"), "unknown method 'nonsense'; there are native, pseudoinverse, "),
        (("--seeds", "0"), "'--seeds'"),
        (("--draws", "0"), "'--draws'"),
        (("--moved", "-1"), "'--moved'"),
        (("--moved", "inf"), "--moved inf: give finite shares"),
        (("--out", "."), "'.'; a table is called .csv"),
    ],
)
def test_wrong_input_of_a_race_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    refused(called("solve", "--seeds", "1", "--draws", "1", *arguments), said)


def scene(name: str) -> Scene:
    return next(s for s in SCENES if s.name == name)


def test_a_few_ticks_fill_tables_and_csv(tmp_path: Path) -> None:
    out = tmp_path / "tick.csv"
    done = called("tick", "--ticks", "20", "--rounds", "1", "-o", str(out))
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.read_text().splitlines()))
    arms = [s.name for s in SCENES]
    assert list(dict.fromkeys(row["scene"] for row in rows)) == [*arms, *(s.name for s in STANDING)]
    for row in rows:
        assert float(row["median us"]) > 0
        if row["method"] == "hqp" and row["scene"] in arms:
            assert (row["kept"], row["proved"], float(row["off"])) == ("100%", "1/1", 0.0)
            assert row["lost"] == "-" if row["scene"] == "humanoid" else float(row["lost"]) < 1e-9
        elif row["method"] == "hqp":
            assert (row["lost"], row["proved"], row["failed"]) == ("0e+00", "1/1", "0")
    for s in (*SCENES, *STANDING):
        assert f"{s.name}: {s.about}" in done.stdout
    alone = done.stdout[done.stdout.index("what else the joints are used for") :]
    for name in STACKS:
        assert re.search(rf"{re.escape(name)} .* 20/20", alone), name
    for peer in PEERS:
        assert any(row["method"] == peer.name for row in rows) != (f"{peer.name}: left out, " in done.stdout)


def test_lower_levels_cost_a_strict_first_one_nothing() -> None:
    from benchmarks.strictness import METHODS, STACKS, strictness

    held, rows, left_out = strictness(6)
    active, states = map(int, held.split(" of "))
    assert 0 < active < states == 6 * len(STACKS)
    assert len(rows) + len(left_out) == len(METHODS)
    strict, *others = rows
    columns = [scene.name for scene in STACKS]
    assert max(float(strict[column]) for column in [*columns, "alone", "second"]) < 1e-9
    assert (strict["method"], strict["lost"]) == ("hqp strict", "0")
    for row in others:
        assert row["method"].startswith("roboplan levels") or int(row["lost"]) > 0, row["method"]


def test_a_slow_motion_reaches_no_limit_and_a_fast_one_does() -> None:
    slow, fast = (record(scene(f"panda {name}"), 200) for name in ("slow", "saturated"))
    assert slow.saturated == 0.0
    assert fast.saturated > 2.0
    assert len(slow) == len(slow.q) == len(slow.v) == 200


@pytest.mark.parametrize("peer", ["pink", "mink"])
def test_peers_are_asked_for_the_same_motion(peer: str) -> None:
    pytest.importorskip(peer, reason=f"{peer} is not among the test tools: pip install 'hqp[peers]'")
    stream = record(scene("panda slow"), 60)
    ours, *others = measure_ticks(_drivers(stream, None), rounds=1)
    assert ours.proved == [True]
    found = [other for other in others if other.name.startswith(peer)]
    assert found
    for other in found:
        assert np.isfinite(other.v).all()
        assert (np.linalg.norm(other.v - ours.v, axis=1)[1:] < 0.02 * np.linalg.norm(ours.v, axis=1)[1:]).all()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-s", "nonsense"), "unknown scene 'nonsense'; there are panda slow, panda saturated, humanoid"),
        (("--ticks", "0"), "'--ticks'"),
        (("--rounds", "0"), "'--rounds'"),
        (("--placo", "/nowhere/python"), "--placo /nowhere/python: No such file or directory"),
        (("--placo", "/bin/false"), "--placo /bin/false: it ended without a word"),
        (("--tsid", "/nowhere/python"), "--tsid /nowhere/python: No such file or directory"),
        (("--drake", "/bin/false"), "--drake /bin/false: it ended without a word"),
        (("--out", "."), "'.'; a table is called .csv"),
    ],
)
def test_wrong_input_of_a_tick_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    refused(called("tick", "--ticks", "1", "--rounds", "1", *arguments), said)


def test_poses_are_solved_by_ours_and_by_what_is_here(tmp_path: Path) -> None:
    pytest.importorskip("pinocchio")
    from benchmarks.ik_methods import METHODS, missing

    out = tmp_path / "ik.csv"
    done = called("ik", "-n", "3", "-r", "ur5", "-a", "1", "-a", "10", "--seed", "5", "-o", str(out))
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.read_text().splitlines()))
    here = [kind.name for kind in METHODS if not missing(kind)]
    assert [(row["attempts"], row["method"]) for row in rows] == [(a, m) for a in ("1", "10") for m in here]
    for kind in METHODS:
        assert not missing(kind) or missing(kind) in " ".join(done.stdout.split())
    for row in rows:
        assert row["family"] == "ur5"
        assert 0 < float(row["p50 ms"]) <= float(row["p95 ms"])
        assert not row["method"].startswith("native") or row["outside"] == "0"
    assert rows[len(here)]["solved"] == "100.0%"


def test_peers_that_are_not_here_are_left_out_aloud(monkeypatch: pytest.MonkeyPatch) -> None:
    from benchmarks import ik_methods

    monkeypatch.setattr(ik_methods, "find_spec", lambda name: None)
    assert [kind.name for kind in ik_methods.METHODS if not ik_methods.missing(kind)] == [
        "native",
        "native, strict",
        "native, posture",
    ]
    assert ik_methods.missing(ik_methods.Mink).startswith("mink: left out, mink, mujoco, daqp is not installed")


@pytest.mark.parametrize("peer", ["Pink", "Mink", "Oink"])
def test_a_peer_stands_where_ours_stands(peer: str) -> None:
    pytest.importorskip("pinocchio")
    from benchmarks import ik, ik_methods

    kind = getattr(ik_methods, peer)
    if why := ik_methods.missing(kind):
        pytest.skip(why)
    for machine in ik.MACHINES.values():
        robot = machine.load()
        method, target = kind(robot, True), ik.poses(robot, 1, 0)[0]
        q = robot.random(np.random.default_rng(0))
        method.move(q)
        tip = robot.at(q, np.zeros(robot.nv)).frame()
        for mine, other in zip(method.place(), (tip.position, tip.rotation), strict=True):
            np.testing.assert_allclose(mine, other, atol=1e-9)
        assert method.solve(target, 1000).reached


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-r", "nonsense"), "unknown robot 'nonsense'; there are panda, xarm7, ur5, g1 arm"),
        (("-a", "0"), "'--attempts'"),
        (("-b", "0"), "'--budget'"),
        (("-n", "0"), "'--count'"),
        (("--out", "."), "'.'; a table is called .csv"),
    ],
)
def test_wrong_input_of_the_poses_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    pytest.importorskip("pinocchio")
    refused(called("ik", *arguments), said)


@pytest.mark.parametrize("option", numeric(app), ids=lambda own: f"{own.command} {own.name}")
def test_what_spells_no_number_or_one_too_large_is_one_line(option: Option) -> None:
    for word in option.wrong():
        done = called(option.command, f"{option.name}={word}")
        refused(done, option.name)
        assert repr(word) in done.stderr or f" {word} must be at least" in done.stderr


@pytest.mark.parametrize("command", ["compile", "ik", "parts", "solve", "teleop", "tick"])
def test_a_table_is_called_as_one(command: str, tmp_path: Path) -> None:
    for name in "rows.png", "rows":
        refused(called(command, "-o", str(tmp_path / name)), "a table is called .csv")
    with pytest.raises(InvalidInput, match=r"a table is called \.csv"):
        save(tmp_path / "rows.png", [{"name": "one"}])
    assert list(tmp_path.iterdir()) == []
