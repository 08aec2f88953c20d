"""Scenes as data that every library can read: a robot, its tasks, and the motion of their targets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from hqp.arrays import Array
from tasks import load_robot
from tasks.base.rotations import exp
from tasks.robots.robot import joint_index

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot

What = Literal["position", "orientation", "pose", "com", "posture"]
#: Under which name the centre of mass has its motion.
COM = "centre of mass"


@dataclass(frozen=True)
class Goal:
    """One task.

    Attributes
    ----------
    what : str
    frame : str
        Whose position, orientation or pose.
    cost : float
        For libraries whose priorities are weights.
    mask : str, optional
        The coordinates of a position that count, as in ``"z"``; by default all.
    """

    what: What
    frame: str = ""
    cost: float = 1.0
    mask: str | None = None


@dataclass(frozen=True)
class Motion:
    """How a target moves, from where its frame is at the start.

    Attributes
    ----------
    shift : tuple, shape (3,)
        Away from there at once [m].
    sway : tuple, shape (3,)
        To and fro about that point [m].
    turn : tuple, shape (3,)
        To and fro about this rotation vector [rad].
    rate : tuple, shape (3,)
        How often, axis by axis [Hz]; the first counts for the turn.
    """

    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sway: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rate: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def at(self, t: float, position: Array, rotation: Array) -> tuple[Array, Array]:
        """The target at time t [s] of a frame that started there; of a planar arm, that turns about z by an angle."""
        wave = np.sin(2.0 * np.pi * np.asarray(self.rate) * t)
        moved = position + np.asarray(self.shift) + np.asarray(self.sway) * wave
        turn = np.asarray(self.turn) * wave[0]
        return moved, rotation + turn[2:] if rotation.ndim == 1 else exp(turn) @ rotation


@dataclass(frozen=True)
class Scene:
    """A robot, tasks in order of priority below its joint limits, and how their targets move.

    Attributes
    ----------
    name, about : str
    robot : str
        A name of the library of robots.
    levels : tuple of tuple of Goal
    motions : dict of str to Motion
        Of each frame, and of `COM`; what is not named stands still.
    held : tuple of str
        Joints that do not move.
    start : dict of str to float
        Joints that start elsewhere than at home [rad], [m]; the posture is that of the start.
    gain : float
        The rate at which errors decay [1/s].
    dt : float
        Tick [s].
    posture_gain : float, optional
        The same of postures, where it is another one.
    speed : float
        The share of their speed that the joints may use.
    """

    name: str
    about: str
    robot: str
    levels: tuple[tuple[Goal, ...], ...]
    motions: Mapping[str, Motion] = field(default_factory=dict)
    held: tuple[str, ...] = ()
    start: Mapping[str, float] = field(default_factory=dict)
    gain: float = 10.0
    dt: float = 0.005
    posture_gain: float | None = None
    speed: float = 1.0

    @property
    def goals(self) -> list[Goal]:
        """All tasks, from the highest level down."""
        return [goal for level in self.levels for goal in level]

    @property
    def frames(self) -> list[str]:
        """The frames that have a task, each once."""
        return list(dict.fromkeys(goal.frame for goal in self.goals if goal.frame))

    @property
    def step(self) -> float:
        """The share of an error that one tick takes away."""
        return self.gain * self.dt

    @property
    def posture_step(self) -> float:
        """The same of postures."""
        return self.step if self.posture_gain is None else self.posture_gain * self.dt

    def cost(self, frame: str, *what: What) -> float:
        """What the tasks of a frame cost that ask for this; 0 where none does."""
        return float(sum(goal.cost for goal in self.goals if goal.frame == frame and goal.what in what))

    def load(self) -> PinocchioRobot:
        """The robot, at home where it starts."""
        robot = load_robot(self.robot, mimic="free", lock=self.held)
        step, joints = np.zeros(robot.nv), robot.at(robot.home, np.zeros(robot.nv)).joints
        for name, position in self.start.items():
            joint = joint_index(robot.joint_names, name, "joint")
            step[joint] = position - joints[joint]
        if self.start:
            robot.home = robot.integrate(robot.home, step)
        if robot.velocity_limit is not None:
            robot.velocity_limit = self.speed * robot.velocity_limit
        return robot

    def motion(self, what: str) -> Motion:
        """How the target of a frame or of the centre of mass moves."""
        return self.motions.get(what, Motion())


_TIP = "panda_hand_tcp"
_FINGERS = ("panda_finger_joint1", "panda_finger_joint2")
_ARM = ((Goal("position", _TIP),), (Goal("orientation", _TIP),), (Goal("posture", cost=1e-3),))
_LEFT, _RIGHT = (f"{side}_ankle_roll_link" for side in ("left", "right"))
_HANDS = tuple(f"{side}_rubber_hand" for side in ("left", "right"))

SCENES = (
    Scene(
        "panda slow",
        "limits > position > orientation > posture, slow",
        "panda",
        _ARM,
        {_TIP: Motion(sway=(0.06, 0.12, 0.08), turn=(0.0, 0.2, 0.2), rate=(0.1, 0.07, 0.13))},
        _FINGERS,
    ),
    Scene(
        "panda saturated",
        "the same, fast and beyond reach",
        "panda",
        _ARM,
        {_TIP: Motion((0.3, 0.0, 0.0), sway=(0.6, 0.9, 0.6), turn=(0.0, 1.0, 1.0), rate=(0.9, 0.7, 1.1))},
        _FINGERS,
    ),
    Scene(
        "humanoid",
        "limits > feet > centre of mass > hands > torso > posture, slow",
        "g1",
        (
            (Goal("pose", _LEFT, 10.0), Goal("pose", _RIGHT, 10.0)),
            (Goal("com", cost=3.0),),
            tuple(Goal("position", hand) for hand in _HANDS),
            (Goal("orientation", "torso_link", 0.3),),
            (Goal("posture", cost=1e-3),),
        ),
        {
            COM: Motion(sway=(0.01, 0.03, 0.0), rate=(0.11, 0.09, 0.0)),
            _HANDS[0]: Motion(sway=(0.06, 0.04, 0.08), rate=(0.1, 0.07, 0.13)),
            _HANDS[1]: Motion(sway=(0.08, 0.03, 0.06), rate=(0.08, 0.12, 0.1)),
            "torso_link": Motion(turn=(0.0, 0.1, 0.1), rate=(0.1, 0.0, 0.0)),
        },
    ),
)
