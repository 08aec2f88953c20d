"""Finished runs on disk, found again by their inputs, so that an interrupted report continues."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable
from dataclasses import fields
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import hqp

from .runs import CERTIFY, SPEED_CAP, Job

#: What of the thesis makes a motion; changes in the rest, and in the command, leave the runs as they are.
MOVING = ("thesis/laws.py", "thesis/runs.py", "thesis/scenarios.py")
#: Law, sources, job.
NAME = re.compile(r"[a-z-]+-([0-9a-f]{8})-[0-9a-f]{16}\.npz")
NUMERICS = ("numpy", "numba", "scipy", "qpsolvers", "proxsuite", "osqp", "daqp", "quadprog", "clarabel", "piqp")


class Store:
    """A folder of records, a file a job.

    The name of a file carries digests of everything that made it: our sources and the versions of the
    numerical packages, then scenario, law and backend. Records made by anything else are never found.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def path(self, job: Job) -> Path:
        """Where the record of this job is, or will be."""
        law = f"{job.law.key}-formula" if job.closed_form else job.law.key
        return self.folder / f"{law}-{sources(drawing=False)[:8]}-{self.key(job)[:16]}.npz"

    def key(self, job: Job) -> str:
        """The digest of everything that makes the record."""
        item = job.scenario
        compared = {field.name: getattr(item, field.name) for field in fields(item) if field.compare}
        made_by = (compared, job.law.key, job.backend, job.closed_form, CERTIFY, SPEED_CAP, sources(drawing=False))
        return _digest(*map(str, made_by))

    def __contains__(self, job: Job) -> bool:
        return self.path(job).exists()

    def forget_other_versions(self) -> None:
        """Remove the records made by other versions of the sources: they are never read again."""
        for path in self.folder.glob("*.npz"):
            name = NAME.fullmatch(path.name)
            if name and name[1] != sources(drawing=False)[:8]:
                path.unlink(missing_ok=True)


class Drawn:
    """The drawings of a folder that are up to date: a table of file names and digests of their contents."""

    def __init__(self, folder: Path, table: Path) -> None:
        self.folder, self.table = folder, table
        try:
            self.keys: dict[str, str] = dict(json.loads(table.read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError, RecursionError):
            self.keys = {}

    def has(self, name: str, key: str) -> bool:
        """Whether this file shows what this digest stands for."""
        return self.keys.get(name) == key and (self.folder / name).exists()

    def add(self, name: str, key: str) -> None:
        """Remember that it does."""
        self.keys[name] = key
        self._write()

    def forget(self, names: Iterable[str]) -> None:
        """Forget these files, which are about to be drawn, until they are complete."""
        for name in names:
            self.keys.pop(name, None)
        self._write()

    def _write(self) -> None:
        self.table.write_text(json.dumps(self.keys, indent=1), encoding="utf-8")

    def key(self, runs: Collection[str]) -> str:
        """The digest of a drawing of these runs."""
        return _digest(*runs, sources(), _version("matplotlib"))


@cache
def sources(*, drawing: bool = True) -> str:
    """Digest of our own sources, with or without those that only draw, and of the numerical packages' versions."""
    lines = [f"{name} {_version(name)}" for name in NUMERICS]
    for package in (Path(str(hqp.__file__)).parent, Path(__file__).parents[1]):
        root = package
        for path in sorted(root.rglob("*.py")):
            name = path.relative_to(root).as_posix()
            if drawing or not name.startswith(("thesis/", "cli/")) or name in MOVING:
                lines.append(f"{name} {_digest(path.read_text(encoding='utf-8'))}")
    return _digest(*lines)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"


def _digest(*texts: str) -> str:
    return sha256("\n".join(texts).encode()).hexdigest()
