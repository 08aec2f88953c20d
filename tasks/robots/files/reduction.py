"""Locks joints: the reduced model, and its configurations."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from ...base.checks import Array, finite_scalar, suggestion
from ..frame_names import KINDS
from ..joint_axes import NONE, joint_axes
from ..ranges import SAME

#: The kind of a frame, by its type.
KIND_OF = {own: kind for kind, types in KINDS.items() for own in types}


def reduced(
    model: pin.Model, positions: Mapping[str, float | None], neutral: Array, what: str
) -> tuple[pin.Model, Array]:
    """The model with these joints locked at a position or, if that is None, in their range nearest to neutral.

    Returns
    -------
    pinocchio.Model, and the neutral configuration of it.

    Raises
    ------
    InvalidInput
        If a joint is unknown, or a position outside its range; the message gives the nearest names, or the range.
    """
    q, held = np.array(neutral), []
    names = list(model.names)[1:]
    single = {axis.joint: axis for axis in joint_axes(model) if axis.name == axis.joint}
    for name, position in positions.items():
        if name not in names:
            raise InvalidInput(f"{what}: {name!r} is no joint{suggestion(str(name), names)}")
        held.append(int(model.getJointId(name)))
        axis, own = single.get(name), f"{what}: lock of joint {name!r}"
        if position is None:
            if axis is not None and axis.q_index != NONE:
                low, high = model.lowerPositionLimit[axis.q_index], model.upperPositionLimit[axis.q_index]
                q[axis.q_index] = np.clip(q[axis.q_index], low, high)
            continue
        if axis is None:
            raise InvalidInput(f"{own}: it has several axes, and can only be held at its neutral place")
        value = finite_scalar(position, own)
        if axis.q_index == NONE:
            q[axis.circle : axis.circle + 2] = np.cos(value), np.sin(value)
            continue
        low, high = model.lowerPositionLimit[axis.q_index], model.upperPositionLimit[axis.q_index]
        if not low - SAME <= value <= high + SAME:
            raise InvalidInput(f"{own} at {value:g} {axis.unit} is outside its range, {low:g} .. {high:g} {axis.unit}")
        q[axis.q_index] = value
    if not held:
        return model, q
    if len(held) == model.njoints - 1:
        raise InvalidInput(f"{what}: lock holds all joints; one must be left to move")
    left = without(model, held, q)
    return left, carried(q, model, left)


def carried(q: Array, before: pin.Model, after: pin.Model) -> Array:
    """A configuration of one model for another one, which has some of its joints."""
    kept = [before.joints[before.getJointId(name)] for name in after.names]
    places = [
        joint.idx_q + i
        for joint, own in zip(kept[1:], list(after.joints)[1:], strict=True)
        for i in range(own.nq)  # mimic joints have none
    ]
    return np.asarray(q[places])


def without(model: pin.Model, held: list[int], q: Array) -> pin.Model:
    """The model with the joints of these numbers held at q.

    Pinocchio finds frames by name only, so each gets a unique name meanwhile.
    """
    model = pin.Model(model)
    for i, name in enumerate(model.names):
        model.names[i] = f"joint:{name}" if i else name
    for frame in list(model.frames)[1:]:
        frame.name = f"{KIND_OF[frame.type]}:{frame.name}"
    left = pin.buildReducedModel(model, held, q)
    for i, name in enumerate(left.names):
        left.names[i] = name.removeprefix("joint:")
    for frame in list(left.frames)[1:]:
        frame.name = frame.name.removeprefix(f"{KIND_OF[frame.type]}:")
    return left
