"""A motion as a GIF: the arms of all laws side by side, in time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..simulation.record import Record
from .arms import BASE, LINKS, PATHS, desired_path, proportion, show, view
from .runs import Job
from .scenarios import MINUTE, Scenario
from .style import ACTUAL, ARM, DESIRED, LAST, MUTED

FRAMES, PER_SECOND, DPI = 75, 15, 70


def animate(scenario: Scenario, runs: Mapping[Job, Record], path: Path) -> None:
    """Write the motion of one scenario as a GIF, a column a law; a run that ended early stands still.

    Parameters
    ----------
    scenario : Scenario
    runs : mapping of Job to Record
        One run a law, at least one.
    path : Path
        Of the file.
    """
    from matplotlib.animation import PillowWriter
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    piece = view(scenario, runs.values())
    figure = Figure(figsize=(3.6 * len(runs), 0.6 + 3.3 * proportion(piece)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, len(runs), squeeze=False)[0]
    moving = []
    for axis, job in zip(axes, runs, strict=True):
        axis.set_title(job.law.title, fontsize=10)
        axis.set_aspect("equal")
        show(axis, piece)
        axis.grid(alpha=0.15)
        axis.plot(*desired_path(scenario).T, color=DESIRED, lw=6.0, alpha=0.4, solid_capstyle="round", zorder=PATHS)
        trace = axis.plot([], [], color=ACTUAL, lw=2.4, zorder=PATHS + 0.1)[0]
        inner, last = (axis.plot([], [], color=color, lw=2.2, zorder=LINKS)[0] for color in (ARM, LAST))
        joints = axis.plot([], [], "o", color=ARM, ms=4.0, mec="white", mew=0.5, zorder=BASE)[0]
        note = axis.text(0.5, 0.03, "", transform=axis.transAxes, ha="center", color=MUTED, fontsize=8)
        moving.append((trace, inner, last, joints, note))

    writer = PillowWriter(fps=PER_SECOND)
    with writer.saving(figure, str(path), dpi=DPI):
        for t in np.linspace(0.0, scenario.duration, FRAMES):
            for (trace, inner, last, joints, note), record in zip(moving, runs.values(), strict=True):
                k = min(int(np.searchsorted(record.t, t)), len(record.q) - 1)
                trace.set_data(*record.pose[: k + 1, :2].T)
                points = scenario.arm.points(record.q[k])
                inner.set_data(*points[:-1].T)
                last.set_data(*points[-2:].T)
                joints.set_data(*points[:-1].T)
                over = record.stopped is not None and t >= record.stopped.t
                note.set_text("diverged" if over else f"t = {t / MINUTE:.2f} min")
            writer.grab_frame()
