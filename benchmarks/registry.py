"""Registered objects: every module of a package that has a tuple of a given name adds its own to one table."""

from __future__ import annotations

import pkgutil
from collections.abc import Collection, Iterator, Mapping
from fnmatch import fnmatchcase
from importlib import import_module
from types import ModuleType
from typing import Any, TypeVar

from hqp import InvalidInput

T = TypeVar("T")


def registered(package: ModuleType, attribute: str) -> Iterator[Any]:
    """The contents of the tuples of this name in the modules of a package, in alphabetical order of the modules."""
    for module in sorted(pkgutil.iter_modules(package.__path__), key=lambda module: module.name):
        yield from getattr(import_module(f"{package.__name__}.{module.name}"), attribute, ())


def select(patterns: Collection[str] | None, among: Mapping[str, T], what: str) -> list[T]:
    """Those whose key one of the patterns matches (``motion/*``), in their own order; all if there is no pattern.

    Raises
    ------
    InvalidInput
        If a pattern matches none.
    """
    for pattern in patterns or ():
        if not any(fnmatchcase(key, pattern) for key in among):
            raise InvalidInput(f"unknown {what} {pattern!r}; there are {', '.join(among)}")
    return [
        item for key, item in among.items() if not patterns or any(fnmatchcase(key, pattern) for pattern in patterns)
    ]
