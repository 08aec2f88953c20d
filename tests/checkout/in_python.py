"""Which parts of stacks Python writes: of all that are made while somebody looks.

Run as a program, ``in_python.py FILE SCRIPT ...``, it runs a script and writes the reasons into a file, line by line.
"""

from __future__ import annotations

import runpy
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

from tasks.rows.hierarchy_writer import HierarchyWriter


@contextmanager
def reasons() -> Iterator[set[str]]:
    """Why Python writes parts of the stacks that are made meanwhile: none, where loops write all."""
    found, begin = set[str](), HierarchyWriter.__init__

    def watched(self: HierarchyWriter, *args: Any) -> None:
        begin(self, *args)
        found.update(part.why for part in self.describe().in_python)

    with mock.patch.object(HierarchyWriter, "__init__", watched):
        yield found


if __name__ == "__main__":
    out, *sys.argv = sys.argv[1:]
    sys.path[0] = str(Path(sys.argv[0]).parent)  # where it would look if it ran alone
    with reasons() as told:
        runpy.run_path(sys.argv[0], run_name="__main__")
    Path(out).write_text("\n".join(sorted(told)), encoding="utf-8")
