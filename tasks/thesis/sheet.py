"""A sheet of panels, a column a run, laid out in inches: title and legend above, heads over the columns, a foot."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .style import DESIRED, GRID, MUTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Of a column, left and right of all, and between two of them [inch].
COLUMN, LEFT, RIGHT, BETWEEN = 3.5, 0.95, 0.2, 0.26
#: Below the last panel, for its time axis; and of a line of text [inch].
TIME, LINE = 0.5, 0.19
#: Of an entry of the legend [inch].
ENTRY = 1.5


@dataclass(frozen=True)
class Row:
    """A row of panels: the label at its left edge, its height, and the free space above it [inch]."""

    label: str
    height: float
    above: float = 0.14


@dataclass(frozen=True)
class Head:
    """The heading of a column: a name, numbers, and in red how the run ended, if early."""

    name: str
    lines: Sequence[str]
    ended: str = ""


def sheet(
    title: str, rows: Mapping[str, Row], heads: Sequence[Head], legend: Mapping[str, Any], foot: str = ""
) -> tuple[Figure, dict[str, NDArray[np.object_]]]:
    """A figure with a column a head, and its panels: name of the row -> one panel a column.

    Parameters
    ----------
    title, foot : str
        Broken into lines where the figure is narrow.
    rows : mapping of str to Row
        From top to bottom.
    heads : sequence of Head
    legend : mapping
        ``labels``, ``handles`` and ``handler_map`` of what all columns share.
    """
    from matplotlib.figure import Figure

    width = LEFT + RIGHT + len(heads) * COLUMN + (len(heads) - 1) * BETWEEN
    title, foot = _broken(title, 0.112, width), _broken(foot, 0.078, width)
    named_rows = ceil(len(legend["labels"]) * ENTRY / (width - 0.2))
    across = ceil(len(legend["labels"]) / named_rows)
    named = 0.12 + LINE * named_rows
    titled = 0.2 + 0.26 * (1 + title.count("\n"))
    lines = max(len(head.lines) + bool(head.ended) for head in heads)
    over = titled + named + 0.42 + LINE * lines
    below = TIME + (0.2 + LINE * (1 + foot.count("\n")) if foot else 0.06)
    height = over + below + sum(row.height + row.above for row in rows.values())

    figure = Figure(figsize=(width, height))
    figure.text(0.5, 1 - 0.14 / height, title, ha="center", va="top", fontsize=14, fontweight="bold")
    figure.legend(
        **legend, loc="upper center", bbox_to_anchor=(0.5, 1 - titled / height), ncols=across, fontsize=9.5,
        frameon=False, borderaxespad=0.0, columnspacing=1.6,
    )  # fmt: skip
    if foot:
        figure.text(0.5, 0.12 / height, foot, ha="center", va="bottom", fontsize=9, color=MUTED)
    panels: dict[str, NDArray[np.object_]] = {}
    top = height - over
    for name, row in rows.items():
        top -= row.above
        panels[name] = np.empty(len(heads), dtype=object)
        for k in range(len(heads)):
            place = (LEFT + k * (COLUMN + BETWEEN)) / width, (top - row.height) / height
            panel = figure.add_axes((*place, COLUMN / width, row.height / height))
            panel.yaxis.set_visible(k == 0)
            panels[name][k] = panel
        _label(panels[name][0], row.label)
        top -= row.height
    for panel, head in zip(next(iter(panels.values())), heads, strict=True):
        _head(panel, head, lines)
    return figure, panels


def rule(figure: Figure) -> None:
    """The grid of panels that share the numbers of another one: their own axes are not visible.

    Lines in one piece: an axis would make five artists of every tick, which take longer than all that is drawn.
    """
    from matplotlib import rcParams
    from matplotlib.collections import LineCollection

    look = {"colors": rcParams["grid.color"], "linewidths": rcParams["grid.linewidth"], "alpha": GRID, "zorder": 1.5}
    for panel in figure.axes:
        for axis, across in (panel.xaxis, panel.get_xaxis_transform()), (panel.yaxis, panel.get_yaxis_transform()):
            if not axis.get_visible():
                upright = axis is panel.xaxis
                ends = [
                    [(at, 0.0), (at, 1.0)] if upright else [(0.0, at), (1.0, at)] for at in axis.get_majorticklocs()
                ]
                panel.add_collection(LineCollection(ends, transform=across, **look), autolim=False)


def same_range(panels: Iterable[Axes], low: float | None = None, high: float | None = None) -> None:
    """One scale for all panels of a row: the given ends, or what all of them need."""
    row = list(panels)
    ends = np.array([panel.get_ylim() for panel in row])
    for panel in row:
        panel.set_ylim(ends[:, 0].min() if low is None else low, ends[:, 1].max() if high is None else high)


def _label(panel: Axes, text: str) -> None:
    """At the left edge, in line with those of the other rows however wide their numbers are."""
    panel.set_ylabel(text)
    panel.yaxis.set_label_coords(-0.7 / COLUMN, 0.5)


def _head(panel: Axes, head: Head, lines: int) -> None:
    """Line by line above a panel, the names of all columns at the same height."""
    texts = [(line, MUTED) for line in head.lines] + [(head.ended, DESIRED)] * bool(head.ended)
    for k, (text, color) in enumerate(texts, start=1):
        _above(panel, text, 5 + 72 * LINE * (lines - k), color=color, fontsize=8.5)
    _above(panel, head.name, 8 + 72 * LINE * lines, fontsize=12, fontweight="bold")


def _above(panel: Axes, text: str, points: float, **look: Any) -> None:
    panel.annotate(text, (0.5, 1.0), (0, points), "axes fraction", "offset points", ha="center", **look)


def _broken(text: str, letter: float, width: float) -> str:
    """In lines of at most so many inches, a letter being about so wide."""
    return fill(text, max(20, int((width - 0.3) / letter)))
