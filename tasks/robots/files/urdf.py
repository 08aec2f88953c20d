"""Robots from URDF, read by Pinocchio; what Pinocchio ignores silently is refused here, or reported."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from hqp import InvalidInput
from hqp.checks import spelled_number

from ...base.checks import LARGEST
from ...base.quiet import caught, reason
from ...base.telling import tell
from ..choices import Base
from ..frame_names import KINDS
from ..ranges import open_ranges
from .description import BASE_JOINT, BASES, Description
from .elements import check_elements, what_is_unread
from .soft_ranges import ENDS, SAFETY, narrow_ranges
from .ties import Tie
from .xml import parsed, written

#: Types of joints that move along or about one axis.
MOVING = ("revolute", "continuous", "prismatic")
#: The numbers of a mimic element, and their defaults.
MIMIC = (("multiplier", "1"), ("offset", "0"))


def read_urdf(path: Path, base: Base | None, what: str) -> Description:
    """The robot of a URDF, on the base that is asked for; else on that of the file, or mounted.

    Raises
    ------
    InvalidInput
        If it cannot be read exactly; the message names the element and the reason.
    """
    root = parsed(path, what)
    check_elements(root, path, what)
    unread = what_is_unread(root, what)
    joints = root.findall("joint")
    added = base if _take_base(root, base) else None
    ties = list(_ties(joints, what))
    _check_axes(joints, what)
    _tell_of_zeros(joints, what)
    left_out = list(_left_out(joints))
    narrow_ranges(joints, _number, what)
    _open(joints, {name for tie in ties for name in (tie.follower, tie.leader)})
    shared = rename_shared(root)
    _drop_pictures(root)
    arguments = [written(root, what)]
    if added in BASES:
        taken = {joint.get("name") for joint in joints}
        arguments += [BASES[added](), next(name for name in _names(BASE_JOINT) if name not in taken)]
    try:
        with caught() as lines:
            model = pin.buildModelFromXML(*arguments)
    except (ValueError, RuntimeError) as error:
        raise InvalidInput(f"{what} is no valid URDF: {reason(lines, error)}") from None
    _check_said(lines, what)
    _check_whole(root, model, what)
    rename(model, shared)
    model.lowerVelocityLimit[:], model.lowerEffortLimit[:] = -model.velocityLimit, -model.effortLimit
    open_ranges(model, what)
    fixed = tuple(str(joint.get("name")) for joint in joints if joint.get("type") == "fixed")
    names = tuple(shared.get(name, name) for name in fixed)
    return Description(model, np.array(pin.neutral(model)), ties, names, (*left_out, *unread))


def _take_base(root: Element, base: Base | None) -> bool:
    """Hold the joint that is the base of the file, if another base is asked for; whether one is still to be added.

    That joint is the only one that moves on what the root of the tree holds, and floats or is planar.
    """
    joints, held = root.findall("joint"), {link.get("name") for link in root.findall("link")}
    ends = {joint: (_named(joint, "parent"), _named(joint, "child")) for joint in joints}
    held -= {child for _, child in ends.values()}
    while (
        grown := {end for joint, (start, end) in ends.items() if joint.get("type") == "fixed" and start in held} - held
    ):
        held |= grown
    first = [joint for joint, (start, _) in ends.items() if start in held and joint.get("type") != "fixed"]
    own = first[0].get("type") if len(first) == 1 else None
    if own in BASES and base not in (None, own):
        first[0].set("type", "fixed")
    return own != base


def _named(joint: Element, tag: str) -> str | None:
    """The link that is the parent or the child of a joint."""
    found = joint.find(tag)
    return None if found is None else found.get("link")


def _left_out(joints: list[Element]) -> Iterator[str]:
    """Limits of joints that have no single position, and ranges of those that turn without end."""
    endless = []
    for joint in joints:
        kind, name, limit, soft = joint.get("type"), joint.get("name"), joint.find("limit"), joint.find(SAFETY)
        if kind in BASES and limit is not None:
            yield f"limits of {kind} joint {name!r}"
        ends = [(element, pair[place]) for place, element in enumerate((limit, soft)) for pair in ENDS]
        if kind == "continuous" and any(own is not None and not _is_zero(own.get(end, "0")) for own, end in ends):
            endless.append(repr(name))
    if endless:
        yield f"ranges of the continuous joints {', '.join(endless)} (a joint of type revolute has one)"


def rename_shared(root: Element) -> dict[str, str]:
    """Rename joints that share their name with a link, which Pinocchio would confuse; returns new name -> old name."""
    links, renamed = {link.get("name") for link in root.findall("link")}, {}
    taken = links | {joint.get("name") for joint in root.findall("joint")}
    for joint in root.findall("joint"):
        name = joint.get("name", "")
        if name in links:
            new = next(own for own in _names(f"joint:{name}") if own not in taken)
            joint.set("name", new)
            renamed[new] = name
    return renamed


def _drop_pictures(root: Element) -> None:
    """Remove colours and visual shapes, because errors in them do not matter to the robot."""
    for element in [root, *root.findall("link")]:
        for child in [own for own in element if own.tag in ("material", "visual")]:
            element.remove(child)


def rename(model: pin.Model, names: dict[str, str]) -> None:
    """Rename joints and their frames."""
    for i, name in enumerate(model.names):
        model.names[i] = names.get(name, name)
    for frame in model.frames:
        if frame.type in KINDS["joint"]:
            frame.name = names.get(frame.name, frame.name)


def _names(name: str) -> Iterator[str]:
    """This name, then variations of it."""
    while True:
        yield name
        name += "_"


def _check_said(lines: list[str], what: str) -> None:
    """Refuse a file with a mass that urdfdom could not read and left out; report its other messages."""
    errors = [line.strip().removeprefix("Error:").strip() for line in lines if line.lstrip().startswith("Error")]
    for line in errors:
        if any(word in line.lower() for word in ("inertia", "mass")):
            raise InvalidInput(f"{what} is no valid URDF: {line}")
    if errors:
        tell(f"{what}: {'; '.join(errors)}")


def _check_whole(root: Element, model: pin.Model, what: str) -> None:
    """Refuse a file with links or joints missing from the model because they are not connected to its first tree."""
    frames = {kind: {frame.name for frame in model.frames if frame.type in own} for kind, own in KINDS.items()}
    for tag, kind in ("link", "body"), ("joint", "joint"):
        for element in root.findall(tag):
            if element.get("name") not in frames[kind]:
                raise InvalidInput(
                    f"{what}: {tag} {element.get('name')!r} is no part of the tree that begins with"
                    f" {model.frames[1].name!r}; all must be in one tree"
                )


def _ties(joints: list[Element], what: str) -> Iterator[Tie]:
    for joint in joints:
        mimic = joint.find("mimic")
        if mimic is not None:
            name = joint.get("name", "")
            own = f"{what}: mimic of joint {name!r}"
            factor, offset = (_number(mimic, key, default, own) for key, default in MIMIC)
            yield Tie(name, mimic.get("joint", ""), factor, offset)


def _number(element: Element, key: str, default: str, what: str) -> float:
    text = element.get(key, default)
    value = spelled_number(text.strip())
    if value is None or not abs(value) <= LARGEST:
        raise InvalidInput(f"{what}: {key} = {text!r} must be a finite number")
    return value


def _check_axes(joints: list[Element], what: str) -> None:
    """Refuse axes that Pinocchio does not support: of length zero, or, for planar joints, other than z."""
    for joint in joints:
        axis, name, kind = joint.find("axis"), joint.get("name"), joint.get("type")
        if axis is None and kind == "planar":
            raise InvalidInput(f"{what}: planar joint {name!r} has no axis; it must be 0 0 1")
        if axis is None or kind in ("fixed", "floating"):
            continue
        own = np.array([spelled_number(word) for word in axis.get("xyz", "").split()], dtype=np.float64)
        if np.isnan(own).any():
            continue  # urdfdom reports the error
        if not own.any():
            raise InvalidInput(f"{what}: the axis of joint {name!r} is {axis.get('xyz')}; it must have a direction")
        if kind == "planar" and (own.shape != (3,) or own[0] or own[1] or own[2] < 0.0):
            raise InvalidInput(
                f"{what}: the axis of planar joint {name!r} is {axis.get('xyz')}; only 0 0 1 is read, turn its origin"
            )


def _tell_of_zeros(joints: list[Element], what: str) -> None:
    """Tell of largest speeds and efforts of 0, which count as unknown: a joint that never moves would be fixed."""
    for key, named in ("velocity", "speed"), ("effort", "effort"):
        limits = {str(joint.get("name")): joint.find("limit") for joint in joints if joint.get("type") in MOVING}
        found = [name for name, limit in limits.items() if limit is not None and _is_zero(limit.get(key, ""))]
        if found:
            tell(f"{what}: joints whose largest {named} is 0 are taken to have none: {', '.join(found)}")


def _is_zero(text: str) -> bool:
    return spelled_number(text.strip()) == 0.0  # urdfdom reports what is no number


def _open(joints: list[Element], tied: set[str | None]) -> None:
    """Give tied continuous joints one number, an angle, so that the tie can be a linear equation."""
    for joint in joints:
        if joint.get("name") in tied and joint.get("type") == "continuous":
            joint.set("type", "revolute")
            limit = joint.find("limit")
            if limit is None:
                limit = SubElement(joint, "limit", velocity="0", effort="0")
            limit.set("lower", f"{-10 * LARGEST:g}")
            limit.set("upper", f"{10 * LARGEST:g}")
