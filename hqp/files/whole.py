"""Files: written whole or not at all, read whole or refused with a reason. Arrays are numpy's .npz without pickle."""

from __future__ import annotations

import math
import os
import zipfile
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any, BinaryIO
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidInput
from .names import ARRAYS, check_name, name_of

#: How a zip archive begins.
_ARCHIVE = b"PK\x03\x04"

#: So many bytes may come out of any file, and so many times what it holds: more is a small file that asks for a
#: large memory. What is written keeps to it.
MOST_UNPACKED, MOST_SHRUNK = 2**30, 100

#: Who reads what stands in front of an array.
_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}

#: What numpy and zipfile say of a file that is another's or damaged, and what its reader says of the contents.
_DAMAGED = (
    zipfile.BadZipFile, zlib.error, EOFError, LookupError, MemoryError, RuntimeError, TypeError, ValueError,
)  # fmt: skip


def write_arrays(path: str | os.PathLike[str], arrays: Mapping[str, NDArray[Any]], *, compressed: bool = False) -> None:
    """Write arrays to a file, which appears whole or not at all. The same arrays make the same bytes.

    Raises
    ------
    InvalidInput
        If the file has another suffix than .npz, or cannot be written.
    """
    check_name(path, *ARRAYS)
    small = sum(array.nbytes for array in arrays.values()) < MOST_UNPACKED // 2
    method = zipfile.ZIP_DEFLATED if compressed and small else zipfile.ZIP_STORED
    with _whole_or_nothing(path) as part, zipfile.ZipFile(part, "w", method) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as stream:
                np.lib.format.write_array(stream, array, allow_pickle=False)


def write_lines(path: str | os.PathLike[str], lines: Iterable[str], what: str, suffixes: Collection[str]) -> None:
    """Write lines of text to a file, which appears whole or not at all, the same on every system.

    Parameters
    ----------
    path : str or path
    lines : iterable of str
    what, suffixes : str, collection of str
        What the text is, as in "a page", and how a file of it may end.

    Raises
    ------
    InvalidInput
        If the name of the file ends otherwise, or it cannot be written.
    """
    check_name(path, what, suffixes)
    with _whole_or_nothing(path) as part, open(part, "w", encoding="utf-8", newline="\n") as stream:
        stream.writelines(f"{line}\n" for line in lines)


def writable(folder: Path, files: Iterable[str]) -> None:
    """Make the folder, and refuse it, or one of the files in it, now rather than after the work.

    Raises
    ------
    InvalidInput
        If the folder cannot be made, nothing can be written into it, or a file that is there cannot be overwritten.
    """
    place = f"to the folder {str(folder)!r}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            pass
        for path in filter(Path.exists, (folder / name for name in files)):
            place = repr(str(path))
            with path.open("ab"):
                pass
    except OSError as error:
        raise InvalidInput(f"cannot write {place}: {error.strerror or error}") from None


@contextmanager
def arrays_of(path: str | os.PathLike[str], what: str) -> Iterator[dict[str, NDArray[Any]]]:
    """The arrays of a file, read-only, by name; an error found inside the block names the file.

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
    with _blamed(path, what) as file:
        with zipfile.ZipFile(file) as archive:
            _check_size(archive, file.stat().st_size)
            members = dict(_members(archive))
        yield members


@contextmanager
def bytes_of(path: str | os.PathLike[str], what: str) -> Iterator[BinaryIO]:
    """The bytes of a file, as a stream to read; for the rest see :func:`arrays_of`."""
    with _blamed(path, what) as file, open(file, "rb") as stream:
        yield stream


def is_archive(path: str | os.PathLike[str]) -> bool:
    """Whether a file holds arrays, or should: it begins as an archive does, or it is called .npz.

    Raises
    ------
    InvalidInput
        If the file cannot be read.
    """
    with bytes_of(path, "file") as stream:
        return stream.read(len(_ARCHIVE)) == _ARCHIVE or name_of(path).suffix.lower() == ".npz"


@contextmanager
def _blamed(path: str | os.PathLike[str], what: str) -> Iterator[Path]:
    """The file to read; an error inside the block names the file."""
    file = _as_path(path)
    try:
        yield file
    except OSError as error:
        raise InvalidInput(f"cannot read {str(file)!r}: {error.strerror or error}") from None
    except _DAMAGED as error:
        why = f"it has no {error}" if isinstance(error, KeyError) else error
        raise InvalidInput(f"{str(file)!r} is no {what}, or damaged: {why}") from None


def _as_path(path: str | os.PathLike[str]) -> Path:
    name_of(path)
    try:
        file = Path(os.path.realpath(path))  # a link stays a link: what it leads to is meant
    except ValueError as error:  # a name that no file can have
        raise InvalidInput(f"cannot write or read {str(path)!r}: {error}") from None
    if file.exists() and not (file.is_file() or file.is_dir()):
        raise InvalidInput(f"path = {str(path)!r} is a device; it must be a file")
    return file


@contextmanager
def _whole_or_nothing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary file beside the file to write; at the end it replaces the file in one step."""
    file = _as_path(path)
    part = file.with_name(f".{file.name}.{uuid4().hex}")
    try:
        try:
            yield part
            os.replace(part, file)
        finally:
            part.unlink(missing_ok=True)
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        raise InvalidInput(f"cannot write {str(file)!r}: {getattr(error, 'strerror', None) or error}") from None


def _check_size(archive: zipfile.ZipFile, held: int) -> None:
    """Refuse, before anything is unpacked, what would fill a memory that the file does not account for."""
    declared, most = sum(member.file_size for member in archive.infolist()), max(MOST_UNPACKED, MOST_SHRUNK * held)
    if declared > most:
        raise ValueError(f"its {held} bytes would unpack to {declared}; they may to {most}")


def _members(archive: zipfile.ZipFile) -> Iterator[tuple[str, NDArray[Any]]]:
    for member in archive.infolist():
        with archive.open(member) as stream:
            _check_header(stream, member)
        with archive.open(member) as stream:
            array = np.lib.format.read_array(stream, allow_pickle=False)
        array.flags.writeable = False
        yield member.filename.removesuffix(".npy"), array


def _check_header(stream: IO[bytes], member: zipfile.ZipInfo) -> None:
    """Refuse an array that says to be larger, or smaller, than what is there: numpy takes the memory first."""
    version = np.lib.format.read_magic(stream)
    if version not in _HEADERS:
        raise ValueError(f"its member {member.filename!r} has version {version} of the format of numpy's arrays")
    shape, _, dtype = _HEADERS[version](stream)
    size = math.prod(shape) * dtype.itemsize
    if size != member.file_size - stream.tell() and not dtype.hasobject:  # objects are refused by their reader
        raise ValueError(
            f"its member {member.filename!r} says to be {dtype} of shape {shape}, {size} bytes,"
            f" but holds {member.file_size - stream.tell()}"
        )
