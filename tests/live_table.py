"""Every kind of part that users meet: how to make one, and of each attribute another value, or that it stays.

The one table that drives `test_live_laws.py`. A path such as ``"task.gain"`` leads through the parts that a part is
made with; a value stands for itself where a keyword of the same name makes a fresh part with it, and `Made` tells which
keywords do where that differs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, ClassVar, Literal

import numpy as np

from hqp.checks import of_type
from tasks import (
    AtLeast,
    AtMost,
    AvoidanceTask,
    AxisTask,
    Box,
    BoxLimit,
    Capsule,
    CenterOfMassTask,
    CollisionLimit,
    Damping,
    DistanceLimit,
    DynamicManipulabilityTask,
    FrameTask,
    FrameVelocityLimit,
    Freeze,
    GradientTask,
    JointAccelerationLimit,
    JointCentringTask,
    JointCouplingTask,
    JointLimits,
    JointMotion,
    JointPositionLimit,
    JointTorqueLimit,
    JointVelocityLimit,
    JointVelocityTask,
    KineticEnergyTask,
    Line,
    LinearHolonomicTask,
    LinkCapsule,
    LookAtTask,
    ManipulabilityTask,
    MinimumMotionTask,
    MinimumTorqueTask,
    MinorAxisTask,
    OmniwheelTask,
    OrientationTask,
    Part,
    PlanarArm,
    PlaneLimit,
    PlaneTask,
    Polyhedron,
    PoseTask,
    PositionTask,
    PostureTask,
    Reconstructed,
    RollingTask,
    SelfCollisionLimit,
    Setpoint,
    Sphere,
    TargetTask,
    Task,
    Turn,
    VelocityRatioTask,
    Within,
    load_robot,
)
from tasks.base.rotations import exp

Order = Literal["velocity", "acceleration"]


class Spec:
    """What a part is made of: its class and its keywords, which may be made anew themselves; `args` stand in front."""

    def __init__(self, kind: Callable[..., Any], *args: Any, **options: Any) -> None:
        self.kind, self.args, self.options = kind, args, options

    def make(self, changes: Mapping[str, Any], wrap: Callable[[Any], Any], found: dict[str, Any], at: str = "") -> Any:
        """The part, made with these changes; each part in it goes to `found`, by its path."""
        given = {str(i): value for i, value in enumerate(self.args)} | self.options
        prefix = f"{at}." if at else ""
        for path, value in changes.items():
            head, _, rest = path.removeprefix(prefix).partition(".")
            if path.startswith(prefix) and not rest:
                given[head] = value
        made = {name: _made(value, changes, wrap, found, f"{prefix}{name}") for name, value in given.items()}
        args = [made.pop(str(i)) for i in range(len(self.args))]
        found[at] = wrap(self.kind)(*args, **made)
        return found[at]


def _made(value: Any, changes: Mapping[str, Any], wrap: Callable[[Any], Any], found: dict[str, Any], at: str) -> Any:
    if isinstance(value, Spec):
        return value.make(changes, wrap, found, at)
    if isinstance(value, list) and any(isinstance(item, Spec) for item in value):
        return [_made(item, changes, wrap, found, f"{at}.{i}") for i, item in enumerate(value)]
    return value


@dataclass(frozen=True)
class Made:
    """A value, and the keywords by which a fresh part is made with it; None: it is set before there is a controller."""

    value: Any
    keywords: Mapping[str, Any] | None = None


@dataclass
class Case:
    """One kind of part.

    `live` must be seen; `stays` must be refused; `either` may be seen or refused, and never be ignored.
    """

    spec: Spec
    live: dict[str, Any] = field(default_factory=dict)
    stays: tuple[str, ...] = ()
    either: dict[str, Any] = field(default_factory=dict)
    orders: tuple[Order, ...] = ("velocity", "acceleration")


@dataclass(frozen=True)
class Setting:
    """A robot, and numbers that fit it."""

    robot: Any
    frame: str
    flat: bool
    q: Any
    states: tuple[tuple[Any, Any, float], ...]

    def point(self, *xyz: float) -> list[float]:
        return list(xyz[:2] if self.flat else xyz)


@cache
def planar() -> Setting:
    return _setting(arm(), "link3", True, np.array([0.3, 0.7, 0.9, 0.4]))


@cache
def panda() -> Setting:
    robot = spatial()
    return _setting(robot, "panda_link5", False, robot.home + 0.1)


def arm(**limits: Any) -> PlanarArm:
    own: dict[str, Any] = {"position_limit": (-2.0, 2.0), "velocity_limit": 2.5, "acceleration_limit": 20.0}
    return PlanarArm([0.5, 0.4, 0.3, 0.2], **(own | {"torque_limit": 5.0} | limits))


def spatial(**limits: Any) -> Any:
    return load_robot("panda", lock=["panda_finger_joint1"], **({"acceleration_limit": 15.0} | limits))


def _setting(robot: Any, frame: str, flat: bool, q: Any) -> Setting:
    """States: inside the ranges, near their ends and quick, and outside."""
    low, high = robot.position_limit
    v = 0.4 * np.cos(np.arange(robot.nv))
    near, out = np.where(v > 0.0, high - 0.02, low + 0.02), np.array(q)
    out[1] = high[1] + 0.1
    return Setting(robot, frame, flat, q, ((q, v, 0.3), (near, 2.0 * v, 0.0), (out, 0.1 * v, 1.2)))


SETTINGS: dict[str, Callable[[], Setting]] = {"arm": planar, "panda": panda}


# A part of each kind in Python.


class Height(Task):
    """A task with an attribute of its own, which is nobody's business: it is read at every tick."""

    rows = 1

    def __init__(self, height: float, **options: Any) -> None:
        self.height = height
        super().__init__(**options)

    def error(self, state, t):
        return self.height - state.frame().position[1:2]

    def jacobian(self, state):
        return state.frame().linear[1:2]

    def drift(self, state):
        return state.frame().linear_drift[1:2]


