"""The joint axes of a Pinocchio model, one a velocity: name, unit, and which number of q is the position."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import pinocchio as pin

#: Units of the velocities of joints whose type name does not show them, linear before angular.
UNITS = {
    "FreeFlyer": "m m m rad rad rad",
    "Planar": "m m rad",
    "Translation": "m m m",
    "Spherical": "rad rad rad",
    "SphericalZYX": "rad rad rad",
    "Ellipsoid": "rad rad rad",
    "Universal": "rad rad",
}
#: Joints whose velocities are not the rates of as many numbers of q.
MANIFOLDS = ("FreeFlyer", "Planar", "Spherical")
#: Those of them that are a free base if they come first.
BASES = ("FreeFlyer", "Planar")
#: Index that means: no number of q.
NONE = -1


class JointAxis(NamedTuple):
    """One axis of a joint: one velocity of the model is the rotation about it, or the translation along it.

    Attributes
    ----------
    name : str
        That of the joint; of a joint with several velocities ``"name[i]"``.
    joint : str
        The name of the joint itself.
    unit : {"rad", "m"}
        Of its position.
    q_index : int
        Index in q of its position, so that ``q[q_index]`` changes at this velocity; -1 if there is none.
    circle : int
        Index in q of the cosine of its angle, the sine is the next number; -1 if there is none.
    """

    name: str
    joint: str
    unit: str
    q_index: int
    circle: int


def kind(joint: Any) -> str:
    """What a joint of a model is: ``"RX"``, ``"PrismaticUnaligned"``, ``"FreeFlyer"``, ``"Composite"``, ..."""
    return str(joint.shortname()).removeprefix("JointModel")


def joint_axes(model: pin.Model) -> tuple[JointAxis, ...]:
    """All joint axes of a model, in the order of its velocities; a joint that follows another one has none."""
    found = []
    for joint, name in zip(list(model.joints)[1:], list(model.names)[1:], strict=True):  # the first is the universe
        own = list(_axes_of(joint))
        several = len(own) > 1
        found += [JointAxis(f"{name}[{i}]" if several else name, name, *axis) for i, axis in enumerate(own)]
    return tuple(found)


def unit_parts(model: pin.Model) -> list[tuple[str, int, int]]:
    """The numbers of q that must have norm 1: circles (cosine, sine) and quaternions; joint, first number, count."""
    found = []
    for joint, name in zip(list(model.joints)[1:], list(model.names)[1:], strict=True):
        found += [(name, first, count) for first, count in _units(joint)]
    return found


def _parts(joint: Any) -> Iterable[Any]:
    """The joints that a composite one is made of."""
    composite = joint.extract() if isinstance(joint, pin.JointModel) else joint
    return list(composite.joints)


def _units(joint: Any) -> Iterator[tuple[int, int]]:
    what = kind(joint)
    if what == "Composite":
        for part in _parts(joint):
            yield from _units(part)
    elif what.startswith(("RUB", "RevoluteUnbounded")):
        yield joint.idx_q, 2
    elif what == "Planar":
        yield joint.idx_q + 2, 2
    elif what == "FreeFlyer":
        yield joint.idx_q + 3, 4
    elif what == "Spherical":
        yield joint.idx_q, 4


def base_of(model: pin.Model) -> tuple[int, int]:
    """Number of entries of q and number of velocities of a free base; 0, 0 if the base is fixed."""
    if model.njoints > 1 and kind(model.joints[1]) in BASES:
        return int(model.joints[1].nq), int(model.joints[1].nv)
    return 0, 0


def further_bases(model: pin.Model) -> tuple[list[str], list[int]]:
    """Joints, and their velocities, of bodies that are free besides the base: no motor moves them.

    These float, wherever they are, or stand in the plane of the world: a thing that is carried, or a second robot.
    """
    names, velocities = list[str](), list[int]()
    for i, joint in enumerate(list(model.joints)[2:], 2):
        if kind(joint) == "FreeFlyer" or (kind(joint) == "Planar" and not model.parents[i]):
            names.append(str(model.names[i]))
            velocities += range(joint.idx_v, joint.idx_v + joint.nv)
    return names, velocities


def _axes_of(joint: Any) -> Iterator[tuple[str, int, int]]:
    """Unit, index in q and circle of every velocity of a joint."""
    what = kind(joint)
    if what == "Mimic":
        return
    if what == "Composite":
        for part in _parts(joint):
            yield from _axes_of(part)
    elif what.startswith(("RUB", "RevoluteUnbounded")):
        yield "rad", NONE, joint.idx_q
    elif what in MANIFOLDS:
        for i, unit in enumerate(UNITS[what].split()):
            yield unit, NONE, joint.idx_q + 2 if what == "Planar" and i == 2 else NONE
    elif what in UNITS:
        for i, unit in enumerate(UNITS[what].split()):
            yield unit, joint.idx_q + i, NONE
    else:  # one axis that turns, slides or screws
        yield "m" if what.startswith("P") else "rad", joint.idx_q, NONE


def sequence(joint: Any) -> list[int] | None:
    """The order of the velocities within a joint; None if their axes have no order.

    The places increase if each axis carries the next, as in a universal joint; all are 0 if all axes are fixed to the
    moved body, as in a ball joint.
    """
    what = kind(joint)
    if what == "Composite":
        places: list[int] = []
        for part in _parts(joint):
            own = sequence(part)
            if own is None:
                return None
            places += [place + 1 + max(places, default=-1) for place in own]
        return places
    if what == "Ellipsoid":
        return None
    if what in MANIFOLDS:
        return [0] * int(joint.nv)
    return list(range(int(joint.nvExtended)))
