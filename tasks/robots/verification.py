"""Checks of every loaded model, whatever its format: sizes, unique names, axes, ranges, inertias."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from ..base.telling import tell
from .frame_names import by_kind
from .joint_axes import joint_axes, kind

#: Tolerance for the length of an axis, and for a rotation matrix.
EXACT = 1e-9
#: How far numbers that files round to some digits may be off.
DIGITS = 1e-3


def verify(model: pin.Model, what: str) -> None:
    """Refuse a model without joints, or with an invalid size, name, axis, range or number.

    Raises
    ------
    InvalidInput
        The message names the first such element.
    """
    if model.nv == 0:
        raise InvalidInput(
            f"{what} has 0 degrees of freedom: no joint that moves; of a robot that flies, base='floating' gives six"
        )
    _verify_sizes(model, what)
    everything = {"joint": list(model.names), "axis": [axis.name for axis in joint_axes(model)], **_frames(model)}
    for place, names in everything.items():
        twice = [name for name, count in Counter(names).items() if count > 1]
        if twice:
            raise InvalidInput(
                f"{what}: {place} {twice[0]!r} is there {names.count(twice[0])} times; names must differ"
            )
    for index, name in enumerate(model.names):
        _verify_placed(model.jointPlacements[index], f"{what}: joint {name!r}")
        _verify_inertia(model.inertias[index], f"{what}: what joint {name!r} carries")
    for frame in model.frames:
        _verify_placed(frame.placement, f"{what}: frame {frame.name!r}")
    _verify_axes(model, what)
    _verify_limits(model, what)


def _verify_sizes(model: pin.Model, what: str) -> None:
    """Check the sizes of arrays that would otherwise be read beyond their end."""
    count = model.njoints
    lists = {"joints": model.joints, "names": model.names, "parents": model.parents, "inertias": model.inertias}
    for name, own in {**lists, "jointPlacements": model.jointPlacements}.items():
        if len(own) != count:
            raise InvalidInput(f"{what}: {name} has {len(own)} entries; there are {count} joints")
    for index in range(1, count):
        joint, name = model.joints[index], model.names[index]
        if not 0 <= model.parents[index] < index:
            raise InvalidInput(f"{what}: joint {name!r} has the parent {model.parents[index]}; it must come before it")
        if kind(joint) != "Mimic" and joint.nv == 0:
            raise InvalidInput(f"{what}: joint {name!r} is a {kind(joint)} of no joints; it must move something")
    for frame in model.frames:
        if not 0 <= frame.parentJoint < count:
            raise InvalidInput(f"{what}: frame {frame.name!r} has the parent joint {frame.parentJoint}, which is none")
    vectors = {
        "lowerPositionLimit": model.nq,
        "upperPositionLimit": model.nq,
        "lowerVelocityLimit": model.nv,
        "upperVelocityLimit": model.nv,
        "lowerEffortLimit": model.nv,
        "upperEffortLimit": model.nv,
        "armature": model.nv,
        "damping": model.nv,
    }
    for name, size in vectors.items():
        if len(getattr(model, name)) != size:
            raise InvalidInput(f"{what}: {name} has {len(getattr(model, name))} numbers; it must have {size}")
    for entry in model.referenceConfigurations:
        q = np.array(entry.data())
        if q.shape != (model.nq,) or not np.isfinite(q).all():
            raise InvalidInput(f"{what}: configuration {entry.key()!r} = {q}; it must have {model.nq} finite numbers")
    for name, numbers in ("gravity", model.gravity.vector), ("armature", model.armature):
        if not np.isfinite(numbers).all() or (name == "armature" and (numbers < 0.0).any()):
            raise InvalidInput(f"{what}: {name} = {np.array(numbers)}; it must be finite, and armature not negative")


def _frames(model: pin.Model) -> dict[str, list[str]]:
    return {f"the frame of a {kind}": [name for name, _ in frames] for kind, frames in by_kind(model).items()}


def _verify_placed(placement: pin.SE3, what: str) -> None:
    R, p = np.array(placement.rotation), np.array(placement.translation)
    if not (np.isfinite(p).all() and np.abs(R.T @ R - np.eye(3)).max() <= EXACT):
        raise InvalidInput(f"{what} is placed at {p.tolist()} with axes {R.tolist()}; the place must be finite")


def _verify_inertia(inertia: pin.Inertia, what: str) -> None:
    J = np.array(inertia.inertia)
    numbers = np.array([inertia.mass, *inertia.lever, *np.ravel(J)])
    if not np.isfinite(numbers).all() or inertia.mass < 0.0:
        raise InvalidInput(f"{what} has the mass {inertia.mass:g} kg; it must be finite and not negative")


def tell_of_inertias(model: pin.Model, what: str) -> None:
    """Warn of inertias that no body can have: kinematics stay right, but torques are wrong.

    Principal moments are integrals of y^2 + z^2, x^2 + z^2 and x^2 + y^2: not negative, and none above the sum of the
    other two.
    """
    wrong = []
    for inertia, name in list(zip(model.inertias, model.names, strict=True))[1:]:
        least, middle, most = np.linalg.eigvalsh(np.array(inertia.inertia))
        if least < -EXACT * (1.0 + most) or most > (1.0 + DIGITS) * (least + middle) + EXACT:
            wrong.append(name)
    if wrong:
        tell(f"{what}: no body has such an inertia, torques are not to be trusted, at the joints {', '.join(wrong)}")


def _verify_axes(model: pin.Model, what: str) -> None:
    q = pin.neutral(model)
    for joint, name in zip(list(model.joints)[1:], list(model.names)[1:], strict=True):
        for part, own in _single(joint, q):
            length = float(np.linalg.norm(own[3:] if own[3:].any() else own[:3]))
            if not abs(length - 1.0) <= EXACT:
                raise InvalidInput(f"{what}: the axis of joint {name!r} ({kind(part)}) has length {length:g}, not 1")


def _single(joint: Any, q: np.ndarray) -> Iterator[tuple[Any, np.ndarray]]:
    """The joints of one axis among those that a joint is made of, and their motion: linear, angular."""
    if kind(joint) == "Composite":
        for part in joint.extract().joints:
            yield from _single(part, q)
    elif joint.nv == 1:
        data = joint.createData()
        joint.calc(data, q)
        yield joint, np.array(data.S).reshape(6)


def _verify_limits(model: pin.Model, what: str) -> None:
    for i, axis in enumerate(joint_axes(model)):
        if axis.q_index >= 0:
            low, high = float(model.lowerPositionLimit[axis.q_index]), float(model.upperPositionLimit[axis.q_index])
            if not low <= high:
                raise InvalidInput(
                    f"{what}: the range of joint {axis.name!r} is from {low:g} to {high:g} {axis.unit};"
                    " the lowest must not be above the highest"
                )
        for name, limits in ("speed", model.upperVelocityLimit), ("torque", model.upperEffortLimit):
            if not limits[i] >= 0.0:
                raise InvalidInput(
                    f"{what}: the largest {name} of joint {axis.name!r} is {limits[i]}; it must be positive"
                )
