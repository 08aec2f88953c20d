"""A sweep measures what its plan says, loses nothing, repeats nothing, and finds the same wherever it runs."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
import pyarrow.parquet as pq
import pytest
from command import ROOT, called, refused, run
from interrupts import heard

from benchmarks.analysis.comparison import differences, paired
from benchmarks.families import FAMILIES, Family
from benchmarks.methods import METHODS
from benchmarks.sweep import workers
from benchmarks.sweep.cell import STARTS, measure
from benchmarks.sweep.machine import describe, sources
from benchmarks.sweep.plan import Cell, Plan
from benchmarks.sweep.plans import PLANS
from benchmarks.sweep.schema import COLUMNS, KEYS, SCHEMA, TIMES
from benchmarks.sweep.store import Store
from hqp import InvalidInput

#: Quick, and with everything in it: several families, a slow method, one that takes no inequalities, two settings.
SMALL = Plan(
    "small",
    "for tests",
    families=("control/P[12]", "adversarial/vertex", "size/n 3", "thesis/line"),
    methods=("native", "pseudoinverse", "daqp.solve/rows", "cascade:osqp"),
    settings=("tight", "loose"),
    draws=6,
    few=2,
    block=2,
    rounds=2,
)
OPTIONS = [
    *(word for family in SMALL.families for word in ("-f", family)),
    *(word for method in SMALL.methods for word in ("-m", method)),
    *("-s", "tight", "-s", "loose", "--draws", "12"),
]


@pytest.fixture(scope="module")
def plan() -> Plan:
    return SMALL.resolved()[0]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that nobody interrupts."""
    folder = tmp_path_factory.mktemp("runs") / "undisturbed"
    done = run("run", "smoke", *OPTIONS, "-o", str(folder))
    assert done.returncode == 0, done.stderr
    return folder


def same(a: Path, b: Path) -> None:
    """Two runs have the same rows, and but for times the same in them."""
    first, second = Store.open(a).table(), Store.open(b).table()
    pairs = paired(first, second)
    assert len(pairs) == len(first) == len(second)
    assert differences(pairs) == {}


def test_a_plan_is_resolved_into_what_is_here(monkeypatch: pytest.MonkeyPatch) -> None:
    plan, left_out = SMALL.resolved()
    assert set(plan.families) <= set(FAMILIES)
    assert plan.methods == ("native", "pseudoinverse", "cascade:osqp", "daqp.solve/rows")  # in their own order
    assert left_out == []
    monkeypatch.setattr(type(METHODS["native"]), "missing", lambda self: "not here" if self.name != "native" else "")
    plan, left_out = SMALL.resolved()
    assert "native" in plan.methods
    assert "cascade:osqp: not here" in left_out
    with pytest.raises(InvalidInput, match="unknown family 'nonsense'"):
        replace(SMALL, families=("nonsense",)).resolved()
    with pytest.raises(InvalidInput, match="nothing to measure"):
        replace(SMALL, families=("control/P2",), methods=("pseudoinverse",)).resolved()


@pytest.mark.parametrize("name", PLANS)
def test_named_plans_have_cells_that_cover_every_draw_once(name: str) -> None:
    plan, _ = PLANS[name].resolved()
    cells = plan.cells()
    assert len({cell.name for cell in cells}) == len(cells)
    for key in plan.families:
        draws = [draw for cell in cells if cell.family == key for draw in range(cell.first, cell.last)]
        expected = min(plan.draws, FAMILIES[key].draws or plan.draws)
        assert sorted(draws) == (list(range(expected)) if draws else [])
    assert plan.digest != replace(plan, seed=1).digest


def test_slow_methods_get_few_draws_spread_over_all() -> None:
    slow, fast = METHODS["cascade:osqp"], METHODS["native"]
    plan = replace(SMALL, draws=64, few=8)
    assert [draw for draw in range(64) if plan.rounds_of(slow, draw)] == list(range(0, 64, 8))
    assert all(plan.rounds_of(fast, draw) == plan.rounds for draw in range(64))