class Abscissa(TargetTask):
    rows = 1

    def measure(self, state):
        return state.frame().position[:1]

    def jacobian(self, state):
        return state.frame().linear[:1]

    def drift(self, state):
        return state.frame().linear_drift[:1]


class Ordinate(FrameTask):
    rows = 1

    def __init__(self, *, frame: str, gain: Any, damping_ratio: float = 1.0, weight: Any = 1.0) -> None:
        super().__init__(frame, None, gain=gain, damping_ratio=damping_ratio, weight=weight, name=None)

    def error(self, state, t):
        return 0.2 - self.seen(state).position[1:2]

    def jacobian(self, state):
        return self.seen(state).linear[1:2]

    def drift(self, state):
        return self.seen(state).linear_drift[1:2]


class Biased(PositionTask):
    """A subclass that overrides the measure."""

    def error(self, state, t):
        return super().error(state, t) + 0.01


class Stretched(GradientTask):
    """A criterion with an attribute of its own."""

    def __init__(self, share: float, **options: Any) -> None:
        super().__init__(**options)
        self.share = share

    def value(self, robot, q, t=0.0):
        return self.share * float(robot.at(q, np.zeros(robot.nv)).frame().position[0])


class Slow(Part):
    """A limit, written by hand."""

    is_limit: ClassVar[bool] = True
    plain: ClassVar[bool] = True
    rows = None

    def __init__(self, most: float) -> None:
        self.name, self.weight, self.most = of_type("slow", str, "name"), np.array(1.0), most

    def write(self, tick, A, lower, upper):
        lower[:], upper[:] = -self.most, self.most


# The table.

HALF = np.array(0.5)
LAW = {"gain": 3.0, "damping_ratio": 0.8, "weight": 0.5}
#: What shortens errors: of tasks that are to be met.
SHORT = {"cap": 0.02, "deceleration": 0.05}
GAINS = {**LAW, **SHORT}
KEPT = ("name", "rows")
FRAME = (*KEPT, "frame", "relative_to")
PLACE = (*FRAME, "mask", "reference")


