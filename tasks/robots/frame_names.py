"""Frames by name: a plain name means a link before a joint, and ``"joint:gripper"`` asks for the joint.

In files, links, joints and sites have separate names, and often share one.
"""

from __future__ import annotations

import pinocchio as pin

#: Kinds of frames with separate names; a plain name means the first kind that has it.
KINDS: dict[str, tuple[pin.FrameType, ...]] = {
    "body": (pin.FrameType.BODY,),
    "site": (pin.FrameType.OP_FRAME,),
    "sensor": (pin.FrameType.SENSOR,),
    "joint": (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT),
}


def by_kind(model: pin.Model) -> dict[str, list[tuple[str, int]]]:
    """Names and numbers of the frames of each kind."""
    frames = list(enumerate(model.frames))
    return {kind: [(frame.name, i) for i, frame in frames if frame.type in own] for kind, own in KINDS.items()}


def frame_numbers(model: pin.Model) -> dict[str, int]:
    """The number of every frame, under its plain name if that is unique or first, and under ``"kind:name"``."""
    found: dict[str, int] = {}
    kinds = by_kind(model)
    for frames in kinds.values():
        for name, i in frames:
            found.setdefault(name, i)
    for kind, frames in kinds.items():
        for name, i in frames:
            found.setdefault(f"{kind}:{name}", i)
    return found
