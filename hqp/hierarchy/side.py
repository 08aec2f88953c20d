"""The side of a row: free between its bounds, at the lower one, at the upper one, or an equality."""

from __future__ import annotations

from enum import IntEnum


class Side(IntEnum):
    """On which of its bounds a row sits, or which it violates."""

    LOWER = -1
    INACTIVE = 0
    UPPER = 1
    EQUALITY = 2
