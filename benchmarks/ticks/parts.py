"""Stacks of a Panda with every kind of part, in place of a plain one or added, compared with the plain stack.

Public names of the library only, so that these stacks can be declared in another checkout too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from hqp.arrays import Array
from tasks import (
    AtLeast,
    AtMost,
    AvoidanceTask,
    AxisTask,
    BoxLimit,
    Capsule,
    CenterOfMassTask,
    Circle,
    Damping,
    DistanceLimit,
    DynamicManipulabilityTask,
    FrameVelocityLimit,
    JointAccelerationLimit,
    JointCentringTask,
    JointCouplingTask,
    JointLimits,
    JointMotion,
    JointPositionLimit,
    JointTorqueLimit,
    JointVelocityLimit,
    KineticEnergyTask,
    LinkCapsule,
    LookAtTask,
    ManipulabilityTask,
    MinimumMotionTask,
    MinimumTorqueTask,
    OrientationTask,
    Part,
    PlaneLimit,
    PlaneTask,
    PoseTask,
    PositionTask,
    PostureTask,
    RobotState,
    SelfCollisionLimit,
    Sphere,
    Stack,
    TargetTask,
    VelocityRatioTask,
    Within,
    load_robot,
)

if TYPE_CHECKING:
    from tasks import PinocchioRobot

Order = Literal["velocity", "acceleration", "torque"]
ORDERS: tuple[Order, ...] = ("velocity", "acceleration", "torque")
#: The tick [s], the rate of the tasks [1/s], the acceleration that joints are limited to where a stack says so.
DT, GAIN, ACCELERATION = 0.005, 4.0, 15.0
ELBOW, BASE = "panda_link4", "panda_link1"


class Path:
    """The hand's way: a circle that lies flat."""

    def __init__(self, start: Array) -> None:
        self.circle, self.height = Circle(start[:2] + np.array([0.08, 0.0]), 0.08, 10.0), float(start[2])

    def __call__(self, t: float) -> tuple[Array, Array, Array]:
        at, v, a = self.circle(t)
        return np.array([*at, self.height]), np.array([*v, 0.0]), np.array([*a, 0.0])


class Same(PositionTask):
    """A subclass that overrides nothing."""


class Own(TargetTask):
    """A task that somebody wrote in Python: the distance of the hand from the axis z, squared."""

    rows = 1

    def measure(self, state: RobotState) -> Array:
        x, y, _ = state.frame().position
        return np.array([x * x + y * y])

    def jacobian(self, state: RobotState) -> Array:
        frame = state.frame()
        return 2.0 * frame.position[None, :2] @ frame.linear[:2]

    def drift(self, state: RobotState) -> Array:
        frame, v = state.frame(), state.v
        speed = frame.linear[:2] @ v
        return np.array([2.0 * (speed @ speed + frame.position[:2] @ frame.linear_drift[:2])])


