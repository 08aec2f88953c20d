"""Claims against findings: a row a figure, to read in a terminal and in claims.md; and every number of every run."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan
from typing import TYPE_CHECKING

import numpy as np

from .findings import Finding, digits
from .laws import DAMPED, LIMITS, STRICT, THESIS, TIP, TIP_LIMITS, Law
from .scenarios import SCENARIOS, Scenario

if TYPE_CHECKING:
    from rich.table import Table

#: The columns of the laws: with task priority, and what stands there without.
COLUMNS: dict[str, tuple[Law, ...]] = {
    "Eq. 4.8": (THESIS, TIP),
    "strict": (STRICT,),
    "strict, limits": (LIMITS, TIP_LIMITS),
    "strict, limits, damped": (DAMPED,),
}

LEGEND = (
    "With priority: share of the minute with φ within 1 degree. Without: largest tip error after 0.7 min."
    " ✓: the text's claim holds of this run, ✗: it does not."
)

HEADINGS = {
    "figure": "figure",
    "law": "law",
    "backend": "backend",
    "tip_error_mm": "tip error after 0.7 min [mm]",
    "phi_share": "share of time with φ within 1°",
    "phi_peak_deg": "largest φ error after 0.2 min [deg]",
    "peak_speed": "peak joint speed [rad/min]",
    "peak_torque": "peak torque [N m]",
    "least_singular": "least singular value of J1 [m/rad]",
    "least_manipulability": "least manipulability [m²]",
    "velocity_excess": "velocity limit exceeded by [rad/s]",
    "acceleration_excess": "acceleration limit exceeded by [rad/s²]",
    "limited_share": "share of time at a limit",
    "diverged_min": "diverged at [min]",
    "certified": "certified",
    "difference_rad": "largest difference to the closed form [rad]",
    "note": "note",
}
TEXT = {"figure", "law", "backend", "note"}
FORMATS = {
    "tip_error_mm": ".3g",
    "phi_share": ".2f",
    "phi_peak_deg": ".3g",
    "peak_speed": ".1f",
    "peak_torque": ".3g",
    "least_singular": ".3f",
    "least_manipulability": ".3f",
    "velocity_excess": ".1e",
    "acceleration_excess": ".1e",
    "limited_share": ".2f",
    "diverged_min": ".3f",
    "certified": ".1%",
    "difference_rad": ".1e",
}


def against_claims(findings: Sequence[Finding]) -> list[list[str]]:
    """A row a figure: number, phi, what the text says, and a cell a law: its number and whether the claim holds."""
    rows = []
    for figure in dict.fromkeys(found.figure for found in findings):
        item = SCENARIOS[figure]
        phi = "" if item.phi is None else f"{np.degrees(item.phi):.0f}°"
        cells = [_cell(item, _shown(laws, figure, findings)) for laws in COLUMNS.values()]
        rows.append([figure, phi, item.claim.says, *cells])
    return rows


def _shown(laws: Sequence[Law], figure: str, findings: Sequence[Finding]) -> Finding | None:
    """The run that speaks for a law: the backend's, which comes after the formula's."""
    titles = {law.title for law in laws}
    return next((found for found in reversed(findings) if found.figure == figure and found.law in titles), None)


def _cell(item: Scenario, found: Finding | None) -> str:
    if found is None:
        return ""
    if not isnan(found.diverged_min):
        number = f"diverges at {found.diverged_min:.3f} min"
    elif found.note:
        number = found.note
    else:
        number = f"{digits(found.tip_error_mm)} mm" if item.phi is None else f"{found.phi_share:.2f}"
    return f"{number} {'✓' if item.claim.holds(found) else '✗'}"


def to_markdown(findings: Sequence[Finding], remarks: Sequence[str] = ()) -> str:
    """Both tables to read: claims against findings, then every run; and remarks."""
    names = _columns(findings)
    runs = [[_text(found, name) for name in names] for found in findings]
    return "\n".join(
        [
            "# Claims against findings\n",
            *_pipes(["figure", "φ", "the text", *COLUMNS], against_claims(findings), left=3),
            f"\n{LEGEND}\n",
            "# Every run\n",
            *_pipes([HEADINGS[name] for name in names], runs, left=3),
            *(["\n# Remarks\n", *(f"* {remark}" for remark in remarks)] if remarks else []),
            "",
        ]
    )


def to_terminal(findings: Sequence[Finding]) -> Table:
    """Claims against findings, a line a figure where the terminal is wide enough."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), caption=LEGEND, caption_justify="left")
    for name in ("fig.", "φ", "the text", *COLUMNS):
        table.add_column(name, justify="right" if name in COLUMNS else "left")
    for row in against_claims(findings):
        table.add_row(*(Text(cell, style="red" if cell.endswith("✗") else "") for cell in row))
    return table


def _pipes(headings: Sequence[str], rows: Sequence[Sequence[str]], *, left: int) -> list[str]:
    """A table of Markdown, its first columns set to the left, the others to the right."""
    rule = "|".join(["---"] * left + ["---:"] * (len(headings) - left))
    return [f"| {' | '.join(headings)} |", f"|{rule}|", *(f"| {' | '.join(row)} |" for row in _escaped(rows))]


def _escaped(rows: Sequence[Sequence[str]]) -> list[list[str]]:
    return [[cell.replace("|", "\\|") for cell in row] for row in rows]


def _columns(findings: Sequence[Finding]) -> list[str]:
    """All columns, without the notes if there are none."""
    return [name for name in HEADINGS if name != "note" or any(found.note for found in findings)]


def _text(found: Finding, name: str) -> str:
    value = getattr(found, name)
    if name in TEXT:
        return str(value)
    return "" if isnan(value) else format(value, FORMATS[name])