def under(path: str, live: Mapping[str, Any]) -> dict[str, Any]:
    """The same attributes of a part inside of another."""
    found: dict[str, Any] = {}
    for name, value in live.items():
        if isinstance(value, Made) and value.keywords is not None:
            value = Made(value.value, {f"{path}.{key}": other for key, other in value.keywords.items()})
        found[f"{path}.{name}"] = value
    return found


def position(s: Setting) -> Iterator[Case]:
    start, other = s.point(0.4, 0.2, 0.5), s.point(0.3, 0.4, 0.4)
    way = Line(start, other, 2.0)
    live = {**GAINS, "target": other, "position": Made([0.3, 0.4, 0.0 if s.flat else 0.4], {"target": other})}
    options: dict[str, Any] = {"target": start, "gain": 2.0}
    either = {"rotation": Made(np.eye(3))}
    yield Case(Spec(PositionTask, **options), {**live, "weight": 0.0}, PLACE, either)
    yield Case(Spec(PositionTask, **options, frame=s.frame), {**live, "target": way}, PLACE)
    there, back = Line([0.4, 0.2, 0.0], [0.3, 0.4, 0.2], 2.0), Line([0.6, 0.2, 0.0], [0.3, 0.4, 0.2], 3.0)
    masked = {**GAINS, "target": Made([0.7], {"target": [0.7, 0.0, 0.0]}), "position": Made(back, {"target": back})}
    yield Case(Spec(PositionTask, **(options | {"target": there}), mask="x"), masked, PLACE)
    yield Case(Spec(PositionTask, **options), {"gain": [1.0, 2.0, 3.0][: len(start)], "target": Setpoint(other)})
    yield Case(Spec(Biased, **options), live, PLACE, either)
    if not s.flat:
        yield Case(Spec(PositionTask, **options, relative_to=s.frame, reference="local"), live, PLACE)


def orientation(s: Setting) -> Iterator[Case]:
    live = {**GAINS, "target": 0.9, "rotation": Made(0.9, {"target": 0.9})}
    yield Case(Spec(OrientationTask, target=0.2, gain=2.0), live, PLACE, {"position": Made(np.zeros(3))})
    if not s.flat:
        R, other = exp(np.array([0.3, -0.2, 0.5])), exp(np.array([0.1, 0.9, 0.2]))
        live = {**GAINS, "target": other, "rotation": Made(other, {"target": other})}
        yield Case(Spec(OrientationTask, target=R, gain=2.0), {**live, "weight": 0.0}, PLACE)
        turn = Turn(R, other, 2.0)
        yield Case(Spec(OrientationTask, target=turn, gain=2.0, reference="local", mask="xz"), live, PLACE)
        yield Case(
            Spec(OrientationTask, target=R, gain=2.0), {"target": turn, "rotation": Made(turn, {"target": turn})}
        )


def pose(s: Setting) -> Iterator[Case]:
    if not s.flat:
        R, other = exp(np.array([0.3, -0.2, 0.5])), exp(np.array([0.1, 0.9, 0.2]))
        options: dict[str, Any] = {"position": [0.4, 0.2, 0.5], "rotation": R, "gain": 2.0}
        both = np.block([[other, np.array([[0.3], [0.4], [0.4]])], [np.zeros((1, 3)), np.ones((1, 1))]])
        whole = Made(both, {"position": [0.3, 0.4, 0.4], "rotation": other})
        live = {**GAINS, "position": [0.3, 0.4, 0.4], "rotation": other, "target": whole}
        for reference in "local_world_aligned", "local", "world":
            yield Case(Spec(PoseTask, **options, reference=reference), live, PLACE)
        yield Case(Spec(PoseTask, **options, mask="x rz"), {**live, "gain": [1.0, 4.0], "weight": [0.0, 2.0]}, PLACE)


def center_of_mass(s: Setting) -> Iterator[Case]:
    if not s.flat:
        other = [0.3, 0.4, 0.4]
        live = {**GAINS, "target": other, "position": Made(other, {"target": other})}
        spec = Spec(CenterOfMassTask, target=[0.1, 0.2, 0.5], gain=2.0)
        yield Case(spec, live, PLACE, {"rotation": Made(np.eye(3))})