class Scene:
    """A Panda, and the parts of its plain stack: limits > position > orientation > posture.

    A robot belongs to one controller at a time, so that every stack has a scene of its own.

    Attributes
    ----------
    robot : PinocchioRobot
    path : Path
    limits, hand, turn, rest : Part
    """

    def __init__(self, order: Order) -> None:
        acceleration = None if order == "velocity" else ACCELERATION
        self.robot: PinocchioRobot = load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=acceleration)
        self.order = order
        tip = self.robot.at(self.robot.home, np.zeros(self.robot.nv)).frame()
        self.path, self.start, self.rotation = Path(tip.position), tip.position, tip.rotation
        self.limits, self.hand = JointLimits(), PositionTask(self.path, gain=GAIN)
        self.turn, self.rest = OrientationTask(tip.rotation, gain=GAIN), PostureTask(self.robot.home, gain=1.0)

    def stack(self, **instead: Part | Stack) -> Stack:
        """The plain stack, some of its parts replaced."""
        return Stack(*(instead.get(name, getattr(self, name)) for name in ("limits", "hand", "turn", "rest")))

    def above(self, part: Part | Stack) -> Stack:
        """The plain stack with one more part below the limits."""
        return self.limits >> part >> self.hand >> self.turn >> self.rest

    def below(self, part: Part) -> Stack:
        """The plain stack with one more part above the posture."""
        return self.limits >> self.hand >> self.turn >> part >> self.rest

    def limited(self, limit: Callable[[], Part] = JointAccelerationLimit) -> tuple[Part, ...]:
        """The limits of the joints one by one, with that of accelerations at the orders that have one."""
        return JointPositionLimit(), JointVelocityLimit(), *([] if self.order == "velocity" else [limit()])

    @cached_property
    def elbow(self) -> Array:
        """Where the elbow is at the start [m]."""
        return self.robot.at(self.robot.home, np.zeros(self.robot.nv)).frame(ELBOW).position

    def links(self) -> list[LinkCapsule]:
        """All that moves, one capsule a link."""
        inner = [LinkCapsule(f"panda_link{i}", f"panda_link{i + 1}", 0.06) for i in range(1, 7)]
        return [*inner, LinkCapsule("panda_link7", "panda_hand", 0.06)]

    def braked(self) -> JointLimits:
        """Limits beside which inequalities brake in time."""
        return JointLimits(JointPositionLimit(), JointVelocityLimit(), JointAccelerationLimit(ACCELERATION))


@dataclass(frozen=True)
class Kind:
    """A kind of part at work.

    Attributes
    ----------
    name : str
    stands : str
        Where it stands: in place of which part of the plain stack, or added to it.
    declare : callable
        Scene -> Stack.
    orders : tuple of str
        Those that it has.
    """

    name: str
    stands: str
    declare: Callable[[Scene], Stack]
    orders: tuple[Order, ...] = ORDERS


PLAIN = Kind("plain", "", lambda s: s.stack())


def _position(name: str, make: Callable[[Scene], Part]) -> Kind:
    return Kind(name, "for position", lambda s: s.stack(hand=make(s)))


def _orientation(name: str, make: Callable[[Scene], Part]) -> Kind:
    return Kind(name, "for orientation", lambda s: s.stack(turn=make(s)))


def _posture(name: str, make: Callable[[Scene], Part], orders: tuple[Order, ...] = ORDERS) -> Kind:
    return Kind(name, "for posture", lambda s: s.stack(rest=make(s)), orders)


def _limits(name: str, make: Callable[[Scene], Part | Stack], orders: tuple[Order, ...] = ORDERS) -> Kind:
    return Kind(name, "for limits", lambda s: s.stack(limits=make(s)), orders)


def _added(name: str, make: Callable[[Scene], Part]) -> Kind:
    return Kind(name, "added", lambda s: s.above(make(s)))


def _together(parts: tuple[Part, ...]) -> Part | Stack:
    return Stack(parts[0]) if len(parts) == 1 else parts[0] + _together(parts[1:])


def _sphere() -> Sphere:
    return Sphere([0.3, 0.5, 0.5], 0.1)


def _rail() -> Capsule:
    return Capsule([0.6, -0.5, 0.2], [0.6, -0.5, 0.9], 0.05)


def _gain(s: Scene) -> Any:
    """The rate at which motion is braked, that criteria of least motion have at acceleration order."""
    return None if s.order == "velocity" else 1.0


