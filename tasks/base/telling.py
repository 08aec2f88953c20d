"""Warnings that are logged once per process."""

from __future__ import annotations

import logging

LOG = logging.getLogger("hqp")
_TOLD: set[str] = set()


def tell(message: str) -> None:
    """Log a warning, unless this process has logged the same one before."""
    if message not in _TOLD:
        _TOLD.add(message)
        LOG.warning(message)