def axis(s: Setting) -> Iterator[Case]:
    if not s.flat:
        other = [0.0, 1.0, 0.3]
        live = {**GAINS, "target": Made(other, {"direction": other}), "direction": other, "axis": [1.0, 0.0, 0.2]}
        yield Case(Spec(AxisTask, direction=[0.0, 0.3, -1.0], gain=2.0), {**live, "weight": 0.0}, FRAME)


def look_at(s: Setting) -> Iterator[Case]:
    if not s.flat:
        other = [0.0, 1.0, 0.3]
        live = {**GAINS, "target": Made(other, {"point": other}), "point": other, "axis": [1.0, 0.0, 0.2]}
        yield Case(Spec(LookAtTask, point=[0.5, 0.3, 0.0], gain=2.0, frame=s.frame), live, FRAME)


def plane(s: Setting) -> Iterator[Case]:
    live = {**GAINS, "target": Made(0.3, {"distance": 0.3}), "distance": 0.3, "normal": [0.6, 0.9, 0.0]}
    yield Case(Spec(PlaneTask, normal=[0.0, 1.0, 0.0], distance=0.1, gain=2.0, frame=s.frame), live, FRAME)


def posture(s: Setting) -> Iterator[Case]:
    live = {**GAINS, "target": s.q + 0.2, "gain": np.linspace(1.0, 2.0, len(s.q))}
    yield Case(Spec(PostureTask, target=s.q - 0.1, gain=2.0), {**live, "weight": 0.0}, (*KEPT, "joints"))
    some = {**GAINS, "target": [0.4, 0.3]}
    yield Case(Spec(PostureTask, target=[0.1, 0.2], joints=[1, 2], gain=2.0), some, (*KEPT, "joints"))


def coupling(s: Setting) -> Iterator[Case]:
    live = {**GAINS, "target": 0.3, "factors": {0: 2.0, 1: 0.5}}
    yield Case(Spec(JointCouplingTask, factors={0: 1.0, 1: -1.0}, gain=2.0), live, KEPT)


def linear(s: Setting) -> Iterator[Case]:
    A, other = np.eye(len(s.q))[[0, 2]] + 0.1, np.eye(len(s.q))[[1, 2]]
    live = {**GAINS, "b": [0.1, 0.3], "A": other, "q0": s.q + 0.1, "target": Made([0.1, 0.3], {"b": [0.1, 0.3]})}
    yield Case(Spec(LinearHolonomicTask, A=A, b=[0.2, -0.1], q0=s.q - 0.2, gain=2.0), live, KEPT)
    yield Case(Spec(LinearHolonomicTask, A=A, gain=2.0), {"b": Line([0.1, 0.3], [0.2, 0.2], 2.0)}, KEPT)


def wheels(s: Setting) -> Iterator[Case]:
    if not s.flat:
        live = {**GAINS, "radius": 0.2, "normal": [0.1, 0.2, 1.0], "floor": 0.1}
        yield Case(Spec(RollingTask, radius=0.1, frame=s.frame, gain=2.0), live, FRAME)
        turned = {**live, "axle": [0.1, 0.3, 1.0], "rollers": 0.6}
        yield Case(Spec(OmniwheelTask, radius=0.1, frame=s.frame, gain=2.0), turned, FRAME)


def joint_motion(s: Setting) -> Iterator[Case]:
    task = Spec(PositionTask, target=s.point(0.4, 0.2, 0.5), gain=2.0)
    inner = {"gain": 3.0, "damping_ratio": 0.8, "target": s.point(0.3, 0.4, 0.4)}
    live = {**under("task", inner), "damping": 0.3, "weight": Made(HALF)}
    yield Case(Spec(JointMotion, task=task), live, (*KEPT, "task", *(f"task.{name}" for name in PLACE)))


def damping(s: Setting) -> Iterator[Case]:
    yield Case(Spec(Damping, weight=0.1), {"weight": np.linspace(0.0, 0.5, len(s.q))}, KEPT)


