"""One panel of the workspace: the arm along its path."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.checks import Array
from ..robots.manipulability import velocity_ellipse
from ..simulation.record import Record
from .measuring import HELD as WITHIN
from .scenarios import Scenario
from .style import ACTUAL, ARM, DESIRED, ELLIPSE, GRID, HELD, LAST, tones

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POSES, ELLIPSES = 16, 6
#: Length at which an ellipse shows a velocity ratio of 1 [m per m/rad].
ELLIPSE_SCALE = 0.12
#: Height of a view per its width: no flatter, no taller.
FLATTEST, TALLEST = 0.75, 1.3
#: What lies above what: the links above the paths, and above all of them the last link, which is the orientation.
PATHS, OUTLINES, LINKS, LAST_LINK, BASE = 2.0, 3.0, 4.0, 5.0, 6.0


def draw_arm(axis: Axes, scenario: Scenario, record: Record, *, scale: float = 1.0) -> None:
    """Both paths, and above them the arm at equal times, the later the darker, its last link in its own colour."""
    from matplotlib.collections import LineCollection

    desired = desired_path(scenario)
    axis.plot(
        *desired.T, color=DESIRED, lw=8.0 * scale, alpha=0.4, solid_capstyle="round", label="desired path", zorder=PATHS
    )
    axis.plot(
        record.pose[:, 0],
        record.pose[:, 1],
        color=ACTUAL,
        lw=4.0 * scale,
        solid_capstyle="round",
        label="actual path",
        zorder=PATHS + 0.1,
    )
    points = scenario.arm.points(snapshots(scenario, record))
    times = len(points)
    inner, last = tones(ARM, POSES)[:times], tones(LAST, POSES)[:times]
    round_ends: dict[str, Any] = {"capstyle": "round", "joinstyle": "round"}
    for chain, colors, label, width, height in (
        (points[:, :-1], inner, "links", 1.7, LINKS),
        (points[:, -2:], last, "last link", 2.0, LAST_LINK),
    ):
        lines = LineCollection(
            list(chain), colors=colors, linewidths=width * scale, label=label, zorder=height, **round_ends
        )
        axis.add_collection(lines)
    x, y = points[:, 1:-1].reshape(-1, 2).T
    shades = np.repeat(inner, points.shape[1] - 2, axis=0)
    axis.scatter(x, y, s=10.0 * scale**2, c=shades, edgecolors="white", linewidths=0.4 * scale, zorder=LAST_LINK + 0.1)
    axis.plot(0, 0, "s", color=ARM, ms=8 * scale, zorder=BASE)
    axis.set_aspect("equal")
    axis.set_axisbelow(True)
    axis.grid(alpha=GRID)


def draw_ellipses(axis: Axes, scenario: Scenario, record: Record) -> None:
    """The velocity-ratio ellipses of the tip."""
    from matplotlib.collections import LineCollection

    lines = list(ellipses(scenario, record))
    axis.add_collection(LineCollection(lines, colors=ELLIPSE, linewidths=1.1, label="velocity ratio", zorder=OUTLINES))


def ellipses(scenario: Scenario, record: Record) -> Array:
    """Where joint velocities of norm one can take the tip (section 1.3.5): outlines [m], shape (<= 6, 49, 2)."""
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    circle = np.array([np.cos(turn), np.sin(turn)])
    arm, outlines = scenario.arm, []
    for q in snapshots(scenario, record, ELLIPSES):
        ellipse = velocity_ellipse(arm.jacobian(q)[:2])
        outline = ellipse.directions @ (ellipse.half_axes[:, None] * circle)
        outlines.append(arm.points(q)[-1] + ELLIPSE_SCALE * outline.T)
    return np.array(outlines)


def view(scenario: Scenario, records: Iterable[Record], *, outlines: bool = False) -> Array:
    """The piece of the plane that is drawn of these runs, with ellipses or without: ((x, x), (y, y)) [m].

    Of a run that ended early only the arms count: its path may lead anywhere.
    """
    needed = [desired_path(scenario), np.zeros((1, 2))]
    for record in records:
        needed.append(scenario.arm.points(snapshots(scenario, record)).reshape(-1, 2))
        if outlines:
            needed += list(ellipses(scenario, record))
        if not record.stopped:
            needed.append(record.pose[:, :2])
    covered = np.concatenate(needed)
    low, high = covered.min(axis=0), covered.max(axis=0)
    size = (high - low) + 0.08 * (high - low).max() + 0.02
    size = np.maximum(size, [size[1] / TALLEST, size[0] * FLATTEST])
    middle = (low + high) / 2.0
    return np.stack([middle - size / 2.0, middle + size / 2.0], axis=1)


def show(axis: Axes, piece: Array) -> None:
    """Set the limits of the axes, with ticks at the same steps in both directions."""
    from matplotlib.ticker import MultipleLocator

    axis.set_xlim(*piece[0])
    axis.set_ylim(*piece[1])
    step = next(step for step in (0.1, 0.2, 0.5, 1.0, np.inf) if np.ptp(piece, axis=1).max() <= 9.0 * step)
    for direction in axis.xaxis, axis.yaxis:
        direction.set_major_locator(MultipleLocator(step))


def proportion(piece: Array) -> float:
    """Height of a piece of the plane per its width."""
    width, height = np.ptp(piece, axis=1)
    return float(height / width)


def legend(*, outlines: bool = False, held: bool = False) -> dict[str, Any]:
    """What a legend needs to name all that is drawn of an arm; links in four tones, for the later is the darker.

    Parameters
    ----------
    outlines : bool
        Whether velocity-ratio ellipses are drawn, too.
    held : bool
        Whether the panel of phi has a band in which it counts as held.
    """
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    def links(color: str) -> tuple[Line2D, ...]:
        return tuple(Line2D([], [], color=tone, lw=2.4, solid_capstyle="butt") for tone in tones(color, 4))

    named: dict[str, Any] = {
        "desired path": Line2D([], [], color=DESIRED, lw=6.0, alpha=0.4),
        "actual path": Line2D([], [], color=ACTUAL, lw=3.2),
        "links, darker is later": links(ARM),
        "last link": links(LAST),
    }
    if outlines:
        named["velocity ratio"] = Line2D([], [], color=ELLIPSE, lw=1.1, marker="o", ms=8, mfc="none", ls="")
    if held:
        named[f"φ within {WITHIN:g}°"] = Patch(color=HELD, alpha=0.2, lw=0)
    return {
        "labels": list(named),
        "handles": list(named.values()),
        "handler_map": {tuple: HandlerTuple(ndivide=None, pad=0.0)},
    }


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
