"""What is said of a run follows from its rows: judgements, metrics, profiles, growth, comparison, pages."""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import ROOT, called, refused
from rich.console import Console

from benchmarks import extra
from benchmarks.__main__ import app
from benchmarks.analysis.advice import PICTURE, advice
from benchmarks.analysis.comparison import answers, changes, differences, paired
from benchmarks.analysis.figures import FIGURES, best_others
from benchmarks.analysis.growth import growth
from benchmarks.analysis.metrics import METRICS, PENALTY, SHIFT, ratios, share, shifted_geometric_mean
from benchmarks.analysis.profiles import profiles
from benchmarks.analysis.report import report
from benchmarks.analysis.shortfalls import shortfalls
from benchmarks.analysis.summary import YARDSTICK, overview
from benchmarks.sweep.judge import WRONG, judge
from benchmarks.sweep.schema import COLUMNS
from benchmarks.sweep.store import Store
from benchmarks.tables import show, terminal
from hqp import Hierarchy, Level, MissingPackage, solve


def hierarchy() -> Hierarchy:
    """Bounds above a reach of 3 which they cut to 2, above a posture."""
    limits = Level.bounds([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0])
    return Hierarchy([limits, Level.equality([[1.0, 1.0, 0.0]], [3.0]), Level.bounds([0.5], [0.5], indices=[2])])


def test_answers_are_judged_beside_the_best_one() -> None:
    h = hierarchy()
    x = solve(h).x
    np.testing.assert_allclose(x, [1.0, 1.0, 0.5])
    first, last = np.eye(3)[0], np.eye(3)[2]
    beyond, short, sloppy, nothing = x + 0.5 * first, x - 0.3 * first, x + 1e-7 * last, np.full(3, np.nan)
    (best, over, under, near, none), proved, active = judge(h, [x, beyond, short, sloppy, nothing])
    assert proved
    assert active == pytest.approx(2 / 3)
    assert (best.certified, best.wrong, best.gap, best.violation, best.error) == (True, False, 0.0, 0.0, 0.0)
    size = np.linalg.norm(x)
    assert over.wrong
    assert over.gap == pytest.approx(0.5 / (np.sqrt(3) * size))  # lost at level 0, whatever it wins below
    assert over.gaps[1] < 0
    assert over.violation == pytest.approx(0.5 / size)
    assert (under.wrong, under.violation) == (True, 0.0)
    assert under.gap == pytest.approx(0.3 / (np.sqrt(2) * size))
    assert under.gaps[0] == 0.0
    assert (near.certified, near.wrong) == (False, False)
    assert 0 < near.error < WRONG
    assert (none.certified, none.wrong, none.gap, none.violation, none.error) == (False, True, np.inf, np.inf, np.inf)
    assert len(best.gaps) == 4  # the implicit last level too


def test_without_a_proof_the_smallest_answer_is_the_best() -> None:
    h = hierarchy()
    x = solve(h).x
    worse, better = x - [0.3, 0, 0], x - [0.1, 0, 0]
    (first, second), proved, _ = judge(h, [worse, better])
    assert not proved
    assert second.gap == 0.0
    assert first.gap > WRONG


def rows(**columns: object) -> pd.DataFrame:
    """Rows of results, with plain values where nothing is said."""
    plain = {
        **{"family": "control/P1", "group": "control", "curve": "", "at": 0, "seed": 0, "draw": 0, "n": 3, "m": 6},
        **{"levels": 3, "method": "native", "setting": "tight", "start": "warm", "seconds": 1e-6, "slowest": 1e-6},
        **{"rounds": 3, "claimed": True, "status": "optimal", "iterations": 1, "proved": True, "active": 0.0},
        **{"certified": True, "gaps": None, "gap": 0.0, "wrong": False, "violation": 0.0, "error": 0.0},
    }
    assert set(plain) == set(COLUMNS)
    frame = pd.DataFrame({name: pd.Series(value) for name, value in columns.items()})
    for name, value in plain.items():
        if name not in frame:
            frame[name] = pd.Series([value] * len(frame), dtype=object if value is None else None)
    for name in ("family", "method", "setting"):
        frame[name] = pd.Categorical(frame[name], categories=list(dict.fromkeys(frame[name])), ordered=True)
    return frame[list(COLUMNS)]