LATER: tuple[Order, ...] = ("acceleration", "torque")
KINDS: tuple[Kind, ...] = (
    PLAIN,
    _position("relative_to", lambda s: PositionTask(s.path, relative_to="panda_link0", gain=GAIN)),
    _position("relative_to, moving", lambda s: PositionTask([0.3, 0.0, 0.3], relative_to=BASE, gain=GAIN)),
    _position("reference local", lambda s: PositionTask(s.path, reference="local", gain=GAIN)),
    _position("subclass", lambda s: Same(s.path, gain=GAIN)),
    _position("plane", lambda s: PlaneTask([0.0, 0.0, 1.0], float(s.start[2]), gain=GAIN)),
    _position("pose", lambda s: PoseTask(s.path, s.rotation, gain=GAIN)),
    _position("at least", lambda s: AtLeast(PositionTask(s.path, gain=GAIN))),
    _position("at most", lambda s: AtMost(PositionTask(s.path, gain=GAIN))),
    _position("within", lambda s: Within(PositionTask(s.path, gain=GAIN), 0.01)),
    Kind("within, braking", "for position", lambda s: s.stack(limits=s.braked(), hand=Within(s.hand, 0.01))),
    _position("position + damping", lambda s: s.hand + Damping(0.1)),
    _position("own, in Python", lambda s: Own([0.3], gain=GAIN, name="own")),
    _orientation("axis", lambda s: AxisTask(s.rotation[:, 2], gain=GAIN)),
    _orientation("look-at", lambda s: LookAtTask(s.start + s.rotation[:, 2], gain=GAIN)),
    _orientation("joint motion", lambda s: JointMotion(s.turn)),
    _orientation("joint motion, damped", lambda s: JointMotion(s.turn, damping=0.1)),
    _orientation("orientation within", lambda s: Within(s.turn, 0.05)),
    _posture("joint centring", lambda s: JointCentringTask(gain=1.0)),
    _posture("manipulability", lambda s: ManipulabilityTask(s.hand, gain=1.0)),
    _posture("dynamic manipulability", lambda s: DynamicManipulabilityTask(s.hand, gain=1.0)),
    _posture("velocity ratio", lambda s: VelocityRatioTask(s.hand, gain=1.0)),
    _posture("minimum motion", lambda s: MinimumMotionTask(gain=_gain(s))),
    _posture("kinetic energy", lambda s: KineticEnergyTask(gain=_gain(s))),
    _posture("minimum torque", lambda s: MinimumTorqueTask(), LATER),
    _posture("posture of two joints", lambda s: PostureTask([0.0, 0.3], joints=[0, 2], gain=1.0)),
    _limits("JointLimits, named", lambda s: JointLimits(*s.limited())),
    _limits("limits on one level", lambda s: _together(s.limited())),
    _limits("limits level by level", lambda s: Stack(*s.limited())),
    _limits("position limit alone", lambda s: JointPositionLimit()),
    _limits("velocity limit alone", lambda s: JointVelocityLimit()),
    _limits("acceleration limit alone", lambda s: JointAccelerationLimit(ACCELERATION)),
    _limits("torque limit above limits", lambda s: JointTorqueLimit() >> s.limits, LATER),
    _added("elbow position", lambda s: PositionTask(s.elbow, frame=ELBOW, mask="z", gain=GAIN)),
    _added("box limit", lambda s: BoxLimit(s.elbow - 0.3, s.elbow + 0.3, frame=ELBOW, gain=GAIN)),
    _added("plane limit", lambda s: PlaneLimit([0.0, 0.0, 1.0], 0.1, frame=ELBOW, gain=GAIN)),
    _added("frame velocity limit", lambda s: FrameVelocityLimit(0.5)),
    _added("distance, 2 pairs", lambda s: DistanceLimit(s.links()[2:6:2], [_sphere()], margin=0.02, gain=20.0)),
    _added("distance, 14 pairs", lambda s: DistanceLimit(s.links(), [_sphere(), _rail()], margin=0.02, gain=20.0)),
    _added("avoidance", lambda s: AvoidanceTask(s.links(), [_sphere()], influence=0.3, speed=0.1)),
    _added("self-collision", lambda s: SelfCollisionLimit(margin=0.02, gain=20.0)),
    Kind("coupling", "added", lambda s: s.below(JointCouplingTask({0: 1.0, 2: -0.5}, gain=1.0))),
    Kind("centre of mass", "added", lambda s: s.below(CenterOfMassTask([0.0, 0.0, 0.4], mask="z", gain=1.0))),
)
