"""Objects of other libraries as parts of a stack: their tasks, barriers and limits, under strict priorities.

>>> from tasks.adapters import from_mink, from_pink  # doctest: +SKIP
"""

from __future__ import annotations

from .mink import from_mink
from .pink import from_pink

__all__ = ["from_mink", "from_pink"]
