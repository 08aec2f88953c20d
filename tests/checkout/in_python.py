"""Which parts of stacks Python writes: of all that are made while somebody looks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from unittest import mock

from tasks.rows.rows import Rows


@contextmanager
def reasons() -> Iterator[set[str]]:
    """Why Python writes parts of the stacks that are made meanwhile: none, where loops write all."""
    found, begin = set[str](), Rows.__init__

    def watched(self: Rows, *args: Any) -> None:
        begin(self, *args)
        found.update(part.why for part in self.describe().in_python)

    with mock.patch.object(Rows, "__init__", watched):
        yield found
