"""The text's claims as numbers: one row a figure, law and backend."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass, fields
from io import StringIO
from math import isnan, nan
from typing import TYPE_CHECKING

import numpy as np

from .._checks import Array
from ..motion.record import Record
from .runs import Job, phi_error, tip_error
from .scenarios import MINUTE

if TYPE_CHECKING:
    from rich.table import Table

#: From when on the tip must be on its path, and phi settled: shares of the move. The position
#: feedback is slow (10 /min): the error of the start is below 1 mm only after 0.5 to 0.67 min.
TIP_FROM, PHI_FROM = 0.7, 0.2

HEADINGS = {
    "figure": "figure",
    "law": "law",
    "backend": "backend",
    "tip_error_mm": "tip error after 0.7 min [mm]",
    "phi_share": "share of time with φ within 1°",
    "phi_peak_deg": "largest φ error after 0.2 min [deg]",
    "peak_speed": "peak joint speed [rad/min]",
    "diverged_min": "diverged at [min]",
    "certified": "certified",
    "difference_rad": "largest difference to the closed form [rad]",
    "note": "note",
}


@dataclass(frozen=True)
class Claim:
    """One row of the table; NaN where a number means nothing.

    Attributes
    ----------
    figure, law, backend : str
    tip_error_mm : float
        Largest distance of the tip from where it should be, from 0.7 of the move on [mm].
    phi_share : float
        Share of the whole move in which phi is within 1 degree; what a stopped run missed counts as not.
    phi_peak_deg : float
        Largest error of phi from 0.2 of the move on [deg].
    peak_speed : float
        Largest joint speed [rad/min].
    diverged_min : float
        When the motion left all bounds [min].
    certified : float
        Share of the checked ticks whose answer is proved optimal.
    difference_rad : float
        Largest difference of a joint angle to the closed form's run, over the ticks of both [rad].
    note : str
        Why a run ended early, if not by divergence.
    """

    figure: str
    law: str
    backend: str
    tip_error_mm: float
    phi_share: float
    phi_peak_deg: float
    peak_speed: float
    diverged_min: float
    certified: float
    difference_rad: float
    note: str = ""


def measure(job: Job, record: Record, closed_form: Record | None = None) -> Claim:
    """The row of one run; `closed_form` is the run of the same law by its formula."""
    scenario = job.scenario
    elapsed = record.t / scenario.duration
    share = peak = nan
    if scenario.phi is not None:
        error = np.abs(np.degrees(phi_error(scenario, record)))
        share = float(np.count_nonzero(error < 1.0) / (round(scenario.duration / scenario.tick) + 1))
        peak = _largest(error[elapsed >= PHI_FROM])
    difference = nan
    if closed_form is not None and not job.closed_form:
        both = min(len(record.q), len(closed_form.q))
        difference = _largest(np.abs(record.q[:both] - closed_form.q[:both]))
    stopped = record.stopped
    return Claim(
        figure=scenario.figure,
        law=job.law.title,
        backend=job.backend,
        tip_error_mm=1e3 * _largest(tip_error(scenario, record)[elapsed >= TIP_FROM]),
        phi_share=share,
        phi_peak_deg=peak,
        peak_speed=MINUTE * _largest(np.abs(record.v)),
        diverged_min=nan if record.diverged_at is None else record.diverged_at / MINUTE,
        certified=record.certified_share,
        difference_rad=difference,
        note=stopped.reason if stopped is not None and not stopped.diverged else "",
    )


def to_csv(claims: Sequence[Claim]) -> str:
    """The table with full precision, one header line; empty where a number means nothing."""
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    names = [field.name for field in fields(Claim)]
    writer.writerow(names)
    for claim in claims:
        values = [getattr(claim, name) for name in names]
        writer.writerow(["" if isinstance(value, float) and isnan(value) else value for value in values])
    return out.getvalue()


def to_markdown(claims: Sequence[Claim], remarks: Sequence[str] = ()) -> str:
    """The table to read, and below it a list of remarks."""
    names = _shown(claims)
    lines = ["| " + " | ".join(HEADINGS[name] for name in names) + " |"]
    lines.append("|" + "|".join("---" if name in TEXT else "---:" for name in names) + "|")
    lines += ["| " + " | ".join(_text(claim, name).replace("|", "\\|") for name in names) + " |" for claim in claims]
    return "\n".join([*lines, "", *(f"* {remark}" for remark in remarks)]) + "\n"


def to_terminal(claims: Sequence[Claim]) -> Table:
    """The table for a terminal, under shorter headings; those of :data:`HEADINGS` say what they mean."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    names = _shown(claims)
    for name in names:
        table.add_column(Text(SHORT[name]), justify="left" if name in TEXT else "right", overflow="fold")
    for before, claim in zip([None, *claims], claims, strict=False):
        if before is not None and before.figure != claim.figure:
            table.add_section()
        table.add_row(*(_text(claim, name) for name in names))
    return table


#: For a terminal, where a line should hold a row.
SHORT = {
    "figure": "fig.",
    "law": "law",
    "backend": "backend",
    "tip_error_mm": "tip\n[mm]",
    "phi_share": "φ held",
    "phi_peak_deg": "φ error\n[deg]",
    "peak_speed": "speed\n[rad/min]",
    "diverged_min": "diverged\n[min]",
    "certified": "proved",
    "difference_rad": "formula\n[rad]",
    "note": "note",
}

TEXT = {"figure", "law", "backend", "note"}
FORMATS = {"tip_error_mm": ".3g", "phi_share": ".2f", "phi_peak_deg": ".3g", "peak_speed": ".1f"} | {
    "diverged_min": ".3f",
    "certified": ".1%",
    "difference_rad": ".1e",
}


def _shown(claims: Sequence[Claim]) -> list[str]:
    """All columns, without the notes if there are none."""
    return [name for name in HEADINGS if name != "note" or any(claim.note for claim in claims)]


def _text(claim: Claim, name: str) -> str:
    value = getattr(claim, name)
    if name in TEXT:
        return str(value)
    return "" if isnan(value) else format(value, FORMATS[name])


def _largest(values: Array) -> float:
    return float(values.max()) if values.size else nan
