"""The full picture of a figure, a column a law: the arm along its path, and panels of phi, speeds, torques, limits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..simulation.record import Record
from .arms import draw_arm, draw_ellipses, legend, proportion, show, view
from .measuring import TIP_FROM, digits, measure
from .panels import draw_joints, draw_limits, draw_phi, draw_time, name_joints, name_limits, speed_range, torque_range
from .run_result import RunResult
from .runs import Job
from .scenarios import MINUTE, Scenario
from .sheet import COLUMN, Head, Row, rule, same_range, sheet
from .style import ACTUAL, MUTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: The rows below the arm. The last one is that of laws which have limits.
PANELS = {
    "phi": Row("φ error [deg]", 1.05, above=0.56),
    "speed": Row("speed [rad/min]", 1.15, above=0.32),
    "torque": Row("torque [N m]", 1.15),
    "manipulability": Row("W [m²]", 0.75),
    "limits": Row("", 0.5, above=0.62),
}


def draw(scenario: Scenario, runs: Mapping[Job, Record]) -> Figure:
    """The figure of one scenario, a column a law.

    Parameters
    ----------
    scenario : Scenario
    runs : mapping of Job to Record
        One run a law, at least one.

    Returns
    -------
    matplotlib.figure.Figure
        With the desired path in red and the actual one in blue; time in minutes, like the text.
    """
    piece = view(scenario, runs.values(), outlines=True)
    rows = {"arm": Row("y [m]", COLUMN * proportion(piece), above=0.0)} | PANELS
    if scenario.phi is None:
        rows["phi"] = replace(PANELS["phi"], label="φ [deg]")
    limited = [job.law.inequalities for job in runs]
    if not any(limited):
        del rows["limits"]
    elif all(limited):  # no time axis above it
        rows["limits"] = replace(PANELS["limits"], above=0.32)
    heads = [Head(job.law.title, _lines(job, record), ended(record)) for job, record in runs.items()]
    named = legend(outlines=True, held=scenario.phi is not None)
    figure, panels = sheet(scenario.title, rows, heads, named, foot(scenario, runs))
    for k, (job, record) in enumerate(runs.items()):
        draw_arm(panels["arm"][k], scenario, record)
        draw_ellipses(panels["arm"][k], scenario, record)
        show(panels["arm"][k], piece)
        panels["arm"][k].set_xlabel("x [m]")
        _draw_column({name: row[k] for name, row in panels.items() if name != "arm"}, job, record)
    _scales(panels, scenario, runs)
    rule(figure)
    return figure


def _draw_column(column: dict[str, Axes], job: Job, record: Record) -> None:
    """All panels over time of one run; where its law has no limits, a word stands for the last one."""
    scenario, limited = job.scenario, job.law.inequalities
    if "limits" in column and not limited:
        empty = column.pop("limits")
        x, y = empty.get_position().get_points().mean(axis=0)
        empty.figure.text(x, y, "no joint limits", color=MUTED, ha="center", va="center")
        empty.remove()
    draw_phi(column["phi"], scenario, record)
    draw_joints(column["speed"], record.t, record.v * MINUTE, scenario.velocity_limit * MINUTE if limited else 0.0)
    assert record.tau is not None  # a planar arm knows its torques and
    assert record.manipulability is not None  # its manipulability
    draw_joints(column["torque"], record.t[:-1], record.tau)
    column["manipulability"].plot(record.t / MINUTE, record.manipulability, color=ACTUAL)
    if limited:
        draw_limits(column["limits"], scenario, record)
        column["limits"].yaxis.set_visible(True)
        name_limits(column["limits"])
    last = list(column)[-1]
    for name, panel in column.items():
        draw_time(panel, scenario, record, last=name == last)


def _scales(panels: Mapping[str, NDArray[np.object_]], scenario: Scenario, runs: Mapping[Job, Record]) -> None:
    """What all laws share: the scales, and which line is which joint."""
    same_range(panels["phi"])
    same_range(panels["speed"], *speed_range(scenario, runs.values()))
    same_range(panels["torque"], *(torque_range(runs.values()) or (None, None)))
    same_range(panels["manipulability"], 0.0, 1.06 * max(panel.get_ylim()[1] for panel in panels["manipulability"]))
    limited = any(job.law.inequalities for job in runs)
    name_joints(panels["speed"][0], scenario.velocity_limit * MINUTE if limited else 0.0)


def foot(scenario: Scenario, runs: Iterable[Job]) -> str:
    """What the text says of a figure, whether that can be decided, and what solved it."""
    parts = [f"The text: {'; '.join(claim.says for claim in scenario.claims)}."]
    if scenario.undecided:
        parts.append(f"Undecided: {scenario.undecided}.")
    parts.append(f"Solved by {', '.join(dict.fromkeys(job.backend for job in runs))}.")
    return " ".join(parts)


def ended(record: Record) -> str:
    """When a run ended early, or nothing."""
    if not record.stopped:
        return ""
    verb = "diverges" if record.stopped.diverged else "stops"
    return f"{verb} at {record.stopped.t / MINUTE:.3f} min"


def summary(found: RunResult) -> str:
    """How well both tasks are met, in a line."""
    parts = [] if np.isnan(found.phi_share) else [f"φ within 1° for {found.phi_share:.0%}"]
    if not np.isnan(found.tip_error_mm):
        parts.append(f"tip within {digits(found.tip_error_mm)} mm after {TIP_FROM:g} min")
    return ", ".join(parts)


def _lines(job: Job, record: Record) -> list[str]:
    """Numbers over a column. Degrees (Eq. 3.7, 3.8) are of the task levels and of what is below, where checked."""
    found = measure(job, record)
    lines = [summary(found)]
    if found.turning:
        lines.append(f"at the end a joint still turns at {digits(found.end_speed)} rad/min")
    if record.checked:
        tasks = record.degrees.manipulability[:, 1 if job.law.inequalities else 0 :]
        levels = " + ".join(_span(level) for level in tasks.T)
        lines.append(f"degree of manipulability {levels}, of redundancy {_span(record.degrees.redundancy[:, -1])}")
    return lines


def _span(values: NDArray[np.int64]) -> str:
    low, high = values.min(), values.max()
    return f"{low}" if low == high else f"{low}..{high}"