def test_metrics_of_known_rows() -> None:
    some = rows(
        seconds=[1e-6, 2e-6, 4e-6, 2e-3],
        slowest=[2e-6, 4e-6, 4e-6, 2e-3],
        certified=[True, False, False, False],
        wrong=[False, True, True, False],
        claimed=[True, True, False, True],
        gap=[0.0, 1e-3, -2.0, 0.0],
    )
    values = {name: metric.of(some) for name, metric in METRICS.items()}
    assert (values["certified"], values["silent"], values["failures"], values["late"]) == (0.25, 0.25, 0.25, 0.25)
    assert (values["gap"], values["worst"], values["median"], values["spread"]) == (2.0, 2e-3, 3e-6, 1.5)
    assert np.isnan(values["p99"])
    assert METRICS["p99"].text(some) == ""
    assert METRICS["worst"].text(some) == "2000"
    usable = np.array([1e-6, PENALTY, PENALTY, 2e-3]) + SHIFT
    assert shifted_geometric_mean(some) == pytest.approx(np.prod(usable) ** 0.25 - SHIFT)
    many = rows(seconds=np.arange(1, 1001) * 1e-6, draw=range(1000))
    assert METRICS["p99.9"].of(many) == pytest.approx(999e-6, rel=1e-3)
    assert (share(1.0), share(0.0), share(0.99999999), share(1e-9)) == ("100", "0", "99.99", "0.01")


def pair(times: dict[str, list[float]], **columns: object) -> pd.DataFrame:
    """Several methods on the same problems."""
    count = len(next(iter(times.values())))
    parts = {"method": np.repeat(list(times), count), "draw": [*range(count)] * len(times)}
    return rows(**parts, seconds=np.concatenate(list(times.values())), **columns)


def test_ratios_are_taken_problem_by_problem() -> None:
    some = pair({"native": [1.0, 2.0, 4.0], "daqp": [2.0, 2.0, 2.0]})
    found = ratios(some, YARDSTICK)
    assert list(found[some["method"] == "daqp"]) == [2.0, 1.0, 0.5]
    assert [row["warm"] for row in overview(some)] == ["1.00", "1.00"]


def test_profiles_count_good_answers_alone() -> None:
    some = pair({"native": [1.0, 1.0, 3.0, 1.0], "daqp": [2.0, 1.0, 1.0, 1.0]})
    good = pd.Series([True, True, True, True, True, True, True, False])
    native, daqp = profiles(some, good)
    assert [native.at(factor) for factor in (1.0, 2.9, 3.0)] == [0.75, 0.75, 1.0]
    assert [daqp.at(factor) for factor in (0.5, 1.0, 2.0, 1e9)] == [0.0, 0.5, 0.75, 0.75]
    some = pd.concat([some, rows(method=["native"], draw=[9], seconds=[5.0])])  # a problem that one alone was given
    some["method"] = pd.Categorical(some["method"], categories=["native", "daqp"], ordered=True)
    assert len(profiles(some.reset_index(drop=True), pd.Series(True, index=range(9)))[0].shares) == 4


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.3])
def test_growth_finds_the_exponent(exponent: float) -> None:
    sizes = np.array([3, 6, 12, 25, 50, 100])
    times = {name: factor * (1e-7 * sizes**exponent) for name, factor in (("native", 1), ("a", 9), ("b", 3), ("c", 5))}
    some = pair(times, curve=["n"] * 24, at=[*sizes] * 4)
    found = growth(some)
    assert [each.method for each in found] == ["native", "a", "b", "c"]
    for each in found:
        assert each.exponent == pytest.approx(exponent)
        np.testing.assert_array_equal(each.sizes, sizes)
    assert best_others(found) == ["b", "c"]


def test_shortfalls_name_who_is_faster_and_no_more_often_wrong() -> None:
    some = pair({"native": [2.0, 2.0], "daqp": [1.0, 1.0]})
    (found,) = shortfalls(some)
    assert (found["family"], found["start"], found["faster"]) == ("control/P1", "warm", "daqp (0.50)")
    assert shortfalls(pair({"native": [1.0, 1.0], "daqp": [2.0, 2.0]})) == []
    wrong = pair({"native": [2.0, 2.0], "daqp": [1.0, 1.0]}, wrong=[False, False, False, True])
    assert shortfalls(wrong) == []  # faster, and wrong
    missed = pair({"native": [1.0, 1.0], "daqp": [2.0, 2.0]}, certified=[True, False, True, True])
    assert shortfalls(missed)[0]["not certified"] == "50"


