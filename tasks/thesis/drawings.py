"""Drawings that need no simulation: mechanisms with the names that the simulations use."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .mechanisms import draw_three_links, draw_two_links
from .spaces import draw_manipulable, draw_mapping, draw_priority, draw_pseudoinverse, draw_redundant

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Drawing:
    """A figure of the thesis that shows a concept, not a motion.

    Attributes
    ----------
    figure : str
        Its number in the text.
    draw : callable
        Makes it.
    """

    figure: str
    draw: Callable[[], Figure]


#: Figure -> drawing, in the order of the text.
DRAWINGS = {
    drawing.figure: drawing
    for drawing in (
        Drawing("2.1", draw_two_links),
        Drawing("3.1", draw_manipulable),
        Drawing("3.2", draw_redundant),
        Drawing("3.3", draw_mapping),
        Drawing("3.4", draw_pseudoinverse),
        Drawing("3.5", draw_priority),
        Drawing("4.1", draw_three_links),
    )
}
