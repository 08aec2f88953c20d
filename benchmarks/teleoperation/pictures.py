"""One picture for each scene: the error of the hand, and the motion of one joint, library by library."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from ..ticks.stream import Stream
from .loop import Run
from .tracking import Tracking

#: After Okabe and Ito, told apart by all eyes; one a setup; a library has one kind of line.
STYLES = {
    "hqp": ("#ee7733", "-"),
    "hqp strict": ("#0072b2", "-"),
    "hqp damped": ("#56b4e9", "-"),
    "hqp braked": ("#000000", "-"),
    "hqp both": ("#332288", "-"),
    "hqp error": ("#cc3311", "-"),
    "hqp error braked": ("#117733", "-"),
    "pink daqp": ("#d55e00", "--"),
    "pink proxqp": ("#e69f00", "--"),
    "pink daqp lm": ("#cc79a7", "--"),
    "pink daqp lm 100": ("#882255", "--"),
    "pink daqp braked": ("#8c510a", "--"),
    "mink daqp": ("#009e73", ":"),
    "mink daqp lm": ("#7f7f7f", ":"),
    "roboplan": ("#aa4499", "-."),
    "roboplan lm 100": ("#44aa99", "-."),
    "roboplan levels": ("#999933", "-."),
    "roboplan levels lm": ("#661100", "-."),
}
#: Below this, errors are not told apart [mm]; panels of joint velocities side by side, at most.
LEAST, COLUMNS = 0.1, 5
_STYLE = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#808080",
    "axes.grid": True,
    "grid.color": "#e6e6e6",
}


def draw(path: Path, stream: Stream, runs: Sequence[Run], tracking: Mapping[str, Tracking]) -> None:
    """Draw a scene: above, the excess of the position error; below, the joint that jerks most, a panel a run."""
    t, joint = stream.scene.dt * np.arange(len(stream)), _restless(runs)
    columns = min(COLUMNS, len(runs))
    rows = -(-len(runs) // columns)
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(9.5, 2.4 + 0.95 * rows), layout="constrained")
        grid = figure.add_gridspec(1 + rows, columns, height_ratios=[2.2, *[1.0] * rows])
        above = figure.add_subplot(grid[0, :])
        above.set_title(f"{stream.scene.name}: hand off by more than it has to be [mm]")
        above.set_yscale("log")
        panels: list = []
        for number, run in enumerate(runs):
            colour, line = STYLES[run.name]
            above.plot(t, np.maximum(1e3 * tracking[run.name].excess, LEAST), color=colour, ls=line, lw=1.1)
            share = panels[0] if panels else None
            panel = figure.add_subplot(grid[1 + number // columns, number % columns], sharex=share, sharey=share)
            panel.plot(t, run.v[:, joint], color=colour, lw=0.5, rasterized=True)
            panel.set_title(run.name, color=colour, fontweight="bold", pad=2.0)
            last = number + columns >= len(runs)
            panel.tick_params(labelbottom=last, labelleft=number % columns == 0)
            panels.append(panel)
        above.set_xlim(t[0], t[-1])
        panels[0].set_xlim(t[0], t[-1])
        figure.supxlabel("t [s]", fontsize="medium")
        panels[0].set_ylabel(f"{stream.robot.joint_names[joint].removeprefix('panda_')} [rad/s]")
        figure.savefig(path, dpi=110, metadata={"Software": None}, pil_kwargs={"optimize": True})


def _restless(runs: Sequence[Run]) -> int:
    """The joint whose velocity jumps most, in all runs together."""
    return int(np.argmax(sum(np.square(np.diff(run.v, n=2, axis=0)).sum(axis=0) for run in runs)))
