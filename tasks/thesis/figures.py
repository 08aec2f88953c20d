"""One picture a figure, a column a law: the arm along its path, and what it takes to get there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .._checks import Array
from ..motion.record import Record
from ..robots.manipulability import velocity_ellipse
from .findings import TIP_FROM, Finding, digits, measure
from .runs import Job, phi_error
from .scenarios import MINUTE, Scenario

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POSES, ELLIPSES = 16, 6
#: Length at which an ellipse shows a velocity ratio of 1 [m per m/rad].
ELLIPSE_SCALE = 0.12
DESIRED, ACTUAL, ARM, MUTED, ELLIPSE = "#d62728", "#1f5fbf", "#2b2f36", "#6b7280", "#e69f00"
#: Of the joints, distinguishable in every kind of colour vision (Okabe and Ito).
JOINTS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00")
#: Of a joint at a velocity limit, at an acceleration limit, at both.
AT_LIMIT = ("#ffffff", "#d55e00", "#56b4e9", "#2b2f36")

#: The panels of a column: height, and what the left edge says.
PANELS = {
    "arm": (2.5, "y [m]"),
    "phi": (0.9, "φ error [deg]"),
    "speed": (0.9, "speed [rad/min]"),
    "torque": (0.9, "torque [N m]"),
    "manipulability": (0.6, "W [m²]"),
    "limits": (0.4, "at a limit"),
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
    heights = [height for height, _ in PANELS.values()]
    figure, axes = grid(heights, len(runs), column=3.9, height=13.0, top=0.915, bottom=0.06)
    for column, (job, record) in zip(axes.T, runs.items(), strict=True):
        panels = dict(zip(PANELS, column, strict=True))
        _title(panels["arm"], job, record)
        draw_arm(panels["arm"], scenario, record)
        draw_ellipses(panels["arm"], scenario, record)
        draw_phi(panels["phi"], scenario, record)
        draw_joints(panels["speed"], record.t, record.v * MINUTE)
        assert record.tau is not None  # a planar arm knows its torques and
        assert record.manipulability is not None  # its manipulability
        draw_joints(panels["torque"], record.t[:-1], record.tau)
        panels["manipulability"].plot(record.t / MINUTE, record.manipulability, color=ACTUAL)
        _at_limits(panels["limits"], scenario, record)
        if job.law.inequalities:
            for side in -1, 1:
                panels["speed"].axhline(side * scenario.velocity_limit * MINUTE, color=MUTED, ls="--", lw=1.0)
        for name, panel in panels.items():
            if name != "arm":
                draw_time(panel, scenario, record, last=name == "limits")
    common_view(axes[0], scenario, runs.values())
    _edges(dict(zip(PANELS, axes, strict=True)), scenario, runs)
    figure.align_ylabels(axes[:, 0])
    figure.text(0.5, 0.993, scenario.title, ha="center", va="top", fontsize=14, fontweight="bold")
    backends = ", ".join(dict.fromkeys(job.backend for job in runs))
    foot = f"The text: {scenario.claim.says}.   Solved by {backends}."
    figure.text(0.5, 0.008, foot, ha="center", fontsize=9, color=MUTED)
    return figure


def grid(
    heights: Sequence[float], columns: int, *, column: float, height: float, top: float, bottom: float
) -> tuple[Figure, Array]:
    """A figure of so many columns [inch], and its panels, shape (len(heights), columns): one y axis a row."""
    from matplotlib.figure import Figure

    width = 1.1 + column * columns
    figure = Figure(figsize=(width, height))
    axes = figure.subplots(len(heights), columns, squeeze=False, height_ratios=heights)
    figure.subplots_adjust(left=0.85 / width, right=1 - 0.15 / width, top=top, bottom=bottom, wspace=0.06, hspace=0.16)
    for row in axes:
        for other in row[1:]:
            other.sharey(row[0])
            other.tick_params(labelleft=False)
    return figure, axes


def draw_arm(axis: Axes, scenario: Scenario, record: Record, poses: int = POSES) -> None:
    """The arm at equal times, the later the darker, with both paths."""
    for tone, q in zip(np.linspace(0.12, 1.0, poses), snapshots(scenario, record, poses), strict=False):
        points = scenario.arm.points(q)
        axis.plot(*points.T, color=ARM, alpha=tone, lw=1.8, solid_capstyle="round", zorder=2)
        axis.plot(*points[:-1].T, "o", color=ARM, alpha=tone, ms=3.2, mec="white", mew=0.5, zorder=2.1)
    desired = desired_path(scenario)
    axis.plot(*desired.T, color=DESIRED, lw=5.0, alpha=0.55, solid_capstyle="round", label="desired path", zorder=3)
    axis.plot(record.pose[:, 0], record.pose[:, 1], color=ACTUAL, lw=1.6, label="actual path", zorder=4)
    axis.plot(0, 0, "s", color=ARM, ms=8, zorder=5)
    axis.set_aspect("equal")
    axis.grid(alpha=0.15)
    axis.text(0.985, 0.015, "x [m]", transform=axis.transAxes, ha="right", fontsize=9)
    if record.stopped:
        verb = "diverges" if record.stopped.diverged else "stops"
        text = f"{verb} at {record.stopped.t / MINUTE:.3f} min"
        axis.annotate(text, (0.5, 0.03), xycoords="axes fraction", ha="center", color=DESIRED, fontsize=9, zorder=6)


def draw_ellipses(axis: Axes, scenario: Scenario, record: Record) -> None:
    """The velocity-ratio ellipses of the tip (section 1.3.5): where joint velocities of norm one can take it."""
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    circle = np.array([np.cos(turn), np.sin(turn)])
    label = "velocity ratio"
    for q in snapshots(scenario, record, ELLIPSES):
        ellipse = velocity_ellipse(scenario.arm.jacobian(q)[:2])
        outline = ellipse.directions @ (ellipse.half_axes[:, None] * circle)
        outline = scenario.arm.points(q)[-1, :, None] + ELLIPSE_SCALE * outline
        axis.plot(*outline, color=ELLIPSE, lw=1.1, alpha=0.9, zorder=4.5, label=label)
        label = "_"


def draw_phi(axis: Axes, scenario: Scenario, record: Record) -> None:
    """Error of phi, linear within the degree that counts as held; phi itself where none is desired."""
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


def draw_joints(axis: Axes, t: Array, values: Array) -> None:
    """One line a joint."""
    for joint, line in enumerate(values.T):
        axis.plot(t / MINUTE, line, color=JOINTS[joint % len(JOINTS)], lw=1.2, label=f"joint {joint + 1}")


def _at_limits(axis: Axes, scenario: Scenario, record: Record) -> None:
    """A stripe a joint: when it is at its velocity limit, at its acceleration limit, or at both."""
    from matplotlib.colors import ListedColormap

    joints = len(scenario.lengths)
    if not len(record):
        return
    kinds = np.zeros((len(record), joints), dtype=np.uint8)
    for bit, name in ((1, "velocity"), (2, "acceleration")):
        if name in record.active:
            kinds |= np.uint8(bit) * (record.active[name] != 0)
    # As many columns as a screen has: a limit that is met in between still shows.
    bins = np.array_split(kinds, 600) if len(kinds) >= 600 else [kinds[k : k + 1] for k in range(len(kinds))]
    stripes = np.array([np.bitwise_or.reduce(block, axis=0) for block in bins]).reshape(-1, joints).T
    end = record.t[len(record)] / MINUTE
    axis.imshow(
        stripes, aspect="auto", interpolation="nearest", extent=(0, end, joints + 0.5, 0.5),
        cmap=ListedColormap(AT_LIMIT), vmin=-0.5, vmax=3.5,
    )  # fmt: skip
    axis.set_yticks(range(1, joints + 1))


def draw_time(axis: Axes, scenario: Scenario, record: Record, *, last: bool = True) -> None:
    """The time axis of the whole motion, shaded from where a run ended early."""
    end = scenario.duration / MINUTE
    axis.set_xlim(0, end)
    axis.set_xticks(np.linspace(0.0, end, 5), [f"{t:g}" for t in np.linspace(0.0, end, 5)])
    axis.grid(alpha=0.15)
    axis.tick_params(labelbottom=last)
    if last:
        axis.set_xlabel("time [min]")
    if record.stopped:
        axis.axvspan(record.stopped.t / MINUTE, end, color=DESIRED, alpha=0.08, lw=0)
        axis.axvline(record.stopped.t / MINUTE, color=DESIRED, lw=1.0, ls=":")


def common_view(axes: Array, scenario: Scenario, records: Iterable[Record]) -> None:
    """The same piece of the plane for all: what the drawn arms and the path cover."""
    drawn = [scenario.arm.points(q) for record in records for q in snapshots(scenario, record)]
    covered = np.concatenate([*drawn, desired_path(scenario)])
    low, high = covered.min(axis=0), covered.max(axis=0)
    margin = 0.06 * (high - low).max() + 0.02
    for axis in axes:
        axis.set_xlim(low[0] - margin, high[0] + margin)
        axis.set_ylim(low[1] - margin, high[1] + margin)


def desired_path(scenario: Scenario) -> Array:
    """Places of the desired path, shape (241, 2): corners of polygons of three or four sides among them."""
    path = scenario.path
    return np.array([path(t)[0] for t in np.linspace(0.0, scenario.duration, 241)])


def snapshots(scenario: Scenario, record: Record, poses: int = POSES) -> Array:
    """Joint angles at equal times of the whole motion, as far as the run came, shape (<= poses, n)."""
    times = np.linspace(0.0, scenario.duration, poses)
    if len(record.t) < 2:
        return record.q
    tick = record.t[1] - record.t[0]
    return np.asarray(record.q[np.round(times[times <= record.t[-1] + 0.5 * tick] / tick).astype(int)])


def summary(found: Finding) -> str:
    """How well both tasks are met, in a line."""
    parts = [] if np.isnan(found.phi_share) else [f"φ within 1° for {found.phi_share:.0%}"]
    if not np.isnan(found.tip_error_mm):
        parts.append(f"tip within {digits(found.tip_error_mm)} mm after {TIP_FROM:g} min")
    return ", ".join(parts)


def _title(axis: Axes, job: Job, record: Record) -> None:
    axis.set_title(f"{job.law.title}\n\n", fontsize=12, fontweight="bold")
    lines = f"{summary(measure(job, record))}\n{_degrees(job, record)}"
    axis.text(0.5, 1.015, lines, transform=axis.transAxes, ha="center", color=MUTED, fontsize=8.5)


def _degrees(job: Job, record: Record) -> str:
    """Degrees of manipulability of the task levels and of redundancy below them (Eq. 3.7, 3.8), where checked."""
    if not record.checked:
        return ""
    tasks = record.degrees.manipulability[:, 1 if job.law.inequalities else 0 :]
    levels = " + ".join(_span(level) for level in tasks.T)
    return f"degree of manipulability {levels}, of redundancy {_span(record.degrees.redundancy[:, -1])}"


def _span(values: NDArray[np.int64]) -> str:
    low, high = values.min(), values.max()
    return f"{low}" if low == high else f"{low}..{high}"


def _edges(axes: Mapping[str, Array], scenario: Scenario, runs: Mapping[Job, Record]) -> None:
    """What stands at the left edge, the scales that all laws share, and the legends."""
    from matplotlib.patches import Patch

    for name, (_, label) in PANELS.items():
        axes[name][0].set_ylabel("φ [deg]" if name == "phi" and scenario.phi is None else label)
    axes["speed"][0].set_ylim(*speed_range(scenario, runs.values()))
    whole = [record.tau for record in runs.values() if not record.stopped and record.tau is not None]
    if whole:  # a run that diverges may leave the panel
        top = 1.1 * max(np.abs(tau).max() for tau in whole)
        axes["torque"][0].set_ylim(-top, top)
    axes["manipulability"][0].set_ylim(bottom=0.0)
    axes["arm"][0].legend(loc="upper left", fontsize=8, framealpha=0.9)
    axes["speed"][0].legend(loc="lower right", fontsize=7, ncols=len(scenario.lengths), framealpha=0.6)
    names = ("velocity", "acceleration", "both")
    patches = [Patch(color=color, label=name) for color, name in zip(AT_LIMIT[1:], names, strict=True)]
    axes["limits"][0].legend(handles=patches, loc="center right", fontsize=7, ncols=3, framealpha=0.9)


def speed_range(scenario: Scenario, records: Iterable[Record]) -> tuple[float, float]:
    """Of the joint speeds [rad/min]: all of them, but not those of a run that diverges."""
    peak = MINUTE * max(np.abs(record.v).max() for record in records)
    limit = MINUTE * scenario.velocity_limit
    top = 1.15 * min(peak or limit, 2.2 * limit)
    if 0.9 * limit < top < 1.1 * limit:
        top = 1.1 * limit  # lest the frame hide the limits
    return -top, top