def speeds(s: Setting) -> Iterator[Case]:
    stays = (*KEPT, "joints")
    yield Case(Spec(Freeze, joints=[1, 3]), {"weight": [0.5, 0.0]}, (*stays, "all_but"))
    yield Case(Spec(Freeze, all_but=[0]), {"weight": 0.5}, (*stays, "all_but"))
    way = Line([0.1, 0.2], [0.4, -0.1], 2.0)
    live = {"target": way, "weight": 0.5}
    yield Case(Spec(JointVelocityTask, target=[0.1, -0.2], joints=[0, 2]), live, stays, {"gain": 3.0})
    live = {"target": np.linspace(-0.3, 0.3, len(s.q)), "gain": 5.0}
    yield Case(Spec(JointVelocityTask, target=0.2, gain=4.0), live, stays, orders=("acceleration",))


def own(s: Setting) -> Iterator[Case]:
    yield Case(Spec(Height, height=0.2, gain=2.0), {**GAINS, "height": 0.4}, KEPT)
    yield Case(Spec(Abscissa, target=0.2, gain=2.0), {**GAINS, "target": 0.4, "weight": 0.0}, KEPT)
    short = {name: Made(value) for name, value in SHORT.items()}  # which its keywords do not know
    yield Case(Spec(Ordinate, frame=s.frame, gain=2.0), {**LAW, **short}, FRAME)
    yield Case(Spec(Stretched, share=2.0, gain=2.0), {"gain": 3.0, "weight": 0.5, "share": 3.0}, KEPT)
    yield Case(Spec(Slow, most=0.4), {"most": 0.2}, KEPT, {"weight": Made(HALF)})


def inequality(s: Setting) -> Iterator[Case]:
    other = s.point(0.3, 0.4, 0.4)
    task = Spec(PositionTask, target=s.point(0.4, 0.2, 0.5), gain=2.0)
    inner = under("task", {**LAW, "target": other})
    stays = (*KEPT, "plain", "task", *(f"task.{name}" for name in PLACE))
    weight = {"weight": Made(HALF, {"task.weight": 0.5})}
    for kind in AtLeast, AtMost:
        sides = {"below": Made(np.array(-0.1)), "above": Made(np.array(0.2))}
        yield Case(Spec(kind, task=task), {**inner, **weight, **sides}, stays)
    sides = {"above": Made(0.2, {"tolerance": 0.2, "below": 0.1}), "below": Made(-0.3, {"below": 0.3})}
    yield Case(Spec(Within, task=task, tolerance=0.1), {**inner, **weight, **sides}, stays)
    posture = Spec(PostureTask, target=s.q - 0.1, gain=2.0)
    live = {**sides, "task.target": s.q + 0.2, "task.gain": 3.0}
    yield Case(Spec(Within, task=posture, tolerance=0.1), live, (*KEPT, "plain", "task"))
    own = Spec(Height, height=0.2, gain=2.0)
    yield Case(Spec(AtMost, task=own), {"task.height": 0.4, "task.gain": 3.0}, (*KEPT, "plain", "task"))


def cartesian(s: Setting) -> Iterator[Case]:
    low, high = s.point(-0.2, -0.1, 0.1), s.point(0.3, 0.5, 0.4)
    options: dict[str, Any] = {"lower": low, "upper": high, "gain": 2.0}
    less, more = s.point(-0.5, 0.1, 0.2), s.point(0.6, 0.6, 0.6)
    sides = {"below": Made(less, {"lower": less}), "above": Made(more, {"upper": more}), "weight": Made(HALF)}
    yield Case(Spec(BoxLimit, **options), {**sides, "lower": less, "upper": more}, (*KEPT, "plain", "task"))
    sides = {"below": Made(np.array(-0.1)), "above": Made(np.array(0.2)), "weight": Made(HALF)}
    live = {**sides, "normal": [0.6, 0.9, 0.0], "distance": 0.3}
    yield Case(Spec(PlaneLimit, normal=[0.0, 1.0, 0.0], distance=0.1, gain=2.0), live, (*KEPT, "plain", "task"))
    live = {"limit": 0.05, "weight": Made(HALF)}
    yield Case(Spec(FrameVelocityLimit, limit=0.3, mask="x rz", frame=s.frame), live, (*KEPT, "pose_task"))


