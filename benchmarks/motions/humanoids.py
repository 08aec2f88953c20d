"""Humanoids in four characters each: slow, saturated, singular, infeasible."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..ticks.scenes import COM, Goal, Motion, Scene


@dataclass(frozen=True)
class Humanoid:
    """A humanoid of the library of robots: its frames, and how it stands.

    Attributes
    ----------
    robot : str
    feet, hands : tuple of str
        Frames, left and right.
    torso : str
        A frame.
    held : tuple of str
        Joints that do not move.
    start : dict of str to float
        Joints that start elsewhere than at home [rad].
    """

    robot: str
    feet: tuple[str, str]
    hands: tuple[str, str]
    torso: str
    held: tuple[str, ...]
    start: Mapping[str, float]

    def scene(self, character: str, about: str, com: Motion, left: Motion, right: Motion, torso: Motion) -> Scene:
        """limits > feet > centre of mass > hands > torso > posture."""
        levels = (
            tuple(Goal("pose", foot, 10.0) for foot in self.feet),
            (Goal("com", cost=3.0),),
            tuple(Goal("position", hand) for hand in self.hands),
            (Goal("orientation", self.torso, 0.3),),
            (Goal("posture", cost=1e-3),),
        )
        motions = {COM: com, self.hands[0]: left, self.hands[1]: right, self.torso: torso}
        return Scene(f"{self.robot} {character}", about, self.robot, levels, motions, self.held, self.start)

    def scenes(self) -> tuple[Scene, ...]:
        """All characters."""
        return (
            self.scene(
                "slow",
                "both hands in reach",
                Motion(sway=(0.01, 0.03, 0.0), rate=(0.11, 0.09, 0.0)),
                Motion(sway=(0.06, 0.04, 0.08), rate=(0.1, 0.07, 0.13)),
                Motion(sway=(0.08, 0.03, 0.06), rate=(0.08, 0.12, 0.1)),
                Motion(turn=(0.0, 0.1, 0.1), rate=(0.1, 0.0, 0.0)),
            ),
            self.scene(
                "saturated",
                "hands, trunk and centre of mass as fast and as far as the joints go",
                Motion(sway=(0.06, 0.08, 0.0), rate=(0.5, 0.4, 0.0)),
                Motion(sway=(0.5, 0.5, 0.6), rate=(0.9, 0.7, 1.1)),
                Motion(sway=(0.5, 0.5, 0.6), rate=(0.8, 1.0, 0.6)),
                Motion(turn=(0.8, 0.8, 1.2), rate=(0.7, 0.0, 0.0)),
            ),
            self.scene(
                "singular",
                "hands up until arms and knees are straight, and down again",
                Motion(),
                Motion(shift=(0.0, 0.0, 0.5), sway=(0.0, 0.05, 0.5), rate=(0.1, 0.1, 0.12)),
                Motion(shift=(0.0, 0.0, 0.5), sway=(0.0, 0.05, 0.5), rate=(0.1, 0.1, 0.12)),
                Motion(),
            ),
            self.scene(
                "infeasible",
                "hands pulled apart, the trunk and the centre of mass beyond the feet",
                Motion(shift=(0.1, 0.0, 0.0), sway=(0.1, 0.2, 0.0), rate=(0.1, 0.08, 0.0)),
                Motion(shift=(0.4, 0.5, 0.3), sway=(0.2, 0.2, 0.3), rate=(0.1, 0.07, 0.13)),
                Motion(shift=(-0.4, -0.5, 0.2), sway=(0.2, 0.2, 0.3), rate=(0.08, 0.12, 0.1)),
                Motion(turn=(1.0, 0.5, 0.5), rate=(0.1, 0.0, 0.0)),
            ),
        )


def _both(**joints: float) -> dict[str, float]:
    """Left and right: ``SIDE`` in their names is one, and the other."""
    return {name.replace("SIDE", side): value for name, value in joints.items() for side in ("left", "right")}


G1 = Humanoid(
    "g1",
    ("left_ankle_roll_link", "right_ankle_roll_link"),
    ("left_rubber_hand", "right_rubber_hand"),
    "torso_link",
    (),
    {},
)
TALOS = Humanoid(
    "talos",
    ("left_sole_link", "right_sole_link"),
    ("gripper_left_base_link", "gripper_right_base_link"),
    "torso_2_link",
    ("gripper_left_joint", "gripper_right_joint"),
    {"arm_left_2_joint": 0.3, "arm_right_2_joint": -0.3},
)

SCENES = (*G1.scenes(), *TALOS.scenes())
