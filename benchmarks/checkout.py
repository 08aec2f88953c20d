"""Runs the present benchmarks on another checkout of the library."""

from __future__ import annotations

import os
from pathlib import Path

HERE = Path(__file__).parents[1]


def front(folder: Path, tree: Path) -> dict[str, str]:
    """The environment of a process that imports these benchmarks and the library of a checkout, by links."""
    folder.mkdir(exist_ok=True)
    for package, source in (("hqp", tree), ("tasks", tree), ("benchmarks", HERE)):
        if not (folder / package).exists():
            (folder / package).symlink_to(source.absolute() / package)
    return os.environ | {"PYTHONPATH": str(folder)}
