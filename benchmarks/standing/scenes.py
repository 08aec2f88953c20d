"""Robots that stand on contacts, each in three characters: balanced, at contact changes, saturated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import reduce
from operator import add
from typing import TYPE_CHECKING

import numpy as np

from hqp.arrays import Array
from tasks import (
    CenterOfMassTask,
    Contact,
    Dynamics,
    ForceTask,
    JointLimits,
    JointTorqueLimit,
    OrientationTask,
    PoseTask,
    PositionTask,
    PostureTask,
    Stack,
    SupportLimit,
    Task,
    load_robot,
)
from tasks.robots.robot import joint_index
from tasks.targets.timing import quintic

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot

#: Tick [s]; all motions repeat after so long [s].
DT, PERIOD = 2e-3, 4.0
#: How long a foot takes to be let go, twice, and to be put down [s]; what the way of a lifted foot takes [s].
RAMP, SWING = 0.1, 0.2
#: The share of its height at the start below which a robot has fallen: it is set back on its feet.
FALLEN = 0.9
#: Coefficient of friction; what is left free inside the support polygon [m].
FRICTION, MARGIN = 0.6, 0.01

Point = tuple[float, float, float]
Moving = Callable[[float], tuple[Array, Array, Array]]


@dataclass(frozen=True)
class Body:
    """A robot of the library that can stand.

    Attributes
    ----------
    robot : str
    feet : tuple of str
        Frames.
    base : str
        A frame that stays upright.
    sole : tuple of points
        Where a foot touches, in its own coordinates [m]; empty for a point foot.
    bent : dict of str to float
        Joints that start elsewhere than at home [rad].
    acceleration : float
        How hard joints may brake before their ends [rad/s^2].
    """

    robot: str
    feet: tuple[str, ...]
    base: str
    sole: tuple[Point, ...] = ()
    bent: dict[str, float] = field(default_factory=dict)
    acceleration: float = 200.0


@dataclass(frozen=True)
class Way:
    """The centre of mass goes to a point beside its start [m], from a time on and within so long [s]."""

    at: float
    to: Point
    time: float


@dataclass(frozen=True)
class Lift:
    """A foot that is let go at a time [s], lifted, and put down again."""

    foot: str
    at: float

    @property
    def down(self) -> float:
        """When it is put down [s]: it has been let go, and has gone up and down."""
        return self.at + 2.0 * RAMP + SWING


@dataclass(frozen=True)
class StandingScene:
    """motion equation and contacts > limits > centre of mass, lifted feet > base upright > posture, least forces.

    Attributes
    ----------
    name, about : str
    body : Body
    sway : tuple, shape (3,)
        To and fro about where the centre of mass is at the start [m].
    rate : tuple, shape (3,)
        How often, axis by axis [Hz].
    ways : tuple of Way
        Of the centre of mass, one after the other.
    lifts : tuple of Lift
    height : float
        To which a foot is lifted [m].
    torque : float
        The share of their torque that the joints may use.
    support : bool
        Whether the capture point is kept inside the support polygon, above all tasks, and only the horizontal
        coordinates of the centre of mass are asked for.
    """

    name: str
    about: str
    body: Body
    sway: Point = (0.0, 0.0, 0.0)
    rate: Point = (0.25, 0.5, 0.0)
    ways: tuple[Way, ...] = ()
    lifts: tuple[Lift, ...] = ()
    height: float = 0.04
    torque: float = 1.0
    support: bool = False

    def load(self) -> PinocchioRobot:
        """The robot, at home where it starts."""
        robot = load_robot(self.body.robot, acceleration_limit=self.body.acceleration)
        step, joints = np.zeros(robot.nv), robot.at(robot.home, np.zeros(robot.nv)).joints
        for name, position in self.body.bent.items():
            joint = joint_index(robot.joint_names, name, "joint")
            step[joint] = position - joints[joint]
        robot.home = robot.integrate(robot.home, step)
        assert robot.torque_limit is not None
        robot.torque_limit = self.torque * robot.torque_limit
        return robot

    def center_of_mass(self, start: Array, mask: str) -> Moving:
        """Where the centre of mass is asked to be at a time, how fast, and how it speeds up, along these axes."""
        own = ["xyz".index(axis) for axis in mask]
        sway, w = np.array(self.sway), 2.0 * np.pi * np.array(self.rate)

        def at(t: float) -> tuple[Array, Array, Array]:
            wave = sway * np.sin(w * t)
            place, speed, rate = start + wave, sway * w * np.cos(w * t), -w * w * wave
            before = np.zeros(3)
            for way in self.ways:
                s, ds, dds = quintic((t % PERIOD - way.at) / way.time)
                step, before = np.array(way.to) - before, np.array(way.to)
                place, speed, rate = place + s * step, speed + ds / way.time * step, rate + dds / way.time**2 * step
            return place[own], speed[own], rate[own]

        return at

    def lifted(self, foot: str, start: Array) -> Moving:
        """Where a foot is asked to be at a time, how fast, and how it speeds up."""
        half, w = np.array([0.0, 0.0, 0.5 * self.height]), 2.0 * np.pi / SWING
        begins = [lift.at + 2.0 * RAMP for lift in self.lifts if lift.foot == foot]

        def at(t: float) -> tuple[Array, Array, Array]:
            for begin in begins:
                phase = w * (t % PERIOD - begin)
                if 0.0 < phase < 2.0 * np.pi:
                    return start + half * (1.0 - np.cos(phase)), half * w * np.sin(phase), half * w * w * np.cos(phase)
            return start, np.zeros(3), np.zeros(3)

        return at


@dataclass(frozen=True, eq=False)
class Declared:
    """The stack of a scene, and of its parts those that are asked about."""

    stack: Stack
    contacts: dict[str, Contact]
    center_of_mass: CenterOfMassTask


def declare(scene: StandingScene, robot: PinocchioRobot) -> Declared:
    """The stack of a scene; its targets follow from the time."""
    body, state = scene.body, robot.at(robot.home, np.zeros(robot.nv))
    touching = {"points": body.sole} if body.sole else {}
    contacts = {foot: Contact(foot, friction=FRICTION, **touching) for foot in body.feet}  # type: ignore[arg-type]
    mask, gain = ("xy", 4.0) if scene.support else ("xyz", 6.0)
    start = state.center_of_mass.position.copy()
    center = CenterOfMassTask(scene.center_of_mass(start, mask), mask=mask, gain=gain)
    swings = [_swing(scene, foot, robot) for foot in dict.fromkeys(lift.foot for lift in scene.lifts)]
    wanted = reduce(add, swings, Stack(center))
    levels = [reduce(add, contacts.values(), Stack(Dynamics())), JointTorqueLimit() + JointLimits()]
    levels += [Stack(SupportLimit(margin=MARGIN))] if scene.support else []
    upright = OrientationTask(state.frame(body.base).rotation.copy(), frame=body.base, gain=8.0)
    rest = PostureTask(robot.home, gain=4.0) + ForceTask(weight=1e-2)
    return Declared(Stack(*levels, wanted, upright, rest), contacts, center)


def _swing(scene: StandingScene, foot: str, robot: PinocchioRobot) -> Task:
    place = robot.at(robot.home, np.zeros(robot.nv)).frame(foot)
    target = scene.lifted(foot, place.position.copy())
    if scene.body.sole:
        return PoseTask((target, place.rotation.copy()), frame=foot, gain=20.0)
    return PositionTask(target, frame=foot, gain=20.0)


def _rectangle(x: tuple[float, float], y: tuple[float, float], z: float) -> tuple[Point, ...]:
    return tuple((a, b, z) for a in x for b in y)


def _sides(*names: str, left: str, right: str) -> tuple[str, ...]:
    return tuple(name.replace("SIDE", side) for name in names for side in (left, right))


_G1 = Body(
    "g1",
    ("left_ankle_roll_link", "right_ankle_roll_link"),
    "pelvis",
    _rectangle((-0.05, 0.12), (-0.03, 0.03), -0.03),
)
_TALOS = Body(
    "talos",
    ("left_sole_link", "right_sole_link"),
    "base_link",
    _rectangle((-0.1, 0.1), (-0.06, 0.06), 0.0),
)
_LEGS = ("FL", "FR", "RL", "RR")
_GO2 = Body(
    "go2",
    tuple(f"{leg}_foot" for leg in _LEGS),
    "base",
    bent={f"{leg}_{joint}_joint": angle for leg in _LEGS for joint, angle in (("thigh", 0.8), ("calf", -1.6))},
    acceleration=500.0,
)


def _humanoid(body: Body, beside: float, far: float, torque: float) -> tuple[StandingScene, ...]:
    """Characters of a robot with two soles: how far beside the middle it stands on one, and how far out is too far."""
    name, (_, right) = body.robot, body.feet
    over = Way(0.0, (0.0, beside, 0.0), 1.1), Way(3.0, (0.0, 0.0, 0.0), 1.0)
    return (
        StandingScene(f"{name} balanced", "the centre of mass sways", body, (0.01, 0.03, 0.0)),
        StandingScene(
            f"{name} steps",
            "on its left foot the right one is lifted and put down",
            body,
            ways=over,
            lifts=tuple(Lift(right, at) for at in (1.2, 1.8, 2.4)),
        ),
        StandingScene(
            f"{name} saturated",
            f"asked {100 * far:g} cm out, torques limited to {100 * torque:g} %, until it falls",
            body,
            (far, far / 2.0, 0.0),
            torque=torque,
            support=True,
        ),
    )


_AWAY = 0.06
SCENES = (
    *_humanoid(_G1, 0.105, 0.3, 0.6),
    *_humanoid(_TALOS, 0.075, 0.3, 0.6),
    StandingScene("go2 balanced", "the centre of mass sways", _GO2, (0.03, 0.03, 0.0)),
    StandingScene(
        "go2 steps",
        "one leg after the other is lifted and put down",
        _GO2,
        ways=(
            Way(0.0, (-_AWAY, -_AWAY, 0.0), 0.5),
            Way(1.2, (_AWAY, _AWAY, 0.0), 0.8),
            Way(2.6, (0.0, 0.0, 0.0), 1.0),
        ),
        lifts=(Lift("FL_foot", 0.6), Lift("RR_foot", 2.1)),
    ),
    StandingScene(
        "go2 saturated",
        "asked 30 cm out, torques limited to 60 %, until it falls",
        _GO2,
        (0.3, 0.15, 0.0),
        torque=0.6,
        support=True,
    ),
)