def both_starts(times: dict[str, list[float]], **columns: object) -> pd.DataFrame:
    """As `pair`, cold and warm."""
    return pd.concat(
        [pair(times, start=[start] * sum(map(len, times.values())), **columns) for start in ("cold", "warm")]
    )


def test_the_advice_is_the_fastest_whose_answers_can_be_used() -> None:
    times = {"native": [1e-6, 1e-6], "daqp": [5e-7, 5e-7], "other": [9e-6, 9e-6]}
    assert "In a control loop (warm): daqp, 0.5 us, 100 % certified" in advice(both_starts(times))
    wrong = {"wrong": [False, False, True, True, False, False], "certified": [True, True, False, False, True, True]}
    said = advice(both_starts(times, **wrong))
    assert "In a control loop (warm): native, 1.0 us, 100 % certified" in said
    assert "for one problem (cold): native" in said
    assert "for a second opinion: other, 9.0 us" in said
    assert "wrong without a word: daqp (100 %)" in said
    assert said.count("\n") == 0
    assert said.endswith(".")


def test_the_advice_for_some_families_is_for_them_alone() -> None:
    everywhere = both_starts({"native": [2e-6, 2e-6]}, family=["control/P1", "equalities/n 7"], group=["control", "e"])
    there = both_starts({"formula": [1e-6]}, family=["equalities/n 7"], group=["e"]).assign(draw=1)
    some = pd.concat([everywhere, there])
    for name in ("family", "method", "setting"):
        some[name] = pd.Categorical(some[name], categories=list(dict.fromkeys(some[name])), ordered=True)
    said = advice(some.reset_index(drop=True))
    assert "In a control loop (warm): native" in said
    assert "on e: formula, 1.0 us" in said


def noisy(rng: np.random.Generator, factors: dict[str, float]) -> pd.DataFrame:
    """40 problems by each method, with noise of 3 % on every time."""
    base = np.random.default_rng(0).uniform(1e-6, 1e-4, 40)
    return pair(
        {name: list(base * factor * np.exp(0.03 * rng.standard_normal(40))) for name, factor in factors.items()}
    )


def test_a_comparison_takes_the_machine_out_and_sees_what_changed() -> None:
    rng = np.random.default_rng(1)
    before = noisy(rng, {"native": 1.0, "daqp": 2.0, "a": 9.0, "b": 5.0})
    slower_machine = noisy(rng, {"native": 1.4, "daqp": 2.8, "a": 12.6, "b": 7.0})
    assert not [change for change in changes(paired(before, slower_machine), "group") if change.real]
    faster = noisy(rng, {"native": 0.7 * 1.4, "daqp": 2.8, "a": 12.6, "b": 7.0})
    (real,) = [change for change in changes(paired(before, faster), "group") if change.real]
    assert (real.method, real.problems) == ("native", 40)
    assert real.factor == pytest.approx(0.7, rel=0.05)
    assert real.drift == pytest.approx(1.4, rel=0.05)


def test_a_comparison_tells_answers_that_changed() -> None:
    before = pair({"native": [1.0, 1.0], "daqp": [1.0, 1.0]})
    after = pair(
        {"native": [1.0, 1.0], "daqp": [1.0, 1.0]}, certified=[True, False, True, True], gap=[0, 1e-3, 0, 1e-12]
    )
    pairs = paired(before, after)
    assert differences(pairs) == {"certified": 1, "gap": 1}  # 1e-12 is round-off
    (told,) = answers(pairs)
    assert (told["method"], told["certified"], told["gap"]) == ("native", "100 -> 50", "0 -> 1e-03")
    assert differences(paired(before, before)) == {}


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "small"
    done = called(
        "run", "smoke", "-f", "size/n *", "-m", "native", "-m", "daqp*", "-m", "cascade:proxsuite", "-o", str(folder)
    )
    assert done.returncode == 0, done.stderr
    assert "native" in done.stdout
    return folder