def joint_limits(s: Setting) -> Iterator[Case]:
    weight, n = {"weight": Made(HALF)}, len(s.q)
    speed = {"limit": np.linspace(0.1, 0.5, n), **weight}
    force = {"limit": np.linspace(4.0, 8.0, n), **weight}
    low, high = np.full(n, -2.8), np.full(n, 2.8)
    high[1] = 1.5  # where one of the states is beyond
    ends = {"upper": s.q + 0.005, "lower": s.q - 0.005, "return_speed": 0.05, **weight}
    yield Case(Spec(JointVelocityLimit, limit=1.0), speed, KEPT)
    yield Case(Spec(JointVelocityLimit, limit=1.0), {"limit": None}, KEPT)
    yield Case(Spec(JointVelocityLimit), speed, KEPT)
    yield Case(Spec(JointAccelerationLimit, limit=10.0), force, KEPT)
    yield Case(Spec(JointPositionLimit, lower=low, upper=high), ends, KEPT)
    yield Case(
        Spec(JointTorqueLimit, limit=3.0),
        {"limit": np.linspace(1.0, 4.0, n), "speeds": (0.1, 5.0), **weight},
        KEPT,
        {},
        ("acceleration",),
    )
    yield Case(Spec(JointLimits), {"weight": Made(HALF)}, (*KEPT, "limits"))
    limits = [
        Spec(JointPositionLimit, lower=low, upper=high),
        Spec(JointVelocityLimit, limit=1.0),
        Spec(JointAccelerationLimit, limit=10.0),
    ]
    live = {**under("0", ends), **under("1", speed), **under("2", force)}
    live = {path: value for path, value in live.items() if not path.endswith("weight")}  # they have no rows
    yield Case(Spec(JointLimits, *limits), live, (*KEPT, "limits"))


def criteria(s: Setting) -> Iterator[Case]:
    live = {"gain": 3.0, "weight": 0.5}
    task = Spec(PositionTask, target=s.point(0.4, 0.2, 0.5), gain=2.0)
    yield Case(Spec(JointCentringTask, gain=2.0), live, KEPT)
    yield Case(Spec(ManipulabilityTask, task=task, gain=2.0), live, (*KEPT, "task"))
    yield Case(Spec(MinorAxisTask, task=task, gain=2.0), live, (*KEPT, "task"))
    yield Case(Spec(DynamicManipulabilityTask, task=task, gain=2.0), live, (*KEPT, "task"))
    rows = len(s.point(0.0, 0.0, 0.0))
    towards = {**live, "direction": np.arange(1.0, 1.0 + rows)}
    yield Case(Spec(VelocityRatioTask, task=task, direction=np.ones(rows), gain=2.0), towards, (*KEPT, "task"))
    moving = Spec(PositionTask, target=Line(s.point(0.4, 0.2, 0.5), s.point(0.3, 0.4, 0.4), 2.0), gain=2.0)
    aim = {"task.target": Line(s.point(0.4, 0.2, 0.5), s.point(0.5, 0.1, 0.4), 2.0), "direction": np.ones(rows)}
    yield Case(Spec(VelocityRatioTask, task=moving, gain=2.0), aim, (*KEPT, "task"))
    yield Case(Spec(MinimumMotionTask, gain=2.0), {**live, "weight": np.linspace(0.5, 2.0, len(s.q))}, KEPT)
    yield Case(Spec(KineticEnergyTask, gain=2.0), live, KEPT)
    live = {"weight": 0.5, "torque_range": (-1.0, 2.0)}
    yield Case(Spec(MinimumTorqueTask), live, KEPT, orders=("acceleration",))


def reconstructed(s: Setting) -> Iterator[Case]:
    above = Spec(PositionTask, target=s.point(0.4, 0.2, 0.5), gain=2.0)
    task = Spec(OrientationTask, target=0.2, gain=2.0)
    inner = {"task.gain": 3.0, "task.target": 0.9, "above.gain": 3.0, "above.target": s.point(0.3, 0.4, 0.4)}
    live = {**inner, "threshold": 20.0, "weight": Made(HALF, {"task.weight": 0.5})}
    spec = Spec(Reconstructed, task=task, above=above, threshold=10.0)
    yield Case(spec, live, (*KEPT, "task", "above"), orders=("velocity",))


