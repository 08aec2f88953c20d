"""Robots from URDF, read by Pinocchio; what it passes over in silence is refused here."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from .._checks import LARGEST
from .._quiet import caught
from .choices import Base
from .description import BASES, Description
from .frame_names import KINDS
from .ties import Tie

#: The numbers of a tie, and what they are where the file does not say.
MIMIC = (("multiplier", "1"), ("offset", "0"))
#: Of XML: comments, the first element, and an ampersand that begins no entity.
COMMENT, FIRST = re.compile(r"<!--.*?-->", re.DOTALL), re.compile(r"<\s*([A-Za-z_][\w.:-]*)")
AMPERSAND = re.compile(r"&(?!(?:\w+|#\w+);)")


def read_urdf(path: Path, base: Base | None, what: str) -> Description:
    """The robot of a URDF, mounted unless another base is asked for.

    Raises
    ------
    InvalidInput
        If it cannot be read; tells why.
    """
    root = parsed(path, what)
    if any(element.tag.startswith("{http://www.ros.org/wiki/xacro}") for element in root.iter()):
        raise InvalidInput(f"{what} is to be expanded by xacro first: xacro {path.name} > {stem(path)}.urdf")
    joints = root.findall("joint")
    ties = list(_ties(joints, what))
    _check_axes(joints, what)
    _open(joints, {name for tie in ties for name in (tie.follower, tie.leader)})
    shared = _shared(root, joints)
    arguments = [ElementTree.tostring(root, encoding="unicode")]
    if base in BASES:
        arguments.append(BASES[base]())
    try:
        with caught() as lines:
            model = pin.buildModelFromXML(*arguments)
    except (ValueError, RuntimeError) as error:
        raise InvalidInput(f"{what} is no valid URDF: {reason(lines, error)}") from None
    _rename(model, shared)
    fixed = tuple(str(joint.get("name")) for joint in joints if joint.get("type") == "fixed")
    fixed = tuple(shared.get(name, name) for name in fixed)
    return Description(model, np.array(pin.neutral(model)), ties, fixed)


def parsed(path: Path, what: str) -> Element:
    """The root element of an XML file, which may break those rules that readers of URDF do not insist on.

    Raises
    ------
    InvalidInput
        If it cannot be opened, or is no XML; tells the line.
    """
    text = COMMENT.sub(lambda comment: "\n" * comment.group().count("\n"), text_of(path, what))
    try:
        return ElementTree.fromstring(AMPERSAND.sub("&amp;", text.strip()))
    except ElementTree.ParseError as error:
        raise InvalidInput(f"{what} is no valid XML: {error}") from None


def root_of(path: Path, what: str) -> str:
    """The name of the first element of an XML file; empty if there is none.

    Raises
    ------
    InvalidInput
        If the file cannot be read.
    """
    first = FIRST.search(COMMENT.sub("", text_of(path, what)))
    return first.group(1) if first else ""


def text_of(path: Path, what: str) -> str:
    """What is written in a file.

    Raises
    ------
    InvalidInput
        If it cannot be read.
    """
    try:
        return path.read_bytes().decode("utf-8-sig", errors="replace")
    except OSError as error:
        raise InvalidInput(f"{what} cannot be read: {error.strerror or error}") from None


def reason(lines: list[str], error: Exception) -> str:
    """The first line that a library printed of why it failed, or else the first of its exception, without its place."""
    told = [line.strip().removeprefix("Error:").strip() for line in lines if line.lstrip().startswith("Error")]
    return next(iter(told or str(error).strip().splitlines()), type(error).__name__)


def stem(path: Path) -> str:
    return path.name.split(".")[0]


def _ties(joints: list[Element], what: str) -> Iterator[Tie]:
    for joint in joints:
        mimic = joint.find("mimic")
        if mimic is not None:
            name = joint.get("name", "")
            factor, offset = (
                _number(mimic, key, default, f"{what}: mimic of joint {name!r}") for key, default in MIMIC
            )
            yield Tie(name, mimic.get("joint", ""), factor, offset)


def _number(element: Element, key: str, default: str, what: str) -> float:
    text = element.get(key, default)
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not abs(value) <= LARGEST:
        raise InvalidInput(f"{what}: {key} = {text!r} must be a finite number")
    return value


def _shared(root: Element, joints: list[Element]) -> dict[str, str]:
    """Rename joints that share their name with a link, which Pinocchio would confuse: the new names, and the old."""
    links, renamed = {link.get("name") for link in root.findall("link")}, {}
    for joint in joints:
        name = joint.get("name", "")
        if name in links:
            joint.set("name", f"joint:{name}")
            renamed[f"joint:{name}"] = name
    return renamed


def _rename(model: pin.Model, names: dict[str, str]) -> None:
    """Give joints, and their frames, these names in the place of their own."""
    for i, name in enumerate(model.names):
        model.names[i] = names.get(name, name)
    for frame in model.frames:
        if frame.type in KINDS["joint"]:
            frame.name = names.get(frame.name, frame.name)


def _check_axes(joints: list[Element], what: str) -> None:
    """Refuse axes that Pinocchio does not take: those of length zero, and of planar joints any other than z."""
    for joint in joints:
        axis, name, kind = joint.find("axis"), joint.get("name"), joint.get("type")
        if axis is None or kind in ("fixed", "floating"):
            if axis is None and kind == "planar":
                raise InvalidInput(f"{what}: planar joint {name!r} has no axis; it must be 0 0 1")
            continue
        try:
            own = np.array([float(number) for number in axis.get("xyz", "").split()])
        except ValueError:
            continue  # urdfdom says what is wrong with it
        if not own.any():
            raise InvalidInput(f"{what}: the axis of joint {name!r} is {axis.get('xyz')}; it must have a direction")
        if kind == "planar" and (own.shape != (3,) or own[0] or own[1] or own[2] < 0.0):
            raise InvalidInput(
                f"{what}: the axis of planar joint {name!r} is {axis.get('xyz')}; only 0 0 1 is read, turn its origin"
            )


def _open(joints: list[Element], tied: set[str | None]) -> None:
    """Give tied joints that turn without end one number, an angle, from which that of the other can be counted."""
    for joint in joints:
        if joint.get("name") in tied and joint.get("type") == "continuous":
            joint.set("type", "revolute")
            limit = joint.find("limit")
            if limit is None:
                limit = ElementTree.SubElement(joint, "limit", velocity="0", effort="0")
            limit.set("lower", f"{-10 * LARGEST:g}")
            limit.set("upper", f"{10 * LARGEST:g}")