def test_a_cell_has_a_row_for_everyone_and_repeats_itself(plan: Plan) -> None:
    cell = Cell("control/P2", 2, 4)
    rows, again = (pd.DataFrame(measure(plan, cell)) for _ in range(2))
    assert set(rows.columns) == set(COLUMNS)
    assert not rows.duplicated(list(KEYS)).any()
    part = rows.groupby(["method", "setting", "start"]).size()
    assert set(part.index.get_level_values("start")) == set(STARTS)
    assert part["native", "tight", "cold"] == 2
    assert ("native", "loose", "cold") not in part.index  # makes no difference to it
    assert part["daqp.solve/rows", "loose", "warm"] == 2
    assert "pseudoinverse" not in set(rows["method"])
    assert (rows["seconds"] > 0).all()
    assert (rows["slowest"] >= rows["seconds"]).all()
    tight = rows[rows["setting"] == "tight"]
    assert not tight["wrong"].any()
    assert (tight[tight["method"] == "native"]["certified"]).all()
    pd.testing.assert_frame_equal(rows.drop(columns=list(TIMES)), again.drop(columns=list(TIMES)))


def test_a_run_is_kept_with_schema_and_versions(undisturbed: Path, tmp_path: Path) -> None:
    store = Store.open(undisturbed)
    assert store.missing() == []
    file = next((undisturbed / "cells").glob("*.parquet"))
    assert pq.read_schema(file).equals(SCHEMA)
    assert b"about" in pq.read_schema(file).field("gap").metadata
    (machine,) = store.machines()
    assert machine == describe()
    assert machine["threads"] == "1"
    assert {"processor", "python", "numpy", "commit", "sources"} <= set(machine)
    assert json.loads((undisturbed / "run.json").read_text())["sources digest"] == sources()
    done = called("export", str(undisturbed), str(tmp_path / "deep" / "rows.csv"))
    assert done.returncode == 0, done.stderr
    exported = pd.read_csv(tmp_path / "deep" / "rows.csv")
    assert list(exported.columns) == list(COLUMNS)
    assert len(exported) == len(store.table())


def _kill_after(command: list[str], folder: Path, cells: int) -> None:
    """Start, and kill at once when so many cells are there."""
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while len(list(folder.glob("cells/*.parquet"))) < cells:
        assert process.poll() is None, "it ended before it could be killed"
        time.sleep(0.002)
    process.kill()
    process.wait()


