"""Tables of claims against results: for the terminal, for claims.md, and of every number of every run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan
from typing import TYPE_CHECKING

import numpy as np

from .claims import Claim
from .laws import DAMPED, LIMITS, STRICT, THESIS, TIP, TIP_LIMITS, Law
from .measuring import CONVERGED, digits
from .run_result import AT_REST, RunResult
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

#: Of cells: whether the claim holds of the run, does not, or is not decided; and a joint that has not come to rest.
HOLDS, FAILS, UNDECIDED, TURNS = "✓", "✗", "?", "↻"
LEGEND = (
    "Of claims on both tasks: share of the minute with φ within 1 degree. Of claims on the tip: its largest error after"
    f" 0.7 min. {HOLDS}: the text's claim holds of this run, {FAILS}: it does not, {UNDECIDED}: undecided, for the text"
    f" does not give the line ('hqp thesis --figure lines' tries others). {TURNS}: at the end, where the path rests, a"
    f" joint still turns faster than {AT_REST:g} rad/min, at so many rad/min."
)
CONVERGENCE = (
    f"Runs whose joint angles differ by more than {CONVERGED:g} degree from the same run at twice the tick, by so many"
    " degrees: at the tick shown as much is still open. All others that do not diverge differ by less."
)

HEADINGS = {
    "figure": "figure",
    "law": "law",
    "backend": "backend",
    "tip_error_mm": "tip error after 0.7 min [mm]",
    "phi_share": "share of time with φ within 1°",
    "phi_peak_deg": "largest φ error after 0.2 min [deg]",
    "peak_speed": "peak joint speed [rad/min]",
    "end_speed": "joint speed at the end [rad/min]",
    "peak_acceleration": "peak joint acceleration after 0.2 min [rad/min²]",
    "reversals": "reversals of a joint",
    "turned_deg": "a joint turns through [deg]",
    "peak_torque": "peak torque [N m]",
    "least_singular": "least singular value of J1 [m/rad]",
    "least_manipulability": "least manipulability [m²]",
    "velocity_excess": "velocity limit exceeded by [rad/s]",
    "acceleration_excess": "acceleration limit exceeded by [rad/s²]",
    "limited_share": "share of time at a limit",
    "diverged_min": "diverged at [min]",
    "certified": "certified",
    "difference_rad": "largest difference to the closed form [rad]",
    "tick_deg": "largest difference to twice the tick [deg]",
    "note": "note",
}
TEXT = {"figure", "law", "backend", "note"}
FORMATS = {
    "tip_error_mm": ".3g",
    "phi_share": ".2f",
    "phi_peak_deg": ".3g",
    "peak_speed": ".1f",
    "end_speed": ".2f",
    "peak_acceleration": ".0f",
    "reversals": "d",
    "turned_deg": ".0f",
    "peak_torque": ".3g",
    "least_singular": ".3f",
    "least_manipulability": ".3f",
    "velocity_excess": ".1e",
    "acceleration_excess": ".1e",
    "limited_share": ".2f",
    "diverged_min": ".3f",
    "certified": ".1%",
    "difference_rad": ".1e",
    "tick_deg": ".1f",
}


@dataclass(frozen=True)
class Section:
    """A table under a heading, with its legend.

    Attributes
    ----------
    title : str
    headings : tuple of str
    rows : list of lists of str
    legend : str
    left : int
        How many columns are words, set to the left.
    """

    title: str
    headings: tuple[str, ...]
    rows: list[list[str]]
    legend: str = ""
    left: int = 3

    def to_markdown(self) -> str:
        """Heading, table, legend."""
        rule = "|".join(["---"] * self.left + ["---:"] * (len(self.headings) - self.left))
        lines = [f"# {self.title}\n", f"| {' | '.join(self.headings)} |", f"|{rule}|"]
        lines += [f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |" for row in self.rows]
        return "\n".join([*lines, *([f"\n{self.legend}"] if self.legend else []), ""])


def against_claims(results: Sequence[RunResult]) -> list[list[str]]:
    """A row a claim: figure, phi, what the text says, and a cell a law: its number and whether the claim holds."""
    rows = []
    for figure in dict.fromkeys(found.figure for found in results):
        item = SCENARIOS[figure]
        for claim in item.claims:
            runs = [_shown(laws, figure, results) for laws in COLUMNS.values()]
            rows.append([figure, angle(item), claim.says, *(verdict(item, claim, found) for found in runs)])
    return rows


def unconverged(results: Sequence[RunResult]) -> list[list[str]]:
    """A row for each motion with a run that depends on the tick: figure, and a cell a law, empty where it does not."""
    motions: dict[Scenario, str] = {}
    for found in results:
        motions.setdefault(SCENARIOS[found.figure], found.figure)
    rows = []
    for figure in motions.values():
        runs = [_shown(laws, figure, results) for laws in COLUMNS.values()]
        cells = [digits(found.tick_deg) if found and found.tick_deg > CONVERGED else "" for found in runs]
        if any(cells):
            rows.append([figure, *cells])
    return rows


def angle(item: Scenario) -> str:
    """The desired orientation, or nothing."""
    return "" if item.phi is None else f"{np.degrees(item.phi):.0f}°"


def _shown(laws: Sequence[Law], figure: str, results: Sequence[RunResult]) -> RunResult | None:
    """The run that represents a law: the backend's, which comes after the formula's."""
    titles = {law.title for law in laws}
    return next((found for found in reversed(results) if found.figure == figure and found.law in titles), None)


def verdict(item: Scenario, claim: Claim, found: RunResult | None) -> str:
    """The number which decides, whether the claim holds, and, if joints still turn at the end, how fast."""
    if found is None:
        return ""
    if not isnan(found.diverged_min):
        number = f"diverges at {found.diverged_min:.3f} min"
    elif found.note:
        number = found.note
    else:
        number = f"{digits(found.tip_error_mm)} mm" if claim.of_tip else f"{found.phi_share:.2f}"
    mark = UNDECIDED if item.undecided else HOLDS if claim.holds(found) else FAILS
    return f"{number} {mark} {TURNS}{digits(found.end_speed)}" if found.turning else f"{number} {mark}"


def to_markdown(results: Sequence[RunResult], studies: Sequence[Section] = (), remarks: Sequence[str] = ()) -> str:
    """All tables to read: claims against results, studies, what has not converged, every run; and remarks."""
    sections = [
        Section("Claims against results", ("figure", "φ", "the text", *COLUMNS), against_claims(results), LEGEND),
        *studies,
        Section("Not converged in the tick", ("figure", *COLUMNS), unconverged(results), CONVERGENCE, left=1),
        every_run("Every run", results),
    ]
    texts = [section.to_markdown() for section in sections if section.rows]
    if remarks:
        texts.append("\n".join(["# Remarks\n", *(f"* {remark}" for remark in remarks), ""]))
    return "\n".join(texts)


def every_run(title: str, results: Sequence[RunResult], names: Sequence[str] = (), legend: str = "") -> Section:
    """A row a run: these numbers of it, or all."""
    names = names or [name for name in HEADINGS if name != "note" or any(found.note for found in results)]
    rows = [[_text(found, name) for name in names] for found in results]
    return Section(title, tuple(HEADINGS[name] for name in names), rows, legend, sum(name in TEXT for name in names))


def to_terminal(results: Sequence[RunResult]) -> Table:
    """Claims against results, a line a figure where the terminal is wide enough."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), caption=LEGEND, caption_justify="left")
    for name in ("fig.", "φ", "the text", *COLUMNS):
        table.add_column(name, justify="right" if name in COLUMNS else "left")
    for row in against_claims(results):
        table.add_row(*row[:3], *(Text(cell, style="red" if FAILS in cell else "") for cell in row[3:]))
    return table


def _text(found: RunResult, name: str) -> str:
    value = getattr(found, name)
    if name in TEXT:
        return str(value)
    return "" if isnan(value) else format(value, FORMATS[name])