def test_a_run_ends_with_its_picture_and_which_backend_to_use(small: Path) -> None:
    done = called(
        "run", "smoke", "-f", "size/n *", "-m", "native", "-m", "daqp*", "-m", "cascade:proxsuite", "-o", str(small)
    )
    assert done.returncode == 0, done.stderr
    assert (small / PICTURE).stat().st_size > 5000
    last = done.stdout.splitlines()[-1]
    assert last == advice(Store.open(small).table())
    assert last.startswith("Which backend, for what? In a control loop (warm): ")


def test_a_run_becomes_a_page_with_figures(small: Path, tmp_path: Path) -> None:
    done = called("report", str(small), "-o", str(tmp_path / "page" / "results.md"))
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "page" / "results.md").read_text()
    for name in FIGURES:
        picture = tmp_path / "page" / "images" / f"benchmark-{name}.png"
        assert picture.stat().st_size > 5000
        assert f"](images/benchmark-{name}.png)" in page
    for said in ("## By group", "## Tails", "## Growth", "## Where native is not best", "| native | tight |", "numpy "):
        assert said in page
    assert "nan" not in page
    assert "Not finished" not in page
    done = called("plot", str(small), "growth", "-o", str(tmp_path / "growth.svg"))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "growth.svg").read_text().startswith("<?xml")


def test_a_run_compared_with_itself_has_not_changed(small: Path) -> None:
    done = called("compare", str(small), str(small))
    assert done.returncode == 0, done.stderr
    assert "all answers are the same" in done.stdout
    assert "\n0 of " in done.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("report", "nowhere"), "'nowhere' holds no run; 'python -m benchmarks run' makes one"),
        (("plot", "nowhere", "nonsense"), "unknown figure 'nonsense'; there are profiles, growth, accuracy, tails"),
        (("plot", "nowhere", "growth", "-o", "x.txt"), "'x.txt'; a figure is called .png, .pdf or .svg"),
        (("export", "nowhere", "rows.json"), "'rows.json'; a table is called .csv or .parquet"),
        (("compare", "nowhere", "nowhere"), "'nowhere' is neither the folder of a run nor a commit"),
        (("compare", "a", "b", "--plan", "nonsense"), "unknown plan 'nonsense'; there are full, smoke"),
        (("compare", "a", "b", "--by", "nonsense"), "'--by'"),
    ],
)
def test_wrong_input_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    refused(called(*arguments), said)


@pytest.mark.parametrize("number", [np.nan, np.inf, 1e300, -1e308, 1e-320])
def test_no_answer_is_too_strange_to_be_judged(number: float) -> None:
    h = hierarchy()
    x = solve(h).x
    strange = np.array([number, *x[1:]])
    for given in ([x, strange], [strange], [strange, -strange]):
        for verdict in judge(h, given).verdicts:
            assert not np.isnan([verdict.gap, verdict.violation, verdict.error, *verdict.gaps]).any()


def test_problems_are_counted_once_however_they_are_started() -> None:
    both = pd.concat([pair({"native": [1.0, 2.0]}, start=[start] * 2) for start in ("cold", "warm")])
    assert METRICS["problems"].text(both) == "2"
    assert METRICS["problems"].text(both[:0]) == "0"


def test_an_unchanged_method_is_not_told_changed_by_one_noisy_other() -> None:
    """With one other method the drift is its median, and as uncertain: two of them, and neither has changed."""
    found = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        before, after = (pair({name: list(np.exp(0.1 * rng.standard_normal(20))) for name in "ab"}) for _ in range(2))
        found += changes(paired(before, after), "group")
    assert sum(change.real for change in found) <= 1  # of 60, where 0.1 % is promised


def test_methods_that_drift_apart_are_not_told_changed() -> None:
    """Each method is faster or slower by some 10 % of its own, as from another layout of memory."""
    found = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        factors = {name: list(np.full(40, np.exp(0.1 * rng.standard_normal()))) for name in "abcdefgh"}
        found += changes(paired(pair({name: [1.0] * 40 for name in factors}), pair(factors)), "group")
    assert sum(change.real for change in found) <= 0.1 * len(found)  # seven others tell the spread roughly


def test_differences_are_counted_row_by_row() -> None:
    count = 10_000
    many = rows(draw=range(count), gap=np.zeros(count), iterations=np.arange(count))
    many["gaps"] = [np.zeros(4)] * count
    other = many.assign(iterations=many["iterations"] + (many["draw"] == 7))
    other["gaps"] = [np.zeros(4)] * (count - 2) + [np.zeros(3), np.full(4, 1e-6)]
    assert differences(paired(many, other)) == {"iterations": 1, "gaps": 2}


