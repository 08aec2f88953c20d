"""One figure in the layout of the thesis: the arm along its path under one law, with a caption."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from ..simulation.record import Record
from .arms import draw_arm, legend, proportion, show, view
from .figures import ended
from .runs import Job
from .style import COLUMN, SIZE, caption, paper

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Beside the panel [inch]: numbers on its left, the legend above, the axis and the caption below it.
LEFT, RIGHT, ABOVE, BELOW, LINE = 0.5, 0.08, 0.4, 0.42, 0.15
#: Letters of a line of the caption; laws with long names take two lines.
LETTERS = 56


def draw_plain(job: Job, record: Record) -> Figure:
    """One run in one panel, 3.4 inch wide, all text of 8 pt.

    Parameters
    ----------
    job : Job
    record : Record

    Returns
    -------
    matplotlib.figure.Figure
        Its caption names figure, law, links and phi.
    """
    scenario = job.scenario
    piece = view(scenario, [record])
    text = fill(title(job, record), LETTERS)
    wide = COLUMN - LEFT - RIGHT
    high = wide * proportion(piece)
    below = BELOW + LINE * (1 + text.count("\n")) + 0.06
    height = ABOVE + high + below
    figure = paper(height)
    panel = figure.add_axes((LEFT / COLUMN, below / height, wide / COLUMN, high / height))
    draw_arm(panel, scenario, record, scale=0.6)
    show(panel, piece)
    panel.tick_params(labelsize=SIZE, length=2.5, pad=2.0)
    panel.set_xlabel("x [m]", fontsize=SIZE, labelpad=2.0)
    panel.set_ylabel("y [m]", fontsize=SIZE, labelpad=2.0)
    figure.legend(
        **legend(), loc="upper center", bbox_to_anchor=((LEFT + wide / 2) / COLUMN, 1.0), ncols=2,
        fontsize=SIZE, frameon=False, borderaxespad=0.15, borderpad=0.1, labelspacing=0.2,
    )  # fmt: skip
    caption(figure, text)
    return figure


def title(job: Job, record: Record) -> str:
    """``Figure 4.7: Eq. 4.8, links 0.7 0.7 0.3 m, φ = 0°``."""
    scenario = job.scenario
    parts = [job.law.title, "\N{NO-BREAK SPACE}".join(["links", *map(str, scenario.lengths), "m"])]
    if scenario.phi is not None:
        parts.append(f"φ = {np.degrees(scenario.phi):.0f}°")
    if record.stopped:
        parts.append(ended(record))
    return f"Figure {scenario.figure}: {', '.join(parts)}"
