"""A run as a page: ratios first, then accuracy, groups, tails and growth, and where the native solver is not best."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ..families import FAMILIES
from ..settings import SETTINGS
from ..sweep.cell import STARTS
from ..sweep.store import Store
from ..tables import Row, markdown
from .figures import FIGURES, best_others, controllable, tight
from .growth import CURVES, growth
from .metrics import METRICS, entrants, of_entrant, ratios, share
from .shortfalls import shortfalls
from .summary import YARDSTICK, overview, ratio

_TOLD = ("problems", "median", "p99", "p99.9", "worst", "late", "spread")


def report(store: Store, page: Path, images: Path) -> list[Path]:
    """Write the page, and its figures to the folder `images`; the files."""
    rows = store.table()
    chosen = tight(rows)
    lacking = {"growth": not growth(chosen), "tails": controllable(chosen).empty}
    drawn = {name: images / f"benchmark-{name}.png" for name in FIGURES if not lacking.get(name)}
    for name, path in drawn.items():
        FIGURES[name](rows, path)
    pictures = {name: path.relative_to(page.parent).as_posix() for name, path in drawn.items()}
    problems, missing = rows.drop_duplicates(["family", "seed", "draw"]), len(store.missing())
    parts = [
        "# Benchmark results",
        "<!-- written by python -m benchmarks report -->",
        f"Plan `{store.plan.name}`: {store.plan.about}. {len(problems)} problems of {problems['family'].nunique()}"
        f" families, {len(rows)} answers, every one put to the certificate. What families and columns are, how it is"
        " measured, and what it means: [benchmarks.md](benchmarks.md).",
        *([f"**Not finished:** {missing} of {len(store.plan.cells())} cells are missing."] if missing else []),
        _measured_by(store),
        "## All families",
        _setting(rows),
        f"![Performance profiles]({pictures['profiles']})",
        f"![Error against time]({pictures['accuracy']})",
        "## By group",
        *_groups(chosen),
    ]
    if "tails" in pictures:
        parts += ["## Tails", _TAILS, markdown(_tails(chosen)), f"![Tails]({pictures['tails']})"]
    if "growth" in pictures:
        parts += ["## Growth", _GROWTH, markdown(_exponents(chosen)), f"![Growth]({pictures['growth']})"]
    if not of_entrant(rows, *YARDSTICK).empty:
        parts += ["## Where native is not best", *_shortfalls(rows)]
    page.write_text("\n\n".join(part.strip("\n") for part in parts) + "\n", encoding="utf-8")
    return [page, *drawn.values()]


_TAILS = (
    "Over the families whose first level can be met, warm. The times are those of the shortest rounds: what a problem"
    " costs. What the machine adds, the spread tells: the slowest round over the fastest, median."
)

_GROWTH = (
    "Median time over unknowns (four tasks of 0.6 n rows in all), levels (36 unknowns, 18 equality rows on more and"
    " more levels), and rows (36 unknowns, more and more inequalities, few of them active), and the exponent p of time"
    " ~ size^p, fitted to the upper half of each curve; of the two best others in bold."
)


def _measured_by(store: Store) -> str:
    """The machine, the versions and the settings of the measurement."""
    lines = []
    for machine in store.machines():
        packages = ", ".join(f"{name} {machine[name]}" for name in machine if name not in _NOT_PACKAGES)
        lines.append(
            f"Measured on {machine['processor']}, {machine['cores']} cores, {machine['system']}, Python"
            f" {machine['python']}, {machine['threads']} thread; commit {machine['commit'] or 'unknown'}; {packages}."
        )
    left_out = f" Left out: {'; '.join(store.left_out)}." if store.left_out else ""
    return " ".join(lines) + left_out


_NOT_PACKAGES = ("processor", "cores", "system", "python", "threads", "commit", "sources")


def _setting(rows: pd.DataFrame) -> str:
    told = "; ".join(f"{name}: {SETTINGS[name].about}" for name in rows["setting"].cat.categories)
    return (
        f"cold, warm: time over that of {YARDSTICK[0]} on the same problem, median; us: median. certified, silent"
        " (wrong, but claimed), failures, late: % of the answers; gap, violation: the largest."
        f" {told[:1].upper()}{told[1:]}.\n\n{markdown(overview(rows))}"
    )


def _groups(rows: pd.DataFrame) -> list[str]:
    """A table a start: a row an entrant, a column a group; ratio to the native solver, and what is not certified."""
    groups = list(dict.fromkeys(FAMILIES[key].group for key in rows["family"].cat.categories))
    parts = []
    for start in STARTS:
        here = rows[rows["start"] == start]
        times = ratios(here, YARDSTICK)
        table: list[Row] = []
        for method, setting in entrants(here):
            mine = of_entrant(here, method, setting)
            row = {"method": method}
            for group in groups:
                inside = mine[mine["group"] == group]
                bad = 1.0 - inside["certified"].mean()
                mark = f" ({share(bad)})" if len(inside) and bad else ""
                row[group] = ratio(times.reindex(inside.index)) + mark
            table.append(row)
        parts += [f"Ratio to {YARDSTICK[0]}, {start}; in brackets the % of the answers that are not certified:"]
        parts += [markdown(table)]
    return parts


def _tails(rows: pd.DataFrame) -> list[Row]:
    warm = controllable(rows[rows["start"] == "warm"])
    return [
        {"method": method} | {name: METRICS[name].text(of_entrant(warm, method, setting)) for name in _TOLD}
        for method, setting in entrants(warm)
    ]


def _exponents(rows: pd.DataFrame) -> list[Row]:
    """A row a method, a column a curve and start; the best others in bold."""
    curves = growth(rows)
    table = []
    for method in dict.fromkeys(each.method for each in curves):
        row = {"method": method}
        for start in STARTS:
            for curve, what in CURVES.items():
                here = [each for each in curves if (each.curve, each.start) == (curve, start)]
                mine = [each for each in here if each.method == method]
                text = f"{mine[0].exponent:.2f}" if mine else ""
                row[f"{start}, {what}"] = f"**{text}**" if method in best_others(here) else text
        table.append(row)
    return table


def _shortfalls(rows: pd.DataFrame) -> list[str]:
    found = shortfalls(rows)
    if not found:
        return [
            "Nowhere: it is certified on every problem, and in no family another one, no more often wrong, is faster."
        ]
    return [
        "Families in which some answer of native is not certified, or in which another method, no more often wrong, has"
        " a lower median. The reasons are in [benchmarks.md](benchmarks.md#where-native-is-not-best).",
        markdown(found),
    ]
