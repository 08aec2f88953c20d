"""The rich console that tables are printed on."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console


def console(width: int = 80) -> Console:
    """The console of stdout: as wide as the terminal or COLUMNS says; `width` where neither does."""
    from rich.console import Console

    columns = os.environ.get("COLUMNS", "")
    told = sys.stdout.isatty() or (columns.isdecimal() and int(columns) > 0)
    return Console(width=None if told else width)
