"""The picture of the singularity benchmark: joint speeds and task errors of every remedy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from .singular_scenes import Run

COLOURS = (
    "#bdbdbd", "#000000", "#0072b2", "#0072b2", "#56b4e9", "#009e73", "#e6c700", "#332288", "#d55e00", "#cc79a7",
    "#882255", "#882255",
)  # fmt: skip
#: Of a method whose joint speeds are limited.
LIMITED = "--"
#: Below these nothing is to be told apart: [rad/s], [mm], [deg].
LEAST = 1e-2, 1e-1, 1e-2


def draw(path: Path, runs: Mapping[str, Sequence[Run]]) -> None:
    """Draw a column for each scene: largest joint speed, error of the position, error of the orientation."""
    with mpl.rc_context({"font.size": 11, "axes.titlesize": 12, "axes.titlelocation": "left", "legend.frameon": False}):
        figure = Figure(figsize=(11.0, 8.0), layout="constrained")
        grid = figure.subplots(3, len(runs), sharex="col", sharey="row", squeeze=False)
        for column, (name, each) in zip(grid.T, runs.items(), strict=True):
            column[0].set_title(name)
            column[-1].set_xlabel("t [s]")
            for number, run in enumerate(each):
                t = run.record.t
                values = (
                    np.abs(run.record.v).max(axis=1),
                    1e3 * run.errors("position"),
                    np.degrees(run.errors("orientation")),
                )
                for axes, value, least in zip(column, values, LEAST, strict=True):
                    style = {"color": COLOURS[number], "ls": LIMITED if "limits" in run.method else "-", "lw": 1.1}
                    axes.semilogy(t, np.maximum(value, least), label=run.method, **style)
                    axes.grid(color="#e6e6e6")
                    axes.spines[["top", "right"]].set_visible(False)
        for axes, what in zip(
            grid[:, 0], ("fastest joint [rad/s]", "position error [mm]", "orientation error [deg]"), strict=True
        ):
            axes.set_ylabel(what)
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=-(-len(labels) // 2))
        figure.savefig(path, dpi=100, metadata={"Software": None}, pil_kwargs={"optimize": True})