def test_a_table_is_never_cut() -> None:
    printer = Console(width=20, file=io.StringIO())
    show(printer, terminal("title", [{"name": "x" * 30, "number": "123456789"}]))
    assert "x" * 30 in printer.file.getvalue()
    assert "123456789" in printer.file.getvalue()
    assert printer.width == 20


@pytest.fixture(scope="module")
def odd(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run without native, growth, or a family whose first level can be met: of one problem only."""
    folder = tmp_path_factory.mktemp("odd runs, ünïcode") / "r"
    done = called("run", "smoke", "-f", "adversarial/mixed", "-m", "daqp", "--draws", "1", "-o", str(folder))
    assert (done.returncode, done.stderr) == (0, "")
    return folder


def test_an_odd_run_becomes_a_page_too(odd: Path, tmp_path: Path) -> None:
    done = called("report", str(odd), "-o", str(tmp_path / "a page.md"))
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "a page.md").read_text()
    assert "| daqp | tight |" in page
    for absent in ("## Tails", "## Growth", "## Where native is not best", "nan"):
        assert absent not in page
    refused(called("plot", str(odd), "growth", "-o", str(tmp_path / "g.png")), "no growth curve has three points")
    refused(called("plot", str(odd), "tails", "-o", str(tmp_path / "t.png")), "families whose first level can be met")
    done = called("compare", str(odd), str(odd))
    assert "0 of 0 times changed beyond noise" in done.stdout


def test_a_page_of_an_unfinished_run_says_so(small: Path, tmp_path: Path) -> None:
    shutil.copytree(small, tmp_path / "run")
    page = tmp_path / "page.md"
    for file in sorted((tmp_path / "run" / "cells").iterdir())[:5]:
        file.unlink()
    report(Store.open(tmp_path / "run"), page, tmp_path)
    assert "**Not finished:** 5 of 6 cells are missing." in page.read_text()


def test_what_is_exported_has_every_digit(odd: Path, tmp_path: Path) -> None:
    done = called("export", str(odd), str(tmp_path / "rows.csv"))
    assert done.returncode == 0, done.stderr
    exported, kept = pd.read_csv(tmp_path / "rows.csv"), Store.open(odd).table()
    assert len((tmp_path / "rows.csv").read_text().splitlines()) == 1 + len(kept)
    for text, gaps in zip(exported["gaps"], kept["gaps"], strict=True):
        np.testing.assert_array_equal([float(number) for number in text.split()], gaps)


def test_without_tight_answers_there_is_no_page(tmp_path: Path) -> None:
    folder = str(tmp_path / "loose")
    done = called("run", "smoke", "-f", "control/P1", "-m", "daqp*", "-s", "loose", "--draws", "1", "-o", folder)
    assert done.returncode == 0, done.stderr
    assert "no picture and no advice: the run has no answer at the setting 'tight'" in done.stdout
    refused(called("report", folder, "-o", str(tmp_path / "page.md")), "no answer at the setting 'tight'")


def test_without_pandas_every_command_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extra, "find_spec", lambda package: None if package == "pandas" else find_spec(package))
    for command in ("list", "run", "report x", "plot x tails", "export x y.csv", "compare a b"):
        with pytest.raises(MissingPackage, match=r"pandas not installed: python -m pip install -e '.\[bench\]'"):
            app(command.split(), standalone_mode=False)


def test_without_pinocchio_the_rest_is_there(tmp_path: Path) -> None:
    """An import of it is as if there were none: everything is listed, and what needs it is left out aloud."""
    script = (
        "import sys, importlib.util as u; real = u.find_spec; sys.modules['pinocchio'] = None\n"
        "u.find_spec = lambda name, *rest: None if name == 'pinocchio' else real(name, *rest)\n"
        "from benchmarks.__main__ import main; main()"
    )
    command = [sys.executable, "-c", script, "run", "smoke", "-f", "motion/*", "-f", "control/P1", "-m", "native"]
    done = subprocess.run([*command, "-o", str(tmp_path)], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stderr
    assert "left out: motion/panda" in done.stdout
    assert "the package 'pinocchio' is not installed" in done.stdout
