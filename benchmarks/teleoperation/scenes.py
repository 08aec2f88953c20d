"""Scenes of teleoperation as data: a robot, and the motion of the target."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from hqp.arrays import Array

from ..ticks.scenes import Goal
from ..ticks.scenes import Scene as Asked
from ..ticks.stream import Stream, targeted
from .hand import Hand, Sway

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot


@dataclass(frozen=True)
class Scene(Asked):
    """What is asked of a robot, for how long, and where the robot starts.

    Attributes
    ----------
    seconds : float
    beyond : dict of str to float
        Joints that start outside their range, and by how much [rad]: above it, or below where negative.
    """

    seconds: float = 15.0
    beyond: Mapping[str, float] = field(default_factory=dict)

    def beginning(self, robot: PinocchioRobot) -> Array:
        """Where the robot starts, shape (nq,): its home, but for joints that start outside their range."""
        q = np.array(robot.home)
        for name, far in self.beyond.items():
            joint = robot.joint_names.index(name)
            q[joint] = robot.position_limit[int(far > 0.0), joint] + far
        return q

    def stream(self, seconds: float | None = None) -> Stream:
        """The targets tick by tick; where the robot will be is up to who follows them."""
        ticks = max(2, round((self.seconds if seconds is None else seconds) / self.dt))
        robot = self.load()
        q, v = np.tile(self.beginning(robot), (ticks, 1)), np.zeros((ticks, robot.nv))
        return Stream(self, robot, q, v, *targeted(self, robot, ticks), saturated=0.0)


_TIP, _TOOL = "panda_hand_tcp", "tool0"
_FINGERS = ("panda_finger_joint1", "panda_finger_joint2")


def _arm(tip: str) -> tuple[tuple[Goal, ...], ...]:
    """Position > orientation > posture, and the costs of who weighs them."""
    return (Goal("position", tip),), (Goal("orientation", tip),), (Goal("posture", cost=1e-3),)


_EIGHT = Hand((Sway(0.2, (0.0, 0.25, 0.0), (0.0, 0.2, 0.3)), Sway(0.4, (0.0, 0.0, 0.12))))
_TREMOR = (
    Sway(0.1, (0.05, 0.2, 0.0), (0.0, 0.0, 0.3)),
    Sway(0.15, (0.0, 0.0, 0.1)),
    Sway(8.3, (0.001, 0.0005, 0.0), (0.01, 0.0, 0.0)),
    Sway(9.7, (0.0, 0.001, 0.0005), (0.0, 0.01, 0.0)),
    Sway(11.6, (0.0005, 0.0, 0.001), (0.0, 0.0, 0.01)),
)
_BACK = -np.pi / 2.0

_PANDA = Scene("", "", "panda", _arm(_TIP), held=_FINGERS, gain=20.0, posture_gain=1.0)

SCENES = (
    replace(
        _PANDA,
        name="figure eight",
        about="0.5 m wide and within reach",
        motions={_TIP: _EIGHT},
    ),
    replace(
        _PANDA,
        name="tremor",
        about="a slow path, and a hand that shakes at 8 to 12 Hz",
        motions={_TIP: Hand(_TREMOR)},
    ),
    replace(
        _PANDA,
        name="stretched",
        about="out to the end of its reach and back, the hand held level",
        motions={_TIP: Hand((Sway(0.2, (0.3, 0.0, 0.0), phase=_BACK), Sway(0.13, (0.0, 0.1, 0.05))))},
    ),
    replace(
        _PANDA,
        name="out of reach",
        about="0.4 m beyond it and back",
        motions={_TIP: Hand((Sway(0.15, (0.5, 0.0, 0.0), phase=_BACK), Sway(0.25, (0.0, 0.3, 0.1), (0.0, 0.3, 0.0))))},
    ),
    replace(
        _PANDA,
        name="outside",
        about="three joints start 0.05 to 0.2 rad outside their ranges",
        motions={_TIP: _EIGHT},
        beyond={"panda_joint4": -0.1, "panda_joint6": 0.2, "panda_joint7": 0.05},
    ),
    replace(
        _PANDA,
        name="slow joints",
        about="the figure eight at a tenth of the joint speeds",
        motions={_TIP: _EIGHT},
        speed=0.1,
    ),
    Scene(
        "ur5 stretched",
        "six joints, out to 3 cm beyond its reach and back",
        "ur5",
        _arm(_TOOL),
        {_TOOL: Hand((Sway(0.2, (0.18, 0.0, 0.0), phase=_BACK),))},
        gain=20.0,
        posture_gain=1.0,
    ),
)
