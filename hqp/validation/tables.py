"""The results as tables, for a terminal and in Markdown."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from . import FORMULAS, KNOWN, ZONES, Finding, Judgement, Parting, Point, Report, merge, summed, zone

if TYPE_CHECKING:
    from rich.table import Table as Printed


@dataclass(frozen=True)
class Table:
    """A title, headings, and rows of text, of which the first `text` columns are words and the others numbers."""

    title: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    text: int = 1

    def terminal(self) -> Printed:
        """For a rich console."""
        from rich.box import SIMPLE_HEAD
        from rich.table import Table as Printed

        table = Printed(
            title=self.title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=0, collapse_padding=True
        )
        for k, heading in enumerate(self.headings):
            table.add_column(heading, justify="left" if k < self.text else "right", no_wrap=True)
        for row in self.rows:
            table.add_row(*row)
        return table

    def markdown(self) -> str:
        """As a table of Markdown, without the title."""
        rule = ["---" if k < self.text else "---:" for k in range(len(self.headings))]
        headings = [heading.replace("-\n", "").replace("\n", " ") for heading in self.headings]
        lines = [headings, rule, *([cell.replace("|", "\\|") for cell in row] for row in self.rows)]
        return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def closed_forms(reports: Sequence[Report], cases: bool) -> list[Table]:
    """One a formula: a row a backend, or a row a case."""
    tables = []
    for formula, closed_form in FORMULAS.items():
        own = [report for report in reports if report.formula == formula]
        rows = [
            [
                report.backend,
                *([report.case] if cases else []),
                str(report.count),
                f"{report.worst_x:.0e}",
                f"{report.worst_residual:.0e}",
                f"{report.certified / report.count:.1%}",
                f"{report.levels_solved / report.count:.2f}",
                f"{report.levels_met / report.count:.2f}",
                f"{1e3 * report.seconds / report.count:.2f}",
                _verdict(report.ok, report.allowed),
            ]
            for report in (own if cases else merge(own))
        ]
        headings = ["stacks", "x", "residual", "proved", "solved", "met", "ms", ""]
        titled = ["backend", "n; rows, rank"] if cases else ["backend"]
        tables.append(Table(f"{formula} ({closed_form})", [*titled, *headings], rows, len(titled)))
    return tables


def near_singular(points: Sequence[Point], places: bool) -> list[Table]:
    """One a formula: a row a backend, or a row a backend and place."""
    tables = []
    for formula in FORMULAS:
        groups: dict[tuple[str, ...], list[Point]] = {}
        for point in points:
            if point.formula == formula:
                groups.setdefault((point.name, point.place) if places else (point.name,), []).append(point)
        rows = []
        for key, group in groups.items():
            regular, between, truncated = ([p for p in group if zone(p.sigma) == name] for name in ZONES)
            rows.append(
                [
                    *key,
                    f"{_worst(regular):.0e}",
                    f"{max(float(p.x.max()) for p in between):.0e}",
                    f"{max(float(p.residual.max()) for p in between):.0e}",
                    f"{sum(p.outside for p in between)} of {sum(len(p.x) for p in between)}",
                    f"{_worst(truncated):.0e}",
                    f"{sum(p.certified for p in group) / sum(len(p.x) for p in group):.1%}",
                    _verdict(all(p.ok for p in group), group[0].allowed),
                ]
            )
        titled = ["backend", "place"] if places else ["backend"]
        headings = [*titled, "σ ≥\n1e-6", "between:\nx", "residual", "outside", "σ ≤\n1e-12", "proved", ""]
        tables.append(Table(f"{formula}, singular values from 1 to 1e-14", headings, rows, len(titled)))
    return tables


def two_formulas(partings: Iterable[Parting]) -> Table:
    """A row a relation between the tasks."""
    rows = [
        [
            item.relation,
            "yes" if item.coincide else "no",
            f"{np.median(item.x):.0e}",
            f"{item.x.max():.0e}",
            f"{item.residual.max():.0e}",
            f"{item.certified} of {len(item.x)}",
            _verdict(item.ok),
        ]
        for item in partings
        if math.isnan(item.sigma)
    ]
    return Table(
        "Eq. 4.8 against the strict stack",
        ["tasks", "to coincide", "x, median", "x", "residual", "proved", ""],
        rows,
        2,
    )


def random_hierarchies(judgements: Sequence[Judgement], sizes: bool) -> Table:
    """A row a backend, or a row a backend and size; judged are all sizes together."""
    fine = {total.backend: total.ok for total in summed(judgements)}
    rows = [
        [
            each.backend,
            *([str(each.n), str(each.levels)] if sizes else []),
            str(each.count),
            f"{each.certified / each.count:.1%}",
            str(each.refuted),
            str(each.failures),
            str(each.beaten),
            f"{1e3 * each.seconds / each.count:.2f}",
            _verdict(fine[each.backend], each.allowed),
        ]
        for each in (judgements if sizes else summed(judgements))
    ]
    titled = ["backend", "n", "levels"] if sizes else ["backend"]
    headings = [*titled, "solved", "proved", "refuted", "failed", "beaten", "ms", ""]
    return Table("Random hierarchies, inequalities, conflicts and weights at every level", headings, rows)


def known(findings: Sequence[Finding]) -> Table:
    """A row a known answer: the largest difference of all backends which promise something."""
    rows = []
    for item in KNOWN:
        asked = [found for found in findings if found.name == item.name]
        if not asked:
            continue
        promised = [found for found in asked if not math.isinf(found.allowed)]
        rows.append(
            [
                item.name,
                _largest(found.x for found in promised),
                _largest(found.residual for found in promised),
                _largest(found.multipliers for found in promised),
                f"{sum(found.hit for found in asked)} of {len(asked)}",
                f"{sum(found.certified for found in asked)} of {len(asked)}",
                _verdict(all(found.ok for found in asked)),
            ]
        )
    return Table("Known answers", ["", "x", "residual", "multi-\npliers", "hit by", "proved", ""], rows)


def misses(findings: Sequence[Finding]) -> Table:
    """A row a backend and known answer that it does not give, whether it promised to or not."""
    rows = [
        [found.name, found.backend, f"{found.x:.0e}", f"{found.residual:.0e}", _yes(found.certified)]
        for found in findings
        if not found.hit
    ]
    return Table("Known answers missed", ["", "backend", "x", "residual", "proved"], rows, 2)


def answers() -> Table:
    """A row for each known answer: its description and its source."""
    rows = [
        [
            item.name,
            _numbers(item.x),
            _numbers(item.residuals),
            "; ".join(f"{level}: {_numbers(each)}" for level, each in item.multipliers.items()),
            "the levels" if item.unique else "the last level",
            item.why,
            item.source,
        ]
        for item in KNOWN
    ]
    return Table("", ["", "x", "residuals", "multipliers of level", "unique by", "why", "source"], rows, 7)


def _numbers(values: Iterable[float]) -> str:
    """In brief: what lies between the third and the last is left out of a long row."""
    texts = [f"{round(value, 12) + 0.0:.4g}" for value in values]
    return ", ".join(texts if len(texts) <= 6 else [*texts[:3], "...", texts[-1]])


def _worst(points: Iterable[Point]) -> float:
    return max(float(max(point.x.max(), point.residual.max())) for point in points)


def _largest(values: Iterable[float]) -> str:
    """The largest that is a number, if any is."""
    numbers = [value for value in values if not math.isnan(value)]
    return f"{max(numbers):.0e}" if numbers else ""


def _verdict(ok: bool, allowed: float = 0.0) -> str:
    """The verdict on a backend that promises an accuracy."""
    return "-" if math.isinf(allowed) else "ok" if ok else "!!"


def _yes(truth: bool) -> str:
    return "yes" if truth else "no"
