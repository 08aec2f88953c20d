"""What files are called: the suffix of a name promises a format, which is kept or refused."""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path

from ..errors import InvalidInput, brief

#: What is written, and the suffixes that it may have; a name without a suffix promises nothing. Browsers and viewers
#: go by the suffix: pages and pictures have one.
ARRAYS, HIERARCHY = ("a file of arrays", (".npz", "")), ("a hierarchy as text", (".dat", ".txt", ".lexls", ""))
PAGE, PICTURE, TABLE = ("a page", (".html", ".htm")), ("a picture", (".png",)), ("a table", (".csv",))


def name_of(path: str | os.PathLike[str]) -> Path:
    """The path of a file, which has a name.

    Raises
    ------
    InvalidInput
        If it is no path, or names no file.
    """
    if not (isinstance(path, str | os.PathLike) and Path(path).name):
        raise InvalidInput(f"path = {brief(path)} must be the name of a file")
    return Path(path)


def misnamed(path: Path, what: str, suffixes: Collection[str]) -> str | None:
    """Why a file of this name cannot be `what`, or None if it can."""
    if path.suffix.lower() in suffixes:
        return None
    *first, last = filter(None, suffixes)
    named = f"{', '.join(first)} or {last}" if first else last
    return f"{what} is called {named}{', or has no suffix' if '' in suffixes else ''}"


def check_name(path: str | os.PathLike[str], what: str, suffixes: Collection[str]) -> None:
    """Refuse a name that promises another format, before anything is written.

    Raises
    ------
    InvalidInput
    """
    if why := misnamed(name_of(path), what, suffixes):
        raise InvalidInput(f"path = {str(path)!r}; {why}")
