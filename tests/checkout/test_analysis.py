"""What is said of a run follows from its rows: judgements, metrics, profiles, growth, comparison, pages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import refused, run

from benchmarks.analysis.comparison import answers, changes, differences, paired
from benchmarks.analysis.figures import FIGURES, best_others
from benchmarks.analysis.growth import growth
from benchmarks.analysis.metrics import METRICS, PENALTY, SHIFT, ratios, share, shifted_geometric_mean
from benchmarks.analysis.profiles import profiles
from benchmarks.analysis.shortfalls import shortfalls
from benchmarks.analysis.summary import YARDSTICK, overview
from benchmarks.sweep.judge import WRONG, judge
from benchmarks.sweep.schema import COLUMNS
from hqp import Hierarchy, Level, solve


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
    assert (share(1.0), share(0.0), share(0.99999999), share(1e-9)) == ("100", "0", "100", "0.01")


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


def test_shortfalls_name_who_is_faster_and_no_worse() -> None:
    some = pair({"native": [2.0, 2.0], "daqp": [1.0, 1.0]})
    (found,) = shortfalls(some)
    assert (found["family"], found["start"], found["faster"]) == ("control/P1", "warm", "daqp (0.50)")
    assert shortfalls(pair({"native": [1.0, 1.0], "daqp": [2.0, 2.0]})) == []
    wrong = pair({"native": [2.0, 2.0], "daqp": [1.0, 1.0]}, certified=[True, True, True, False])
    assert shortfalls(wrong) == []  # faster, and wrong
    missed = pair({"native": [1.0, 1.0], "daqp": [2.0, 2.0]}, certified=[True, False, True, True])
    assert shortfalls(missed)[0]["not certified"] == "50"


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
    done = run(
        "run", "smoke", "-f", "size/n *", "-m", "native", "-m", "daqp*", "-m", "cascade:proxsuite", "-o", str(folder)
    )
    assert done.returncode == 0, done.stderr
    assert "native" in done.stdout
    return folder


def test_a_run_becomes_a_page_with_figures(small: Path, tmp_path: Path) -> None:
    done = run("report", str(small), "-o", str(tmp_path / "page" / "results.md"))
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "page" / "results.md").read_text()
    for name in FIGURES:
        picture = tmp_path / "page" / "images" / f"benchmark-{name}.png"
        assert picture.stat().st_size > 5000
        assert f"](images/benchmark-{name}.png)" in page
    for said in ("## By group", "## Tails", "## Growth", "## Where native is not best", "| native | tight |", "numpy "):
        assert said in page
    assert "nan" not in page
    done = run("plot", str(small), "growth", "-o", str(tmp_path / "growth.svg"))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "growth.svg").read_text().startswith("<?xml")


def test_a_run_compared_with_itself_has_not_changed(small: Path) -> None:
    done = run("compare", str(small), str(small))
    assert done.returncode == 0, done.stderr
    assert "all answers are the same" in done.stdout
    assert "\n0 of " in done.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("report", "nowhere"), "'nowhere' holds no run; 'python -m benchmarks run' makes one"),
        (("plot", "nowhere", "nonsense"), "unknown figure 'nonsense'; there are profiles, growth, accuracy, tails"),
        (("plot", "nowhere", "growth", "-o", "x.txt"), "'x.txt': give a file that ends in .png, .pdf or .svg"),
        (("export", "nowhere", "rows.json"), "'rows.json': give a file that ends in .csv or .parquet"),
        (("compare", "nowhere", "nowhere"), "'nowhere' is neither the folder of a run nor a commit"),
        (("compare", "a", "b", "--plan", "nonsense"), "unknown plan 'nonsense'; there are full, smoke"),
        (("compare", "a", "b", "--by", "nonsense"), "'--by'"),
    ],
)
def test_wrong_input_is_one_line(arguments: tuple[str, ...], said: str) -> None:
    refused(run(*arguments), said)
