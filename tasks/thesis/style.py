"""The common style of all pictures: colours, sizes and file formats."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DESIRED, ACTUAL, ARM, LAST, ELLIPSE, HELD = "#d62728", "#1f5fbf", "#23272e", "#d97706", "#009e73", "#009e73"
MUTED = "#6b7280"
#: Of the joints, distinguishable in every kind of colour vision (Okabe and Ito).
JOINTS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00")
#: Of a joint at a velocity limit, at an acceleration limit, at both.
AT_LIMIT = ("#ffffff", "#d55e00", "#56b4e9", "#2b2f36")
#: How strong the lines of a grid are.
GRID = 0.15
#: What the earliest pose is drawn in; the last one is in the colour itself.
EARLIEST = {ARM: "#dcdfe3", LAST: "#fce3ad"}

#: Of what goes into a paper: the width of a column, and of both [inch], and the size of its text [pt].
COLUMN, PAGE, SIZE = 3.4, 7.0, 8.0
FORMATS = ("png", "pdf", "svg")
#: Dots per inch of what a screen shows, and of what a paper prints.
SCREEN, PRINT = 110, 300
#: Letters stay letters, which can be searched and edited. The salt makes equal drawings equal files.
LETTERS: dict[Any, Any] = {"pdf.fonttype": 42, "svg.fonttype": "none", "svg.hashsalt": "hqp"}


def tones(color: str, count: int) -> Array:
    """So many colours, the later the darker, shape (count, 3)."""
    from matplotlib.colors import to_rgb

    first, last = np.array(to_rgb(EARLIEST[color])), np.array(to_rgb(color))
    return np.asarray(first + np.linspace(0.0, 1.0, count)[:, None] * (last - first))


def save(figure: Figure, file: Path, dpi: int = SCREEN) -> None:
    """Save a figure, whole or not at all; the suffix of the file tells the format."""
    from matplotlib import rc_context

    undated = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}.get(file.suffix)
    with rc_context(LETTERS):
        figure.savefig(part(file), dpi=dpi, metadata=undated)
    part(file).replace(file)


def part(file: Path) -> Path:
    """What a file is called while it is written; the suffix stays, for it tells the format."""
    return file.with_stem(f".{file.stem}-part")


def paper(height: float, width: float = COLUMN) -> Figure:
    """An empty figure of a paper [inch]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


def caption(figure: Figure, text: str) -> None:
    """One line, or few, at the foot of a figure of a paper."""
    height = figure.get_figheight()
    figure.text(0.5, 0.05 / height, text, ha="center", va="bottom", fontsize=SIZE, linespacing=1.25)


def write(axis: Axes, place: ArrayLike, text: str, color: str = "black", **look: Any) -> None:
    """Write a word into a figure, centred at a point."""
    x, y = np.asarray(place, dtype=float)
    centred: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": SIZE, "zorder": 8.0}
    axis.text(x, y, text, color=color, **centred | look)
