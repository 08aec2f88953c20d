"""Which parts of stacks Python writes: of all that are made while somebody looks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from unittest import mock

from tasks.rows.hierarchy_writer import HierarchyWriter


@contextmanager
def reasons() -> Iterator[set[str]]:
    """Why Python writes parts of the stacks that are made meanwhile: none, where loops write all."""
    found, begin = set[str](), HierarchyWriter.__init__

    def watched(self: HierarchyWriter, *args: Any, **options: Any) -> None:
        begin(self, *args, **options)
        found.update(part.why for part in self.describe().in_python)

    with mock.patch.object(HierarchyWriter, "__init__", watched):
        yield found
