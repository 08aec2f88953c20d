"""A motion as a GIF: the arms of all laws side by side, in time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..motion.record import Record
from .figures import ACTUAL, ARM, DESIRED, MUTED, common_view, desired_path
from .runs import Job
from .scenarios import MINUTE, Scenario

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

    figure = Figure(figsize=(3.6 * len(runs), 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, len(runs), squeeze=False)[0]
    common_view(axes, scenario, runs.values())
    moving = []
    for axis, job in zip(axes, runs, strict=True):
        axis.set_title(job.law.title, fontsize=10)
        axis.set_aspect("equal")
        axis.grid(alpha=0.15)
        axis.plot(*desired_path(scenario).T, color=DESIRED, lw=4.0, alpha=0.5)
        trace = axis.plot([], [], color=ACTUAL, lw=1.4)[0]
        links = axis.plot([], [], "o-", color=ARM, lw=2.2, ms=4.0, mec="white", mew=0.5)[0]
        note = axis.text(0.5, 0.03, "", transform=axis.transAxes, ha="center", color=MUTED, fontsize=8)
        moving.append((trace, links, note))

    writer = PillowWriter(fps=PER_SECOND)
    with writer.saving(figure, str(path), dpi=DPI):
        for t in np.linspace(0.0, scenario.duration, FRAMES):
            for (trace, links, note), record in zip(moving, runs.values(), strict=True):
                k = min(int(np.searchsorted(record.t, t)), len(record.q) - 1)
                trace.set_data(*record.pose[: k + 1, :2].T)
                links.set_data(*scenario.arm.points(record.q[k]).T)
                over = record.stopped is not None and t >= record.stopped.t
                note.set_text("diverged" if over else f"t = {t / MINUTE:.2f} min")
            writer.grab_frame()
