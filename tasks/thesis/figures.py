"""One picture a figure: the arm along its path, the orientation and the joint speeds, law by law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from .._checks import Array
from ..motion.record import Record
from .claims import TIP_FROM, measure
from .runs import Job, phi_error
from .scenarios import MINUTE, Scenario

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POSES = 16
DESIRED, ACTUAL, ARM, MUTED = "#d62728", "#1f5fbf", "#2b2f36", "#6b7280"
#: Of the joints, distinguishable in every kind of colour vision (Okabe and Ito).
JOINTS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00")


def draw(scenario: Scenario, runs: Mapping[Job, Record]) -> Figure:
    """The figure of one scenario, a column a law.

    Parameters
    ----------
    scenario : Scenario
    runs : mapping of Job to Record
        One run a law.

    Returns
    -------
    matplotlib.figure.Figure
        With the desired path in red and the actual one in blue; time in minutes, like the text.
    """
    from matplotlib.figure import Figure

    columns = len(runs)
    figure = Figure(figsize=(1.2 + 4.4 * columns, 9.6), layout="constrained")
    axes = figure.subplots(3, columns, squeeze=False, height_ratios=[2.2, 1.0, 1.0])
    for row in axes:
        for other in row[1:]:
            other.sharey(row[0])
            other.tick_params(labelleft=False)
    for column, (job, record) in zip(axes.T, runs.items(), strict=True):
        _arm(column[0], scenario, record)
        column[0].set_title(f"{job.law.title}\n", fontsize=12, fontweight="bold")
        column[0].text(
            0.5, 1.02, _summary(job, record), transform=column[0].transAxes, ha="center", color=MUTED, fontsize=9
        )
        _orientation(column[1], scenario, record)
        _speeds(column[2], scenario, record, limited=job.law.inequalities)
        for axis in column[1:]:
            _time(axis, scenario, record)
        column[2].set_xlabel("time [min]")
    _common_view(axes[0], scenario, runs)
    _labels(axes, scenario, runs)
    backends = ", ".join(dict.fromkeys(job.backend for job in runs))
    figure.suptitle(scenario.title, fontsize=14, fontweight="bold")
    figure.supxlabel(f"The text: {scenario.claim}.   Solved by {backends}.", fontsize=9, color=MUTED)
    return figure


def _arm(axis: Axes, scenario: Scenario, record: Record) -> None:
    """The arm at equal times, the later the darker, with both paths."""
    arm = scenario.arm
    for tone, q in zip(np.linspace(0.12, 1.0, POSES), _snapshots(scenario, record), strict=False):
        points = arm.points(q)
        axis.plot(*points.T, color=ARM, alpha=tone, lw=1.8, solid_capstyle="round", zorder=2)
        axis.plot(*points[:-1].T, "o", color=ARM, alpha=tone, ms=3.2, mec="white", mew=0.5, zorder=2.1)
    desired = np.array([scenario.start, scenario.end])
    axis.plot(*desired.T, color=DESIRED, lw=5.0, alpha=0.55, solid_capstyle="round", label="desired path", zorder=3)
    axis.plot(record.pose[:, 0], record.pose[:, 1], color=ACTUAL, lw=1.6, label="actual path", zorder=4)
    axis.plot(0, 0, "s", color=ARM, ms=8, zorder=5)
    axis.set_aspect("equal")
    axis.grid(alpha=0.15)
    axis.set_xlabel("x [m]")
    if record.stopped:
        axis.annotate(
            _end(record), (0.5, 0.03), xycoords="axes fraction", ha="center", color=DESIRED, fontsize=9, zorder=6
        )


def _orientation(axis: Axes, scenario: Scenario, record: Record) -> None:
    """Error of phi, linear within the degree that counts as met; phi itself where none is desired."""
    t = record.t / MINUTE
    if scenario.phi is None:
        axis.plot(t, np.degrees(record.pose[:, 2]), color=ACTUAL)
        return
    axis.axhspan(-1, 1, color="#009e73", alpha=0.15, lw=0)
    axis.plot(t, np.degrees(phi_error(scenario, record)), color=ACTUAL)
    axis.set_yscale("symlog", linthresh=1.0, linscale=0.6)
    axis.set_ylim(-200, 200)
    ticks = [-100, -10, -1, 0, 1, 10, 100]
    axis.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.minorticks_off()


def _speeds(axis: Axes, scenario: Scenario, record: Record, *, limited: bool) -> None:
    """Joint speeds, cut off where a run diverges, with the limits where the law has them."""
    limit = scenario.velocity_limit * MINUTE
    for joint, speed in enumerate(record.v.T * MINUTE):
        axis.plot(record.t / MINUTE, speed, color=JOINTS[joint % len(JOINTS)], lw=1.3, label=f"joint {joint + 1}")
    if limited:
        for side in -limit, limit:
            axis.axhline(side, color=MUTED, ls="--", lw=1.0)


def _time(axis: Axes, scenario: Scenario, record: Record) -> None:
    """The time axis of the whole move, shaded from where a run ended early."""
    end = scenario.duration / MINUTE
    axis.set_xlim(0, end)
    axis.grid(alpha=0.15)
    if record.stopped:
        axis.axvspan(record.stopped.t / MINUTE, end, color=DESIRED, alpha=0.08, lw=0)
        axis.axvline(record.stopped.t / MINUTE, color=DESIRED, lw=1.0, ls=":")


def _common_view(axes: Array, scenario: Scenario, runs: Mapping[Job, Record]) -> None:
    """The same piece of the plane for all laws: what the drawn arms and the path cover."""
    drawn = [scenario.arm.points(q) for record in runs.values() for q in _snapshots(scenario, record)]
    covered = np.concatenate([*drawn, [scenario.start, scenario.end]])
    low, high = covered.min(axis=0), covered.max(axis=0)
    margin = 0.06 * (high - low).max() + 0.02
    for axis in axes:
        axis.set_xlim(low[0] - margin, high[0] + margin)
        axis.set_ylim(low[1] - margin, high[1] + margin)


def _labels(axes: Array, scenario: Scenario, runs: Mapping[Job, Record]) -> None:
    """What stands at the left edge, and one legend a row."""
    axes[0, 0].set_ylabel("y [m]")
    axes[1, 0].set_ylabel("φ [deg]" if scenario.phi is None else "φ desired - actual [deg]")
    axes[2, 0].set_ylabel("joint speed [rad/min]")
    peak = MINUTE * max(np.abs(record.v).max() for record in runs.values())
    limit = MINUTE * scenario.velocity_limit
    top = 1.15 * min(peak, 2.2 * limit)  # a run that diverges may leave the panel
    if 0.9 * limit < top < 1.1 * limit:
        top = 1.1 * limit  # lest the frame hide the limits
    axes[2, 0].set_ylim(-top, top)
    axes[0, 0].legend(loc="upper left", fontsize=8, framealpha=0.9)
    axes[2, 0].legend(loc="lower right", fontsize=8, ncols=len(scenario.lengths), framealpha=0.9)


def _snapshots(scenario: Scenario, record: Record) -> Array:
    """Joint angles at equal times of the whole move, as far as the run came, shape (<= POSES, n)."""
    times = np.linspace(0.0, scenario.duration, POSES)
    ticks = np.round(times / scenario.tick).astype(int)
    return np.asarray(record.q[ticks[ticks < len(record.q)]])


def _summary(job: Job, record: Record) -> str:
    claim, scenario = measure(job, record), job.scenario
    parts = [] if np.isnan(claim.phi_share) else [f"φ within 1° for {claim.phi_share:.0%} of the move"]
    if not np.isnan(claim.tip_error_mm):
        parts.append(f"tip within {claim.tip_error_mm:.2g} mm after {TIP_FROM * scenario.duration / MINUTE:.1f} min")
    return ", ".join(parts)


def _end(record: Record) -> str:
    assert record.stopped is not None
    verb = "diverges" if record.stopped.diverged else "stops"
    return f"{verb} at {record.stopped.t / MINUTE:.3f} min"
