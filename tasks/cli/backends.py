"""``hqp backends``."""

from __future__ import annotations


def backends() -> None:
    """Not written yet."""
