"""Recognises URDF and MJCF by the first element of a file, and calls the reader."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from hqp import InvalidInput, MissingPackage

from ..choices import Base
from .description import Description
from .urdf import read_urdf
from .xml import root_of

if TYPE_CHECKING:
    import mujoco

#: Suffixes of files that are read, or refused with a hint.
SUFFIXES = (".urdf", ".xml", ".mjcf", ".mjb", ".xacro", ".sdf", ".srdf", ".usd", ".usda", ".zip")
#: Longest part of a name that messages show.
LONGEST = 200
#: How many files of a folder are named.
MOST_NAMED = 8
#: What to say of other files.
OTHERS = {
    "mujocoinclude": "is a part that others include; name the file that includes it",
    "sdf": "is SDF, which is not read; give a URDF or an MJCF",
    "COLLADA": "is a mesh; give a URDF or an MJCF",
}


def looks_like_a_file(source: str | PathLike[str]) -> bool:
    """Whether this names a file, or is XML itself, and no robot of the library."""
    if not isinstance(source, str) or source.lstrip().startswith("<"):
        return True
    path = Path(source)
    return path.suffix.lower() in SUFFIXES or len(path.parts) > 1 or source.startswith("./")  # which Path leaves out


def check_file(source: str | PathLike[str]) -> Path:
    """The path of an existing file.

    Raises
    ------
    InvalidInput
        If it is XML text, a folder, or missing; the message says what to do.
    """
    text = str(source)
    if text.lstrip().startswith("<"):
        raise InvalidInput(
            f"robot = {text.lstrip()[:30]!r}... is XML, and no name of a file;"
            " write it to one: Path('robot.urdf').write_text(xml), and load_robot('robot.urdf')"
        )
    path = Path(source)
    if is_folder(source):
        inside = sorted(str(p.relative_to(path)) for p in path.rglob("*") if p.suffix.lower() in (".urdf", ".xml"))
        told = ", ".join(map(repr, inside[:MOST_NAMED])) or "it has no .urdf and no .xml"
        raise InvalidInput(f"robot {text!r} is a folder; name a file in it: {told}")
    try:
        there = path.is_file()
    except (OSError, ValueError):  # not a possible file name
        there = False
    if not there:
        raise InvalidInput(f"there is no file {text[:LONGEST]!r}")
    return path


def is_folder(source: str | PathLike[str]) -> bool:
    """Whether there is a folder of this name."""
    try:
        return Path(source).is_dir()
    except (OSError, ValueError):
        return False


def describe(source: Path | mujoco.MjModel, base: Base | None, bodies: Iterable[str] | None, what: str) -> Description:
    """The robot of a file, or of a model compiled by MuJoCo.

    Raises
    ------
    InvalidInput
        If it cannot be read exactly; the message names the element and the reason.
    MissingPackage
        If it is MJCF, and MuJoCo is not installed.
    """
    if isinstance(source, Path) and source.suffix.lower() != ".mjb":
        tag = root_of(source, what)
        if tag == "robot":
            if bodies is not None:
                raise InvalidInput(f"{what}: body = {bodies!r}, but a URDF has one robot; it must be None")
            return read_urdf(source, base, what)
        if tag != "mujoco":
            unknown = f"begins with <{tag}>" if tag else "has no XML element"
            raise InvalidInput(f"{what} {OTHERS.get(tag, f'{unknown}; URDF begins with <robot>, MJCF with <mujoco>')}")
    try:
        from .mjcf import read_mjcf
    except ModuleNotFoundError as error:
        if error.name != "mujoco":
            raise
        raise MissingPackage(f"{what} is MJCF, which MuJoCo reads: pip install 'hqp[mujoco]'") from None
    return read_mjcf(source, base, bodies, what)
