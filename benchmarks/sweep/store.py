"""A run on disk: a folder with the plan and, as they come, one Parquet file a cell.

A file appears whole or not at all, so that an interrupted run goes on where it was and no finished cell is measured
again. Every file tells the machine and the versions that made it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from uuid import uuid4

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from hqp import InvalidInput

from ..families import FAMILIES
from ..methods import METHODS
from ..settings import SETTINGS
from .cell import Row
from .machine import commit, sources
from .plan import Cell, Plan
from .schema import COLUMNS, KEYS, SCHEMA

_HEAD, _CELLS, _FAILED = "run.json", "cells", "failed"
_TOLD = b"measured by"


class Store:
    """One run.

    Attributes
    ----------
    folder : Path
    plan : Plan
    left_out : list of str
        What could not take part, and why.
    """

    def __init__(self, folder: Path, plan: Plan, left_out: Sequence[str]) -> None:
        self.folder, self.plan, self.left_out = folder, plan, list(left_out)

    @classmethod
    def begin(cls, folder: Path, plan: Plan, left_out: Sequence[str]) -> Store:
        """A new run in this folder, or the one that is there, to go on with it.

        Raises
        ------
        InvalidInput
            If the folder holds a run of another plan, or of other sources, whose cells would be mixed with ours, or
            cells of which nothing tells where they come from.
        """
        head = folder / _HEAD
        if not head.exists():
            if any((folder / _CELLS).glob("*.parquet")):
                raise InvalidInput(f"{str(folder)!r} holds cells, and no {_HEAD} tells of what; choose another folder")
            (folder / _CELLS).mkdir(parents=True, exist_ok=True)
            told = {
                "plan": asdict(plan),
                "plan digest": plan.digest,
                "sources digest": sources(),
                "commit": commit(),
                "left out": list(left_out),
                "begun": datetime.now(UTC).isoformat(timespec="seconds"),
            }
            _write(head, json.dumps(told, indent=1).encode())
        kept = _read(head)
        for what, name, mine in (("another", "plan", plan.digest), ("other", "sources", sources())):
            if kept.get(f"{name} digest") != mine:
                raise InvalidInput(f"{str(folder)!r} holds a run of {what} {name}; choose another folder")
        return cls(folder, plan, left_out)

    @classmethod
    def open(cls, folder: Path) -> Store:
        """The run in this folder.

        Raises
        ------
        InvalidInput
            If there is none, or one of families, methods or settings that are no more.
        """
        if not (folder / _HEAD).is_file():
            raise InvalidInput(f"{str(folder)!r} holds no run; 'python -m benchmarks run' makes one")
        kept = _read(folder / _HEAD)
        try:
            told = {key: tuple(value) if isinstance(value, list) else value for key, value in kept["plan"].items()}
            plan, left_out = Plan(**told), kept["left out"]
        except (AttributeError, KeyError, TypeError):
            raise InvalidInput(f"{str(folder / _HEAD)!r} tells of no plan that these benchmarks know") from None
        for named, known in ((plan.families, FAMILIES), (plan.methods, METHODS), (plan.settings, SETTINGS)):
            if gone := [name for name in named if name not in known]:
                raise InvalidInput(f"{str(folder)!r} was measured by other benchmarks: no {', '.join(gone)} is here")
        return cls(folder, plan, left_out)

    def path(self, cell: Cell) -> Path:
        """Where the rows of a cell are, or will be."""
        return self.folder / _CELLS / f"{cell.name}.parquet"

    def missing(self) -> list[Cell]:
        """The cells that are still to be measured."""
        return [cell for cell in self.plan.cells() if not self.path(cell).exists()]

    def add(self, cell: Cell, rows: Sequence[Row], machine: dict[str, str]) -> None:
        """Keep the rows of a cell."""
        table = pa.Table.from_pylist(list(rows), schema=SCHEMA.with_metadata({_TOLD: json.dumps(machine)}))
        path = self.path(cell)
        part = path.with_name(f".{path.name}.{uuid4().hex}")
        try:
            pq.write_table(table, part, compression="zstd")
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)
        self._failure(cell).unlink(missing_ok=True)

    def fail(self, cell: Cell, why: str) -> Path:
        """Keep why a cell could not be measured; it counts as missing."""
        path = self._failure(cell)
        path.parent.mkdir(exist_ok=True)
        _write(path, why.encode())
        return path

    def _failure(self, cell: Cell) -> Path:
        return self.folder / _FAILED / f"{cell.name}.txt"

    def table(self) -> pd.DataFrame:
        """All rows that there are, sorted by what names them; methods and settings in the order of the plan.

        Raises
        ------
        InvalidInput
            If there are none, or a file is damaged.
        """
        files = [path for cell in self.plan.cells() if (path := self.path(cell)).exists()]
        if not files:
            raise InvalidInput(f"{str(self.folder)!r} holds no finished cell yet")
        frame = pa.concat_tables([_table(path) for path in files]).to_pandas()
        for column, order in (
            ("family", self.plan.families),
            ("method", self.plan.methods),
            ("setting", self.plan.settings),
        ):
            frame[column] = pd.Categorical(frame[column], categories=list(order), ordered=True)
        return frame.sort_values(list(KEYS), ignore_index=True)[list(COLUMNS)]

    def machines(self) -> list[dict[str, str]]:
        """Every machine, with versions, that measured some of it."""
        told = {}
        for path in sorted((self.folder / _CELLS).glob("*.parquet")):
            text = (pq.read_schema(path).metadata or {}).get(_TOLD, b"{}")
            told[text] = json.loads(text)
        return list(told.values())


def place(plan: Plan) -> Path:
    """Where a run is kept where nobody says: plan and sources tell it from all others, so that none are mixed."""
    return Path("out", "benchmarks", f"{plan.name}-{plan.digest[:4]}-{sources()[:8]}")


def _table(path: Path) -> pa.Table:
    try:
        return pq.read_table(path, schema=SCHEMA)
    except (OSError, pa.ArrowException) as error:
        raise InvalidInput(f"{str(path)!r} is damaged; remove it, and run again: {error}") from None


def _read(path: Path) -> dict[str, Any]:
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, TypeError, ValueError) as error:
        raise InvalidInput(f"cannot read {str(path)!r}: {error}") from None


def _write(path: Path, data: bytes) -> None:
    part = path.with_name(f".{path.name}.{uuid4().hex}")
    part.write_bytes(data)
    os.replace(part, path)
