"""The benchmarks run, measure what they say, and refuse what they cannot."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.__main__ import main
from benchmarks.control import CONTRADICTION, CONTROL, moved
from benchmarks.families import FAMILIES, Family
from benchmarks.measure import measure
from benchmarks.methods import DAQP_COST, DAQP_ROWS, RACED, TIGHT, method, raced
from benchmarks.race import COLD, Timing, race
from benchmarks.ratios import table, yardstick
from benchmarks.tick import PEERS, _drivers
from benchmarks.ticks.interleaved import measure as measure_ticks
from benchmarks.ticks.redundancy import STACKS
from benchmarks.ticks.scenes import SCENES, Scene
from benchmarks.ticks.stream import record
from hqp import Hierarchy, InvalidInput, certify, solve

ROOT = Path(__file__).parents[2]


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "benchmarks", *arguments], capture_output=True, text=True, cwd=ROOT, check=False
    )


def refused(done: subprocess.CompletedProcess[str], said: str) -> None:
    assert done.returncode == 2
    assert done.stdout == ""  # nothing was measured before
    assert done.stderr.startswith("benchmarks: ")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1


def test_without_a_command_it_tells_the_commands() -> None:
    done = run()
    assert done.returncode == 0
    assert "backends" in done.stdout
    assert "solve" in done.stdout


def test_a_small_run_fills_table_and_csv(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "table.csv"
    backends = ("-b", "pseudoinverse", "-b", "cascade:proxsuite", "-b", "cascade:osqp")
    done = run("backends", "-n", "4", *backends, "-o", str(out))
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert [(row["family"], row["backend"]) for row in rows] == [
        ("equalities", "pseudoinverse"),
        ("equalities", "cascade:proxsuite"),
        ("equalities", "cascade:osqp"),
        ("mixed", "cascade:proxsuite"),
        ("mixed", "cascade:osqp"),
        ("adversarial", "cascade:proxsuite"),
        ("adversarial", "cascade:osqp"),
    ]
    for row in rows:
        assert row["certified"] == row["rejected"] == "100.00%"
        assert float(row["cold us"]) > 0
        assert row["backend"] in done.stdout
    assert {row["ratio"] for row in rows if row["backend"] == "cascade:proxsuite"} == {"1.00"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-b", "pseudoinverse", "-f", "mixed"), "nothing to measure; mixed: left out, pseudoinverse takes no inequal"),
        (
            ("-b", "pseudoinverse:joint"),
            "equalities: left out, pseudoinverse:joint aims at the optimum of another hier",
        ),
        (("--count", "0"), "'--count'"),
        (("--count", "-1"), "'--count'"),
        (("--count", "abc"), "'--count'"),
        (("--seed", "-1"), "'--seed'"),
        (("extra",), "unexpected extra argument"),
        (("--out", ""), "'--out' / '-o': it is empty"),
        (("--out", "/dev/null/here/table.csv"), "cannot write to the folder '/dev/null/here': "),
        (("--out", "."), "cannot write '.': Is a directory"),
        (("-b", "nonsense"), "unknown backend 'nonsense'; installed here: "),
        (("-f", "nonsense"), "unknown family 'nonsense'; there are equalities, mixed"),
    ],
)
def test_wrong_input_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    done = run("backends", "-n", "1", *arguments)
    refused(done, said)


def test_a_family_that_no_backend_takes_is_left_out_aloud() -> None:
    done = run("backends", "-n", "1", "-b", "pseudoinverse")
    assert done.returncode == 0, done.stderr
    assert "mixed: left out, pseudoinverse takes no inequalities" in done.stdout
    assert "equalities: the shapes" in done.stdout
    assert measure(FAMILIES[1], ["pseudoinverse"], 3, 0) == []


def test_an_interruption_is_exit_code_130(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("benchmarks.backends.measure", interrupted)
    monkeypatch.setattr("sys.argv", ["benchmarks", "backends", "-n", "1"])
    with pytest.raises(SystemExit) as leaving:
        main()
    assert leaving.value.code == 130
    assert capsys.readouterr().err.endswith("benchmarks: interrupted; what was finished is kept\n")


ROWS = {
    "P1": (3, (2, 1, 3)),
    "P2": (7, (7, 3, 3, 7)),
    "P3": (30, (30, 12, 3, 6, 10, 30)),
    "P3h": (30, (30, 12, 3, 6, 11, 30)),
    "P4": (60, (60, 12, 6, 6, 12, 6, 10, 60)),
}


def family(name: str) -> Family:
    return next(family for family in CONTROL if family.name == name)


def draws(name: str, count: int = 4, seed: int = 0) -> list[Hierarchy]:
    return list(family(name).problems(count, seed))


def numbers(h: Hierarchy) -> np.ndarray:
    return np.concatenate([h.A.ravel(), h.lower, h.upper, h.weights])


@pytest.mark.parametrize("name", ROWS)
def test_the_families_of_a_controller_are_made_as_told(name: str) -> None:
    n, rows = ROWS[name]
    for h in draws(name):
        assert (h.n, tuple(len(level) for level in h.levels)) == (n, rows)
        np.testing.assert_allclose(h.row_norms(), 1.0, rtol=1e-14)
        limits, posture = h.levels[0], h.levels[-1]
        if name != "P1":
            assert (limits.lower == -1).all()
            assert (limits.upper == 1).all()
        np.testing.assert_array_equal(h.matrix(len(rows) - 1), np.eye(n))
        assert (posture.lower == posture.upper).all()
        for level in h.levels:
            equal = level.lower == level.upper
            assert equal.all() or not equal.any()
    assert family(name).about.startswith(f"n = {n}: ")


@pytest.mark.parametrize("name", ROWS)
def test_a_draw_is_named_by_its_seed_and_number(name: str) -> None:
    long, short, other = draws(name, 4), draws(name, 2), draws(name, 1, seed=1)
    for a, b in zip(long, short, strict=False):
        np.testing.assert_array_equal(numbers(a), numbers(b))
    assert not np.array_equal(numbers(long[0]), numbers(long[1]))
    assert not np.array_equal(numbers(long[0]), numbers(other[0]))


def test_p3h_has_a_level_that_cannot_be_met() -> None:
    for h in draws("P3h"):
        level = h.levels[4]
        assert level.A is not None
        np.testing.assert_array_equal(level.A[0], level.A[-1])
        assert level.lower[-1] - level.upper[0] == pytest.approx(CONTRADICTION)
        assert solve(h).levels[4].residual_norm >= CONTRADICTION / np.sqrt(2) - 1e-9


@pytest.mark.parametrize("name", ROWS)
def test_moved_changes_equality_targets_and_nothing_else(name: str) -> None:
    for h in draws(name, 2):
        before = numbers(h)
        still, twin = (moved(h, np.random.default_rng(3), share) for share in (0.0, 0.1))
        np.testing.assert_array_equal(numbers(h), before)
        np.testing.assert_array_equal(numbers(still), before)
        np.testing.assert_array_equal(twin.A, h.A)
        equal = h.lower == h.upper
        np.testing.assert_array_equal(twin.lower == twin.upper, equal)
        np.testing.assert_array_equal(twin.lower[~equal], h.lower[~equal])
        np.testing.assert_array_equal(twin.upper[~equal], h.upper[~equal])
        for level, other in zip(h.levels, twin.levels, strict=True):
            if (level.lower == level.upper).all() and len(level) > 1:
                assert (level.lower != other.lower).all()


@pytest.mark.parametrize("name", ROWS)
def test_daqp_is_certified_on_rows_of_norm_one(name: str) -> None:
    pytest.importorskip("daqp")
    for h in draws(name, 8):
        assert solve(h, backend="daqp").certify().ok


@pytest.mark.parametrize("name", ROWS)
def test_both_forms_of_daqp_solve_the_same_problem(name: str) -> None:
    pytest.importorskip("daqp")
    for h in draws(name, 2):
        x = solve(h).x
        for form in DAQP_ROWS, DAQP_COST:
            np.testing.assert_allclose(method(form).cold(h)(), x, atol=1e-6)
            assert certify(h, method(form).warm(h, h)(), tolerance=1e-6).ok
    assert TIGHT["primal_tol"] == 1e-9


def test_the_race_is_run_by_what_is_here(monkeypatch: pytest.MonkeyPatch) -> None:
    assert set(raced()) <= set(RACED)
    assert {"cascade:proxsuite", "pseudoinverse"} <= set(raced())
    monkeypatch.setattr("benchmarks.methods.available_backends", lambda: ("native", "cascade:osqp"))
    assert raced() == ["native"]
    assert method("native").name == "native"
    with pytest.raises(InvalidInput, match="unknown method 'nonsense'; there are daqp"):
        method("nonsense")


def test_a_race_pairs_every_draw_and_start() -> None:
    seen = []
    methods = [method("pseudoinverse"), method("cascade:proxsuite")]
    timings = race(family("P1"), methods, 2, 10, [0.0, 0.1], lambda: seen.append(1))
    assert len(seen) == 20
    assert {t.start for t in timings} == {COLD, "0 %", "10 %"}
    assert all(t.certified and t.seconds > 0 and t.error < 1e-9 for t in timings)
    keys = {m.name: [(t.draw, t.start) for t in timings if t.method == m.name] for m in methods}
    assert len(keys["pseudoinverse"]) == len(set(keys["pseudoinverse"])) == 60
    assert len(keys["cascade:proxsuite"]) == 30  # slow: every other draw
    assert set(keys["cascade:proxsuite"]) < set(keys["pseudoinverse"])
    assert race(family("P2"), [method("pseudoinverse")], 1, 1, []) == []


def test_ratios_are_taken_draw_by_draw_to_the_better_form() -> None:
    times = {DAQP_ROWS: [4.0, 4.0, 4.0], DAQP_COST: [1.0, 2.0, 5.0], "native": [1.0, 1.0, 10.0]}
    timings = [
        Timing(name, COLD, draw, 1e-6 * some, draw > 0, 0.0)
        for name, all_ in times.items()
        for draw, some in enumerate(all_)
    ]
    assert yardstick(timings) == DAQP_COST
    rows, cost, native = table("P2", timings)
    assert (native["ratio"], native["of medians"], native["median us"]) == ("1", "0.5", "1.0")
    assert (rows["ratio"], cost["ratio"], rows["certified"]) == ("2", "1", "2/3")
    assert table("P2", timings[:3])[0]["ratio"] == "1"
    alone = [t for t in timings if t.method == "native"]
    assert yardstick(alone) is None
    assert table("P2", alone)[0]["ratio"] == ""


def test_a_small_race_fills_tables_and_csv(tmp_path: Path) -> None:
    out = tmp_path / "race.csv"
    done = run("solve", "--seeds", "1", "--draws", "2", "-o", str(out))
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert list(dict.fromkeys(row["family"] for row in rows)) == list(ROWS)
    assert list(dict.fromkeys(row["start"] for row in rows)) == [COLD, "0 %", "2 %", "10 %"]
    for row in rows:
        assert row["method"] in raced()
        assert row["method"] != "pseudoinverse" or row["family"] == "P1"
        assert float(row["median us"]) > 0
        assert row["certified"].endswith("/2")
        if not row["method"].startswith("daqp"):
            assert row["certified"] == "2/2", row
    for f in CONTROL:
        assert f"{f.name}: {f.about}" in done.stdout


def test_a_race_of_chosen_ones() -> None:
    few = ("--draws", "1", "--seeds", "1", "--moved", "0.05")
    done = run("solve", "-f", "P2", "-f", "P1", "-m", "pseudoinverse", *few)
    assert done.returncode == 0, done.stderr
    assert "P1: n = 3" in done.stdout
    assert "P2: left out, no method takes it" in done.stdout
    assert "5 %" in done.stdout
    assert "ratios to" not in done.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-f", "nonsense"), "unknown family 'nonsense'; there are P1, P2, P3, P3h, P4"),
        (("-m", "nonsense"), "unknown method 'nonsense'; there are daqp.solve/rows, daqp.solve/cost, "),
        (("--seeds", "0"), "'--seeds'"),
        (("--draws", "0"), "'--draws'"),
        (("--moved", "-1"), "'--moved'"),
        (("--moved", "inf"), "--moved inf: give finite shares"),
        (("--out", "."), "cannot write '.': Is a directory"),
    ],
)
def test_wrong_input_of_a_race_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    refused(run("solve", "--seeds", "1", "--draws", "1", *arguments), said)


def scene(name: str) -> Scene:
    return next(s for s in SCENES if s.name == name)


def test_a_few_ticks_fill_tables_and_csv(tmp_path: Path) -> None:
    out = tmp_path / "tick.csv"
    done = run("tick", "--ticks", "20", "--rounds", "1", "-o", str(out))
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert list(dict.fromkeys(row["scene"] for row in rows)) == [s.name for s in SCENES]
    for row in rows:
        assert float(row["median us"]) > 0
        if row["method"] == "hqp":
            assert (row["kept"], row["proved"], float(row["off"])) == ("100%", "1/1", 0.0)
    for s in SCENES:
        assert f"{s.name}: {s.about}" in done.stdout
    alone = done.stdout[done.stdout.index("what else the joints are used for") :]
    for name in STACKS:
        assert re.search(rf"{re.escape(name)} .* 20/20", alone), name
    for peer in {name for name, _, _ in PEERS}:
        here = any(row["method"].startswith(peer) for row in rows)
        assert here != (f"{peer}: left out, it is not installed: python -m pip install -e '.[peers]'" in done.stdout)


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
        (("--out", "."), "cannot write '.': Is a directory"),
    ],
)
def test_wrong_input_of_a_tick_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    refused(run("tick", "--ticks", "1", "--rounds", "1", *arguments), said)


def test_poses_are_solved_by_ours_and_by_what_is_here(tmp_path: Path) -> None:
    pytest.importorskip("pinocchio")
    from benchmarks.ik_methods import METHODS, missing

    out = tmp_path / "ik.csv"
    done = run("ik", "-n", "3", "-r", "ur5", "-b", "300", "--seed", "5", "-o", str(out))
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.read_text().splitlines()))
    here = [kind.name for kind in METHODS if not missing(kind)]
    assert [(row["method"], row["restarts"]) for row in rows] == [(m, r) for m in here for r in ("on", "off")]
    for kind in METHODS:
        assert not missing(kind) or missing(kind) in " ".join(done.stdout.split())
    for row in rows:
        assert (row["family"], row["budget"]) == ("ur5", "300")
        assert float(row["median ms"]) > 0
        assert not row["method"].startswith("native") or row["outside"] == "0"
    assert rows[0]["solved"] == "100.0%"


def test_peers_that_are_not_here_are_left_out_aloud(monkeypatch: pytest.MonkeyPatch) -> None:
    from benchmarks import ik_methods

    monkeypatch.setattr(ik_methods, "find_spec", lambda name: None)
    assert [kind.name for kind in ik_methods.METHODS if not ik_methods.missing(kind)] == [
        "native",
        "native, strict",
        "native, posture",
    ]
    assert ik_methods.missing(ik_methods.Mink).startswith("mink: left out, mink, mujoco, daqp is not installed")


@pytest.mark.parametrize("peer", ["Pink", "Mink"])
def test_a_peer_stands_where_ours_stands(peer: str) -> None:
    pytest.importorskip("pinocchio")
    from benchmarks import ik, ik_methods
    from tasks import load_robot

    kind = getattr(ik_methods, peer)
    if why := ik_methods.missing(kind):
        pytest.skip(why)
    for name, held in ik.MACHINES.items():
        robot = load_robot(name, lock=held)
        method, target = kind(robot, True), ik.poses(robot, 1, 0)[0]
        q = robot.random(np.random.default_rng(0))
        method.move(q)
        tip = robot.at(q, np.zeros(robot.nv)).frame()
        for mine, other in zip(method.place(), (tip.position, tip.rotation), strict=True):
            np.testing.assert_allclose(mine, other, atol=1e-9)
        assert method.solve(target, 300).reached


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-r", "nonsense"), "unknown robot 'nonsense'; there are panda, ur5"),
        (("-b", "0"), "'--budget'"),
        (("-n", "0"), "'--count'"),
        (("--out", "."), "cannot write '.': Is a directory"),
    ],
)
def test_wrong_input_of_the_poses_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    pytest.importorskip("pinocchio")
    refused(run("ik", *arguments), said)
