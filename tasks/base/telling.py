"""Messages logged once: worth a word, and no error."""

from __future__ import annotations

import logging

LOG = logging.getLogger("hqp")
_TOLD: set[str] = set()


def tell(message: str) -> None:
    """Say it, unless it was said before in this process."""
    if message not in _TOLD:
        _TOLD.add(message)
        LOG.warning(message)
