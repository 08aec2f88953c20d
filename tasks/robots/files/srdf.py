"""Reads an SRDF: groups of joints, and named configurations of a robot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from hqp import InvalidInput
from hqp.checks import spelled_number

from ...base.checks import Array, suggestion
from .elements import check_spelling
from .xml import parsed

#: The elements that are read, by parent element; and others that an SRDF may have.
READ = {
    "robot": ("group", "group_state", "disable_collisions"),
    "group": ("joint", "link", "chain", "group"),
    "group_state": ("joint",),
}
OTHERS = (
    "passive_joint",
    "virtual_joint",
    "end_effector",
    "enable_collisions",
    "disable_default_collisions",
    "gripper",
)


@dataclass(frozen=True, eq=False)
class Semantics:
    """The contents of an SRDF.

    Attributes
    ----------
    groups : dict of str to list of str
        The joints of each group, in the order of the model.
    states : dict of str to dict of str to array
        The configurations by name: joint -> numbers of its position.
    unknown : list of str
        Joints, links and groups in the file that the robot does not have.
    """

    groups: Mapping[str, list[str]]
    states: Mapping[str, Mapping[str, Array]]
    unknown: list[str]


def read_srdf(path: Path, model: pin.Model, what: str) -> Semantics:
    """The groups and the configurations of an SRDF, for a model.

    Configurations of several groups with the same name are merged if they do not contradict each other; otherwise each
    is named ``"group/name"``.

    Raises
    ------
    InvalidInput
        If the file cannot be read or has neither, an element has no name, a group contains itself, a position is not
        a number, a state has two of a joint, or nothing that is named is the robot's.
    """
    root = parsed(path, what)
    _check_names(root, what)
    elements: dict[str, list[Element]] = {}
    for own in root.findall("group"):
        elements.setdefault(_text(own, "name", what), []).extend(own)
    reader = _Groups(elements, model, what)
    groups = {name: reader.joints(name) for name in elements}
    states: dict[str, dict[str, Array]] = {}
    found = [
        (_text(one, "name", what), one.get("group", ""), _positions(one, what)) for one in root.iter("group_state")
    ]
    for name in dict.fromkeys(name for name, _, _ in found):
        alike = [(group, positions) for other, group, positions in found if other == name]
        joined = {joint: q for _, positions in alike for joint, q in positions.items()}
        if all(np.array_equal(joined[joint], q) for _, positions in alike for joint, q in positions.items()):
            states[name] = {reader.told(joint): q for joint, q in joined.items()}
        else:
            for group, positions in alike:
                if f"{group}/{name}" in states:
                    raise InvalidInput(f"{what}: group {group!r} has two group_states {name!r} that are not alike")
                states[f"{group}/{name}"] = {reader.told(joint): q for joint, q in positions.items()}
    if not (groups or states):
        raise InvalidInput(f"{what} has no group and no group_state; it must be an SRDF that has one")
    if reader.unknown and not reader.known:
        raise InvalidInput(f"{what} names no joint and no link of the robot; it is of another one")
    for _, group, _ in found:
        if elements and group and group not in elements:
            reader.unknown.append(f"group {group}")
    return Semantics(groups, states, list(dict.fromkeys(reader.unknown)))


class _Groups:
    """The joints of groups; a group may list joints, links, chains and other groups."""

    def __init__(self, elements: Mapping[str, list[Element]], model: pin.Model, what: str) -> None:
        self._elements, self._model, self._what = elements, model, what
        self._order = list(model.names)[1:]
        self.unknown: list[str] = []
        self.known = False

    def joints(self, group: str, within: tuple[str, ...] = ()) -> list[str]:
        """The joints of a group that the model has, each once, in the order of the model."""
        if group in within:
            raise InvalidInput(f"{self._what}: group {group!r} is a part of itself")
        found: set[str] = set()
        for element in self._elements[group]:
            if element.tag == "joint":
                found.add(self.told(_text(element, "name", self._what)))
            elif element.tag == "link":
                found |= self._above(_text(element, "name", self._what))
            elif element.tag == "chain":
                ends = [_text(element, end, self._what) for end in ("base_link", "tip_link")]
                base, tip = (self._carriers(end) for end in ends)
                found |= {self._model.names[joint] for joint in tip ^ base}  # up to where both meet, and down
            elif element.tag == "group":
                name = _text(element, "name", self._what)
                if name not in self._elements:
                    told = suggestion(name, self._elements)
                    raise InvalidInput(f"{self._what}: group {group!r} holds {name!r}, which is no group{told}")
                found |= set(self.joints(name, (*within, group)))
        return [name for name in self._order if name in found]

    def told(self, joint: str) -> str:
        """The joint; noted as unknown if the model has it neither as a joint nor locked."""
        if joint not in self._order and not self._model.existFrame(joint, pin.FrameType.FIXED_JOINT):
            self.unknown.append(joint)
        else:
            self.known = True
        return joint

    def _above(self, link: str) -> set[str]:
        """The joint that moves a link; none where it is fixed to another."""
        frame = self._frame(link)
        if frame is None:
            return set()
        before = self._model.frames[frame.parentFrame]
        return {before.name} if before.type == pin.FrameType.JOINT else set()

    def _carriers(self, link: str) -> set[int]:
        """The numbers of all joints that move a link; none for a link not in the model, which is the world."""
        frame = self._frame(link)
        return set() if frame is None else set(list(self._model.supports[frame.parentJoint])[1:])

    def _frame(self, link: str) -> pin.Frame | None:
        number = self._model.getFrameId(link, pin.FrameType.BODY)
        if number < self._model.nframes:
            self.known = True
            return self._model.frames[number]
        self.unknown.append(link)
        return None


def _check_names(root: Element, what: str) -> None:
    """Refuse elements whose names are misspelt: they would be passed over."""
    for parent in [root, *root.findall("group"), *root.findall("group_state")]:
        read = READ.get(str(parent.tag), READ["robot"])
        where = f"{parent.tag} {parent.get('name')!r}"
        for child in parent:
            if child.tag not in (*read, *OTHERS):
                check_spelling(str(child.tag), list(read), f"{what}: <{child.tag}> of {where}", "<{}>")


def _positions(state: Element, what: str) -> dict[str, Array]:
    name, found = _text(state, "name", what), dict[str, Array]()
    for joint, value in _joints(state, what):
        numbers = np.array([spelled_number(word) for word in value.split()], dtype=np.float64)  # NaN for None
        if not (len(numbers) and np.isfinite(numbers).all()):
            raise InvalidInput(f"{what}: group_state {name!r} puts {joint!r} at {value!r}; it must be numbers")
        if joint in found and not np.array_equal(found[joint], numbers):
            raise InvalidInput(f"{what}: group_state {name!r} puts {joint!r} at two positions")
        found[joint] = numbers
    return found


def _joints(state: Element, what: str) -> Iterator[tuple[str, str]]:
    for joint in state.findall("joint"):
        yield _text(joint, "name", what), _text(joint, "value", what)


def _text(element: Element, attribute: str, what: str) -> str:
    text = element.get(attribute)
    if not text:
        raise InvalidInput(f"{what}: a {element.tag} has no {attribute}")
    return text
