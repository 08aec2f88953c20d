"""What every model must be, whichever reader it came from: names that name one thing, axes, ranges, numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from .axes import axes, kind
from .frame_names import by_kind

#: How far the length of an axis, or a rotation, may be off.
EXACT = 1e-9


def verify(model: pin.Model, what: str) -> None:
    """Refuse a model that moves nothing, or in which a name, an axis, a range or a number means nothing.

    Raises
    ------
    InvalidInput
        Names the first such element.
    """
    if model.nv == 0:
        raise InvalidInput(
            f"{what} has 0 degrees of freedom: no joint that moves; of a robot that flies, base='floating' gives six"
        )
    everything = {"joint": list(model.names), "axis": [axis.name for axis in axes(model)], **_frames(model)}
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
    for axis in axes(model):
        if axis.place >= 0:
            low, high = float(model.lowerPositionLimit[axis.place]), float(model.upperPositionLimit[axis.place])
            if not low <= high:
                raise InvalidInput(
                    f"{what}: the range of joint {axis.name!r} is from {low:g} to {high:g} {axis.unit};"
                    " the lowest must not be above the highest"
                )


def _frames(model: pin.Model) -> dict[str, list[str]]:
    return {f"the frame of a {kind}": [name for name, _ in frames] for kind, frames in by_kind(model).items()}


def _verify_placed(placement: pin.SE3, what: str) -> None:
    R, p = np.array(placement.rotation), np.array(placement.translation)
    if not (np.isfinite(p).all() and np.abs(R.T @ R - np.eye(3)).max() <= EXACT):
        raise InvalidInput(f"{what} is placed at {p.tolist()} with axes {R.tolist()}; the place must be finite")


def _verify_inertia(inertia: pin.Inertia, what: str) -> None:
    numbers = np.array([inertia.mass, *inertia.lever, *np.ravel(inertia.inertia)])
    if not np.isfinite(numbers).all() or inertia.mass < 0.0:
        raise InvalidInput(f"{what} has the mass {inertia.mass:g} kg; it must be finite and not negative")


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
