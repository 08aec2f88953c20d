"""The recorded ticks as files: one for each robot, and a table of the families."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from hqp import InvalidInput
from hqp.arrays import Array
from hqp.files.whole import arrays_of, write_arrays

FOLDER = Path(__file__).parent / "data"
#: Problems of each family: ticks that are kept of each motion, evenly spread over it.
DRAWS = 64
#: Of one motion: an array a quantity, of shape (DRAWS, 2, ...): at the tick before, and at the tick.
Ticks = dict[str, Array]


class Entry(NamedTuple):
    """A line of the table: a family.

    Attributes
    ----------
    group, name : str
    needs : str
        The package without which there are no problems.
    norm : float
        Of all finite numbers of all problems, by which a test tells whether they are still those that were recorded:
        rows, gains and postures are no data, but follow from states and targets by robot and stack.
    about : str
        What is in it.
    """

    group: str
    name: str
    needs: str
    norm: float
    about: str


def table(folder: Path = FOLDER) -> list[Entry]:
    """All families that were recorded.

    Raises
    ------
    InvalidInput
        If there is no such table.
    """
    try:
        with _table(folder).open(encoding="utf-8", newline="") as lines:
            return [Entry(**line | {"norm": float(line["norm"])}) for line in csv.DictReader(lines)]
    except OSError as error:
        raise InvalidInput(f"cannot read {str(_table(folder))!r}: {error.strerror}") from None


def write_table(entries: Iterable[Entry], folder: Path) -> None:
    """The table of these families."""
    with _table(folder).open("w", encoding="utf-8", newline="") as lines:
        writer = csv.writer(lines, lineterminator="\n")
        writer.writerows([Entry._fields, *entries])


@cache
def ticks(file: str, name: str, folder: Path = FOLDER) -> Ticks:
    """The recorded ticks of one motion.

    Raises
    ------
    InvalidInput
        If there is no such file, or it has no such motion.
    """
    path = folder / f"{file}.npz"
    with arrays_of(path, "recorded motion") as arrays:
        found = {key.removeprefix(f"{name}/"): array for key, array in arrays.items() if key.startswith(f"{name}/")}
    if not found:
        raise InvalidInput(f"{str(path)!r} has no motion {name!r}; record it: python -m benchmarks.motions")
    return found


def write_ticks(file: str, motions: Mapping[str, Ticks], folder: Path) -> None:
    """The ticks of all motions of one file."""
    arrays: dict[str, Any] = {f"{name}/{key}": array for name, own in motions.items() for key, array in own.items()}
    write_arrays(folder / f"{file}.npz", arrays, compressed=True)


def _table(folder: Path) -> Path:
    return folder / "families.csv"
