"""The problem: priority levels of rows with bounds, weights and labels, in a hierarchy."""

from .form import check_told
from .hierarchy import LARGEST, Hierarchy
from .label import Label, in_words, side_in_words
from .level import Level
from .nearest import nearest
from .side import Side

__all__ = [
    "LARGEST",
    "Hierarchy",
    "Label",
    "Level",
    "Side",
    "check_told",
    "in_words",
    "nearest",
    "side_in_words",
]