def test_a_killed_run_goes_on_and_finds_the_same(undisturbed: Path, tmp_path: Path) -> None:
    folder = tmp_path / "killed"
    arguments = ["run", "smoke", *OPTIONS, "-o", str(folder)]
    everything = len(Store.open(undisturbed).plan.cells())
    rng = np.random.default_rng()  # at a random moment, indeed
    _kill_after([sys.executable, "-m", "benchmarks", *arguments], folder, int(rng.integers(1, everything // 2)))
    kept = {path: path.stat().st_mtime_ns for path in folder.glob("cells/*.parquet")}
    assert 0 < len(kept) < everything
    done = called(*arguments)
    assert done.returncode == 0, done.stderr
    assert f"{everything} of {everything} cells in {folder}" in done.stdout
    assert all(path.stat().st_mtime_ns == when for path, when in kept.items())  # never measured again
    assert list(folder.glob("cells/.*")) == []
    same(undisturbed, folder)


def test_a_finished_run_is_not_measured_again(undisturbed: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in undisturbed.glob("cells/*")}
    done = called("run", "smoke", *OPTIONS, "-o", str(undisturbed))
    assert done.returncode == 0
    assert {path: path.stat().st_mtime_ns for path in undisturbed.glob("cells/*")} == before


def test_processes_find_the_same(undisturbed: Path, tmp_path: Path) -> None:
    folder = tmp_path / "processes"
    done = called("run", "smoke", *OPTIONS, "-o", str(folder), "--jobs", "2")
    assert done.returncode == 0, done.stderr
    same(undisturbed, folder)


def test_a_process_that_dies_costs_nothing(plan: Plan) -> None:
    cells = replace(plan, draws=12).cells()
    done = workers.processes(plan, cells, 2)
    found = [next(done)]
    children = [p for p in psutil.Process().children(recursive=True) if "loky" in " ".join(p.cmdline())]
    victim = next(p for p in children if "resource_tracker" not in " ".join(p.cmdline()))
    victim.send_signal(signal.SIGKILL)
    found += done
    assert sorted(cell.name for cell, _ in found) == sorted(cell.name for cell in cells)
    assert all(isinstance(result, workers.Measured) for _, result in found)


def _dies(plan: Plan, cell: Cell, wanted: str) -> workers.Done:
    if cell == plan.cells()[0]:
        os.kill(os.getpid(), signal.SIGKILL)
    return cell, workers.Measured([], {})


def test_a_cell_that_kills_its_processes_costs_no_other(monkeypatch: pytest.MonkeyPatch, plan: Plan) -> None:
    monkeypatch.setattr(workers, "work", _dies)
    found = dict(workers.processes(plan, plan.cells(), 2))
    (failed,) = [cell for cell, result in found.items() if isinstance(result, workers.Failed)]
    assert failed == plan.cells()[0]
    assert "its process died, 3 times" in found[failed].why
    assert set(found) == set(plan.cells())


def test_a_worker_with_other_sources_measures_nothing(plan: Plan) -> None:
    _, result = workers.work(plan, plan.cells()[0], "0" * 16)
    assert isinstance(result, workers.Failed)
    assert f"other sources or package versions, {sources()} in place of 0000" in result.why


def test_slow_methods_alone_have_no_rows_where_they_get_none(plan: Plan) -> None:
    alone = replace(plan, methods=("cascade:osqp",))
    rows = measure(alone, Cell("control/P2", 0, 4))
    assert {row["draw"] for row in rows} == {0, 3}
    assert measure(alone, Cell("control/P2", 1, 3)) == []


@pytest.mark.parametrize("options", [(), ("--jobs", "2")])
def test_an_interrupted_run_ends_in_one_line(options: tuple[str, ...], tmp_path: Path) -> None:
    command = [sys.executable, "-m", "benchmarks", "run", "growth", "-m", "native", "-o", str(tmp_path), *options]
    with heard():
        process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not list(tmp_path.glob("cells/*.parquet")):
        assert process.poll() is None, process.communicate()
        time.sleep(0.002)
    process.send_signal(signal.SIGINT)
    told, errors = process.communicate()
    assert (process.returncode, told) == (130, "")
    assert errors == "benchmarks: interrupted; what was finished is kept\n"


@contextmanager
def cluster() -> Iterator[tuple[str, list[subprocess.Popen[bytes]], subprocess.Popen[bytes]]]:
    """A scheduler and two workers, each a process of its own, as anybody would start them."""
    import socket

    with socket.socket() as door:
        door.bind(("127.0.0.1", 0))
        port = door.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    scheduler, worker = ([sys.executable, "-m", f"distributed.cli.dask_{kind}"] for kind in ("scheduler", "worker"))
    quiet = {"cwd": ROOT, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    started = [subprocess.Popen([*scheduler, "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"], **quiet)]
    worker += [address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    started += [subprocess.Popen(worker, env=environment, **quiet) for _ in range(2)]
    try:
        yield address, started[1:], started[0]
    finally:
        for process in started:
            process.kill()
            process.wait()


def test_a_cluster_that_loses_a_worker_finds_the_same(undisturbed: Path, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    folder = tmp_path / "cluster"
    with cluster() as (address, (first, second), _):
        command = [sys.executable, "-m", "benchmarks", "run", "smoke", *OPTIONS, "-o", str(folder), "--dask", address]
        process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while not list(folder.glob("cells/*.parquet")):
            assert process.poll() is None, process.communicate()[1]
            time.sleep(0.01)
        first.kill()  # in the middle of a cell
        _, errors = process.communicate()
        assert process.returncode == 0, errors
        assert second.poll() is None
    same(undisturbed, folder)


def test_a_cluster_that_loses_its_scheduler_is_told(plan: Plan) -> None:
    pytest.importorskip("distributed")
    with cluster() as (address, _, scheduler):
        done = workers.cluster(replace(plan, draws=200), replace(plan, draws=200).cells(), address)
        next(done)
        scheduler.kill()
        with pytest.raises(InvalidInput, match=f"--dask {address}: the scheduler is lost; what was finished is kept"):
            list(done)


def test_a_cluster_that_is_not_there_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr(workers, "PATIENCE", 1)
    with pytest.raises(InvalidInput, match=r"--dask tcp://127.0.0.1:9: no cluster answers"):
        next(workers.cluster(SMALL, [], "tcp://127.0.0.1:9"))


def test_a_cell_that_fails_costs_no_other(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, plan: Plan) -> None:
    def breaks(seed: int, draw: int) -> None:
        raise RuntimeError("no such problem")

    broken = Family("control", "P2", "breaks", breaks)  # type: ignore[arg-type]
    monkeypatch.setitem(FAMILIES, "control/P2", broken)
    store = Store.begin(tmp_path, plan, [])
    for cell, result in workers.serial(plan, store.missing()):
        if isinstance(result, workers.Failed):
            assert "no such problem" in store.fail(cell, result.why).read_text()
        else:
            store.add(cell, result.rows, result.machine)
    assert [cell.family for cell in store.missing()] == ["control/P2"] * 3
    assert "control/P2" not in set(store.table()["family"])
    monkeypatch.undo()
    for cell, result in workers.serial(plan, store.missing()):
        store.add(cell, result.rows, result.machine)
    assert store.missing() == []
    assert list((tmp_path / "failed").iterdir()) == []


def test_a_folder_of_another_run_is_refused(undisturbed: Path, tmp_path: Path, plan: Plan) -> None:
    with pytest.raises(InvalidInput, match="holds a run of another plan; choose another folder"):
        Store.begin(undisturbed, plan, [])
    Store.begin(tmp_path, plan, [])
    head = tmp_path / "run.json"
    head.write_text(head.read_text().replace(sources(), "0" * 16))
    with pytest.raises(InvalidInput, match="holds a run of other sources"):
        Store.begin(tmp_path, plan, [])
    with pytest.raises(InvalidInput, match="holds no finished cell yet"):
        Store.open(tmp_path).table()
    with pytest.raises(InvalidInput, match="holds no run"):
        Store.open(tmp_path / "nothing")
    Store.open(tmp_path).path(plan.cells()[0]).write_bytes(b"PAR1 no more")
    with pytest.raises(InvalidInput, match="is damaged; remove it, and run again"):
        Store.open(tmp_path).table()
    told = head.read_text()
    for text, said in (
        ("no json", "cannot read"),
        (told[:100], "cannot read"),
        ("7", "cannot read"),
        ("{}", "tells of no plan"),
        (told.replace('"rounds"', '"laps"'), "tells of no plan"),
        (told.replace("control/P1", "control/gone"), "was measured by other benchmarks: no control/gone is here"),
    ):
        head.write_text(text)
        with pytest.raises(InvalidInput, match=said):
            Store.open(tmp_path)
    head.unlink()
    with pytest.raises(InvalidInput, match=r"holds cells, and no run.json tells of what; choose another folder"):
        Store.begin(tmp_path, plan, [])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nonsense",), "unknown plan 'nonsense'; there are full, smoke"),
        (("smoke", "-f", "nonsense"), "unknown family 'nonsense'; there are adversarial/mixed, "),
        (("smoke", "-m", "nonsense"), "unknown method 'nonsense'; there are native, "),
        (("smoke", "-s", "nonsense"), "unknown setting 'nonsense'; there are tight, loose"),
        (("smoke", "--jobs", "0"), "--jobs 0: give a number of processes, or -1 for one a core"),
        (("smoke", "--jobs", "2", "--dask", "tcp://127.0.0.1:9"), "--jobs and --dask: give one of them"),
        (("smoke", "--draws", "0"), "'--draws'"),
        (("smoke", "-m", "pseudoinverse", "-f", "control/P2"), "nothing to measure; no method takes one"),
        (("smoke", "-o", "/dev/null/here"), "cannot write to the folder '/dev/null/here': "),
    ],
)
def test_wrong_input_of_a_run_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    refused(called("run", *arguments), said)


def test_everything_is_listed() -> None:
    done = called("list")
    assert done.returncode == 0, done.stderr
    for name in (*PLANS, *FAMILIES, *METHODS, *COLUMNS, "tight", "p99.9"):
        assert any(line.startswith(f" {name} ") for line in done.stdout.splitlines()), name


def test_the_smoke_plan_runs() -> None:
    plan, _ = PLANS["smoke"].resolved()
    groups = {FAMILIES[key].group for key in plan.families}
    assert groups == {family.group for family in FAMILIES.values()}
