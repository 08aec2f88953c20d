"""Limits in space under the default damping: as well kept as without it, and passed by curvature alone.

A limit is linear within a tick, and its motion is not: a frame, or a pair of bodies, may pass it by the second-order
part of its way, and a distance limit keeps a reserve for that. Nothing else passes it, wherever the target is, from any
speed of the joints, at gains of up to 1/dt.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from tasks import (
    BoxLimit,
    Capsule,
    Controller,
    DistanceLimit,
    JointLimits,
    LinkCapsule,
    OrientationTask,
    PlanarArm,
    PlaneLimit,
    PositionTask,
    PostureTask,
    SelfCollisionLimit,
    Setpoint,
    Sphere,
    link_capsules,
    load_robot,
    planar_links,
)

#: By more than this a limit counts as passed [m], and a range or a speed of joints [rad], [rad/s].
PASSED, BEYOND = 1e-6, 1e-9
#: Ticks [s], and gains, as the share of what is left that a tick may take: 0.774 is 387 /s at 2 ms.
TICKS, SHARES = (0.002, 0.005, 0.01), (0.05, 0.3, 0.774, 1.0)
#: Links of a Panda, each carried by the first of its frames.
PANDA = [("panda_link2", "panda_link3"), ("panda_link4", "panda_link5"), ("panda_link7", "panda_hand_tcp")]
#: Robots, and the limits of each: the links of a planar arm have no shapes that could collide.
CASES = [
    (name, kind)
    for name in ("planar", "panda", "ur5", "ur10")
    for kind in ("box", "plane", "distance", "bodies")
    if (name, kind) != ("planar", "bodies")
]


@cache
def robot_of(name: str):
    """Its bodies are capsules: the faces of hulls turn at once, which is no curvature."""
    if name == "planar":
        return PlanarArm([0.5, 0.4, 0.3, 0.2], position_limit=(-2.6, 2.6), velocity_limit=3.0)
    return load_robot(name, lock=["panda_finger_joint1"] if name == "panda" else []).with_capsules()


@cache
def links_of(name: str):
    if name == "planar":
        return planar_links(robot_of(name), 0.02)
    return [LinkCapsule(*pair, 0.06) for pair in PANDA] if name == "panda" else link_capsules(robot_of(name))


@dataclass
class Guard:
    """A limit, and what is left of it at joint positions q, one number a side or a pair [m], negative beyond it."""

    part: BoxLimit | PlaneLimit | DistanceLimit | SelfCollisionLimit
    left: Callable[[np.ndarray], np.ndarray]


def tip(robot, q: np.ndarray) -> np.ndarray:
    return robot.at(q).frame().position[: 2 if isinstance(robot, PlanarArm) else 3]


def moved(robot, q: np.ndarray, step: np.ndarray) -> np.ndarray:
    return q + step if isinstance(robot, PlanarArm) else robot.integrate(q, step)


def guard_of(name: str, kind: str, q: np.ndarray, ahead: np.ndarray, room: float, gain: float) -> Guard:
    """A limit that leaves the tip at q about this room [m] in the direction `ahead`; of bodies, the nearest pair."""
    robot = robot_of(name)
    place = tip(robot, q)
    if kind == "box":
        upper = place + np.where(np.abs(ahead) == np.abs(ahead).max(), room, 0.3)
        lower = upper - 0.8
        part = BoxLimit(lower, upper, gain=gain)
        return Guard(part, lambda q: np.concatenate([upper - tip(robot, q), tip(robot, q) - lower]))
    if kind == "plane":
        behind = float(-ahead @ place) - room
        plane = PlaneLimit([*-ahead, 0.0][:3], behind, gain=gain)
        return Guard(plane, lambda q: np.array([-ahead @ tip(robot, q) - behind]))
    if kind == "distance":
        links, margin = links_of(name), 0.02
        centre = place + ahead * (room + margin + 0.1 + links[-1].radius)
        pole = Capsule(centre, centre + 0.3 * np.roll(ahead, 1), 0.05)
        away = DistanceLimit(links, [Sphere(centre, 0.1), pole], margin=margin, gain=gain)
        return Guard(away, lambda q: away.distances(robot, robot.at(q)) - margin)
    nearest = SelfCollisionLimit(margin=0.0, gain=gain).distances(robot, robot.at(q)).min()
    own = SelfCollisionLimit(margin=max(nearest - room, 1e-3), gain=gain, rows=100)
    return Guard(own, lambda q: own.distances(robot, robot.at(q)) - own.margin)


class Scene:
    """A robot, a limit in front of its hand or behind it, and a target on the other side."""

    def __init__(self, name: str, kind: str, seed: int, room: tuple[float, float]) -> None:
        self.rng = rng = np.random.default_rng(seed)
        self.robot = robot = robot_of(name)
        self.dt = float(rng.choice(TICKS))
        self.gain, self.pace = (float(rng.choice(SHARES)) / self.dt for _ in range(2))
        assert robot.position_limit is not None
        low, high = robot.position_limit
        while True:
            spread, ends = rng.uniform(low, high), np.where(rng.random(robot.nv) < 0.5, low + 0.04, high - 0.04)
            self.q = np.where(rng.random(robot.nv) < 0.3, ends, spread)
            self.here = tip(robot, self.q)
            ahead = rng.normal(size=len(self.here))
            self.ahead = np.abs(ahead) / np.linalg.norm(ahead) if kind == "box" else ahead / np.linalg.norm(ahead)
            wanted = rng.uniform(*room)
            self.guard = guard_of(name, kind, self.q, self.ahead, wanted, self.gain)
            left = self.guard.left(self.q).min()
            if abs(left - wanted) < 0.02 and left * wanted > 0.0:
                break
        self.target = Setpoint(self.here + 0.4 * self.ahead)

    def control(self, damping: str | None, together: bool = False, rest: np.ndarray | None = None) -> Controller:
        """Of the usual stack, the limit below those of the joints or on their level, and this posture."""
        state = self.robot.at(self.q)
        about = state.pose[2:] if isinstance(self.robot, PlanarArm) else state.frame().rotation
        tasks = PositionTask(self.target, gain=self.pace) >> OrientationTask(about, gain=self.pace)
        tasks = tasks >> PostureTask(self.q if rest is None else rest, gain=1.0)
        limits = JointLimits() + self.guard.part if together else JointLimits() >> self.guard.part
        return Controller(self.robot, limits >> tasks, dt=self.dt, damping=damping)

    def towards(self) -> np.ndarray:
        """Full speed of all joints that brings the hand to its target."""
        state = self.robot.at(self.q)
        J = state.jacobian[:2] if isinstance(self.robot, PlanarArm) else state.frame().linear
        return self.robot.velocity_limit * np.sign(J.T @ self.ahead)


def beyond(scene: Scene, v: np.ndarray, q: np.ndarray) -> float:
    """How far joints are beyond their ranges, or too fast."""
    low, high = scene.robot.position_limit
    return float(max((np.abs(v) - scene.robot.velocity_limit).max(), (low - q).max(), (q - high).max()))


def lacks(controller: Controller, x: np.ndarray, levels: int) -> list[float]:
    """How far x misses each of the first levels, by their rows as they are in this controller."""
    found = []
    for k, level in enumerate(controller.hierarchy.levels[:levels]):
        value = controller.hierarchy.matrix(k) @ x
        found.append(float(np.linalg.norm(value - np.clip(value, level.lower, level.upper))))
    return found


def same_state(name: str, kind: str, seed: int, together: bool) -> bool:
    """At one state, whether some row of the limits is not met; they are met as well as without damping."""
    scene = Scene(name, kind, seed, (-0.05, 0.02))
    v = scene.rng.uniform(-1.0, 1.0, scene.robot.nv) * scene.robot.velocity_limit
    default, strict = (scene.control(damping, together) for damping in ("curvature", None))
    calm, x = default(scene.q, v), strict(scene.q, v).v
    own, other = (lacks(strict, answer, 1 if together else 2) for answer in (calm.v, x))
    for mine, least in zip(own, other, strict=True):
        assert mine <= least + 1e-9 * (1.0 + np.abs(x).max())
    assert calm.solution.certify().ok
    assert together or beyond(scene, calm.v, moved(scene.robot, scene.q, scene.dt * calm.v)) <= BEYOND
    return own[-1] > PASSED


def curvature(scene: Scene, q: np.ndarray, step: np.ndarray, left: np.ndarray) -> np.ndarray:
    """A bound of the second-order part of a step for each number that is left: half the largest second derivative."""
    parts = 6
    ways = [scene.guard.left(moved(scene.robot, q, k / parts * step)) for k in range(1, parts + 1)]
    return 0.55 * np.abs(np.diff([left, *ways], 2, axis=0)).max(axis=0) * parts**2


def passed(name: str, kind: str, seed: int, together: bool) -> float:
    """By how much a run passes its limit at most, in a tick, beyond what curvature permits [m].

    From rest, or at full speed towards the limit. The target swings to the other side of it and back, and stops there.
    """
    scene = Scene(name, kind, seed, (0.005, 0.05))
    controller, q, v, worst = scene.control("curvature", together), scene.q, seed % 2 * scene.towards(), 0.0
    left, rate, distance = scene.guard.left(q), scene.rng.uniform(3.0, 15.0), kind == "distance"
    for k in range(70):
        swing = np.sin(rate * scene.dt * k) if k < 40 else 1.0
        scene.target.move(scene.here + (0.1 + 0.5 * swing) * scene.ahead)
        step = controller(q, v)
        assert step.ok
        before, (q, v) = q, (moved(scene.robot, q, scene.dt * step.v), step.v)
        assert together or beyond(scene, v, q) <= BEYOND
        was, left = left, scene.guard.left(q)
        due = 0.0 * was if distance else (1.0 - scene.gain * scene.dt) * was
        if (left < due).any():
            worst = max(
                worst, float((due - left - (0.0 if distance else curvature(scene, before, q - before, was))).max())
            )
    return worst


def ticks_beyond(scene: Scene, damping: str | None) -> int:
    """How long a robot that starts at rest beyond a limit, with its target farther beyond, takes to come back."""
    controller, q, v = scene.control(damping), scene.q, np.zeros(scene.robot.nv)
    for k in range(500):
        if scene.guard.left(q).min() > -1e-4:
            return k
        v = controller(q, v).v
        q = moved(scene.robot, q, scene.dt * v)
    return 500


both = pytest.mark.parametrize("together", [False, True], ids=["below", "beside"])
cases = pytest.mark.parametrize(("name", "kind"), CASES)


@both
@cases
def test_limits_are_met_as_well_as_without_damping(name: str, kind: str, together: bool) -> None:
    """In front of a limit and beyond it, from any speed: joints near the ends of their ranges brake harder for it."""
    unmet = [same_state(name, kind, seed, together) for seed in range(12)]
    assert any(unmet), "some limits cannot be met at once: there it shows who yields"


@both
@cases
def test_limits_are_passed_by_curvature_alone(name: str, kind: str, together: bool) -> None:
    assert max(passed(name, kind, seed, together) for seed in range(4)) <= PASSED


@cases
def test_what_starts_beyond_a_limit_comes_back_as_soon_as_without_damping(name: str, kind: str) -> None:
    for seed in range(3):
        default, strict = (
            ticks_beyond(Scene(name, kind, seed, (-0.04, -0.005)), damping) for damping in ("curvature", None)
        )
        assert default <= strict + 2


@pytest.mark.sweep
@both
@cases
def test_limits_in_many_scenes(name: str, kind: str, together: bool) -> None:
    for seed in range(12, 100):
        same_state(name, kind, seed, together)
        assert passed(name, kind, seed, together) <= PASSED


@cases
def test_limits_beside_those_of_the_joints_or_below_them_are_the_same(name: str, kind: str) -> None:
    """As long as all of them are met; joints that are near their bounds are so on both levels."""
    damped = 0
    for seed in range(8):
        scene = Scene(name, kind, seed, (0.001, 0.05))
        v = scene.rng.uniform(-1.0, 1.0, scene.robot.nv) * scene.robot.velocity_limit
        below, beside = (scene.control("curvature", together)(scene.q, v) for together in (False, True))
        if beside.solution.levels[0].residual_norm < BEYOND:
            np.testing.assert_allclose(beside.v, below.v, atol=1e-6)
            damped += len(below.relaxed)
    assert damped


@pytest.mark.parametrize("name", ["planar", "panda", "ur5"])
def test_a_hand_at_rest_at_its_target_in_front_of_a_wall_is_proved(name: str) -> None:
    """How fast it nears the wall is round-off."""
    for seed in range(40):
        scene = Scene(name, "box", seed, (1e-4, 0.03))
        scene.target.move(scene.here)
        rest = scene.q + 0.1 * scene.rng.normal(size=scene.robot.nv)
        assert scene.control("curvature", seed % 2 == 1, rest)(scene.q, 0.0 * scene.q).solution.certify().ok
