"""Arms in four characters each: slow, saturated, singular, infeasible."""

from __future__ import annotations

from dataclasses import replace

from ..ticks.scenes import SCENES as TICKS
from ..ticks.scenes import Goal, Motion, Scene
from .planar import PlanarScene

Levels = tuple[tuple[Goal, ...], ...]


def stack(tip: str, elbow: Goal | None = None, mask: str | None = None) -> Levels:
    """position > (elbow >) orientation > posture, below the joint limits."""
    middle = [] if elbow is None else [elbow]
    goals = [Goal("position", tip, mask=mask), *middle, Goal("orientation", tip), Goal("posture", cost=1e-3)]
    return tuple((goal,) for goal in goals)


THREE, FOUR = (0.5, 0.5, 0.5), (0.4, 0.4, 0.4, 0.3)
_BENT, _CURVED = (0.9, -1.2, -0.5), (1.2, -0.9, -0.7, -0.4)
_PLANAR = stack("tip", mask="xy")

PLANAR = (
    PlanarScene(
        name="planar slow",
        about="four links, in reach",
        levels=_PLANAR,
        lengths=FOUR,
        home=_CURVED,
        motions={"tip": Motion(sway=(0.1, 0.15, 0.0), turn=(0.0, 0.0, 0.3), rate=(0.1, 0.07, 0.0))},
    ),
    PlanarScene(
        name="planar saturated",
        about="four links, faster than the joints",
        levels=_PLANAR,
        lengths=FOUR,
        home=_CURVED,
        motions={"tip": Motion(sway=(0.7, 1.0, 0.0), turn=(0.0, 0.0, 1.5), rate=(0.9, 0.7, 0.0))},
    ),
    PlanarScene(
        name="planar singular",
        about="three links, stretched and back, the orientation held",
        levels=_PLANAR,
        lengths=THREE,
        home=_BENT,
        motions={"tip": Motion(shift=(0.25, 0.1, 0.0), sway=(0.2, 0.08, 0.0), rate=(0.15, 0.15, 0.0))},
    ),
    PlanarScene(
        name="planar infeasible",
        about="four links, the tip out of reach, the second joint asked elsewhere",
        levels=stack("tip", Goal("position", "link2", mask="xy"), mask="xy"),
        lengths=FOUR,
        home=_CURVED,
        motions={
            "tip": Motion(shift=(1.2, 0.3, 0.0), sway=(0.3, 0.6, 0.0), turn=(0.0, 0.0, 0.6), rate=(0.1, 0.07, 0.0)),
            "link2": Motion(shift=(-0.6, 0.3, 0.0), sway=(0.2, 0.2, 0.0), rate=(0.13, 0.11, 0.0)),
        },
    ),
)

_PANDA, _FINGERS = "panda_hand_tcp", ("panda_finger_joint1", "panda_finger_joint2")
_SLOW, _SATURATED = (scene for scene in TICKS if scene.robot == "panda")

PANDA = (
    replace(_SLOW, about="in reach"),
    replace(_SATURATED, about="faster than the joints, and beyond reach"),
    Scene(
        "panda singular",
        "stretched and back, the orientation held",
        "panda",
        stack(_PANDA),
        {_PANDA: Motion(shift=(0.15, 0.0, 0.0), sway=(0.3, 0.1, 0.1), rate=(0.15, 0.1, 0.12))},
        _FINGERS,
    ),
    Scene(
        "panda infeasible",
        "the tip out of reach, the elbow asked elsewhere",
        "panda",
        stack(_PANDA, Goal("position", "panda_link4")),
        {
            _PANDA: Motion(shift=(0.7, 0.0, 0.2), sway=(0.1, 0.5, 0.2), turn=(0.0, 0.5, 0.5), rate=(0.1, 0.07, 0.13)),
            "panda_link4": Motion(shift=(0.0, 0.0, 0.4), sway=(0.2, 0.2, 0.0), rate=(0.13, 0.11, 0.0)),
        },
        _FINGERS,
    ),
)

_UR5 = "tool0"

UR5 = (
    Scene(
        "ur5 slow",
        "in reach",
        "ur5",
        stack(_UR5),
        {_UR5: Motion(sway=(0.06, 0.12, 0.08), turn=(0.0, 0.2, 0.2), rate=(0.1, 0.07, 0.13))},
    ),
    Scene(
        "ur5 saturated",
        "faster than the joints, and beyond reach",
        "ur5",
        stack(_UR5),
        {_UR5: Motion((0.2, 0.0, 0.0), sway=(0.6, 0.9, 0.6), turn=(0.0, 1.0, 1.0), rate=(0.9, 0.7, 1.1))},
    ),
    Scene(
        "ur5 singular",
        "to and fro through the singularity of the wrist, the orientation held",
        "ur5",
        stack(_UR5),
        {_UR5: Motion(sway=(0.02, 0.04, 0.02), rate=(0.1, 0.12, 0.07))},
        start={"wrist_1_joint": -0.45, "wrist_2_joint": 0.0},
    ),
    Scene(
        "ur5 infeasible",
        "the tip out of reach, the elbow asked elsewhere",
        "ur5",
        stack(_UR5, Goal("position", "forearm_link")),
        {
            _UR5: Motion(shift=(0.6, 0.0, 0.2), sway=(0.1, 0.5, 0.2), turn=(0.0, 0.5, 0.5), rate=(0.1, 0.07, 0.13)),
            "forearm_link": Motion(shift=(-0.2, 0.0, 0.3), sway=(0.2, 0.2, 0.0), rate=(0.13, 0.11, 0.0)),
        },
    ),
)

SCENES = (*PLANAR, *PANDA, *UR5)