def _moved(p: Any) -> np.ndarray:
    """The transform by a vector."""
    T = np.eye(4)
    T[:3, 3] = p
    return T


def distances(s: Setting) -> Iterator[Case]:
    carried = Spec(LinkCapsule, frame=s.frame, end=[-0.2, 0.0] if s.flat else "panda_link6", radius=0.05)
    hand = Spec(LinkCapsule, frame="tip" if s.flat else "panda_hand", end=[-0.1, 0.0], radius=0.04)
    tip = s.robot.at(s.q, np.zeros(len(s.q))).frame().position
    ball = Spec(Sphere, centre=tip + np.array([0.12, 0.1, 0.0]), radius=0.05)
    pole = Spec(Capsule, start=tip + np.array([-0.3, 0.1, 0.0]), end=tip + np.array([-0.2, 0.3, 0.0]), radius=0.03)
    both: dict[str, Any] = {"links": [carried, hand], "obstacles": [ball, pole]}
    inner = {
        "links.0.radius": 0.08,
        "obstacles.0.radius": 0.07,
        "obstacles.0.centre": tip + np.array([0.15, 0.12, 0.0]),
        "obstacles.1.radius": 0.05,
        "obstacles.1.start": tip + np.array([-0.25, 0.15, 0.0]),
        "obstacles.1.end": tip + np.array([-0.1, 0.12, 0.0]),
    }
    inside = ("links.0.frame", "links.0.name", "links.0.start", "links.0.end", "links", "obstacles", "pairs", "nearest")
    live = {**inner, "margin": 0.04, "gain": 3.0, "weight": 0.5}
    yield Case(Spec(DistanceLimit, **both, margin=0.02, gain=2.0), live, (*KEPT, *inside))
    yield Case(Spec(DistanceLimit, **both, margin=0.02, gain=2.0, nearest=2), live, (*KEPT, *inside))
    live = {"influence": 0.6, "speed": 0.4, "gain": 4.0, "weight": 0.5, "obstacles.0.radius": 0.06}
    yield Case(Spec(AvoidanceTask, **both, influence=0.4, speed=0.3), live, (*KEPT, *inside))
    if not s.flat:
        pairs = [("panda_hand", "panda_link2"), ("panda_link5", "panda_link1"), ("panda_hand", "panda_link0")]
        live = {"margin": 0.05, "gain": 3.0, "weight": Made(HALF)}
        yield Case(
            Spec(SelfCollisionLimit, pairs=pairs, margin=0.02, gain=2.0), live, (*KEPT, "pairs", "asked", "without")
        )
        corners = np.vstack([np.zeros(3), 0.2 * np.eye(3)]) + tip + np.array([0.1, 0.1, 0.0])
        solids = [Spec(Box, size=[0.1, 0.2, 0.3], at=_moved(tip + 0.2)), Spec(Polyhedron, points=corners)]
        live = {
            "margin": 0.05,
            "gain": 3.0,
            "weight": Made(HALF),
            "obstacles.0.size": [0.2, 0.2, 0.2],
            "obstacles.0.at": _moved(tip + 0.25),
            "obstacles.1.points": corners + 0.02,
            "obstacles.1.at": _moved(np.array([0.0, 0.0, 0.05])),
        }
        named = ("obstacles.0.name", "obstacles.1.name", "obstacles", "bodies")
        bodies = ["panda_hand", "panda_link5"]
        spec = Spec(CollisionLimit, obstacles=solids, bodies=bodies, margin=0.02, gain=2.0, rows=2)
        yield Case(spec, live, (*KEPT, *named))


GROUPS: dict[str, Callable[[Setting], Iterator[Case]]] = {
    group.__name__: group
    for group in (
        position, orientation, pose, center_of_mass, axis, look_at, plane, wheels, posture, coupling, linear,
        joint_motion, damping, speeds, own, inequality, cartesian, joint_limits, criteria, reconstructed, distances,
    )
}  # fmt: skip
