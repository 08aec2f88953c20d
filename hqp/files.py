"""Arrays in a file: numpy's .npz without pickle, written whole or not at all, read whole or refused with a reason."""

from __future__ import annotations

import os
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from .errors import InvalidInput

#: What numpy and zipfile say of a file that is another's or damaged, and what its reader says of the contents.
_DAMAGED = (
    zipfile.BadZipFile, zlib.error, EOFError, LookupError, MemoryError, RuntimeError, TypeError, ValueError,
)  # fmt: skip


def write_arrays(path: str | os.PathLike[str], arrays: Mapping[str, NDArray[Any]], *, compressed: bool = False) -> None:
    """Write arrays to a file, which appears whole or not at all. The same arrays make the same bytes.

    Raises
    ------
    InvalidInput
        If the file cannot be written.
    """
    file = _as_path(path)
    method = zipfile.ZIP_DEFLATED if compressed else zipfile.ZIP_STORED
    try:
        with _whole_or_nothing(file) as part, zipfile.ZipFile(part, "w", method) as archive:
            for name, array in arrays.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as stream:
                    np.lib.format.write_array(stream, array, allow_pickle=False)
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        raise InvalidInput(f"cannot write {str(file)!r}: {getattr(error, 'strerror', None) or error}") from None


@contextmanager
def arrays_of(path: str | os.PathLike[str], what: str) -> Iterator[dict[str, NDArray[Any]]]:
    """The arrays of a file, read-only, by name; whatever is found wrong with them inside the block is the file's fault.

    Parameters
    ----------
    path : str or path
    what : str
        What the file should be, as in ``record``.

    Raises
    ------
    InvalidInput
        If the file cannot be read, or is not what it should be.
    """
    file = _as_path(path)
    try:
        with zipfile.ZipFile(file) as archive:
            members = dict(_members(archive))
        yield members
    except OSError as error:
        raise InvalidInput(f"cannot read {str(file)!r}: {error.strerror or error}") from None
    except _DAMAGED as error:
        raise InvalidInput(f"{str(file)!r} is no {what}, or damaged: {error}") from None


def _as_path(path: str | os.PathLike[str]) -> Path:
    if not (isinstance(path, str | os.PathLike) and Path(path).name):
        raise InvalidInput(f"path = {path!r} must be the name of a file")
    try:
        file = Path(os.path.realpath(path))  # a link stays a link: what it leads to is meant
    except ValueError as error:  # a name that no file can have
        raise InvalidInput(f"cannot write or read {str(path)!r}: {error}") from None
    if file.exists() and not (file.is_file() or file.is_dir()):
        raise InvalidInput(f"path = {str(path)!r} is a device; it must be a file")
    return file


@contextmanager
def _whole_or_nothing(file: Path) -> Iterator[Path]:
    """A place beside `file` to write to; what stands there in the end takes the place of `file` in one stroke."""
    part = file.with_name(f".{file.name}.{uuid4().hex}")
    try:
        yield part
        os.replace(part, file)
    finally:
        part.unlink(missing_ok=True)


def _members(archive: zipfile.ZipFile) -> Iterator[tuple[str, NDArray[Any]]]:
    for name in archive.namelist():
        with archive.open(name) as stream:
            array = np.lib.format.read_array(stream, allow_pickle=False)
        array.flags.writeable = False
        yield name.removesuffix(".npy"), array
