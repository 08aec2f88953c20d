"""The elements and attributes of URDF that are read; what else stands where they stand is refused, or told.

Readers of URDF pass over names that they do not know, so that a misspelt ``<orign>`` or ``lowr=`` leaves its default.
"""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path
from xml.etree.ElementTree import Element

from hqp import InvalidInput

#: The elements of a robot by parent element; those that may occur only once.
ELEMENTS = {
    "robot": ("link", "joint"),
    "joint": ("origin", "parent", "child", "axis", "limit", "mimic", "safety_controller"),
    "link": ("inertial", "collision"),
    "inertial": ("origin", "mass", "inertia"),
    "collision": ("origin", "geometry"),
}
ONCE = (*ELEMENTS["joint"], *ELEMENTS["inertial"], "inertial", "geometry")
#: Elements that are known to mean nothing to a controller, by parent element.
PASSED = {
    "joint": ("dynamics", "calibration"),
    "link": ("visual", "contact", "self_filter", "collision_checking", "kinematic", "gravity", "surface"),
}
#: The attributes of elements, all that make a robot what it is.
ATTRIBUTES = {
    "joint": ("name", "type", "dont_collapse"),
    "link": ("name", "type"),
    "origin": ("xyz", "rpy"),
    "parent": ("link",),
    "child": ("link",),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "velocity", "effort"),
    "mimic": ("joint", "multiplier", "offset"),
    "safety_controller": ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"),
    "mass": ("value",),
    "inertia": ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"),
}
#: Elements whose other attributes are told: they add to what is read, and change nothing of it.
OPEN = ("joint", "link", "limit", "parent", "child", "safety_controller")
#: Elements of an SRDF.
SRDF = ("group", "group_state", "disable_collisions")
#: Elements of other tools, which may contain their own joints and links.
FOREIGN = ("gazebo", "transmission", "ros2_control", "drake", "sensor")
#: How alike a misspelt name is to the one that is meant, as :mod:`difflib` has it.
ALIKE = 0.7


def check_elements(root: Element, path: Path, what: str) -> None:
    """Refuse unexpanded xacro, and elements of a robot that Pinocchio does not read in their place or form."""
    unexpanded = any("xacro" in str(element.tag).split("}")[0] for element in root.iter())
    if unexpanded or any("${" in value for element in root.iter() for value in element.attrib.values()):
        raise InvalidInput(f"{what} is to be expanded by xacro first: xacro {path.name} > {_expanded(path)}")
    if root.find("link") is None and any(root.find(tag) is not None for tag in SRDF):
        raise InvalidInput(f"{what} is an SRDF; load the URDF beside it, and robot.with_srdf({path.name!r})")
    for element in [root, *(own for child in root if child.tag in ELEMENTS["robot"] for own in child.iter())]:
        known = ELEMENTS.get(str(element.tag), ())
        for child in element:
            tag = str(child.tag)
            if tag not in known and tag.lower() in known:
                raise InvalidInput(f"{what}: <{tag}> in <{element.tag}> is not read; write <{tag.lower()}>")
            if tag in ONCE and len(element.findall(tag)) > 1:
                name = element.get("name")
                raise InvalidInput(f"{what}: <{element.tag} name={name!r}> has several <{tag}>; only one is read")
    for child in root:
        if child.tag not in ELEMENTS["robot"] and child.tag not in FOREIGN and not str(child.tag).startswith("{"):
            joint = next((own for own in child.iter("joint") if own.find("parent") is not None), None)
            link = next((own for own in child.iter("link") if len(own)), None)
            if joint is not None or link is not None:
                tag = "joint" if joint is not None else "link"
                raise InvalidInput(f"{what}: <{tag}> inside <{child.tag}> is not read; it must stand in <robot>")
    for joint in root.findall("joint"):
        if joint.get("name") == "universe":
            raise InvalidInput(f"{what}: joint 'universe' has the name of the world; it must have another")


def _expanded(path: Path) -> str:
    """A name for what xacro makes of a file; the shell empties the file that it writes to before xacro reads it."""
    stem = path.name.split(".")[0]
    return f"{stem}.urdf" if f"{stem}.urdf" != path.name else f"{stem}.expanded.urdf"


def what_is_unread(root: Element, what: str) -> list[str]:
    """Elements and attributes in joints and links that are not read, with where they stand.

    Raises
    ------
    InvalidInput
        If a name is that of an element or an attribute that is read, misspelt, or it places, turns, ties or weighs.
    """
    found: dict[str, list[str]] = {}
    for part in [own for own in root if own.tag in ELEMENTS["robot"]]:
        where = f"{part.tag} {part.get('name')!r}"
        for element in _read(part):
            for thing in (*_elements(element, where, what), *_attributes(element, root, where, what)):
                found.setdefault(thing, []).append(where)
    return [f"{thing} in {places[0]}{_and_more(len(places) - 1)}" for thing, places in found.items()]


def _and_more(count: int) -> str:
    return f" and {count} more" if count else ""


def _read(part: Element) -> list[Element]:
    """A joint or link, and all in it that is read but shapes."""
    return [part, *(own for child in part if child.tag in ELEMENTS["joint"] + ("inertial",) for own in child.iter())]


def _elements(element: Element, where: str, what: str) -> list[str]:
    tag = str(element.tag)
    known, passed = ELEMENTS.get(tag, ()), PASSED.get(tag, ())
    others = [str(child.tag) for child in element if child.tag not in known + passed]
    others = [name for name in others if name not in FOREIGN and not name.startswith("{")]
    for name in others:
        check_spelling(
            name, [own for own in known if element.find(own) is None], f"{what}: <{name}> of {where}", "<{}>"
        )
    return [f"<{name}>" for name in others]


def _attributes(element: Element, root: Element, where: str, what: str) -> list[str]:
    tag = str(element.tag)
    known = ATTRIBUTES.get(tag)
    if known is None:
        return []
    if tag == "origin" and root.get("version") == "1.2":
        known += ("quat_xyzw",)
    others = [name for name in element.attrib if name not in known and not name.startswith("{")]
    for name in others:
        told = f"{what}: {name!r} of <{tag}> of {where}"
        check_spelling(name, [own for own in known if own not in element.attrib], told, "{!r}")
        if tag not in OPEN:
            raise InvalidInput(f"{told} is not read; there may be {', '.join(map(repr, known))}")
    return [f"{name!r} of <{tag}>" for name in others]


def check_spelling(name: str, absent: list[str], told: str, form: str) -> None:
    """Refuse a name like one that is read, and absent, where it stands.

    Parameters
    ----------
    name : str
    absent : list of str
        Names that are read there.
    told : str
        The name and where it stands, for the message.
    form : str
        How a name is written in it, such as ``"<{}>"``.

    Raises
    ------
    InvalidInput
    """
    meant = get_close_matches(name.lower(), absent, 1, ALIKE)
    if meant:
        raise InvalidInput(f"{told} is not read; write {form.format(meant[0])}")
